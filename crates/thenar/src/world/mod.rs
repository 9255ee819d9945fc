//! The stepped world: one hand or many, and what they touch.

mod advance;
mod assemble;
mod check;
mod condense;
mod energy;
mod error;
mod exact;
mod fall_back;
mod friction;
mod hash;
mod io;
mod limits;
mod model;
mod overlap;
mod reference;
mod response;
mod retune;
mod stability;
mod start;
mod state;
mod two_step;

pub use crate::solver::Failure;
pub use error::ModelError;
pub use io::{ContactPoint, Energy, Input, Stage, StageTimer, StepReport, Target};
pub use model::Model;
pub use overlap::Overlap;
pub use state::State;

use crate::contact::{Contact, Detector, Reach, RigidPlace, Sides};
use crate::coupling::skin_target;
use crate::math::{Pose, Vec3};
use crate::model::{Limits, SolverKind, SolverSettings, WorldDesc};
use crate::skeleton::axis_states;
use crate::solver::Convergence;
use check::is_time_step;
use fall_back::Care;
use state::Scratch;
use std::ops::Range;

/// A simulation: what is constant, what changes, and the memory to step it in.
#[derive(Clone, Debug)]
pub struct World {
    desc: WorldDesc,
    model: Model,
    state: State,
    scratch: Scratch,
    detector: Detector,
    places: Vec<RigidPlace>,
    time_step: f64,
}

impl World {
    /// Checks and compiles a description.
    pub fn new(desc: WorldDesc) -> Result<Self, ModelError> {
        let model = Model::new(&desc)?;
        let detector = Detector::new(&desc);
        let mut state = State::new(&desc, &model);
        let contacts_max = detector.capacity();
        state.impulses.reserve(contacts_max);
        let sides_max = detector.sides_max();
        state.sides = Sides::with_capacity(sides_max);
        let scratch = Scratch::new(&model, &state, [contacts_max, sides_max]);
        let place = |pose_WB: &Pose| RigidPlace {
            pose_WB: *pose_WB,
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        };
        let places = state.poses_WB.iter().map(place).collect();
        let time_step = desc.time_step;
        let mut world = Self { desc, model, state, scratch, detector, places, time_step };
        world.prepare_solver();
        world.embed();
        Ok(world)
    }

    /// Moves the world forward by one time step: the paper's Sec. 4. Allocates nothing (with the
    /// dense reference solver it does; a clone fills its work space in its first steps).
    ///
    /// # Panics
    /// When a list of `input` is shorter than [`World::input`] makes it.
    pub fn step(&mut self, input: &Input, timer: &mut impl StageTimer) -> StepReport {
        let mut report = StepReport { bad_targets: input.bad_targets(), ..StepReport::default() };
        self.scratch.remember(&self.state);
        let kind = self.desc.solver.kind;
        let mut found = self.find_velocities(kind, Care::Accurate, input, timer, &mut report);
        if let Err(failure) = found {
            report.failure = Some(failure);
            if kind == SolverKind::Exact {
                found = self.fall_back(input, timer, &mut report);
            }
        }

        timer.begin(Some(Stage::Embed));
        let Self { model, state, scratch, time_step: h, .. } = self;
        advance::advance(model, state, *h);
        let sound = found.is_ok() && state.is_sound();
        if sound {
            std::mem::swap(&mut state.sides, &mut scratch.sides);
        } else {
            advance::take_back(state, &scratch.before);
            scratch.forget_contacts();
        }
        if !sound {
            report.non_finite = true;
            report.failure.get_or_insert(Failure::NotFinite);
        }
        (report.joint_gap_max, report.joint_misalignment_max) = advance::joint_errors(model, state);
        self.embed();
        timer.begin(None);
        report
    }

