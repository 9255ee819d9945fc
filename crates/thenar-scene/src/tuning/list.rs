//! The settings, one entry each.

use super::apply::{self, SceneBodies};
use super::{Range, Scale, Setting, SettingError, SettingValue};
use crate::text::plain;
use SettingValue::{Choice, Number};
use thenar_core::model::{Cone, SolverKind, WorldDesc};
use thenar_input::quoted;

/// A setting that scenes may have.
pub struct SettingDef {
    pub key: &'static str,
    pub label: &'static str,
    pub help: &'static str,
    pub group: &'static str,
    pub unit: &'static str,
    /// `None` for words.
    pub range: Option<(f64, f64, Scale)>,
    /// The scene's own value; `None` when the setting has no meaning in it.
    pub own: fn(&WorldDesc, &SceneBodies) -> Option<SettingValue>,
    /// Changes a description.
    pub apply: fn(&mut WorldDesc, &SceneBodies, &SettingValue),
}

/// All settings, in the order in which they are applied and shown.
pub const ALL: &[SettingDef] = &[
    SettingDef {
        key: "solver",
        label: "Solver",
        help: "Monolithic solves bones, flesh and contact together. Two-step moves the bones \
               first, then bones and flesh. With frozen flesh the first step is the paper's, which flies \
               apart unless the flesh is bound softly: lower \"Flesh on bone\" to its least first, \
               and restart afterwards. Two-step is offered for the paper's hand alone: where flesh \
               hangs on bone it gains energy.",
        group: "Solver",
        unit: "",
        range: None,
        own: |desc, _| Some(Choice(apply::solver_word(&desc.solver).into())),
        apply: |desc, parts, value| {
            if let Choice(word) = value {
                apply::set_solver(desc, parts, word);
            }
        },
    },
    SettingDef {
        key: "cone",
        label: "Friction cone",
        help: "Circular is exact: friction is equally strong in all directions. Linearised is \
               the paper's four-sided pyramid: weaker between its edges.",
        group: "Solver",
        unit: "",
        range: None,
        own: |desc, _| Some(Choice(apply::cone_word(desc.solver.cone).into())),
        apply: |desc, _, value| {
            let linearised = *value == Choice("linearised".into());
            desc.solver.cone = if linearised { Cone::Linearised } else { Cone::Circular };
        },
    },
    SettingDef {
        key: "time_step",
        label: "Time step",
        help: "Simulated time per step. Shorter steps are more exact and cost more computing \
               per second; longer ones damp motion more.",
        group: "Solver",
        unit: "s",
        range: Some((1e-3, 1.0 / 30.0, Scale::Log)),
        own: |desc, _| Some(Number(desc.time_step)),
        apply: |desc, _, value| number(value, |h| desc.time_step = h),
    },
    SettingDef {
        key: "gravity",
        label: "Gravity",
        help: "How strongly everything is pulled down. 9.81 is the Earth's, 0 is free floating.",
        group: "World",
        unit: "m/s²",
        range: Some((0.0, 20.0, Scale::Linear)),
        own: |desc, _| Some(Number(desc.gravity.norm())),
        apply: |desc, _, value| number(value, |g| apply::set_gravity(desc, g)),
    },
    SettingDef {
        key: "friction",
        label: "Friction",
        help: "Sideways force that a contact holds, as a part of the force that presses it. More \
               grips better, 0 is ice. One value for everything that touches; until it is \
               changed each pair has the scene's own.",
        group: "World",
        unit: "1",
        range: Some((0.0, 2.0, Scale::Linear)),
        own: |desc, parts| {
            let soft = parts.flesh().next().or(parts.objects.first().copied());
            let soft = soft.map(|i| desc.softs[i].flesh.friction);
            let rigid = parts.rigids.iter().find(|i| desc.rigids[**i].shape.is_some());
            soft.or(rigid.map(|i| desc.rigids[*i].friction)).map(Number)
        },
        apply: |desc, _, value| number(value, |mu| apply::set_friction(desc, mu)),
    },
    SettingDef {
        key: "hand_young",
        label: "Flesh stiffness",
        help: "Young's modulus of the hand's flesh. Softer flesh bulges and wraps around what \
               it touches; stiffer flesh is more like rubber.",
        group: "Hand",
        unit: "Pa",
        range: Some((5e3, 1e6, Scale::Log)),
        own: |desc, parts| Some(Number(apply::largest(desc, parts.flesh().next()?, |m| m.young))),
        apply: |desc, parts, value| {
            number(value, |e| parts.flesh().for_each(|soft| apply::set_young(desc, soft, e)));
        },
    },
    SettingDef {
        key: "hand_poisson",
        label: "Flesh incompressibility",
        help: "Poisson's ratio of the hand's flesh. Near 0.5 it keeps its volume: what is \
               pressed in comes out beside. At 0 it is squeezed like a sponge.",
        group: "Hand",
        unit: "1",
        range: Some((0.0, 0.49, Scale::Linear)),
        own: |desc, parts| Some(Number(apply::largest(desc, parts.flesh().next()?, |m| m.poisson))),
        apply: |desc, parts, value| {
            number(value, |nu| parts.flesh().for_each(|soft| apply::set_poisson(desc, soft, nu)));
        },
    },
    SettingDef {
        key: "coupling_stiffness",
        label: "Flesh on bone",
        help: "Springs between flesh and bones, per volume of what they hold. Soft springs let \
               flesh slide around the bones, stiff ones glue it to them. At 1e9 N/m⁴ each cubic \
               centimetre is pulled back by 1 N for every millimetre that it is off its place.",
        group: "Hand",
        unit: "N/m⁴",
        range: Some((1e7, 1e13, Scale::Log)),
        own: |desc, parts| apply::coupling(desc, parts).filter(|k| *k > 0.0).map(Number),
        apply: |desc, parts, value| number(value, |k| apply::set_coupling(desc, parts, k)),
    },
    SettingDef {
        key: "drive_stiffness",
        label: "Strength",
        help: "How strongly the hand is pulled to where it is tracked, relative to the scene's \
               own. A stronger hand follows more closely and presses harder.",
        group: "Hand",
        unit: "1",
        range: Some((0.1, 20.0, Scale::Log)),
        own: |desc, parts| {
            let mut bones = parts.hands.iter().flat_map(|hand| hand.bones.clone());
            bones.any(|bone| desc.drives[bone].is_some()).then_some(Number(1.0))
        },
        apply: |desc, parts, value| number(value, |f| apply::scale_drives(desc, parts, f)),
    },
    SettingDef {
        key: "flesh_damping",
        label: "Damping",
        help: "How quickly soft bodies stop wobbling: stiffness-proportional damping of hands and \
               soft objects. 0 wobbles long, more is like dough.",
        group: "Soft bodies",
        unit: "s",
        range: Some((0.0, 0.05, Scale::Linear)),
        own: |desc, parts| {
            let soft = parts.flesh().next().or(parts.objects.first().copied())?;
            Some(Number(desc.softs[soft].flesh.stiffness_damping))
        },
        apply: |desc, _, value| {
            number(value, |d| {
                desc.softs.iter_mut().for_each(|soft| soft.flesh.stiffness_damping = d);
            });
        },
    },
    SettingDef {
        key: "object_young",
        label: "Object stiffness",
        help: "Young's modulus of the soft object, of its stiffest part. Bread is near 10 kPa, \
               rubber near 1 MPa.",
        group: "Object",
        unit: "Pa",
        range: Some((1e3, 1e6, Scale::Log)),
        own: |desc, parts| Some(Number(apply::largest(desc, *parts.objects.first()?, |m| m.young))),
        apply: |desc, parts, value| {
            number(value, |e| parts.objects.iter().for_each(|i| apply::set_young(desc, *i, e)));
        },
    },
    SettingDef {
        key: "object_poisson",
        label: "Object incompressibility",
        help: "Poisson's ratio of the soft object: 0 is squeezed like a sponge, near 0.5 it keeps \
               its volume.",
        group: "Object",
        unit: "1",
        range: Some((0.0, 0.49, Scale::Linear)),
        own: |desc, parts| {
            Some(Number(apply::largest(desc, *parts.objects.first()?, |m| m.poisson)))
        },
        apply: |desc, parts, value| {
            number(value, |nu| parts.objects.iter().for_each(|i| apply::set_poisson(desc, *i, nu)));
        },
    },
    SettingDef {
        key: "object_mass",
        label: "Object mass",
        help: "Mass of the rigid object (of several: of the heaviest, the others in proportion). \
               A heavier object is harder to lift and to stop.",
        group: "Object",
        unit: "kg",
        range: Some((1e-3, 5.0, Scale::Log)),
        own: |desc, parts| apply::heaviest(desc, parts).map(Number),
        apply: |desc, parts, value| number(value, |m| apply::set_mass(desc, parts, m)),
    },
];

