//! Probes: what is measured, resolved to indices, and its columns.

mod bodies;
mod flesh;
mod resolve;
mod touch;

use crate::build::Built;
use crate::format::VertexWord;
use crate::math::Vec3;
use crate::session::loads::hand_loads;
use thenar_core::World;
use thenar_core::model::BodyId;
use thenar_core::readout::ContactReadout;
use thenar_core::world::{Input, StepReport};

/// One column of the probe table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name of its probe and of the component, e.g. `tip.x`.
    pub name: String,
    /// SI unit; `1` for pure numbers.
    pub unit: &'static str,
}

/// All probes of a scene.
#[derive(Debug)]
pub struct Probes {
    probes: Vec<Measure>,
    columns: Vec<Column>,
    values: Vec<f64>,
    targets: Vec<Vec3>,
    /// Readout of the world's contacts, if a probe asks for it.
    readout: Option<ContactReadout>,
}

/// A mean over nodes.
#[derive(Debug)]
struct NodeSet {
    soft: u32,
    nodes: Vec<u32>,
    /// Places of the nodes in the undeformed body at its start pose \[m\].
    rest: Vec<Vec3>,
}

/// Something measured.
#[derive(Debug)]
enum Measure {
    Pose(u32),
    Velocity(u32),
    Point(u32, Vec3),
    Joint(u32, usize),
    Energy,
    BodyEnergy(BodyId),
    Momentum(Vec<BodyId>, Option<Vec3>),
    Position(NodeSet),
    Displacement(NodeSet),
    NodeVelocity(NodeSet),
    Target(NodeSet),
    Rotation(NodeSet),
    Radius { set: NodeSet, of_target: bool, origin: Vec3, axis: Vec3 },
    Volume(u32),
    Stress { soft: u32, elements: Vec<flesh::Element>, nominal: bool },
    Contact([BodyId; 2]),
    ContactForce(BodyId),
    Vertices(u32, VertexWord),
    Fingers(usize),
    Finger { soft: u32, part: usize },
    BoneForce(u32),
    DriveForce(u32),
    Step,
}

impl Probes {
    /// The columns.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Evaluates all probes. Allocates nothing.
    pub fn evaluate(
        &mut self,
        world: &World,
        input: &Input,
        report: &StepReport,
        built: &Built,
    ) -> &[f64] {
        let Self { probes, values, targets, readout, .. } = self;
        values.clear();
        if let Some(readout) = readout {
            readout.read(world);
        }
        for probe in probes.iter() {
            match readout {
                Some(readout) if probe.needs_readout() => {
                    evaluate_touch(probe, values, world, readout)
                }
                _ => evaluate(probe, values, targets, world, input, report, built),
            }
        }
        values
    }
}

impl Measure {
    fn needs_readout(&self) -> bool {
        use Measure::{Contact, ContactForce, Finger, Vertices};
        matches!(self, Contact(_) | ContactForce(_) | Vertices(..) | Finger { .. })
    }
}

/// Evaluates what needs the contact read-out.
fn evaluate_touch(
    probe: &Measure,
    out: &mut Vec<f64>,
    world: &World,
    readout: &mut ContactReadout,
) {
    match probe {
        Measure::Contact(pair) => {
            touch::between(&readout.pair(world, *pair), out);
        }
        Measure::ContactForce(body) => touch::on_body(world, readout, *body, out),
        Measure::Vertices(soft, what) => touch::vertices(readout, *soft, *what, out),
        Measure::Finger { soft, part } => touch::finger(&readout.parts(*soft)[*part], out),
        _ => {}
    }
}

fn evaluate(
    probe: &Measure,
    out: &mut Vec<f64>,
    targets: &mut [Vec3],
    world: &World,
    input: &Input,
    report: &StepReport,
    built: &Built,
) {
    match probe {
        Measure::Pose(i) => bodies::pose(world, *i, out),
        Measure::Velocity(i) => out.extend(world.rigid_velocity(*i).iter().flat_map(|v| v.iter())),
        Measure::Point(i, point) => out.extend(world.rigid_pose(*i).point(point).iter()),
        Measure::Joint(j, axes) => bodies::joint(world, *j, *axes, out),
        Measure::Energy => bodies::energy(world, input, out),
        Measure::BodyEnergy(body) => bodies::body_energy(world, *body, input.gravity, out),
        Measure::Momentum(list, about) => bodies::momentum(world, list, *about, out),
        Measure::Position(set) => out.extend(set.mean(|k| set.place(world, k)).iter()),
        Measure::Displacement(set) => {
            out.extend(set.mean(|k| set.place(world, k) - set.rest[k]).iter());
        }
        Measure::NodeVelocity(set) => {
            let v = world.node_velocities(set.soft);
            out.extend(set.mean(|k| v[set.nodes[k] as usize]).iter());
        }
        Measure::Target(set) => {
            let targets = set.targets(world, targets);
            out.extend(set.mean(|k| targets[set.nodes[k] as usize]).iter());
        }
        Measure::Rotation(set) => out.extend(flesh::rotation(world, set).iter()),
        Measure::Radius { set, of_target, origin, axis } => {
            let x = if *of_target { set.targets(world, targets) } else { world.nodes(set.soft) };
            let away = |k: usize| (x[set.nodes[k] as usize] - origin).cross(axis).norm();
            out.push((0..set.nodes.len()).map(away).sum::<f64>() / set.nodes.len() as f64);
        }
        Measure::Volume(soft) => out.push(flesh::volume(world, *soft)),
        Measure::Stress { soft, elements, nominal } => {
            flesh::stress(world.nodes(*soft), elements, *nominal, out);
        }
        Measure::Fingers(hand) => {
            let loads = hand_loads(world, &built.hands[*hand]);
            for finger in &loads[1..] {
                out.extend(finger.figures());
            }
        }
        Measure::BoneForce(i) => {
            out.extend(world.coupling_wrench(*i).iter().flat_map(|v| v.iter()))
        }
        Measure::DriveForce(i) => {
            out.extend(world.drive_wrench(*i, input).iter().flat_map(|v| v.iter()));
        }
        Measure::Step => bodies::step(report, out),
        Measure::Contact(_)
        | Measure::ContactForce(_)
        | Measure::Vertices(..)
        | Measure::Finger { .. } => {}
    }
}

impl NodeSet {
    fn place(&self, world: &World, k: usize) -> Vec3 {
        world.nodes(self.soft)[self.nodes[k] as usize]
    }

    fn mean(&self, of: impl Fn(usize) -> Vec3) -> Vec3 {
        (0..self.nodes.len()).map(of).sum::<Vec3>() / self.nodes.len() as f64
    }

    fn targets<'a>(&self, world: &World, memory: &'a mut [Vec3]) -> &'a [Vec3] {
        let memory = &mut memory[..world.nodes(self.soft).len()];
        world.skin_targets(self.soft, memory);
        memory
    }
}