    /// The velocities at the end of the step, contact included.
    ///
    /// # Errors
    /// This solver fails.
    fn find_velocities(
        &mut self,
        kind: SolverKind,
        care: Care,
        input: &Input,
        timer: &mut impl StageTimer,
        report: &mut StepReport,
    ) -> Result<(), Failure> {
        let Self { desc, model, state, scratch, detector, places, time_step: h, .. } = self;
        let (h, settings) = (*h, &desc.solver);
        // The two-step scheme, also as the exact solver's stand-in, has no rows for limits.
        let limits = if kind == SolverKind::TwoStep { Limits::Springs } else { settings.limits };

        timer.begin(Some(Stage::Skeleton));
        assemble::skeleton(desc, model, limits, state, input, h, scratch); // A_s, b_s, J_s (4)
        match kind {
            SolverKind::Exact => {
                exact::couple(model, state, h, scratch); //                               (7-9)
                limits::set_bounds(limits, model, state, h, scratch);
            }
            _ => assemble::coupling(desc, model, state, h, scratch), //   A_sf, A_fs      (7-9)
        }
        if kind == SolverKind::TwoStep {
            two_step::articulated_body(model, state, h, scratch)?; //                        (10)
        }

        timer.begin(Some(Stage::Flesh));
        let tally = assemble::flesh(model, state, input, h, scratch); //  A_f, b_f        (5)
        report.inverted_tets = tally.inverted;
        let mut whole = None;
        let cg = match kind {
            SolverKind::TwoStep => {
                two_step::unconstrained_deformation(settings, model, state, scratch)? //  (11)
            }
            SolverKind::Exact => exact::solve(settings, care, model, state, h, scratch)?, // (9)
            SolverKind::Monolithic => {
                let solved = reference::solve(model, state, h, scratch); //               (9)
                whole = Some(solved.ok_or(Failure::NotPositiveDefinite)?);
                Convergence::default()
            }
        };
        report.cg_iterations = cg.iterations;
        report.cg_residual = cg.residual;
        if !state.is_sound() {
            return Err(Failure::NotFinite);
        }

        timer.begin(Some(Stage::Detect));
        let reach = Reach { h, margin: settings.contact_margin };
        let found = response::detect(reach, model, state, detector, places, scratch);
        report.contacts_dropped = found.dropped;

        timer.begin(Some(Stage::Contact));
        response::build_rows(model, state, h, scratch); //                                (12)
        friction::set_coefficients(model, state, scratch);
        let contacts = scratch.rows.rows.len();
        if limits == Limits::Rows {
            limits::build_rows(kind, model, state, h, scratch);
        }
        let contact = match (kind, &whole) {
            (SolverKind::Exact, _) => exact::respond(settings, care, model, state, scratch)?,
            (_, Some(whole)) => reference::respond(whole, model, settings.cone, state, scratch),
            _ => response::anticipate(settings, state, scratch),
        };
        report.contact_unconverged = match kind {
            // Impulses and velocities may each be off by the tolerance.
            SolverKind::Exact => contact.residual > 2.0 * settings.velocity_tolerance,
            _ => contact.residual > settings.contact_tolerance,
        };
        response::apply(state, scratch);
        if !state.is_sound() {
            return Err(Failure::NotFinite);
        }
        friction::keep_loads(model, &scratch.found, &scratch.rows, h, &mut state.patch_loads);
        report.limits_active = limits::keep_impulses(model, contacts, state, scratch);
        let close = settings.close_joints || care == Care::Safe;
        if kind == SolverKind::TwoStep && close && !model.joints.is_empty() {
            two_step::close_joints(model, state, h, scratch)?;
        }
        if care == Care::Safe {
            let share = match kind {
                SolverKind::Exact => exact::calm(model, state, scratch),
                _ => two_step::calm(model, state, scratch),
            };
            response::shorten(share, state, scratch);
        }
        if limits == Limits::Springs && limits::by_rows(settings) {
            limits::keep_spring_impulses(model, state, h, scratch);
        }
        response::report(state, h, settings.cone, contact, scratch, report);
        Ok(())
    }

    /// Builds the exact solver when it is chosen and not there yet.
    fn prepare_solver(&mut self) {
        if self.desc.solver.kind == SolverKind::Exact && self.scratch.exact.is_none() {
            let places = self.desc.softs.iter();
            let rest: Vec<Vec3> = places
                .flat_map(|soft| soft.flesh.nodes.iter().map(|x| soft.pose_WM.point(x)))
                .collect();
            let contacts_max = self.detector.capacity() + limits::rows_max(&self.model);
            self.scratch.exact = Some(exact::build(&self.model, &rest, contacts_max));
        }
    }

    /// An input of the right size in which nothing but the description's gravity acts.
    pub fn input(&self) -> Input {
        let rigids = self.model.rigids.len();
        Input {
            gravity: self.desc.gravity,
            targets: vec![None; rigids],
            prescribed: vec![[Vec3::zeros(); 2]; rigids],
            wrenches: vec![[Vec3::zeros(); 2]; rigids],
            joint_torques: vec![[0.0; 2]; self.model.joints.len()],
            node_forces: vec![Vec3::zeros(); self.state.x.len()],
        }
    }

    /// Places the collision surfaces on the present nodes.
    fn embed(&mut self) {
        for (out, vertex) in self.scratch.vertices.iter_mut().zip(&self.model.vertices) {
            *out = vertex.of(&self.state.x);
        }
    }

    /// Time simulated \[s\].
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Time step \[s\].
    pub fn time_step(&self) -> f64 {
        self.time_step
    }

    /// Changes the time step \[s\]; ignored unless positive and at most 10 s.
    pub fn set_time_step(&mut self, h: f64) {
        if is_time_step(h) {
            self.time_step = h;
        }
    }

