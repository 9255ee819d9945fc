//! The tip of a finger of the default hand between two steel plates: the lower is fixed, a load
//! presses the upper one down.
#![allow(dead_code)]

use thenar_core::model::{
    BodyId, CouplingKind, Digit, Drive, HandPlacement, Motion, PairRule, RigidDesc, Side,
};
use thenar_core::model::{HandModel, Skinning, WorldDesc};
use thenar_core::shape::Shape;
use thenar_core::world::{Input, StepReport, Target};
use thenar_core::{Mat3, Pose, Quat, Vec3, World};
use thenar_rig::hand::uniform_hand;

/// Half the edges of a plate \[m\]: wider than the tip, and clear of the other fingers.
pub const PLATE: Vec3 = Vec3::new(9e-3, 5e-3, 8e-3);
/// 10 mm of steel over 18 mm by 16 mm \[kg\].
const PLATE_MASS: f64 = 7850.0 * 18e-3 * 10e-3 * 16e-3;
/// Skin so near beside a plate may touch its edges \[m\].
const NEAR: f64 = 3e-3;
/// Friction that is set between the hand and the lower plate.
pub const FRICTION_BELOW: f64 = 0.4;

/// A hand with the tip of a finger at the origin, pad down, between the plates.
pub struct Press {
    pub world: World,
    pub input: Input,
    pub soft: u32,
    pub tip: u32,
    pub digit: Digit,
    pub lower: u32,
    pub upper: u32,
    /// Thickness of the bone of the tip \[m\].
    pub bone: f64,
    /// Collision vertices between the plates.
    between: Vec<usize>,
    /// Work that the load has done \[J\].
    work: f64,
    /// Energy at the start, and the most there was beyond that and the work \[J\].
    energy_start: f64,
    pub excess: f64,
}

/// Thickness of the last bone of a digit \[m\].
fn thickness(solid: &Shape) -> f64 {
    match solid {
        Shape::Compound(parts) => thickness(&parts[0].shape),
        Shape::Capsule { radius, .. } => 2.0 * radius,
        other => panic!("the bone is a {other:?}"),
    }
}

impl Press {
    /// With a hand of so many tetrahedra.
    pub fn new(digit: Digit, tets: usize, step: f64, solid_bones: bool) -> Self {
        let hand = uniform_hand(Side::Right, tets).unwrap();
        let name = format!("{}-distal", digit.name());
        let tip = hand.bones.iter().position(|b| b.name == name).unwrap();
        let middle_B = (hand.bones[tip].ends_B[0] + hand.bones[tip].ends_B[1]) / 2.0;
        let pose_MC = hand.bones[tip].pose_MB * Pose::new(middle_B, Quat::identity());
        let placement = placement(pose_MC.inverse(), solid_bones);
        let (between, [low, high]) = skin_between(&hand, &placement.pose_WM);

        let mut desc =
            WorldDesc { gravity: Vec3::zeros(), time_step: step, ..WorldDesc::default() };
        let handle = desc.add_hand(&hand, &placement);
        let clear = PLATE.y + 0.2e-3;
        let lower = desc.add_rigid(plate("lower", Motion::Prescribed, low - clear));
        let upper = desc.add_rigid(plate("upper", Motion::Dynamic, high + clear));
        let bodies = [BodyId::Soft(handle.soft), BodyId::Rigid(lower)];
        desc.pairs.push(PairRule { bodies, friction: Some(FRICTION_BELOW) });
        let world = World::new(desc).unwrap();
        let mut input = world.input();
        let palm = handle.bones.start;
        input.targets[palm as usize] = Some(Target {
            pose_WB: world.rigid_pose(palm),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        });
        Self {
            energy_start: world.energy(&input).total(),
            world,
            input,
            soft: handle.soft,
            tip: handle.bones.start + tip as u32,
            digit,
            lower,
            upper,
            bone: thickness(&hand.solids[tip].shape),
            between,
            work: 0.0,
            excess: 0.0,
        }
    }

