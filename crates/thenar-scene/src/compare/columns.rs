//! A moment as a row of a table, in SI units.

use super::{Bodies, Moment, Object, SIDES};
use crate::session::{Column, PARTS};

/// Columns of a comparison. Those without a solver's name are differences.
pub fn columns(bodies: &Bodies) -> Vec<Column> {
    let mut columns = Vec::new();
    let mut add = |name: String, unit| columns.push(Column { name, unit });
    if !bodies.bones.is_empty() {
        for (what, unit) in [("position", "m"), ("rotation", "rad")] {
            add(format!("bones.{what}_mean"), unit);
            add(format!("bones.{what}_max"), unit);
        }
    }
    if !bodies.driven.is_empty() {
        add("drives.force_mean".into(), "N");
        add("drives.force_max".into(), "N");
    }
    for (object, name) in bodies.objects.iter().zip(&bodies.object_names) {
        add(format!("{name}.position"), "m");
        if matches!(object, Object::Rigid(_)) {
            add(format!("{name}.rotation"), "rad");
        }
    }
    for side in SIDES {
        add(format!("{side}.joint_gap"), "m");
        add(format!("{side}.joint_misalignment"), "rad");
        add(format!("{side}.penetration"), "m");
        add(format!("{side}.contacts"), "1");
        add(format!("{side}.energy"), "J");
        for hand in &bodies.hand_names {
            for part in PARTS {
                add(format!("{side}.{hand}.{}.normal", part.name()), "N");
                add(format!("{side}.{hand}.{}.shear", part.name()), "N");
            }
        }
    }
    columns
}

/// The numbers of a moment, in the order of [`columns`].
pub fn row(moment: &Moment, bodies: &Bodies, out: &mut Vec<f64>) {
    const NONE: f64 = f64::NAN;
    let mut apart = |apart: Option<super::Deviation>, there: bool| {
        if there {
            out.extend(apart.map_or([NONE; 2], |a| [a.mean, a.max]));
        }
    };
    apart(moment.position, !bodies.bones.is_empty());
    apart(moment.rotation, !bodies.bones.is_empty());
    apart(moment.drive_force, !bodies.driven.is_empty());
    for (object, apart) in bodies.objects.iter().zip(&moment.objects) {
        let [position, rotation] = apart.unwrap_or([NONE; 2]);
        out.push(position);
        if matches!(object, Object::Rigid(_)) {
            out.push(rotation);
        }
    }
    for side in &moment.sides {
        let Some(side) = side else {
            let numbers = 5 + 2 * PARTS.len() * bodies.hands.len();
            out.extend(std::iter::repeat_n(NONE, numbers));
            continue;
        };
        let contacts = f64::from(side.contacts);
        let (gap, turn) = (side.joint_gap, side.joint_misalignment);
        out.extend([gap, turn, side.penetration, contacts, side.energy]);
        out.extend(side.loads.iter().flatten().flat_map(|load| [load.normal, load.shear]));
    }
}
