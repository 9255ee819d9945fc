//! The stepped world: one hand or many, and what they touch.

mod advance;
mod areas;
mod assemble;
mod check;
mod condense;
mod energy;
mod error;
mod fall_back;
mod foresight;
mod freedoms;
mod friction;
mod hash;
mod in_parts;
mod io;
mod joint_tree;
mod keep_momentum;
mod keep_swing;
mod kinematic_advance;
mod limits;
mod model;
mod monolithic;
mod overlap;
mod parts;
mod push_out;
mod readout;
#[cfg(any(test, feature = "reference"))]
mod reference;
mod response;
mod retune;
mod scheme;
mod single_out;
mod stability;
mod start;
mod state;
mod step;
mod sub_world;
mod two_step;
mod validate;

pub use crate::capacity_vec::CapacityVec;
pub use crate::solver::Failure;
pub use check::GRAVITY_MAX;
pub use error::ModelError;
pub use io::{ContactPoint, Energy, Input, JointTarget, Stage, StageTimer, StepReport, Target};
pub use model::Model;
pub use overlap::Overlap;
pub use parts::HALVINGS_MAX;
pub use state::State;
pub use sub_world::SubWorld;
pub use validate::Invalid;

use crate::contact::{Contact, Detector, RigidPlace, SeenSides};
use crate::coupling::skin_target;
use crate::math::{Pose, Vec3};
use crate::model::{SolverKind, SolverSettings, WorldDesc};
use crate::skeleton::axis_states;
use check::is_time_step;
use parts::StepPart;
use readout::Readout;
use scheme::Solver;
use state::Scratch;
use std::ops::Range;

/// A simulation: what is constant, what changes, the memory to step it in, and what the last step
/// found.
#[derive(Clone, Debug)]
pub struct World {
    desc: WorldDesc,
    model: Model,
    state: State,
    scratch: Scratch,
    readout: Readout,
    detector: Detector,
    places: Vec<RigidPlace>,
    solver: Solver,
    time_step: f64,
    /// Number of times that parameters were replaced.
    retuned: u64,
}

impl World {
    /// Checks and compiles a description.
    pub fn new(mut desc: WorldDesc) -> Result<Self, ModelError> {
        check::normalize_rotations(&mut desc);
        let model = Model::new(&desc)?;
        let detector = Detector::new(&desc);
        let mut state = State::new(&desc, &model);
        let contacts_max = detector.capacity();
        state.impulses.reserve(contacts_max);
        let sides_max = detector.sides_max();
        state.sides = SeenSides::with_capacity(sides_max);
        let scratch = Scratch::new(&model, &state, [contacts_max, sides_max]);
        let readout = Readout::new(&model, contacts_max);
        let place = |pose_WB: &Pose| RigidPlace {
            pose_WB: *pose_WB,
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        };
        let places = state.poses_WB.iter().map(place).collect();
        let time_step = desc.time_step;
        let solver = Solver::new(desc.solver.kind, &desc, &model, contacts_max);
        let retuned = 0;
        let mut world = Self {
            desc,
            model,
            state,
            scratch,
            readout,
            detector,
            places,
            solver,
            time_step,
            retuned,
        };
        world.embed();
        Ok(world)
    }

    /// Moves the world forward by one time step: the paper's Sec. 4. A step that contact does not
    /// carry through is made in parts (`SolverSettings::step_halvings_max`); contacts then are
    /// those of the last. Allocates nothing (but a clone fills its work space in its first steps).
    ///
    /// # Panics
    /// When a list of `input` is shorter than [`World::input`] makes it.
    pub fn step(&mut self, input: &Input, timer: &mut impl StageTimer) -> StepReport {
        let end = self.state.time + self.time_step;
        self.readout.lend(&mut self.scratch);
        self.solver.begin_step(self.desc.solver.contact_work_max);
        let mut report = self.make_in_parts(input, timer);
        report.contact_cut_short = self.solver.was_cut_short();
        if !report.taken_back {
            self.state.time = end;
        }

        timer.begin(Some(Stage::Embed));
        let Self { model, state, .. } = self;
        (report.joint_gap_max, report.joint_misalignment_max) = advance::joint_errors(model, state);
        self.embed();
        self.readout.take(&mut self.scratch);
        self.measure_areas();
        timer.begin(None);
        debug_assert_eq!(self.validate_step(), Ok(()), "a step: {report:?}");
        report
    }

    /// Makes one part of a step, as far as its numbers make sense.
    fn make(&mut self, part: StepPart, input: &Input, timer: &mut impl StageTimer) -> StepReport {
        let bad_targets = input.bad_targets();
        let mut report = StepReport { bad_targets, parts: 1, ..StepReport::default() };
        self.readout.part_length = part.h;
        self.scratch.remember(&self.state);
        self.scratch.islands.release();
        let sound = self.attempt(part, input, timer, &mut report)
            || self.step_without_what_fails(part, input, timer, &mut report);
        if !sound {
            let Self { state, scratch, .. } = self;
            advance::take_back(state, &scratch.before);
            scratch.sides.copy_from(&state.sides);
            scratch.forget_contacts();
            (report.non_finite, report.taken_back) = (true, true);
            report.failure.get_or_insert(Failure::NotFinite);
        }
        report
    }

