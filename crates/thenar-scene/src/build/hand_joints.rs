//! Settings that a scene gives single joints of a hand.

use super::solver::set;
use crate::format::{HandAxis, HandJoint, HandJointsFile, JointName};
use crate::motion::{Anatomy, Articulation};
use crate::text::{Fault, Located, Node, SceneError, parse};
use std::path::Path;
use thenar_core::model::{AngleLimit, Axis, HandModel};

/// Largest file of joints \[bytes\].
const BYTES_MAX: u64 = 1 << 20;

/// Changes the joints of a hand as a file of `[[joint]]` tables says, which are those of a scene's
/// `[[hand.joint]]`.
///
/// # Errors
/// The file cannot be read, or something in it is wrong; says what and where.
pub fn change_by_file(model: &mut HandModel, file: &Path) -> Result<(), SceneError> {
    let text = thenar_input::read_text(file, BYTES_MAX)
        .map_err(|e| SceneError::File { file: file.to_path_buf(), problem: e.to_string() })?;
    let changed = Node::parse(&text)
        .and_then(|root| parse::<HandJointsFile>(&root))
        .and_then(|tables| change(model, &tables.joint));
    changed.map_err(|fault| fault.locate(file, &text, &[]))
}

/// Changes the joints of a hand as a scene says, table after table.
///
/// # Errors
/// No joint fits a name, a joint has no such axis, or a range is empty or does not hold the rest
/// pose, in which the hand starts.
pub fn change(model: &mut HandModel, tables: &[HandJoint]) -> Result<(), Fault> {
    let Some(first) = tables.first() else { return Ok(()) };
    let anatomy = Anatomy::of(model);
    let articulation =
        Articulation::new(model).map_err(|e| first.name.fault(format!("the model's {e}")))?;
    for table in tables {
        let found = joints_like(&anatomy, &table.name)?;
        let turns_aside = |j: &usize| anatomy.roles[*j].spread.is_some();
        if let Some(change) = table.abduction.as_ref().filter(|_| !found.iter().any(turns_aside)) {
            let problem = format!("\"{}\" flexes and has no abduction", table.name.value.0);
            return Err(change.fault(problem));
        }
        for j in found {
            let (role, rest) = (&anatomy.roles[j], &articulation.rest_angles[j]);
            let axes = &mut model.joints[j].axes;
            if let (Some(to), Some((k, sense))) = (&table.flexion, role.flexion) {
                change_axis(&mut axes[k], to, sense, rest[k], &role.joint)?;
            }
            // Abduction counts as the model's own angle does.
            if let (Some(to), Some((k, _))) = (&table.abduction, role.spread) {
                change_axis(&mut axes[k], &to.value, 1.0, rest[k], &role.joint)?;
            }
        }
    }
    Ok(())
}

/// The joints that fit a name; with a `*` at the end, all that begin so.
fn joints_like(anatomy: &Anatomy, name: &Located<JointName>) -> Result<Vec<usize>, Fault> {
    let wanted = &name.value.0;
    let fits = |known: &str| match wanted.strip_suffix('*') {
        Some(start) => known.starts_with(start),
        None => known == wanted,
    };
    let roles = anatomy.roles.iter().enumerate();
    let found: Vec<usize> =
        roles.filter(|(_, role)| fits(&role.joint) || fits(&role.bone)).map(|(j, _)| j).collect();
    if found.is_empty() {
        let known: Vec<&str> = anatomy.roles.iter().map(|role| role.joint.as_str()).collect();
        let problem = format!("the hand has no joint \"{wanted}\"; it has {}", known.join(", "));
        return Err(name.fault(problem));
    }
    Ok(found)
}

/// Changes one axis. `rest` is the angle of the model's rest pose \[rad\]; `sense` is -1 where the
/// axis's angles count the other way than the table's.
fn change_axis(
    axis: &mut Axis,
    change: &HandAxis,
    sense: f64,
    rest: f64,
    joint: &str,
) -> Result<(), Fault> {
    if let Some(range) = &change.range_deg {
        let [low, high] = range.value;
        let at_rest = (sense * rest).to_degrees();
        let within = low < high && low <= at_rest && at_rest <= high;
        if !within {
            return Err(range.fault(format!(
                "expected [smallest, largest] around the rest pose of \"{joint}\", {at_rest:.1}°, \
                 got [{low}, {high}]"
            )));
        }
        let [a, b] = [low, high].map(|degrees| sense * degrees.to_radians());
        axis.limit = Some(AngleLimit { min: a.min(b), max: a.max(b) });
    }
    set(&mut axis.stiffness, change.stiffness);
    set(&mut axis.damping, change.damping);
    set(&mut axis.rest_angle, change.rest_deg.map(|degrees| sense * degrees.to_radians()));
    Ok(())
}
