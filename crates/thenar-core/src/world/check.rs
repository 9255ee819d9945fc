//! Checks of a description before anything is built from it.

use crate::contact::{MeshShape, PlacedShape, Shape};
use crate::math::{Mat3, Quat, is_turn, to_turn};
use crate::model::{
    BodyId, BodyParts, ElementPatches, FrictionTable, JointDesc, Law, Motion, OGDEN_ALPHA,
    PATCH_TETS_MAX, RigidDesc, SoftDesc, SolverSettings, WorldDesc,
};
use crate::world::{HALVINGS_MAX, ModelError, freedoms};
use std::sync::Arc;

mod pose_offsets;
mod skin;

/// Gravity stays below this along each axis \[m/s²\].
pub const GRAVITY_MAX: f64 = 1e4;

/// The largest coordinate or size accepted \[m\].
const EXTENT_MAX: f64 = 1e4;

/// Shortest time step \[s\]: a part of 1e-9 of a shock that is over in a millisecond. Forces are
/// impulses over it, which stay finite.
const TIME_STEP_MIN: f64 = 1e-12;

/// True for a time step that can be used \[s\].
pub fn is_time_step(h: f64) -> bool {
    (TIME_STEP_MIN..=10.0).contains(&h)
}

/// Brings rotations of another length to one: those of files in single precision are off by 1e-7,
/// and normals would be by twice as much. One without a length stays, and is refused by [`check`].
pub fn normalize_rotations(desc: &mut WorldDesc) {
    let right = |rotation: &mut Quat| *rotation = to_turn(rotation).unwrap_or(*rotation);
    for rigid in &mut desc.rigids {
        right(&mut rigid.pose_WB.rotation);
        right(&mut rigid.pose_BS.rotation);
        if let Some(Shape::Compound(parts)) = &mut rigid.shape
            && !parts.iter().all(|part| is_turn(&part.pose_SP.rotation))
        {
            let parts = Arc::make_mut(parts);
            parts.iter_mut().for_each(|part| right(&mut part.pose_SP.rotation));
        }
    }
    for joint in &mut desc.joints {
        right(&mut joint.pose_PJ.rotation);
        right(&mut joint.pose_CK.rotation);
    }
}

/// Returns the first fault found.
pub fn check(desc: &WorldDesc) -> Result<(), ModelError> {
    number("world", "time step", "from 1e-12 to 10 s", desc.time_step, is_time_step)?;
    for x in desc.gravity.iter() {
        number("world", "gravity", "finite and below 1e4 m/s²", *x, |x| x.abs() < GRAVITY_MAX)?;
    }
    if desc.drives.len() != desc.rigids.len() {
        return Err(ModelError::Count {
            thing: "world".into(),
            what: "drives",
            expected: desc.rigids.len(),
            got: desc.drives.len(),
        });
    }
    settings(&desc.solver)?;
    for rigid in &desc.rigids {
        check_rigid(rigid)?;
    }
    for (drive, rigid) in desc.drives.iter().zip(&desc.rigids) {
        if let Some(d) = drive {
            for value in [d.stiffness, d.damping, d.angular_stiffness, d.angular_damping] {
                not_negative(&rigid.name, "drive", value)?;
            }
        }
    }
    for joint in &desc.joints {
        check_joint(joint, desc)?;
    }
    for soft in &desc.softs {
        check_soft(soft, desc)?;
    }
    desc.friction_tables.iter().try_for_each(|table| check_table(table, desc))?;
    desc.parts.iter().try_for_each(|parts| check_parts(parts, desc))?;
    desc.patches.iter().try_for_each(|patches| check_patches(patches, desc))?;
    desc.skins.iter().try_for_each(|skin| skin::check(skin, desc))?;
    desc.pose_offsets.iter().try_for_each(|given| pose_offsets::check(given, desc))?;
    check_pairs(desc)?;
    freedoms::check(desc)
}