    /// Chooses another solver. Choosing the exact one for the first time allocates its memory.
    pub fn set_solver(&mut self, kind: SolverKind) {
        self.desc.solver.kind = kind;
        self.prepare_solver();
    }

    /// Changes all solver settings.
    pub fn set_solver_settings(&mut self, settings: SolverSettings) {
        self.desc.solver = settings;
        self.prepare_solver();
    }

    /// What the world was built from.
    pub fn desc(&self) -> &WorldDesc {
        &self.desc
    }

    /// What is constant.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// What changes.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Pose of a rigid body.
    pub fn rigid_pose(&self, i: u32) -> Pose {
        self.state.poses_WB[i as usize]
    }

    /// Linear \[m/s\] and angular \[rad/s\] velocity of a rigid body, world, at its centre of mass.
    pub fn rigid_velocity(&self, i: u32) -> [Vec3; 2] {
        [self.state.v[2 * i as usize], self.state.v[2 * i as usize + 1]]
    }

    /// Angles of a joint's measured axes \[rad\]; zero where there is none.
    pub fn joint_angles(&self, j: u32) -> [f64; 2] {
        let frames = assemble::joint_frames(&self.model, &self.state, j as usize);
        axis_states(self.model.joints[j as usize].kind, &frames)
            .map(|axis| axis.map_or(0.0, |axis| axis.angle))
    }

    /// Rates of these angles \[rad/s\].
    pub fn joint_rates(&self, j: u32) -> [f64; 2] {
        let joint = &self.model.joints[j as usize];
        let frames = assemble::joint_frames(&self.model, &self.state, j as usize);
        let turning = |b: u32| self.state.v[2 * b as usize + 1];
        let relative = turning(joint.child) - joint.parent.map_or(Vec3::zeros(), turning);
        axis_states(joint.kind, &frames)
            .map(|axis| axis.map_or(0.0, |axis| axis.direction_W.dot(&relative)))
    }

    /// Distance between the two sides of a joint \[m\] and misalignment of its axes \[rad\].
    pub fn joint_error(&self, j: u32) -> (f64, f64) {
        let frames = assemble::joint_frames(&self.model, &self.state, j as usize);
        let kind = self.model.joints[j as usize].kind;
        (frames.gap().norm(), crate::skeleton::misalignment(kind, &frames))
    }

    /// Node positions of a deformable body, world \[m\].
    pub fn nodes(&self, soft: u32) -> &[Vec3] {
        &self.state.x[self.node_range(soft)]
    }

    /// Node velocities of a deformable body, world \[m/s\].
    pub fn node_velocities(&self, soft: u32) -> &[Vec3] {
        let (rigids, range) = (self.model.rigids.len(), self.node_range(soft));
        &self.state.v[2 * rigids + range.start..2 * rigids + range.end]
    }

    /// Where a deformable body's nodes lie in `Input::node_forces`.
    pub fn node_range(&self, soft: u32) -> Range<usize> {
        self.model.soft_nodes[soft as usize].clone()
    }

    /// Lumped node masses of a deformable body \[kg\].
    pub fn node_masses(&self, soft: u32) -> &[f64] {
        &self.model.flesh.mass[self.node_range(soft)]
    }

    /// Collision-surface vertices of a deformable body, world \[m\].
    pub fn collision_vertices(&self, soft: u32) -> &[Vec3] {
        &self.scratch.vertices[self.model.soft_vertices[soft as usize].clone()]
    }

    /// Skinning targets f_i (Eq. 6) of a deformable body's nodes; nodes bound to no bone keep
    /// their position. `out` has one entry per node.
    pub fn skin_targets(&self, soft: u32, out: &mut [Vec3]) {
        let range = self.node_range(soft);
        out.copy_from_slice(&self.state.x[range.clone()]);
        for bound in &self.model.coupling.bound {
            let node = bound.node as usize;
            if range.contains(&node) {
                out[node - range.start] = skin_target(bound, &self.state.poses_WB).position_W;
            }
        }
    }

    /// The contacts of the last step, near and touching.
    pub fn contacts(&self) -> &[ContactPoint] {
        &self.scratch.contacts
    }

    /// These, each with where it holds its bodies.
    pub(crate) fn contact_sites(&self) -> impl Iterator<Item = (&Contact, &ContactPoint)> {
        self.scratch.found.iter().zip(&self.scratch.contacts)
    }

    /// Collision-surface vertices of all deformable bodies, one after another, world \[m\].
    pub(crate) fn all_collision_vertices(&self) -> &[Vec3] {
        &self.scratch.vertices
    }

    /// Changes whenever any bit of the state does.
    pub fn state_hash(&self) -> u64 {
        self.state.hash()
    }
}