    /// Finds velocities and moves by them; false when the state makes no sense afterwards.
    fn attempt(
        &mut self,
        part: StepPart,
        input: &Input,
        timer: &mut impl StageTimer,
        report: &mut StepReport,
    ) -> bool {
        let found = self.find_velocities(part, input, timer, report);
        if let Err(failure) = found {
            report.failure.get_or_insert(failure);
        } else {
            self.rest_what_is_held();
        }

        timer.begin(Some(Stage::Embed));
        let Self { model, state, scratch, solver, .. } = self;
        let push = std::mem::take(&mut scratch.push);
        advance::advance(solver, model, state, scratch.pushes.then_some(&push), part.h, scratch);
        scratch.push = push;
        found.is_ok() && state.is_sound()
    }

    /// Builds the solver that the settings choose, when it is another one than before.
    fn prepare_solver(&mut self) {
        let kind = self.desc.solver.kind;
        if self.solver.kind() != kind {
            let contacts_max = self.detector.capacity();
            self.solver = Solver::new(kind, &self.desc, &self.model, contacts_max);
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
            joint_targets: vec![None; self.model.joints.len()],
            node_forces: vec![Vec3::zeros(); self.state.x.len()],
        }
    }

    /// Places the collision surfaces on the present nodes.
    fn embed(&mut self) {
        for (out, vertex) in self.readout.vertices.iter_mut().zip(&self.model.vertices) {
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

    /// Changes the time step \[s\]; ignored unless from 1e-12 to 10 s.
    pub fn set_time_step(&mut self, h: f64) {
        if is_time_step(h) {
            self.state.scale_impulses(h / self.time_step);
            self.time_step = h;
        }
    }

    /// Chooses another solver. Choosing the monolithic one allocates its memory, choosing another
    /// frees it.
    pub fn set_solver(&mut self, kind: SolverKind) {
        self.desc.solver.kind = kind;
        self.prepare_solver();
    }

    /// Changes all solver settings.
    ///
    /// # Errors
    /// A setting is out of range: all stay as they were.
    pub fn set_solver_settings(&mut self, settings: SolverSettings) -> Result<(), ModelError> {
        check::settings(&settings)?;
        self.desc.solver = settings;
        self.prepare_solver();
        Ok(())
    }

    /// Returns the description that the world was built from.
    pub fn desc(&self) -> &WorldDesc {
        &self.desc
    }

    /// Returns the constant part of the world.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Returns the changing part of the world.
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

    /// Returns the range of a deformable body's nodes in `Input::node_forces`.
    pub fn node_range(&self, soft: u32) -> Range<usize> {
        self.model.soft_nodes[soft as usize].clone()
    }

    /// Lumped node masses of a deformable body \[kg\].
    pub fn node_masses(&self, soft: u32) -> &[f64] {
        &self.model.flesh.mass[self.node_range(soft)]
    }

    /// Collision-surface vertices of a deformable body, world \[m\].
    pub fn collision_vertices(&self, soft: u32) -> &[Vec3] {
        &self.readout.vertices[self.model.soft_vertices[soft as usize].clone()]
    }

    /// Skinning targets f_i (Eq. 6) of a deformable body's nodes; nodes bound to no bone keep
    /// their position. `out` has one entry per node.
    pub fn skin_targets(&self, soft: u32, out: &mut [Vec3]) {
        let range = self.node_range(soft);
        out.copy_from_slice(&self.state.x[range.clone()]);
        let (coupling, poses_WB) = (&self.model.coupling, &self.state.poses_WB);
        let shares = coupling.shares(poses_WB);
        let posed = coupling.offsets.with(&shares);
        for bound in &coupling.bound {
            let node = bound.node as usize;
            if range.contains(&node) {
                out[node - range.start] = skin_target(bound, poses_WB, &posed).position_W;
            }
        }
    }

    /// The contacts of the last step, near and touching.
    pub fn contacts(&self) -> &[ContactPoint] {
        &self.readout.contacts
    }

    /// Contacts of the last step, each with the places where it holds its bodies.
    pub(crate) fn contact_sites(&self) -> impl Iterator<Item = (&Contact, &ContactPoint)> {
        self.readout.sites.iter().zip(&self.readout.contacts)
    }

    /// Collision-surface vertices of all deformable bodies, one after another, world \[m\].
    pub(crate) fn all_collision_vertices(&self) -> &[Vec3] {
        &self.readout.vertices
    }

    /// Changes whenever any bit of the state does.
    pub fn state_hash(&self) -> u64 {
        self.state.hash()
    }
}
