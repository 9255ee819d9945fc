//! Places and turns, in any of the ways in which they may be written.

use super::super::link_tree::{SHORT, frame_of, unit};
use super::super::xml::Attribute;
use super::classes::Styled;
use super::settings::Settings;
use super::{Element, RigError};
use nalgebra::{Quaternion, UnitVector3};
use thenar_core::{Pose, Quat, Vec3};

/// Ways to write a turn besides the quaternion, which gives way to them.
const TURNS: [&str; 4] = ["axisangle", "xyaxes", "zaxis", "euler"];

/// The pose of a body or a frame in the frame around.
pub(super) fn pose_of(element: Element<'_>, settings: &Settings) -> Result<Pose, RigError> {
    let position = Vec3::from(element.numbers::<3>("pos")?.unwrap_or_default());
    let turn = turn(element, settings, &|name| element.get(name))?;
    Ok(Pose::new(position, turn.unwrap_or_default()))
}

/// The pose of a geom in its body, which its class may give.
pub(super) fn pose_of_styled(
    styled: &Styled<'_, '_>,
    settings: &Settings,
) -> Result<Pose, RigError> {
    let position = Vec3::from(styled.numbers_or("pos", [0.0; 3])?);
    let own = turn(styled.element, settings, &|name| styled.element.get(name))?;
    let turned = match own {
        Some(own) => own,
        None => turn(styled.element, settings, &|name| styled.of_class(name))?.unwrap_or_default(),
    };
    Ok(Pose::new(position, turned))
}

/// The turn that attributes give, if any does.
fn turn<'a>(
    element: Element<'_>,
    settings: &Settings,
    get: &dyn Fn(&str) -> Option<Attribute<'a>>,
) -> Result<Option<Quat>, RigError> {
    let given: Vec<Attribute<'a>> = TURNS.iter().filter_map(|name| get(name)).collect();
    match given[..] {
        [] => get("quat").map(quaternion).transpose(),
        [one] => of_attribute(one, settings).map(Some),
        [one, other, ..] => {
            let what = format!("{} and {} are both given: keep one", one.name, other.name);
            Err(element.error(what))
        }
    }
}

fn of_attribute(attribute: Attribute<'_>, settings: &Settings) -> Result<Quat, RigError> {
    match attribute.name {
        "axisangle" => {
            let [x, y, z, angle] = attribute.numbers::<4>()?;
            let axis =
                unit(&Vec3::new(x, y, z)).ok_or_else(|| attribute.error("of some length"))?;
            Ok(about(&axis, angle * settings.angle))
        }
        "xyaxes" => {
            let [a, b, c, d, e, f] = attribute.numbers::<6>()?;
            axes(&Vec3::new(a, b, c), &Vec3::new(d, e, f))
                .ok_or_else(|| attribute.error("two vectors in different directions"))
        }
        "zaxis" => {
            let z = unit(&Vec3::from(attribute.numbers::<3>()?));
            z.map(|z| z_to(&z)).ok_or_else(|| attribute.error("of some length"))
        }
        _ => {
            let angles = attribute.numbers::<3>()?.map(|angle| angle * settings.angle);
            let mut turn = Quat::identity();
            for (angle, (axis, moving)) in angles.into_iter().zip(settings.euler) {
                let step = about(&axis, angle);
                turn = if moving { turn * step } else { step * turn };
            }
            Ok(turn)
        }
    }
}

/// A turn about a unit vector.
fn about(axis: &Vec3, angle: f64) -> Quat {
    Quat::from_axis_angle(&UnitVector3::new_unchecked(*axis), angle)
}

/// The quaternion of an attribute: w, x, y, z, of any length.
pub(super) fn quaternion(attribute: Attribute<'_>) -> Result<Quat, RigError> {
    let [w, x, y, z] = attribute.numbers::<4>()?;
    let length = (w * w + x * x + y * y + z * z).sqrt();
    if length.is_finite() && length > SHORT {
        return Ok(Quat::from_quaternion(Quaternion::new(w, x, y, z)));
    }
    Err(attribute.error("of some length"))
}

/// The frame of this x, and of a y that is made perpendicular.
fn axes(x: &Vec3, y: &Vec3) -> Option<Quat> {
    let x = unit(x)?;
    let y = unit(&(y - x * x.dot(y)))?;
    Some(frame_of(&x, &y))
}

/// The least turn from z to a unit vector; half a turn about x to -z.
pub(super) fn z_to(to: &Vec3) -> Quat {
    Quat::rotation_between(&Vec3::z(), to)
        .unwrap_or_else(|| Quat::from_axis_angle(&Vec3::x_axis(), std::f64::consts::PI))
}
