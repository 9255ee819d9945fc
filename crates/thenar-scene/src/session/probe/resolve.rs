//! From the tables of probes to what is measured.

use super::flesh::Element;
use super::{Column, Measure, NodeSet, Probes};
use crate::build::Built;
use crate::format::{
    ContactProbe, DigitWord, FingerProbe, NodesProbe, Probe, ProbeHand, ProbeMomentum,
    QuantityWord, RadiusProbe, Scene, Selector, StressProbe, StressWord, VertexWord, VerticesProbe,
};
use crate::math::Vec3;
use crate::session::HandLoad;
use crate::text::{Fault, Located};
use thenar_core::World;
use thenar_core::kernels::RestTet;
use thenar_core::model::{BodyId, Digit};
use thenar_core::readout::ContactReadout;

/// Names of components and their unit.
type Parts = Vec<(String, &'static str)>;

fn parts(names: &[&str], unit: &'static str) -> Parts {
    names.iter().map(|n| ((*n).to_string(), unit)).collect()
}

const XYZ: [&str; 3] = ["x", "y", "z"];

impl Probes {
    /// Resolves the probes of a scene.
    ///
    /// # Errors
    /// A probe's name is taken, or it names nothing that exists.
    pub fn new(scene: &Scene, built: &Built, world: &World) -> Result<Self, Fault> {
        let nodes = built.world.softs.iter().map(|s| s.flesh.nodes.len()).max().unwrap_or(0);
        let mut probes = Self {
            probes: Vec::new(),
            columns: Vec::new(),
            values: Vec::new(),
            targets: vec![Vec3::zeros(); nodes],
            readout: None,
        };
        let mut names: Vec<&str> = Vec::new();
        for probe in &scene.probe {
            let (name, measure, parts) = resolve(probe, built, world)?;
            if names.contains(&name.value.as_str()) {
                return Err(name.fault(format!("another probe is named \"{}\"", name.value)));
            }
            if name.value.contains([',', '"', '\n']) {
                return Err(name.fault("expected a name without commas, quotes and line ends"));
            }
            names.push(&name.value);
            probes.probes.push(measure);
            probes.columns.extend(
                parts
                    .into_iter()
                    .map(|(part, unit)| Column { name: format!("{}.{part}", name.value), unit }),
            );
        }
        if probes.probes.iter().any(Measure::needs_readout) {
            probes.readout = Some(ContactReadout::new(world));
        }
        probes.values.reserve(probes.columns.len());
        Ok(probes)
    }
}

fn resolve<'a>(
    probe: &'a Probe,
    built: &Built,
    world: &World,
) -> Result<(&'a Located<String>, Measure, Parts), Fault> {
    let names = &built.names;
    let both = |a: Parts, b: Parts| a.into_iter().chain(b).collect::<Parts>();
    Ok(match probe {
        Probe::Pose(p) => {
            let columns = both(parts(&XYZ, "m"), parts(&["qx", "qy", "qz", "qw"], "1"));
            (&p.name, Measure::Pose(names.rigid(&p.body)?), columns)
        }
        Probe::Velocity(p) => {
            let columns =
                both(parts(&["vx", "vy", "vz"], "m/s"), parts(&["wx", "wy", "wz"], "rad/s"));
            (&p.name, Measure::Velocity(names.rigid(&p.body)?), columns)
        }
        Probe::Point(p) => {
            (&p.name, Measure::Point(names.rigid(&p.body)?, p.point), parts(&XYZ, "m"))
        }
        Probe::Joint(p) => {
            let joint = names.joint(&p.joint)?;
            let axes = built.world.joints[joint as usize].kind.angles();
            let angle = |k: usize| [(format!("angle{k}"), "rad"), (format!("rate{k}"), "rad/s")];
            let angles: Parts = (0..axes).flat_map(angle).collect();
            let errors = vec![("gap".into(), "m"), ("misalignment".into(), "rad")];
            let torque = |k: usize| (format!("limit_torque{k}"), "N m");
            let torques: Parts = (0..axes).map(torque).collect();
            (&p.name, Measure::Joint(joint, axes), both(angles, both(errors, torques)))
        }
        Probe::Energy(p) => {
            let kinds = ["kinetic", "gravity", "elastic", "coupling", "joint", "drive", "total"];
            (&p.name, Measure::Energy, parts(&kinds, "J"))
        }
        Probe::BodyEnergy(p) => {
            let body = names.body(&p.body)?;
            (&p.name, Measure::BodyEnergy(body), parts(&["kinetic", "gravity"], "J"))
        }
        Probe::Momentum(p) => (
            &p.name,
            momentum(p, built)?,
            both(parts(&["px", "py", "pz"], "kg m/s"), parts(&["lx", "ly", "lz"], "kg m²/s")),
        ),
        Probe::Nodes(p) => {
            let set = nodes(&p.body, p.nodes.as_ref(), built)?;
            let unit = if p.quantity == QuantityWord::Velocity { "m/s" } else { "m" };
            let measure = match p.quantity {
                QuantityWord::Position => Measure::Position(set),
                QuantityWord::Displacement => Measure::Displacement(set),
                QuantityWord::Velocity => Measure::NodeVelocity(set),
                QuantityWord::Target => Measure::Target(set),
            };
            (&p.name, measure, parts(&XYZ, unit))
        }
        Probe::Rotation(p) => (&p.name, rotation(p, built)?, parts(&["rx", "ry", "rz"], "rad")),
        Probe::Radius(p) => (&p.name, radius(p, built)?, parts(&["mean"], "m")),
        Probe::Volume(p) => {
            (&p.name, Measure::Volume(names.soft(&p.body)?), parts(&["volume"], "m³"))
        }
        Probe::Stress(p) => (&p.name, stress(p, built, world)?, stress_parts(p.stress)),
        Probe::Contact(p) => (
            &p.name,
            contact(p, built)?,
            [
                parts(&["fx", "fy", "fz", "normal", "shear"], "N"),
                parts(&["area"], "m²"),
                parts(&["cx", "cy", "cz", "penetration"], "m"),
                parts(&["points"], "1"),
                slip_parts(),
                parts(&["normal_sum", "shear_sum"], "N"),
                parts(&["pressure_mean"], "Pa"),
            ]
            .concat(),
        ),
        Probe::ContactForce(p) => {
            (&p.name, Measure::ContactForce(names.body(&p.body)?), wrench_parts())
        }
        Probe::Vertices(p) => {
            let soft = names.soft(&p.body)?;
            let surface = &built.world.softs[soft as usize].flesh.collision;
            let columns = vertex_parts(p, surface.vertices.len());
            (&p.name, Measure::Vertices(soft, p.quantity), columns)
        }
        Probe::Finger(p) => (&p.name, finger(p, built)?, one_finger_parts()),
        Probe::Fingers(p) => (&p.name, fingers(p, built)?, finger_parts()),
        Probe::BoneForce(p) => (&p.name, Measure::BoneForce(names.rigid(&p.body)?), wrench_parts()),
        Probe::DriveForce(p) => {
            let body = names.rigid(&p.body)?;
            if built.world.drives[body as usize].is_none() {
                return Err(p.body.fault(format!("\"{}\" has no drive", p.body.value)));
            }
            (&p.name, Measure::DriveForce(body), wrench_parts())
        }
        Probe::Step(p) => (&p.name, Measure::Step, step_parts()),
    })
}

