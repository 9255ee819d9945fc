//! The shipped hand as all engines can express it, as a model of Thenar's own: the simplification
//! of `peers/hand.py`, so that Thenar's Python package has the very hand that jobs have.

use std::collections::BTreeMap;
use thenar_core::Vec3;
use thenar_core::model::{
    AngleLimit, Binding, Digit, EmbeddedSurface, HandModel, JointKind, Law, Material, SurfaceVertex,
};

/// As of `peers/hand.py`: Young's modulus \[Pa\], Poisson's ratio, damping of stiffness \[s\],
/// friction.
const YOUNG: f64 = 50e3;
const POISSON: f64 = 0.43;
const STIFFNESS_DAMPING: f64 = 1e-3;
const FRICTION: f64 = 0.6;
/// A node nearer to the middle between two bones than this is left free.
const WEIGHT_TIED: f64 = 0.75;

/// One material; every node tied to one bone or to none; joints without limits, whose springs are
/// relaxed as the hand was built; the boundary of the tetrahedra touches.
pub fn simplified(mut hand: HandModel) -> HandModel {
    let flesh = &mut hand.flesh;
    let volumes: Vec<f64> = flesh
        .tets
        .iter()
        .map(|tet| {
            let [a, b, c, d] = tet.map(|n| flesh.nodes[n as usize]);
            (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
        })
        .collect();
    let mass: f64 = volumes.iter().zip(&flesh.materials).map(|(v, m)| v * m.density).sum();
    let density = mass / volumes.iter().sum::<f64>();
    let material = Material { law: Law::Corotational, young: YOUNG, poisson: POISSON, density };
    flesh.materials.fill(material);
    flesh.relaxation.clear();
    flesh.mass_damping = 0.0;
    flesh.stiffness_damping = STIFFNESS_DAMPING;
    flesh.friction = FRICTION;
    flesh.collision = boundary(&flesh.nodes, &flesh.tets);
    hand.collision_digits = vec![Digit::Palm; flesh.collision.vertices.len()];
    hand.regions.clear();
    hand.solids.clear();
    for (binding, volume) in hand.bindings.iter_mut().zip(&mut hand.node_volumes) {
        let Binding { bones: [a, b], weights: [first, second] } = *binding;
        let (bone, weight) = if first >= second { (a, first) } else { (b, second) };
        let weight = if a == b { first + second } else { weight };
        *binding = Binding { bones: [bone; 2], weights: [1.0, 0.0] };
        if weight < WEIGHT_TIED {
            *volume = 0.0;
        }
    }
    for joint in &mut hand.joints {
        let [parent, child] = [joint.parent.unwrap_or(0), joint.child].map(|b| b as usize);
        let [parent, child] = [parent, child].map(|b| hand.bones[b].pose_MB.rotation);
        let turn = (parent * joint.pose_PJ.rotation).inverse() * child * joint.pose_CK.rotation;
        let (x, y, z) = (turn * Vec3::x(), turn * Vec3::y(), turn * Vec3::z());
        // Rx(a) of a hinge; Ry(a) Rx(b) takes x to (cos a, 0, -sin a).
        let angles = match joint.kind {
            JointKind::Hinge => [y.z.atan2(y.y), 0.0],
            _ => [(-x.z).atan2(x.x), (-z.y).atan2(y.y)],
        };
        for (axis, angle) in joint.axes.iter_mut().zip(angles) {
            axis.limit = None::<AngleLimit>;
            axis.rest_angle = angle;
        }
    }
    hand
}

/// Faces of one tetrahedron only, outward.
fn boundary(nodes: &[Vec3], tets: &[[u32; 4]]) -> EmbeddedSurface {
    let mut faces: BTreeMap<[u32; 3], Vec<[u32; 3]>> = BTreeMap::new();
    let mut order = Vec::new();
    for [a, b, c, d] in tets {
        for face in [[*a, *c, *b], [*a, *b, *d], [*a, *d, *c], [*b, *c, *d]] {
            let mut key = face;
            key.sort_unstable();
            faces.entry(key).or_insert_with(|| {
                order.push(key);
                Vec::new()
            });
            faces.entry(key).or_default().push(face);
        }
    }
    let mut numbers = vec![None; nodes.len()];
    let mut vertices = Vec::new();
    let mut number = |node: u32| {
        *numbers[node as usize].get_or_insert_with(|| {
            vertices.push(at_node(tets, node));
            vertices.len() as u32 - 1
        })
    };
    let single = order.iter().filter_map(|key| match faces[key].as_slice() {
        [face] => Some(*face),
        _ => None,
    });
    let triangles = single.map(|face| face.map(&mut number)).collect();
    EmbeddedSurface { vertices, triangles }
}

/// The node itself, as a place in one of its tetrahedra.
fn at_node(tets: &[[u32; 4]], node: u32) -> SurfaceVertex {
    let corner = |tet: &[u32; 4]| tet.iter().position(|n| *n == node);
    let found = tets.iter().enumerate().find_map(|(t, tet)| Some((t, corner(tet)?)));
    let (tet, corner) = found.expect("a node of a face belongs to a tetrahedron");
    let weights = std::array::from_fn(|k| f64::from(u8::from(k == corner)));
    SurfaceVertex { tet: tet as u32, weights }
}
