//! Geoms of bodies.

use super::super::link_tree::{Body, LinkSolid, of_shape, unit, y_to_z};
use super::classes::Styled;
use super::place::{pose_of_styled, z_to};
use super::world::Place;
use super::{Context, RigError};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat, Vec3};
use thenar_input::quoted;

/// Density of what gives none \[kg/m³\].
const DENSITY: f64 = 1000.0;
/// Types of geoms as they are written.
const TYPES: [&str; 9] =
    ["sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "plane", "hfield", "sdf"];

/// Role of a geom in contact and in mass.
#[derive(Clone, Copy, Debug)]
pub(super) struct Role {
    /// True where others touch the geom.
    pub touches: bool,
    /// True where mass or density is given.
    pub stated: bool,
    /// True where the geom has mass.
    pub heavy: bool,
}

/// Returns the role of a geom, by its attributes alone.
pub(super) fn role(place: &Place<'_>, context: &Context<'_>) -> Result<Role, RigError> {
    let styled = context.classes.styled(place.element, place.class)?;
    let touches =
        styled.number_or("contype", 1.0)? != 0.0 || styled.number_or("conaffinity", 1.0)? != 0.0;
    let group = styled.number_or("group", 0.0)?;
    let [first, last] = context.settings.mass_groups;
    let counts = (first..=last).contains(&group);
    let given = ["mass", "density"].map(|name| styled.get(name).is_some());
    let nothing = match styled.get("mass") {
        Some(_) => styled.amount("mass")? == 0.0,
        None => styled.get("density").is_some() && styled.amount("density")? == 0.0,
    };
    Ok(Role { touches, stated: counts && given.contains(&true), heavy: counts && !nothing })
}

/// The solid of a geom and its mass; none where it is zero.
///
/// # Errors
/// Names the line, the geom and its body.
pub(super) fn read(
    place: &Place<'_>,
    role: Role,
    body: &str,
    context: &mut Context<'_>,
) -> Result<(LinkSolid, Option<Body>), RigError> {
    let styled = context.classes.styled(place.element, place.class)?;
    let word = styled.get("type").map(|a| a.one_of(&TYPES)).transpose()?;
    let kind = TYPES[word.unwrap_or(0)];
    let (solid, unit_mass) = match kind {
        "plane" | "hfield" | "sdf" => {
            let name = place.element.get("name").map_or("", |name| name.value);
            let (name, body) = (quoted(name), quoted(body));
            return Err(place.element.error(format!(
                "geom {name} of body {body} is a {kind}, which no bone can have: use a box or a mesh"
            )));
        }
        "mesh" => {
            let Some(mesh) = styled.get("mesh") else {
                return Err(place.element.missing("mesh", "the name of a mesh"));
            };
            let (path, change) = context.assets.mesh(
                place.element,
                mesh.name()?,
                &context.classes,
                &context.settings,
            )?;
            let solid = context.meshes.solid(&path, &change)?;
            let pose_LF = place.pose * pose_of_styled(&styled, &context.settings)?;
            let link_solid = LinkSolid { shape: solid.shape, pose_LS: pose_LF * solid.pose_FS };
            (link_solid, solid.body.moved(&pose_LF))
        }
        _ if styled.get("mesh").is_some() => {
            let what = format!("a {kind} fitted to a mesh is not read: give its size instead");
            return Err(place.element.error(what));
        }
        _ => {
            let (shape, pose) = primitive(&styled, kind, context)?;
            let pose_LS = place.pose * pose;
            let Some(unit_mass) = of_shape(&shape) else {
                return Err(place.element.error("the shape has no mass"));
            };
            (LinkSolid { shape, pose_LS }, unit_mass.moved(&pose_LS))
        }
    };
    let mass = match styled.get("mass") {
        Some(_) => styled.amount("mass")?,
        None => match styled.get("density") {
            Some(_) => styled.amount("density")? * unit_mass.mass,
            None => DENSITY * unit_mass.mass,
        },
    };
    Ok((solid, (role.heavy && mass > 0.0).then(|| unit_mass.with_mass(mass))))
}

/// A shape and its pose in the body.
fn primitive(
    styled: &Styled<'_, '_>,
    kind: &str,
    context: &Context<'_>,
) -> Result<(Shape, Pose), RigError> {
    let needed = match kind {
        "sphere" => 1,
        "capsule" | "cylinder" => 2,
        _ => 3,
    };
    let Some(size) = styled.get("size") else {
        return Err(styled.element.missing("size", "positive lengths"));
    };
    // A sphere's further numbers mean nothing.
    let mut sizes = size.list(3)?;
    let pose = match ends(styled, kind)? {
        Some((pose, half_length)) => {
            sizes.truncate(1);
            sizes.resize(needed - 1, sizes.first().copied().unwrap_or(0.0));
            sizes.push(half_length);
            pose
        }
        None => pose_of_styled(styled, &context.settings)?,
    };
    sizes.truncate(needed);
    if sizes.len() < needed || sizes.iter().any(|&s| s <= 0.0) {
        return Err(size.error(&format!("{needed} positive lengths for a {kind}")));
    }
    let [x, y, z] = [0, 1, 2].map(|k| sizes.get(k).copied().unwrap_or(0.0));
    let half = Vec3::new(x, y, z);
    let (shape, turn) = match kind {
        "sphere" => (Shape::Sphere { radius: x }, Quat::identity()),
        "capsule" => (Shape::Capsule { radius: x, half_length: y }, y_to_z()),
        "cylinder" => (Shape::Cylinder { radius: x, half_length: y }, y_to_z()),
        "ellipsoid" => (Shape::Ellipsoid { half }, Quat::identity()),
        _ => (Shape::Cuboid { half }, Quat::identity()),
    };
    Ok((shape, pose * Pose::new(Vec3::zeros(), turn)))
}

/// The pose and half the length of a geom that is given by its ends, along its z.
fn ends(styled: &Styled<'_, '_>, kind: &str) -> Result<Option<(Pose, f64)>, RigError> {
    let Some(attribute) = styled.get("fromto") else { return Ok(None) };
    if kind == "sphere" {
        let what = "fromto is for a capsule, cylinder, ellipsoid or box, not for a sphere";
        return Err(styled.element.error(what));
    }
    let [a, b, c, d, e, f] = attribute.numbers::<6>()?;
    let (from, to) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
    let along = unit(&(from - to)).ok_or_else(|| attribute.error("two different points"))?;
    let pose = Pose::new((from + to) * 0.5, z_to(&along));
    Ok(Some((pose, (from - to).norm() * 0.5)))
}