fn check_body(body: BodyId, thing: &str, desc: &WorldDesc) -> Result<(), ModelError> {
    let (i, count) = match body {
        BodyId::Rigid(i) => (i, desc.rigids.len()),
        BodyId::Soft(i) => (i, desc.softs.len()),
    };
    index(thing, "body", u64::from(i), count)
}

fn check_pairs(desc: &WorldDesc) -> Result<(), ModelError> {
    for rule in &desc.pairs {
        for body in rule.bodies {
            check_body(body, "pair", desc)?;
        }
        not_negative("pair", "friction", rule.friction.unwrap_or(0.0))?;
    }
    Ok(())
}

fn check_table(table: &FrictionTable, desc: &WorldDesc) -> Result<(), ModelError> {
    for body in table.bodies {
        check_body(body, "friction table", desc)?;
    }
    let points = table.points.len() as f64;
    number("friction table", "number of points", "at least 1", points, |n| n >= 1.0)?;
    let mut before = f64::NEG_INFINITY;
    for [load, mu] in &table.points {
        let rises = |x: f64| x >= 0.0 && x > before && x.is_finite();
        number("friction table", "load", "not negative and rising [N]", *load, rises)?;
        before = *load;
        not_negative("friction table", "coefficient", *mu)?;
    }
    Ok(())
}

fn check_parts(parts: &BodyParts, desc: &WorldDesc) -> Result<(), ModelError> {
    index("parts", "deformable body", u64::from(parts.soft), desc.softs.len())?;
    let soft = &desc.softs[parts.soft as usize];
    if !parts.vertices.is_empty() {
        let vertices = soft.flesh.collision.vertices.len();
        count(&soft.name, "parts of vertices", vertices, parts.vertices.len())?;
    }
    for (bone, _) in &parts.bones {
        index(&soft.name, "bone of a part", u64::from(*bone), desc.rigids.len())?;
    }
    let lists = desc.parts.iter().filter(|other| other.soft == parts.soft).count();
    count(&soft.name, "lists of parts", 1, lists)
}

fn check_patches(patches: &ElementPatches, desc: &WorldDesc) -> Result<(), ModelError> {
    index("patches", "deformable body", u64::from(patches.soft), desc.softs.len())?;
    let SoftDesc { name, flesh, .. } = &desc.softs[patches.soft as usize];
    count(name, "patches of tetrahedra", flesh.tets.len(), patches.of_tet.len())?;
    let lists = desc.patches.iter().filter(|other| other.soft == patches.soft).count();
    count(name, "lists of patches", 1, lists)?;
    let mut of_patch: Vec<(u32, usize)> = patches.of_tet.iter().copied().zip(0..).collect();
    of_patch.sort_unstable();
    for (number, members) in of_patch.chunk_by(|a, b| a.0 == b.0).enumerate() {
        self::number(
            name,
            "numbers of patches",
            "0, 1, 2, ... without gaps",
            f64::from(members[0].0),
            |x| x == number as f64,
        )?;
        let expected = "at most 8";
        self::number(name, "tetrahedra of a patch", expected, members.len() as f64, |x| {
            x <= PATCH_TETS_MAX as f64
        })?;
        let law = |t: usize| flesh.materials[t].law;
        let others = members.iter().filter(|&&(_, t)| law(t) != law(members[0].1)).count();
        self::number(name, "laws of a patch", "one", 1.0 + others as f64, |x| x == 1.0)?;
        let relaxation = |t: usize| flesh.relaxation.get(t);
        let alike = |&&(_, t): &&(u32, usize)| relaxation(t) == relaxation(members[0].1);
        let others = members.len() - members.iter().filter(alike).count();
        self::number(name, "relaxations of a patch", "one", 1.0 + others as f64, |x| x == 1.0)?;
    }
    Ok(())
}

