//! Settings of a running scene: what can be changed while it runs, by how much, and what it does.
//!
//! A setting changes the description that the scene's world was built from; the world then goes
//! on from its present state with the changed description. What was never set stays as the scene
//! has it, body by body.

mod apply;
mod list;

use crate::format::MONOLITHIC_ONCE;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use thenar_core::model::WorldDesc;
use thenar_input::quoted;

/// A value of a setting.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum SettingValue {
    /// A number, in the setting's unit.
    Number(f64),
    /// One of the setting's choices.
    Choice(String),
}

/// Division of a range by a slider.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// Equal steps of the slider are equal differences.
    Linear,
    /// By factors.
    Log,
}

/// Values that a setting may have.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Range {
    /// A number from `min` to `max`, both included.
    Number {
        /// Smallest value.
        min: f64,
        /// Largest value.
        max: f64,
        /// For sliders.
        scale: Scale,
    },
    /// One of these words.
    Choices {
        /// The words.
        choices: Vec<&'static str>,
    },
}

/// One setting as it is now.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Setting {
    /// Name in commands.
    pub key: &'static str,
    /// Name for people.
    pub label: &'static str,
    /// Effect of a change, in plain words.
    pub help: &'static str,
    /// Heading it belongs under.
    pub group: &'static str,
    /// SI unit; empty for words, `1` for pure numbers.
    pub unit: &'static str,
    /// Present value.
    pub value: SettingValue,
    /// The scene's own value.
    pub own: SettingValue,
    /// Values that it may have.
    #[serde(flatten)]
    pub range: Range,
}

/// Why a setting was refused. Nothing has changed then.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SettingError {
    /// No setting here has this key.
    #[error("no setting {} in this scene{hint}", quoted(key))]
    Unknown {
        /// Key given.
        key: String,
        /// Suggestion of a key that may have been meant.
        hint: String,
    },
    /// The value is not one of those allowed.
    #[error("`{key}`: expected {expected}, got {got}")]
    Value {
        /// Key of the setting.
        key: &'static str,
        /// Description of the values allowed.
        expected: String,
        /// Value that was given.
        got: String,
    },
    /// The simulator refused the changed world.
    #[error("`{key}`: {cause}")]
    World {
        /// Key that is not known.
        key: String,
        /// Reason in words.
        cause: String,
    },
}

/// The present spelling of a choice, which may come in an old one.
pub(crate) fn spelled_now<'a>(key: &str, word: &'a str) -> &'a str {
    if key == "solver" && word == MONOLITHIC_ONCE { apply::MONOLITHIC } else { word }
}

/// A scene's settings.
#[derive(Clone, Debug)]
pub struct Tuning {
    /// The world as the scene describes it.
    base: WorldDesc,
    /// Bodies of the scene, by what they are.
    parts: apply::SceneBodies,
    /// Settings that were changed, by key.
    set: BTreeMap<&'static str, SettingValue>,
}

impl Tuning {
    /// Nothing set yet. `hands` are the bodies of each hand and figure.
    pub(crate) fn new(base: WorldDesc, hands: Vec<apply::HandBodies>) -> Self {
        let parts = apply::SceneBodies::new(&base, hands);
        Self { base, parts, set: BTreeMap::new() }
    }

    /// All settings that have a meaning in this scene.
    pub fn settings(&self) -> Vec<Setting> {
        list::ALL.iter().filter_map(|known| self.setting(known)).collect()
    }

    fn setting(&self, known: &list::SettingDef) -> Option<Setting> {
        let own = (known.own)(&self.base, &self.parts)?;
        Some(Setting {
            key: known.key,
            label: known.label,
            help: known.help,
            group: known.group,
            unit: known.unit,
            range: list::range_around(known, &own, &self.parts),
            value: self.set.get(known.key).cloned().unwrap_or_else(|| own.clone()),
            own,
        })
    }

    /// The description with `key` set to `value`, and the settings that lead to it.
    ///
    /// # Errors
    /// There is no such setting, or the value is out of its range.
    pub fn with(&self, key: &str, value: &SettingValue) -> Result<(Self, WorldDesc), SettingError> {
        let known = list::ALL.iter().find(|known| known.key == key);
        let found = known.and_then(|known| Some((known, self.setting(known)?)));
        let (known, setting) = found.ok_or_else(|| self.unknown(key))?;
        list::check(&setting, value)?;
        let mut tuning = self.clone();
        tuning.set.insert(known.key, value.clone());
        let desc = tuning.desc();
        Ok((tuning, desc))
    }

    /// Returns the settings that were changed, by key.
    pub(crate) fn changed(&self) -> impl Iterator<Item = (&'static str, &SettingValue)> {
        self.set.iter().map(|(key, value)| (*key, value))
    }

    /// True when exactly these are set.
    pub(crate) fn is_changed_to<'a>(
        &self,
        set: impl Iterator<Item = (&'a str, SettingValue)>,
    ) -> bool {
        set.eq(self.changed().map(|(key, value)| (key, value.clone())))
    }

    /// The description with exactly these set, and the settings that lead to it.
    ///
    /// # Errors
    /// There is no such setting, or a value is out of its range.
    pub(crate) fn changed_to<'a>(
        &self,
        set: impl Iterator<Item = (&'a str, SettingValue)>,
    ) -> Result<(Self, WorldDesc), SettingError> {
        let mut tuning = Self { set: BTreeMap::new(), ..self.clone() };
        for (key, value) in set {
            tuning = tuning.with(key, &value)?.0;
        }
        let desc = tuning.desc();
        Ok((tuning, desc))
    }

    /// The description with all that was set.
    pub fn desc(&self) -> WorldDesc {
        let mut desc = self.base.clone();
        for known in list::ALL {
            if let Some(value) = self.set.get(known.key) {
                (known.apply)(&mut desc, &self.parts, value);
            }
        }
        desc
    }

    fn unknown(&self, key: &str) -> SettingError {
        let here = self.settings();
        let hint = match crate::text::nearest(key, here.iter().map(|s| s.key)) {
            Some(near) => format!("; did you mean `{near}`?"),
            None => {
                let keys: Vec<_> = here.iter().map(|s| s.key).collect();
                format!("; there are {}", keys.join(", "))
            }
        };
        SettingError::Unknown { key: key.into(), hint }
    }
}

pub(crate) use apply::HandBodies;
