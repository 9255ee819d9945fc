//! Small worlds that several tests share.
#![allow(dead_code)]

use thenar_core::model::{
    Axis, Binding, Coupling, EmbeddedSurface, Flesh, JointDesc, JointKind, Law, Material, Motion,
    RigidDesc, Skinning, SoftDesc, Springs, SurfaceVertex, WorldDesc,
};
use thenar_core::{Mat3, Pose, Quat, Vec3};

pub fn body(name: &str, mass: f64, inertia: [f64; 3], position: Vec3) -> RigidDesc {
    RigidDesc {
        name: name.into(),
        motion: Motion::Dynamic,
        mass,
        inertia: Mat3::from_diagonal(&inertia.into()),
        pose_WB: Pose::new(position, Quat::identity()),
        velocity_W: Vec3::zeros(),
        angular_velocity_W: Vec3::zeros(),
        shape: None,
        pose_BS: Pose::identity(),
        friction: 0.5,
    }
}

/// A box of flesh with one corner at the origin; each cell is split into the six tetrahedra that
/// share the diagonal from its low to its high corner.
pub fn bar(size: Vec3, cells: [usize; 3], material: Material) -> Flesh {
    let count = cells.map(|c| c + 1);
    let index = |i: usize, j: usize, k: usize| (i + count[0] * (j + count[1] * k)) as u32;
    let mut nodes = Vec::new();
    for k in 0..count[2] {
        for j in 0..count[1] {
            for i in 0..count[0] {
                let at = [i, j, k];
                nodes.push(Vec3::from_fn(|a, _| size[a] * at[a] as f64 / cells[a] as f64));
            }
        }
    }
    let paths = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let mut tets = Vec::new();
    for k in 0..cells[2] {
        for j in 0..cells[1] {
            for i in 0..cells[0] {
                for path in paths {
                    let mut at = [i, j, k];
                    let mut tet = [index(i, j, k); 4];
                    for (step, axis) in path.iter().enumerate() {
                        at[*axis] += 1;
                        tet[step + 1] = index(at[0], at[1], at[2]);
                    }
                    let x = tet.map(|n| nodes[n as usize]);
                    if (x[1] - x[0]).cross(&(x[2] - x[0])).dot(&(x[3] - x[0])) < 0.0 {
                        tet.swap(2, 3);
                    }
                    tets.push(tet);
                }
            }
        }
    }
    let collision = boundary(&tets);
    Flesh {
        materials: vec![material; tets.len()],
        nodes,
        tets,
        relaxation: Vec::new(),
        mass_damping: 0.0,
        stiffness_damping: 0.0,
        fixed: Vec::new(),
        collision,
        friction: 0.5,
    }
}

/// Faces that belong to one tetrahedron only, as a surface whose vertices are nodes.
pub fn boundary(tets: &[[u32; 4]]) -> EmbeddedSurface {
    use std::collections::BTreeMap;
    let faces = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];
    let mut seen: BTreeMap<[u32; 3], ([u32; 3], u32)> = BTreeMap::new();
    for tet in tets {
        for face in faces {
            let nodes = face.map(|k| tet[k]);
            let mut key = nodes;
            key.sort_unstable();
            seen.entry(key).or_insert((nodes, 0)).1 += 1;
        }
    }
    let mut surface = EmbeddedSurface::default();
    let mut vertex_of: BTreeMap<u32, u32> = BTreeMap::new();
    for (nodes, count) in seen.into_values() {
        if count == 1 {
            surface.triangles.push(nodes.map(|n| {
                let next = vertex_of.len() as u32;
                *vertex_of.entry(n).or_insert(next)
            }));
        }
    }
    surface.vertices = vec![SurfaceVertex { tet: 0, weights: [0.0; 4] }; vertex_of.len()];
    for (node, vertex) in vertex_of {
        for (t, tet) in tets.iter().enumerate() {
            if let Some(k) = tet.iter().position(|&n| n == node) {
                let mut weights = [0.0; 4];
                weights[k] = 1.0;
                surface.vertices[vertex as usize] = SurfaceVertex { tet: t as u32, weights };
                break;
            }
        }
    }
    surface
}

pub const FLESH: Material =
    Material { law: Law::Corotational, young: 5e4, poisson: 0.43, density: 1050.0 };

/// A soft finger along x: two bones of 30 mm with a hinge about z, in a bar 60×16×16 mm,
/// coupled by `kappa` \[N/m⁴\]. The root bone is body 0.
pub fn finger(kappa: f64, h: f64) -> WorldDesc {
    let mut desc = WorldDesc { time_step: h, ..WorldDesc::default() };
    for i in 0..2 {
        let at = Vec3::new(0.015 + 0.03 * f64::from(i), 0.008, 0.008);
        desc.add_rigid(body(&format!("bone {i}"), 0.003, [3e-8, 2.5e-7, 2.5e-7], at));
    }
    let to_z = Quat::from_axis_angle(&Vec3::y_axis(), -std::f64::consts::FRAC_PI_2);
    desc.joints.push(JointDesc {
        name: "knuckle".into(),
        kind: JointKind::Hinge,
        parent: Some(0),
        child: 1,
        pose_PJ: Pose::new(Vec3::new(0.015, 0.0, 0.0), to_z),
        pose_CK: Pose::new(Vec3::new(-0.015, 0.0, 0.0), to_z),
        axes: [Axis { stiffness: 0.01, ..Axis::default() }, Axis::default()],
        limit_stiffness: 2.0,
        limit_damping: 1e-3,
    });
    let mut flesh = bar(Vec3::new(0.06, 0.016, 0.016), [8, 2, 2], FLESH);
    flesh.mass_damping = 1.0;
    flesh.stiffness_damping = 1e-3;
    let bindings = flesh
        .nodes
        .iter()
        .map(|x| {
            let w = ((x.x - 0.02) / 0.02).clamp(0.0, 1.0);
            Binding { bones: [0, 1], weights: [1.0 - w, w] }
        })
        .collect();
    let volume = 0.06 * 0.016 * 0.016 / flesh.nodes.len() as f64;
    desc.add_soft(SoftDesc {
        name: "finger".into(),
        coupling: Some(Coupling {
            bindings,
            springs: Springs::PerNode(vec![kappa * volume; flesh.nodes.len()]),
            damping_time: 1e-3,
            skinning: Skinning::Linear,
        }),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
    });
    desc
}