fn wrench_parts() -> Parts {
    [parts(&["fx", "fy", "fz"], "N"), parts(&["tx", "ty", "tz"], "N m")].concat()
}

fn slip_parts() -> Parts {
    [parts(&["pressure_max"], "Pa"), parts(&["slip"], "m/s"), parts(&["slipping", "state"], "1")]
        .concat()
}

fn one_finger_parts() -> Parts {
    [
        parts(&["fx", "fy", "fz", "normal", "shear"], "N"),
        parts(&["tx", "ty", "tz"], "N m"),
        parts(&["cx", "cy", "cz"], "m"),
        parts(&["area"], "m²"),
        slip_parts(),
        parts(&["bone_fx", "bone_fy", "bone_fz"], "N"),
        parts(&["bone_tx", "bone_ty", "bone_tz"], "N m"),
        parts(&["shear_sum"], "N"),
        parts(&["pressure_mean"], "Pa"),
    ]
    .concat()
}

fn vertex_parts(p: &VerticesProbe, count: usize) -> Parts {
    let unit = match p.quantity {
        VertexWord::Pressure => "Pa",
        VertexWord::Force => "N",
        VertexWord::Slip => "m/s",
        VertexWord::State => "1",
        VertexWord::Area => "m²",
    };
    let columns = |v: usize| match p.quantity {
        VertexWord::Force => XYZ.map(|axis| format!("{v}.{axis}")).to_vec(),
        _ => vec![v.to_string()],
    };
    (0..count).flat_map(columns).map(|name| (name, unit)).collect()
}

fn step_parts() -> Parts {
    [
        parts(&["cg_iterations", "cg_residual", "contact_sweeps", "contact_residual"], "1"),
        parts(&["contacts", "contacts_active", "inverted_tets", "non_finite"], "1"),
        parts(&["penetration_max", "joint_gap_max"], "m"),
        parts(&["joint_misalignment_max"], "rad"),
    ]
    .concat()
}

fn finger_parts() -> Parts {
    let of = |d: &Digit| {
        HandLoad::FIGURES.map(|(figure, unit)| (format!("{}.{figure}", d.name()), unit))
    };
    Digit::FINGERS.iter().flat_map(of).collect()
}