/// Returns the first setting of the solvers that is out of range.
pub fn settings(s: &SolverSettings) -> Result<(), ModelError> {
    for (what, value) in
        [("cg_tolerance", s.cg_tolerance), ("contact_tolerance", s.contact_tolerance)]
    {
        number("solver", what, "positive and below 1", value, |x| x > 0.0 && x < 1.0)?;
    }
    number("solver", "velocity_tolerance", "positive [m/s]", s.velocity_tolerance, |x| {
        x > 0.0 && x <= 1.0
    })?;
    not_negative("solver", "contact_margin", s.contact_margin)?;
    for (what, value) in [
        ("cg_iterations_max", s.cg_iterations_max),
        ("contact_sweeps_max", s.contact_sweeps_max),
        ("contact_inner_passes", s.contact_inner_passes),
    ] {
        number("solver", what, "at least 1", f64::from(value), |x| x >= 1.0)?;
    }
    let halvings = f64::from(s.step_halvings_max);
    number("solver", "step_halvings_max", "at most 10", halvings, |x| x <= f64::from(HALVINGS_MAX))
}

fn check_rigid(rigid: &RigidDesc) -> Result<(), ModelError> {
    let name = &rigid.name;
    for x in rigid.pose_WB.position.iter() {
        number(name, "position", "within 1e4 m", *x, |x| x.abs() <= EXTENT_MAX)?;
    }
    let all = rigid.pose_WB.rotation.coords.iter().chain(rigid.pose_BS.position.iter());
    let all = all.chain(rigid.pose_BS.rotation.coords.iter());
    for x in all.chain(rigid.velocity_W.iter()).chain(rigid.angular_velocity_W.iter()) {
        number(name, "pose or velocity", "finite", *x, f64::is_finite)?;
    }
    turns(name, &rigid.pose_WB.rotation)?;
    turns(name, &rigid.pose_BS.rotation)?;
    not_negative(name, "friction", rigid.friction)?;
    if let Some(shape) = &rigid.shape {
        check_shape(name, shape)?;
    }
    if rigid.motion == Motion::Prescribed {
        return Ok(());
    }
    number(name, "mass", "positive and finite [kg]", rigid.mass, |x| x > 0.0 && x < 1e9)?;
    let asymmetry = (rigid.inertia - rigid.inertia.transpose()).norm();
    let largest = rigid.inertia.norm();
    number(name, "inertia asymmetry", "0", asymmetry, |x| x <= 1e-9 * largest)?;
    let smallest = smallest_eigenvalue(&rigid.inertia);
    number(name, "smallest principal inertia", "positive [kg m²]", smallest, |x| x > 0.0)?;
    if matches!(rigid.shape, Some(Shape::HalfSpace)) {
        return Err(ModelError::MovingPlane { thing: name.clone() });
    }
    Ok(())
}

fn turns(name: &str, rotation: &Quat) -> Result<(), ModelError> {
    let is_one = |_| to_turn(rotation).is_some();
    number(name, "rotation's length", "not 0", rotation.coords.norm(), is_one)
}

fn smallest_eigenvalue(m: &Mat3) -> f64 {
    if m.iter().all(|x| x.is_finite()) { m.symmetric_eigenvalues().min() } else { f64::NAN }
}

fn check_shape(name: &str, shape: &Shape) -> Result<(), ModelError> {
    let size = |what, value| {
        number(name, what, "positive and at most 1e4 m", value, |x| x > 0.0 && x <= EXTENT_MAX)
    };
    match shape {
        Shape::Sphere { radius } => size("radius", *radius),
        Shape::Capsule { radius, half_length } => {
            size("radius", *radius)?;
            not_negative(name, "half length", *half_length)
        }
        Shape::Cuboid { half } => half.iter().try_for_each(|&x| size("half edge", x)),
        Shape::HalfSpace => Ok(()),
        Shape::Mesh(mesh) => check_mesh(name, mesh),
        Shape::Cylinder { radius, half_length } => {
            size("radius", *radius)?;
            size("half length", *half_length)
        }
        Shape::Ellipsoid { half } => half.iter().try_for_each(|&x| size("half axis", x)),
        Shape::Cone { radius, height } => {
            size("radius", *radius)?;
            size("height", *height)
        }
        Shape::Compound(parts) => check_compound(name, parts),
    }
}

