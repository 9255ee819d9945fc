//! Inputs and results of a step.

use crate::math::{Pose, Quat, Vec3};
use crate::model::BodyId;
use crate::solver::Failure;

/// Wanted pose and velocity of a driven bone.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Target {
    /// Wanted pose of the bone frame (at its centre of mass) in the world at the end of the step.
    pub pose_WB: Pose,
    /// Velocity of the wanted pose, world \[m/s\], by which a step made in parts leads the drive to
    /// where the target was.
    pub velocity_W: Vec3,
    /// Angular velocity of the wanted pose, world \[rad/s\].
    pub angular_velocity_W: Vec3,
}

impl Target {
    /// Returns the target as it was `time` earlier \[s\], by its velocities.
    pub(super) fn earlier(&self, time: f64) -> Self {
        if time == 0.0 {
            return *self;
        }
        let turn = Quat::from_scaled_axis(self.angular_velocity_W * -time);
        let rotation = Quat::new_normalize((turn * self.pose_WB.rotation).into_inner());
        let position = self.pose_WB.position - self.velocity_W * time;
        Self { pose_WB: Pose { position, rotation }, ..*self }
    }

    /// True when every number is finite.
    pub fn is_finite(&self) -> bool {
        let rates = self.velocity_W.iter().chain(self.angular_velocity_W.iter());
        self.pose_WB.is_finite() && rates.copied().all(f64::is_finite)
    }
}

/// Wanted angles of a joint: a position drive, as strong as the joint's own spring and damper. The
/// spring is relaxed at these angles in the place of `Axis::rest_angle`, and the damper brakes what
/// the joint's rates differ from these.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointTarget {
    /// Angles (`JointKind::angles`) at the end of the step \[rad\].
    pub angles: [f64; 2],
    /// Rates of these angles \[rad/s\].
    pub rates: [f64; 2],
    /// Rotation of the child's joint frame K in the parent's J at the end of the step, of a ball
    /// joint.
    pub rotation_JK: Quat,
    /// Angular velocity of that rotation, in J \[rad/s\].
    pub spin_J: Vec3,
    /// Factor on spring and damper of each axis, from 0 (the joint is let go, and only
    /// `Input::joint_torques` act) to 1; the first one is a ball joint's.
    pub gains: [f64; 2],
}

impl Default for JointTarget {
    /// The joint's zero, at rest.
    fn default() -> Self {
        let (angles, rates) = ([0.0; 2], [0.0; 2]);
        let (rotation_JK, spin_J) = (Quat::identity(), Vec3::zeros());
        Self { angles, rates, rotation_JK, spin_J, gains: [1.0; 2] }
    }
}

impl JointTarget {
    /// Returns the target as it was `time` earlier \[s\], by its rates.
    pub(super) fn earlier(&self, time: f64) -> Self {
        if time == 0.0 {
            return *self;
        }
        let angles = [0, 1].map(|k| self.angles[k] - self.rates[k] * time);
        let turn = Quat::from_scaled_axis(self.spin_J * -time);
        Self { angles, rotation_JK: turn * self.rotation_JK, ..*self }
    }

    /// True when every number is finite.
    pub fn is_finite(&self) -> bool {
        let numbers = self.angles.iter().chain(&self.rates).chain(&self.gains);
        let numbers = numbers.chain(self.rotation_JK.coords.iter());
        numbers.chain(self.spin_J.iter()).copied().all(f64::is_finite)
    }
}

impl Input {
    /// Returns the number of targets, of bodies and of joints, that are not finite.
    pub fn bad_targets(&self) -> u32 {
        let bodies = self.targets.iter().flatten().filter(|target| !target.is_finite()).count();
        let joints = self.joint_targets.iter().flatten().filter(|target| !target.is_finite());
        (bodies + joints.count()) as u32
    }

    /// The target of joint `j`; one that is not finite lets the joint go.
    pub fn joint_target(&self, j: usize) -> Option<JointTarget> {
        let let_go = JointTarget { gains: [0.0; 2], ..JointTarget::default() };
        self.joint_targets[j].map(|target| if target.is_finite() { target } else { let_go })
    }