fn stress_parts(stress: StressWord) -> Parts {
    let names: &[&str] = match stress {
        StressWord::Cauchy => &["xx", "yy", "zz", "xy", "yz", "zx", "von_mises", "spread"],
        StressWord::Nominal => &["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz", "spread"],
    };
    parts(names, "Pa")
}

fn momentum(p: &ProbeMomentum, built: &Built) -> Result<Measure, Fault> {
    let bodies = match &p.bodies {
        Some(list) => built.names.bodies_like(list)?,
        None => {
            let rigids = (0..built.world.rigids.len() as u32).map(BodyId::Rigid);
            let softs = (0..built.world.softs.len() as u32).map(BodyId::Soft);
            rigids.chain(softs).collect()
        }
    };
    let moves = |body: &BodyId| match body {
        BodyId::Rigid(i) => {
            built.world.rigids[*i as usize].motion == thenar_core::model::Motion::Dynamic
        }
        BodyId::Soft(_) => true,
    };
    let moving: Vec<BodyId> = bodies.into_iter().filter(moves).collect();
    match moving.is_empty() {
        true => Err(p.name.fault("none of these bodies moves by forces")),
        false => Ok(Measure::Momentum(moving, p.about)),
    }
}

fn nodes(
    body: &Located<String>,
    selector: Option<&Located<Selector>>,
    built: &Built,
) -> Result<NodeSet, Fault> {
    let soft = built.names.soft(body)?;
    let mesh = &built.meshes[soft as usize];
    let pose_WM = built.world.softs[soft as usize].pose_WM;
    let nodes = mesh.select_nodes(selector)?;
    let rest = nodes.iter().map(|n| pose_WM.point(&mesh.nodes[*n as usize])).collect();
    Ok(NodeSet { soft, nodes, rest })
}

fn rotation(p: &NodesProbe, built: &Built) -> Result<Measure, Fault> {
    let set = nodes(&p.body, p.nodes.as_ref(), built)?;
    match set.nodes.len() >= 3 {
        true => Ok(Measure::Rotation(set)),
        false => Err(p.name.fault("a rotation needs at least three nodes")),
    }
}

fn radius(p: &RadiusProbe, built: &Built) -> Result<Measure, Fault> {
    let axis = p.axis.try_normalize(1e-9);
    let axis = axis.ok_or_else(|| p.name.fault("expected an `axis` that is not zero"))?;
    let of_target = match p.quantity {
        QuantityWord::Position => false,
        QuantityWord::Target => true,
        _ => return Err(p.name.fault("expected `quantity` \"position\" or \"target\"")),
    };
    let set = nodes(&p.body, p.nodes.as_ref(), built)?;
    Ok(Measure::Radius { set, of_target, origin: p.origin, axis })
}

fn stress(p: &StressProbe, built: &Built, world: &World) -> Result<Measure, Fault> {
    let soft = built.names.soft(&p.body)?;
    let mesh = &built.meshes[soft as usize];
    let flesh = &world.desc().softs[soft as usize].flesh;
    let chosen = mesh.select_tets(p.elements.as_ref())?;
    let element = |t: u32| {
        let nodes = mesh.tets[t as usize];
        let rest = nodes.map(|n| mesh.nodes[n as usize]);
        RestTet::new(&rest, &flesh.materials[t as usize]).map(|tet| Element { nodes, tet, rest })
    };
    let elements = chosen.into_iter().filter_map(element).collect();
    Ok(Measure::Stress { soft, elements, nominal: p.stress == StressWord::Nominal })
}

fn contact(p: &ContactProbe, built: &Built) -> Result<Measure, Fault> {
    Ok(Measure::Contact([built.names.body(&p.bodies[0])?, built.names.body(&p.bodies[1])?]))
}

fn finger(p: &FingerProbe, built: &Built) -> Result<Measure, Fault> {
    let hand = built.names.hand(&p.hand)? as usize;
    let digit = match p.finger {
        DigitWord::Palm => Digit::Palm,
        DigitWord::Thumb => Digit::Thumb,
        DigitWord::Index => Digit::Index,
        DigitWord::Middle => Digit::Middle,
        DigitWord::Ring => Digit::Ring,
        DigitWord::Little => Digit::Little,
    };
    let hand = &built.hands[hand];
    let Some(soft) = hand.flesh() else {
        return Err(p.hand.fault("this hand has no flesh, so its fingers touch nothing"));
    };
    match hand.model.bones.iter().any(|bone| bone.digit == digit) {
        true => Ok(Measure::Finger { soft, part: usize::from(digit.part()) }),
        false => Err(p.hand.fault(format!("this hand has no {}", digit.name()))),
    }
}

fn fingers(p: &ProbeHand, built: &Built) -> Result<Measure, Fault> {
    let hand = built.names.hand(&p.hand)? as usize;
    match built.hands[hand].flesh() {
        Some(_) => Ok(Measure::Fingers(hand)),
        None => Err(p.hand.fault("this hand has no flesh, so its fingers touch nothing")),
    }
}