fn check_compound(name: &str, parts: &[PlacedShape]) -> Result<(), ModelError> {
    number(name, "number of parts", "at least 1", parts.len() as f64, |n| n >= 1.0)?;
    for part in parts {
        let nested = matches!(part.shape, Shape::HalfSpace | Shape::Compound(_));
        number(
            name,
            "planes and compounds among its parts",
            "0",
            f64::from(u8::from(nested)),
            |n| n == 0.0,
        )?;
        let finite = if part.pose_SP.is_finite() { 0.0 } else { f64::NAN };
        number(name, "place of a part", "finite", finite, f64::is_finite)?;
        turns(name, &part.pose_SP.rotation)?;
        check_shape(name, &part.shape)?;
    }
    Ok(())
}

fn check_mesh(name: &str, mesh: &MeshShape) -> Result<(), ModelError> {
    let grid = &mesh.grid;
    for x in mesh.points.iter().chain([&grid.origin]).flat_map(|p| p.iter()) {
        number(name, "mesh point", "within 1e4 m", *x, |x| x.abs() <= EXTENT_MAX)?;
    }
    for corner in mesh.triangles.iter().flatten() {
        index(name, "mesh point", u64::from(*corner), mesh.points.len())?;
    }
    number(name, "grid spacing", "positive", grid.cell, |x| x > 0.0 && x <= EXTENT_MAX)?;
    for n in grid.dims {
        number(name, "grid size", "at least 2", f64::from(n), |n| n >= 2.0)?;
    }
    let values: f64 = grid.dims.iter().map(|&n| f64::from(n)).product();
    number(
        name,
        "number of grid values",
        "the product of its sizes",
        grid.values.len() as f64,
        |n| n == values,
    )?;
    let bad = grid.values.iter().find(|v| !v.is_finite());
    number(name, "grid value", "finite", bad.map_or(0.0, |v| f64::from(*v)), f64::is_finite)
}

fn check_joint(joint: &JointDesc, desc: &WorldDesc) -> Result<(), ModelError> {
    let name = &joint.name;
    for body in joint.parent.into_iter().chain([joint.child]) {
        index(name, "body", u64::from(body), desc.rigids.len())?;
    }
    if joint.parent == Some(joint.child) {
        return Err(ModelError::SelfJoint { thing: name.clone() });
    }
    for pose in [&joint.pose_PJ, &joint.pose_CK] {
        number(
            name,
            "frame",
            "finite",
            if pose.is_finite() { 0.0 } else { f64::NAN },
            f64::is_finite,
        )?;
        turns(name, &pose.rotation)?;
    }
    not_negative(name, "limit stiffness", joint.limit_stiffness)?;
    not_negative(name, "limit damping", joint.limit_damping)?;
    for axis in &joint.axes {
        not_negative(name, "stiffness", axis.stiffness)?;
        not_negative(name, "damping", axis.damping)?;
        number(name, "rest angle", "finite", axis.rest_angle, f64::is_finite)?;
        if let Some(limit) = axis.limit {
            number(name, "limit range", "max ≥ min", limit.max - limit.min, |x| x >= 0.0)?;
        }
    }
    Ok(())
}

