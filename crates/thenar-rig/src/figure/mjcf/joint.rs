//! Joints of bodies.

use super::super::link_tree::{LinkJoint, unit};
use super::classes::Styled;
use super::world::Place;
use super::{Context, RigError};
use thenar_core::Vec3;
use thenar_core::model::{AngleLimit, Axis, JointKind};
use thenar_input::quoted;

/// Kind of a joint's motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Free,
    Ball,
    Slide,
    Hinge,
}

/// The kind of a `<joint>` or `<freejoint>`.
pub(super) fn kind(styled: &Styled<'_, '_>) -> Result<Kind, RigError> {
    if styled.element.tag() == "freejoint" {
        return Ok(Kind::Free);
    }
    let kinds = [Kind::Free, Kind::Ball, Kind::Slide, Kind::Hinge];
    let word = styled.get("type").map(|a| a.one_of(&["free", "ball", "slide", "hinge"]));
    Ok(word.transpose()?.map_or(Kind::Hinge, |k| kinds[k]))
}

/// A hinge or ball joint of a body.
///
/// # Errors
/// Names the line and the joint.
pub(super) fn read(
    place: &Place<'_>,
    name: String,
    body: &str,
    context: &mut Context<'_>,
) -> Result<LinkJoint, RigError> {
    let styled = context.classes.styled(place.element, place.class)?;
    let kind = match kind(&styled)? {
        Kind::Hinge => JointKind::Hinge,
        Kind::Ball => JointKind::Ball,
        Kind::Free => {
            let (name, body) = (quoted(&name), quoted(body));
            let what = format!(
                "joint {name} frees body {body} from its parent; only the first body is free"
            );
            return Err(place.element.error(what));
        }
        Kind::Slide => {
            return Err(place.element.error(format!(
                "joint {} of body {} slides, and sliding joints are not simulated: make it a hinge, or leave it \
                 out to fix the body",
                quoted(&name),
                quoted(body)
            )));
        }
    };
    let limit = limit(&styled, context.settings.autolimits)?;
    let angle = context.settings.angle;
    let mut axis = Axis {
        stiffness: styled.amount("stiffness")?,
        damping: styled.amount("damping")?,
        ..Axis::default()
    };
    if kind == JointKind::Hinge {
        let zero = styled.number_or("ref", 0.0)? * angle;
        axis.rest_angle = styled.number_or("springref", 0.0)? * angle - zero;
        axis.limit =
            limit.map(|l| AngleLimit { min: l.min * angle - zero, max: l.max * angle - zero });
    } else if limit.is_some() {
        context.notes.ranged_balls.push(name.clone());
    }
    for passed in ["armature", "frictionloss"] {
        if styled.amount(passed)? > 0.0 {
            context.notes.attributes.insert(passed);
        }
    }
    let point_L = place.pose.point(&Vec3::from(styled.numbers_or("pos", [0.0; 3])?));
    let axis_L = place.pose.vector(&direction(&styled)?);
    Ok(LinkJoint { name, kind, point_L, axis_L, axis })
}

fn direction(styled: &Styled<'_, '_>) -> Result<Vec3, RigError> {
    let Some(attribute) = styled.get("axis") else { return Ok(Vec3::z()) };
    unit(&Vec3::from(attribute.numbers()?)).ok_or_else(|| attribute.error("of some length"))
}

/// The range of a joint in the file's unit.
fn limit(styled: &Styled<'_, '_>, auto: bool) -> Result<Option<AngleLimit>, RigError> {
    let range = styled.get("range");
    let [min, max] = range.map_or(Ok([0.0, 0.0]), |range| range.numbers())?;
    let word = styled.get("limited").map(|a| a.one_of(&["false", "true", "auto"])).transpose()?;
    let limited = match word {
        Some(0) => false,
        Some(1) => true,
        _ => auto && range.is_some() && (min, max) != (0.0, 0.0),
    };
    if !limited {
        return Ok(None);
    }
    match range {
        Some(_) if min < max => Ok(Some(AngleLimit { min, max })),
        Some(range) => Err(range.error("a smaller and a larger angle")),
        None => Err(styled.element.missing("range", "the joint is limited, so two angles")),
    }
}
