//! Loads, with nodes and faces found and directions fixed.

use super::drivers::ease;
use super::{Built, Face, place};
use crate::format::{
    Constant, InterpolationWord, JointTorqueLoad, Load, NodeForceLoad, PressureLoad, Profile,
    Scene, TractionLoad, TwistLoad,
};
use crate::math::Vec3;
use crate::session::random_at;
use crate::text::Fault;
use std::collections::BTreeMap;

/// A load ready to be applied.
#[derive(Clone, Debug)]
pub struct ActiveLoad {
    /// Load at factor 1.
    pub kind: LoadKind,
    /// Size of the load over time.
    pub factor: Factor,
}

/// Kind of a load, with size and target.
#[derive(Clone, Debug)]
pub enum LoadKind {
    /// A force at a point of a rigid body.
    Force {
        /// Rigid body.
        rigid: u32,
        /// Force, world \[N\].
        force: Vec3,
        /// Point in the body's frame \[m\].
        point: Vec3,
    },
    /// A torque on a rigid body.
    Torque {
        /// Rigid body.
        rigid: u32,
        /// Torque, world \[N m\].
        torque: Vec3,
    },
    /// Torques about joint axes.
    JointTorque {
        /// Joints and their number of axes.
        joints: Vec<(u32, usize)>,
        /// Torque about each axis \[N m\].
        torque: f64,
    },
    /// Forces on nodes that keep their direction.
    Nodes(Vec<(u32, Vec3)>),
    /// A pressure that follows the faces.
    Pressure {
        /// Node indices of faces, counter-clockwise from outside.
        faces: Vec<[u32; 3]>,
        /// Pressure \[Pa\], inwards.
        pressure: f64,
    },
}

/// A factor over time. Streams tell the random series of one load apart.
#[derive(Clone, Debug)]
pub struct Factor {
    profile: Profile,
    /// Keeps equal seeds of different loads apart.
    load: u64,
}

impl Factor {
    /// The factor at time `t` \[s\].
    pub fn at(&self, t: f64, stream: u64) -> f64 {
        // A little slack, so that the round-off of summed time steps decides nothing.
        let slack = 1e-9;
        let within = |from: f64, until: Option<f64>| {
            t >= from - slack && until.is_none_or(|end| t <= end + slack)
        };
        match &self.profile {
            Profile::Constant(p) => f64::from(u8::from(within(p.from, p.until))),
            Profile::Ramp(p) if within(p.from, p.until) => {
                let span = p.full - p.from;
                if t >= p.full || span <= 0.0 {
                    1.0
                } else {
                    ease(p.interpolation, (t - p.from) / span, span).0
                }
            }
            Profile::Sine(p) if within(p.from, p.until) => {
                (std::f64::consts::TAU * p.frequency * (t - p.from) + p.phase).sin()
            }
            Profile::Random(p) if within(p.from, p.until) => {
                let u = (t - p.from) / p.interval;
                let knot = u.floor();
                let draw = |k: f64| random_at([u64::from(p.seed), self.load, stream, k as u64]);
                let way = ease(InterpolationWord::Smooth, u - knot, 1.0).0;
                draw(knot) * (1.0 - way) + draw(knot + 1.0) * way
            }
            Profile::Keyframes(p) => {
                let (times, factors) = (&p.times.value, &p.factors.value);
                let after = times.partition_point(|time| *time <= t);
                if after == 0 || after == times.len() {
                    return factors[after.saturating_sub(usize::from(after > 0))];
                }
                let span = times[after] - times[after - 1];
                let way = ease(p.interpolation, (t - times[after - 1]) / span, span).0;
                factors[after - 1] * (1.0 - way) + factors[after] * way
            }
            _ => 0.0,
        }
    }
}

/// Adds all loads.
pub fn add_all(built: &mut Built, scene: &Scene) -> Result<(), Fault> {
    for (i, load) in scene.load.iter().enumerate() {
        let (kind, profile) = match load {
            Load::Force(l) => {
                let rigid = built.names.rigid(&l.body)?;
                (LoadKind::Force { rigid, force: l.force, point: l.point }, &l.profile)
            }
            Load::Torque(l) => {
                let rigid = built.names.rigid(&l.body)?;
                (LoadKind::Torque { rigid, torque: l.torque }, &l.profile)
            }
            Load::JointTorque(l) => (joint_torque(built, l)?, &l.profile),
            Load::NodeForce(l) => (node_forces(built, l)?, &l.profile),
            Load::Traction(l) => (traction(built, l)?, &l.profile),
            Load::Pressure(l) => (pressure(built, l)?, &l.profile),
            Load::Twist(l) => (twist(built, l)?, &l.profile),
        };
        let factor = Factor { profile: checked(profile.as_ref())?, load: i as u64 };
        built.loads.push(ActiveLoad { kind, factor });
    }
    Ok(())
}

fn checked(profile: Option<&Profile>) -> Result<Profile, Fault> {
    if let Some(Profile::Keyframes(p)) = profile {
        let times = &p.times.value;
        if times.is_empty() || times.len() != p.factors.value.len() {
            return Err(p.factors.fault(format!(
                "expected one factor for each of {} times (at least one), got {}",
                times.len(),
                p.factors.value.len()
            )));
        }
        if times.windows(2).any(|w| w[1] - w[0] < 1e-9) {
            return Err(p.times.fault("expected ascending times"));
        }
    }
    Ok(profile.cloned().unwrap_or(Profile::Constant(Constant { from: 0.0, until: None })))
}