    /// Steps for so long \[s\] with the load given at each time \[N, downwards\].
    pub fn run(&mut self, seconds: f64, load: impl Fn(f64) -> f64) -> StepReport {
        let h = self.world.time_step();
        let mut report = StepReport::default();
        for k in 1..=(seconds / h).round() as usize {
            let force = load(k as f64 * h);
            self.input.wrenches[self.upper as usize] = [Vec3::y() * -force, Vec3::zeros()];
            let before = self.world.rigid_pose(self.upper).position.y;
            report = self.world.step(&self.input, &mut ());
            assert!(!report.non_finite, "a step was taken back");
            self.work += force * (before - self.world.rigid_pose(self.upper).position.y);
            let energy = self.world.energy(&self.input).total() - self.energy_start;
            self.excess = self.excess.max(energy - self.work);
        }
        report
    }

    /// Between the plates, where they are nearest \[m\].
    pub fn opening(&self) -> f64 {
        let pose = self.world.rigid_pose(self.upper);
        let corner = |x: f64, z: f64| pose.point(&Vec3::new(x * PLATE.x, -PLATE.y, z * PLATE.z)).y;
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
        let lowest = corners.map(|(x, z)| corner(x, z)).into_iter().fold(f64::INFINITY, f64::min);
        lowest - (self.world.rigid_pose(self.lower).position.y + PLATE.y)
    }

    /// Of the tip, from pad to nail in the frame of its bone \[m\].
    pub fn thickness(&self) -> f64 {
        let pose = self.world.rigid_pose(self.tip);
        let x = self.world.collision_vertices(self.soft);
        let heights = self.between.iter().map(|i| pose.inverse_point(&x[*i]).y);
        heights.clone().fold(f64::NEG_INFINITY, f64::max) - heights.fold(f64::INFINITY, f64::min)
    }

    /// Sum of the forces on the bone of the tip \[N\].
    pub fn on_bone(&self) -> f64 {
        let bone = BodyId::Rigid(self.tip);
        let on = self.world.contacts().iter().filter(|c| c.bodies.contains(&bone));
        on.map(|c| c.force_W.norm()).sum()
    }
}

/// The collision vertices between the plates, and how high they lie in the world.
fn skin_between(hand: &HandModel, pose_WM: &Pose) -> (Vec<usize>, [f64; 2]) {
    let mut between = (Vec::new(), [f64::INFINITY, f64::NEG_INFINITY]);
    for (i, v) in hand.flesh.collision.vertices.iter().enumerate() {
        let nodes = hand.flesh.tets[v.tet as usize].iter().zip(v.weights);
        let x = pose_WM.point(&nodes.map(|(n, w)| hand.flesh.nodes[*n as usize] * w).sum());
        if x.x.abs() < PLATE.x + NEAR && x.z.abs() < PLATE.z + NEAR {
            between.0.push(i);
            between.1 = [between.1[0].min(x.y), between.1[1].max(x.y)];
        }
    }
    between
}

fn placement(pose_WM: Pose, solid_bones: bool) -> HandPlacement {
    let palm =
        Drive { stiffness: 1000.0, damping: 10.0, angular_stiffness: 10.0, angular_damping: 0.1 };
    HandPlacement {
        name: "hand".into(),
        pose_WM,
        coupling: CouplingKind::Uniform,
        coupling_stiffness: 2e9,
        coupling_damping_time: 1e-3,
        skinning: Skinning::Linear,
        root_drive: Some(palm),
        bone_drive: None,
        solid_bones,
        nails: false,
    }
}

/// A plate that a guide keeps level: its inertia is a billion times that of steel.
fn plate(name: &str, motion: Motion, y: f64) -> RigidDesc {
    RigidDesc {
        name: name.into(),
        motion,
        mass: PLATE_MASS,
        inertia: Mat3::identity() * 1e9 * PLATE_MASS * PLATE.x * PLATE.x,
        pose_WB: Pose::new(Vec3::y() * y, Quat::identity()),
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
        shape: Some(Shape::Cuboid { half: PLATE }),
        pose_BS: Pose::identity(),
        friction: 0.5,
    }
}