fn check_soft(soft: &SoftDesc, desc: &WorldDesc) -> Result<(), ModelError> {
    let (name, flesh) = (&soft.name, &soft.flesh);
    let nodes = flesh.nodes.len();
    count(name, "materials", flesh.tets.len(), flesh.materials.len())?;
    number(name, "number of tetrahedra", "at least 1", flesh.tets.len() as f64, |x| x >= 1.0)?;
    for x in flesh.nodes.iter().flat_map(|x| x.iter()) {
        number(name, "node position", "within 1e4 m", *x, |x| x.abs() <= EXTENT_MAX)?;
    }
    number(
        name,
        "pose",
        "finite",
        if soft.pose_WM.is_finite() { 0.0 } else { f64::NAN },
        f64::is_finite,
    )?;
    for x in soft.velocity_W.iter() {
        number(name, "velocity", "finite", *x, |x| x.is_finite())?;
    }
    for value in [flesh.mass_damping, flesh.stiffness_damping, flesh.friction] {
        not_negative(name, "damping or friction", value)?;
    }
    for material in &flesh.materials {
        number(name, "Young's modulus", "positive [Pa]", material.young, |x| x > 0.0 && x < 1e13)?;
        number(name, "Poisson's ratio", "above -1 and below 0.5", material.poisson, |x| {
            x > -1.0 && x < 0.5
        })?;
        if let Law::Ogden { alpha } = material.law {
            let [least, most] = OGDEN_ALPHA;
            let fits = |x: f64| (least..=most).contains(&x);
            let range =
                "from 4 to 20 (2 is neo-Hookean; below 4 crushed tissue could stay crushed)";
            number(name, "Ogden's exponent", range, alpha, fits)?;
            let range = "at least 0 with Ogden's law, or crushed tissue could stay crushed";
            number(name, "Poisson's ratio", range, material.poisson, |x| x >= 0.0)?;
        }
        number(name, "density", "positive [kg/m³]", material.density, |x| x > 0.0 && x < 1e6)?;
    }
    if !flesh.relaxation.is_empty() {
        count(name, "relaxations", flesh.tets.len(), flesh.relaxation.len())?;
    }
    for node in flesh.tets.iter().flatten() {
        index(name, "node", u64::from(*node), nodes)?;
    }
    for fixed in &flesh.fixed {
        index(name, "fixed node", u64::from(fixed.node), nodes)?;
    }
    for vertex in &flesh.collision.vertices {
        index(name, "surface tetrahedron", u64::from(vertex.tet), flesh.tets.len())?;
        number(name, "surface weights' sum", "1", vertex.weights.iter().sum(), |x| {
            (x - 1.0).abs() < 1e-6
        })?;
    }
    for vertex in flesh.collision.triangles.iter().flatten() {
        index(name, "surface vertex", u64::from(*vertex), flesh.collision.vertices.len())?;
    }
    check_coupling(soft, desc)
}

fn check_coupling(soft: &SoftDesc, desc: &WorldDesc) -> Result<(), ModelError> {
    let (name, Some(coupling)) = (&soft.name, &soft.coupling) else { return Ok(()) };
    count(name, "bindings", soft.flesh.nodes.len(), coupling.bindings.len())?;
    count(
        name,
        "coupling stiffnesses",
        soft.flesh.nodes.len(),
        coupling.springs.stiffness().len(),
    )?;
    not_negative(name, "coupling damping time", coupling.damping_time)?;
    for k in coupling.springs.stiffness() {
        not_negative(name, "coupling stiffness", k)?;
    }
    for (node, binding) in coupling.bindings.iter().enumerate() {
        for bone in binding.bones {
            index(name, "bone", u64::from(bone), desc.rigids.len())?;
        }
        let weights = binding.weights;
        let sum_is_one = (weights[0] + weights[1] - 1.0).abs() <= 1e-9;
        if !(sum_is_one && weights[0] >= 0.0 && weights[1] >= 0.0) {
            return Err(ModelError::Weights { thing: name.clone(), node, weights });
        }
    }
    Ok(())
}

fn number(
    thing: &str,
    what: &'static str,
    expected: &'static str,
    got: f64,
    ok: impl Fn(f64) -> bool,
) -> Result<(), ModelError> {
    if ok(got) {
        return Ok(());
    }
    Err(ModelError::Value { thing: thing.into(), what, expected, got })
}

fn not_negative(thing: &str, what: &'static str, got: f64) -> Result<(), ModelError> {
    number(thing, what, "finite and not negative", got, |x| x >= 0.0 && x.is_finite())
}

fn index(thing: &str, what: &'static str, index: u64, count: usize) -> Result<(), ModelError> {
    if index < count as u64 {
        return Ok(());
    }
    Err(ModelError::Index { thing: thing.into(), what, index, count })
}

fn count(thing: &str, what: &'static str, expected: usize, got: usize) -> Result<(), ModelError> {
    if expected == got {
        return Ok(());
    }
    Err(ModelError::Count { thing: thing.into(), what, expected, got })
}