fn number(value: &SettingValue, then: impl FnOnce(f64)) {
    if let Number(x) = value {
        then(*x);
    }
}

/// The range of a setting, wide enough for the scene's own value.
pub fn range_around(known: &SettingDef, own: &SettingValue, parts: &SceneBodies) -> Range {
    match (known.range, own) {
        (Some((min, max, scale)), Number(own)) => {
            Range::Number { min: min.min(*own), max: max.max(*own), scale }
        }
        _ if known.key == "cone" => Range::Choices { choices: vec!["circular", "linearised"] },
        _ => {
            let mut choices = vec![apply::MONOLITHIC];
            // The two-step scheme gains energy with springs in bone.
            let on_bone = parts.hands.iter().any(|hand| hand.on_bone);
            if !on_bone || parts.solver.kind == SolverKind::TwoStep {
                choices.extend([apply::TWO_STEP, apply::FROZEN]);
            }
            Range::Choices { choices }
        }
    }
}

/// Refuses a value out of range.
pub fn check(setting: &Setting, value: &SettingValue) -> Result<(), SettingError> {
    let got = match value {
        Number(x) => plain(*x),
        Choice(word) => quoted(word),
    };
    let (fits, expected) = match (&setting.range, value) {
        (Range::Number { min, max, .. }, value) => {
            let inside = matches!(value, Number(x) if (*min..=*max).contains(x));
            let unit = if setting.unit == "1" { "" } else { setting.unit };
            let expected = format!("{} to {} {unit}", plain(*min), plain(*max));
            (inside, expected.trim_end().to_string())
        }
        (Range::Choices { choices }, value) => {
            let inside = matches!(value, Choice(word) if choices.contains(&word.as_str()));
            (inside, format!("one of \"{}\"", choices.join("\", \"")))
        }
    };
    match fits {
        true => Ok(()),
        false => Err(SettingError::Value { key: setting.key, expected, got }),
    }
}