fn joint_torque(built: &Built, load: &JointTorqueLoad) -> Result<LoadKind, Fault> {
    let joints = built.names.joints_like(&load.joints)?;
    let axes = |j: u32| built.world.joints[j as usize].kind.angles();
    let joints: Vec<_> = joints.into_iter().map(|j| (j, axes(j))).filter(|(_, n)| *n > 0).collect();
    match joints.is_empty() {
        true => Err(load.joints.fault("none of these joints has an angle to act on")),
        false => Ok(LoadKind::JointTorque { joints, torque: load.torque }),
    }
}

/// Area times outward normal \[m²\].
fn area_vector(x: &[Vec3; 3]) -> Vec3 {
    (x[1] - x[0]).cross(&(x[2] - x[0])) * 0.5
}

/// Index of a deformable body's first node among those of all.
fn first_node(built: &Built, soft: u32) -> u32 {
    built.world.softs[..soft as usize].iter().map(|s| s.flesh.nodes.len() as u32).sum()
}

fn node_forces(built: &Built, load: &NodeForceLoad) -> Result<LoadKind, Fault> {
    let soft = built.names.soft(&load.body)?;
    let first = first_node(built, soft);
    let nodes = built.meshes[soft as usize].select_nodes(Some(&load.nodes))?;
    Ok(LoadKind::Nodes(nodes.into_iter().map(|n| (n + first, load.force)).collect()))
}

/// Faces with their nodes' places at rest in the world.
fn placed_faces(
    built: &Built,
    soft: u32,
    faces: &crate::text::Located<crate::format::Selector>,
) -> Result<Vec<(Face, [Vec3; 3])>, Fault> {
    let mesh = &built.meshes[soft as usize];
    let pose_WM = built.world.softs[soft as usize].pose_WM;
    let chosen = mesh.select_faces(faces)?;
    let place = |n: u32| pose_WM.point(&mesh.nodes[n as usize]);
    Ok(chosen.into_iter().map(|f| (f, f.map(place))).collect())
}

fn traction(built: &Built, load: &TractionLoad) -> Result<LoadKind, Fault> {
    let soft = built.names.soft(&load.body)?;
    let faces = placed_faces(built, soft, &load.faces)?;
    let area: f64 = faces.iter().map(|(_, x)| area_vector(x).norm()).sum();
    let traction = match (load.total, load.traction) {
        (Some(total), None) => total / area,
        (None, Some(traction)) => traction,
        _ => return Err(load.body.fault("a traction needs either `total` or `traction`")),
    };
    let shares = faces.iter().flat_map(|(face, x)| {
        let share = traction * (area_vector(x).norm() / 3.0);
        face.map(|n| (n, share))
    });
    Ok(LoadKind::Nodes(summed(shares, first_node(built, soft))))
}

fn pressure(built: &Built, load: &PressureLoad) -> Result<LoadKind, Fault> {
    let soft = built.names.soft(&load.body)?;
    let first = first_node(built, soft);
    let faces = built.meshes[soft as usize].select_faces(&load.faces)?;
    let faces = faces.into_iter().map(|f| f.map(|n| n + first)).collect();
    Ok(LoadKind::Pressure { faces, pressure: load.pressure })
}

/// Tractions `α u × (x - c)` about the faces' centre c; linear over a face, so that a node's
/// share is `A/12 Σ_b (1 + δ_ab) t_b`.
fn twist(built: &Built, load: &TwistLoad) -> Result<LoadKind, Fault> {
    let soft = built.names.soft(&load.body)?;
    let faces = placed_faces(built, soft, &load.faces)?;
    let axis = place::direction(&load.torque)
        .ok_or_else(|| load.body.fault("expected a `torque` that is not zero"))?;
    let area = |x: &[Vec3; 3]| area_vector(x).norm();
    let total: f64 = faces.iter().map(|(_, x)| area(x)).sum();
    let centre =
        faces.iter().map(|(_, x)| (x[0] + x[1] + x[2]) * (area(x) / 3.0)).sum::<Vec3>() / total;
    let mut torque = 0.0;
    let mut shares: Vec<(u32, Vec3)> = Vec::new();
    for (face, x) in &faces {
        let t = x.map(|p| axis.cross(&(p - centre)));
        let sum = t[0] + t[1] + t[2];
        for a in 0..3 {
            let force = (sum + t[a]) * (area(x) / 12.0);
            torque += axis.dot(&(x[a] - centre).cross(&force));
            shares.push((face[a], force));
        }
    }
    if torque <= 0.0 {
        return Err(load.faces.fault("these faces lie on the axis"));
    }
    let scale = load.torque.norm() / torque;
    let shares = shares.into_iter().map(|(n, f)| (n, f * scale));
    Ok(LoadKind::Nodes(summed(shares, first_node(built, soft))))
}

fn summed(shares: impl Iterator<Item = (u32, Vec3)>, first: u32) -> Vec<(u32, Vec3)> {
    let mut sum: BTreeMap<u32, Vec3> = BTreeMap::new();
    for (node, force) in shares {
        *sum.entry(node + first).or_insert_with(Vec3::zeros) += force;
    }
    sum.into_iter().collect()
}
