//! A hand taken out of a scene, with all that refers to it.

use crate::format::{Load, Probe, Scene};
use crate::text::Located;

/// Removes the hand `name`, and probes, pairs, loads, bonds and joints that need it. Lists that
/// name other things too keep those.
pub fn hand(scene: &mut Scene, name: &str) {
    scene.hand.retain(|hand| hand.name.value != name);
    let gone = Removal { name, parts: format!("{name}/") };
    let known: Vec<String> = names(scene);
    scene.probe.retain_mut(|probe| gone.keeps_probe(probe, &known));
    scene.load.retain_mut(|load| gone.keeps_load(load, &known));
    scene.pair.retain(|pair| !pair.bodies.iter().any(|body| gone.means(body)));
    scene.joint.retain(|joint| {
        !gone.means(&joint.child) && !joint.parent.as_ref().is_some_and(|p| gone.means(p))
    });
    for other in &mut scene.hand {
        other.grip.retain(|grip| !grip.value.object.as_ref().is_some_and(|name| gone.means(name)));
    }
    for soft in &mut scene.soft {
        soft.bind.retain(|bind| !bind.bones.value.iter().any(|bone| gone.is_part(bone)));
    }
}

/// Beginnings of all names that are left.
fn names(scene: &Scene) -> Vec<String> {
    let rigids = scene.rigid.iter().map(|rigid| rigid.name.value.clone());
    let joints = scene.joint.iter().map(|joint| joint.name.value.clone());
    let hands = scene.hand.iter().map(|hand| format!("{}/", hand.name.value));
    rigids.chain(joints).chain(hands).collect()
}

struct Removal<'a> {
    name: &'a str,
    /// Prefix of the names of its bones and joints.
    parts: String,
}

impl Removal<'_> {
    fn is_part(&self, name: &str) -> bool {
        name == self.name || name.starts_with(&self.parts)
    }

    fn means(&self, name: &Located<String>) -> bool {
        self.is_part(&name.value)
    }

    /// Takes its names out of a list; false when nothing is left.
    fn thin(&self, list: &mut Located<Vec<String>>, known: &[String]) -> bool {
        list.value.retain(|name| match name.strip_suffix('*') {
            None => !self.is_part(name),
            Some(start) => {
                let met_it = self.parts.starts_with(start) || start.starts_with(&self.parts);
                !met_it || known.iter().any(|k| k.starts_with(start))
            }
        });
        !list.value.is_empty()
    }

    fn keeps_probe(&self, probe: &mut Probe, known: &[String]) -> bool {
        match probe {
            Probe::Pose(p) | Probe::Velocity(p) | Probe::BodyEnergy(p) | Probe::Volume(p) => {
                !self.means(&p.body)
            }
            Probe::BoneForce(p) | Probe::DriveForce(p) | Probe::ContactForce(p) => {
                !self.means(&p.body)
            }
            Probe::Vertices(p) => !self.means(&p.body),
            Probe::Finger(p) => !self.means(&p.hand),
            Probe::Point(p) => !self.means(&p.body),
            Probe::Joint(p) => !self.means(&p.joint),
            Probe::Nodes(p) | Probe::Rotation(p) => !self.means(&p.body),
            Probe::Radius(p) => !self.means(&p.body),
            Probe::Stress(p) => !self.means(&p.body),
            Probe::Contact(p) => !p.bodies.iter().any(|body| self.means(body)),
            Probe::Fingers(p) => !self.means(&p.hand),
            Probe::Momentum(p) => p.bodies.as_mut().is_none_or(|list| self.thin(list, known)),
            Probe::Energy(_) | Probe::Step(_) => true,
        }
    }

    fn keeps_load(&self, load: &mut Load, known: &[String]) -> bool {
        match load {
            Load::Force(l) => !self.means(&l.body),
            Load::Torque(l) => !self.means(&l.body),
            Load::JointTorque(l) => self.thin(&mut l.joints, known),
            Load::NodeForce(l) => !self.means(&l.body),
            Load::Traction(l) => !self.means(&l.body),
            Load::Pressure(l) => !self.means(&l.body),
            Load::Twist(l) => !self.means(&l.body),
        }
    }
}