    /// The target of rigid body `b`, unless it is not finite.
    pub fn target(&self, b: usize) -> Option<&Target> {
        self.targets[b].as_ref().filter(|target| target.is_finite())
    }
}

/// Everything from outside that acts during one step. Made by `World::input`, sized for its
/// world, and refilled by the caller; entries default to nothing acting.
#[derive(Clone, Debug)]
pub struct Input {
    /// Gravity, world \[m/s²\].
    pub gravity: Vec3,
    /// Per rigid body: the target of its drive; `None` lets go.
    pub targets: Vec<Option<Target>>,
    /// Per rigid body: prescribed velocity at the centre of mass, linear \[m/s\] and
    /// angular \[rad/s\], world. Read for prescribed bodies only.
    pub prescribed: Vec<[Vec3; 2]>,
    /// Per rigid body: force \[N\] at the centre of mass and torque \[N m\], world.
    pub wrenches: Vec<[Vec3; 2]>,
    /// Per joint and measured axis (`JointKind::angles`): torque on the child, opposite on the
    /// parent \[N m\].
    pub joint_torques: Vec<[f64; 2]>,
    /// Per joint: where its spring is relaxed; `None` leaves that to its rest angle. Fixed and free
    /// joints have no springs.
    pub joint_targets: Vec<Option<JointTarget>>,
    /// Per node of all deformable bodies, in order: force, world \[N\].
    pub node_forces: Vec<Vec3>,
}

impl Input {
    /// Takes over `other` without allocating; false, and nothing changes, when it is another
    /// world's.
    pub fn copy_from(&mut self, other: &Self) -> bool {
        let lengths = |input: &Self| {
            let Self { gravity: _, targets, prescribed, wrenches, .. } = input;
            let Self { joint_torques, joint_targets, node_forces, .. } = input;
            let joints = [joint_torques.len(), joint_targets.len()];
            [
                targets.len(),
                prescribed.len(),
                wrenches.len(),
                joints[0],
                joints[1],
                node_forces.len(),
            ]
        };
        let fits = lengths(self) == lengths(other);
        if fits {
            self.gravity = other.gravity;
            self.targets.copy_from_slice(&other.targets);
            self.prescribed.copy_from_slice(&other.prescribed);
            self.wrenches.copy_from_slice(&other.wrenches);
            self.joint_torques.copy_from_slice(&other.joint_torques);
            self.joint_targets.copy_from_slice(&other.joint_targets);
            self.node_forces.copy_from_slice(&other.node_forces);
        }
        fits
    }
}

/// One active or near contact after a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// The bodies A and B.
    pub bodies: [BodyId; 2],
    /// Collision-surface vertex nearest to the point, of each body that is deformable.
    pub vertices: [Option<u32>; 2],
    /// The point whose distance to the other surface the gap is, world \[m\].
    pub position_W: Vec3,
    /// Unit normal from B towards A, world.
    pub normal_W: Vec3,
    /// Gap at the start of the step, or of the last part of one made in parts \[m\], negative when
    /// penetrating.
    pub gap: f64,
    /// Mean force on A during the step, or the last part of one made in parts, world \[N\]; B feels
    /// the opposite.
    pub force_W: Vec3,
    /// Relative tangential velocity of A against B at the end of the step \[m/s\].
    pub slip_W: Vec3,
    /// Surface area the point stands for \[m²\] (zero when both bodies are rigid).
    pub area: f64,
    /// Coulomb coefficient in this step.
    pub friction: f64,
    /// True when the point bears load and friction gives all it can: it slides, or is about to.
    pub slips: bool,
}

impl ContactPoint {
    /// True when one of the bodies is deformable there: the point has an area and a pressure. Bones
    /// are rigid.
    pub fn touches_skin(&self) -> bool {
        self.bodies.iter().any(|body| matches!(body, BodyId::Soft(_)))
    }
}

/// Energies \[J\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Energy {
    /// Energy of motion, rigid and deformable \[J\].
    pub kinetic: f64,
    /// Energy of weight, zero at the world's origin \[J\].
    pub gravity: f64,
    /// Energy of flesh deformation \[J\].
    pub elastic: f64,
    /// Energy of the springs between flesh and bones \[J\].
    pub coupling: f64,
    /// Energy of joint springs and limits \[J\].
    pub joint: f64,
    /// Energy of the drives \[J\].
    pub drive: f64,
}

impl Energy {
    /// Sum of all energies \[J\].
    pub fn total(&self) -> f64 {
        self.kinetic + self.gravity + self.elastic + self.coupling + self.joint + self.drive
    }
}

/// Report on one step.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Why the chosen solver did not make this step, when it did not.
    pub failure: Option<Failure>,
    /// Another step was made instead: with the best velocities found, shortened until they bring in
    /// no energy. The next step is made by the chosen solver again.
    pub fell_back: bool,
    /// Conjugate-gradient iterations of step 2.
    pub cg_iterations: u32,
    /// Relative residual they reached; with the monolithic solver the estimated velocity error
    /// \[m/s\].
    pub cg_residual: f64,
    /// Parts in which the step was made: 1 unless contact did not carry it through. Errors and
    /// depths are then the largest of any part, iterations and sweeps the sums over all, contacts
    /// those of the last.
    pub parts: u32,
    /// Outer sweeps of the contact solver.
    pub contact_sweeps: u32,
    /// Relative residual that the sweeps reached; with the monolithic solver the estimated velocity
    /// error that contact leaves \[m/s\]: how far sweeps have moved a contact where they do not
    /// settle.
    pub contact_residual: f64,
    /// True when sweeps (or rounds) stopped at their limit short of the accuracy asked for.
    pub contact_unconverged: bool,
    /// Sweeps ended because `SolverSettings::contact_work_max` was spent; `contact_residual`
    /// estimates what that cost, mostly far too high.
    pub contact_cut_short: bool,
    /// Contact constraints, near or touching.
    pub contacts: u32,
    /// Contact constraints that carry force.
    pub contacts_active: u32,
    /// Contacts left out because there were more than the world has room for (the deepest were
    /// kept), and pairs of rigid bodies not looked at because too many are in one place.
    pub contacts_dropped: u32,
    /// Joint limits that bear load (0 where limits are springs).
    pub limits_active: u32,
    /// Deepest penetration at the end of the step, or of a part of it \[m\]: to first order, or as
    /// found there, and of thin rigid bodies on their way, where much has moved and overlaps have
    /// grown.
    pub penetration_max: f64,
    /// Largest distance between the two sides of a joint \[m\].
    pub joint_gap_max: f64,
    /// Largest misalignment of a joint's axes \[rad\].
    pub joint_misalignment_max: f64,
    /// Elements with negative volume.
    pub inverted_tets: u32,
    /// Parts of the step that were taken back and made shorter because the energy of flesh rose
    /// more than linearised forces foresaw: each was assembled and solved in vain.
    pub flesh_retries: u32,
    /// Targets that were not finite; their drives let go for the step.
    pub bad_targets: u32,
    /// The step, or a part of it, produced a number that is not finite or beyond any sense: bodies
    /// that hang together with it are where they were, at rest.
    pub non_finite: bool,
    /// So is everything else, and no time passed.
    pub taken_back: bool,
}

/// The parts of a step, for timing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Forces, assembly and step 1 (Eq. 10).
    Skeleton,
    /// Flesh assembly and step 2 (Eq. 11).
    Flesh,
    /// Collision detection.
    Detect,
    /// Contact response (Eq. 12).
    Contact,
    /// Integration and embedding of surfaces.
    Embed,
}

/// A stopwatch given by the shell; the core has no clock.
pub trait StageTimer {
    /// Called when `stage` begins (the previous one ends); `None` ends the last.
    fn begin(&mut self, stage: Option<Stage>);
}

/// No timing.
impl StageTimer for () {
    fn begin(&mut self, _: Option<Stage>) {}
}
