//! Commands from clients, strictly read.

use super::TEXT_BYTES_MAX;
use serde::{Deserialize, Serialize};
use thenar_core::model::Side;
use thenar_input::brief;
use thenar_scene::grip::GripKind;
use thenar_scene::hands::Hands;
use thenar_scene::session::FORCE_MAX;
use thenar_scene::text::plain;
use thenar_scene::tuning::SettingValue;

/// A command.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase", deny_unknown_fields)]
pub enum Command {
    /// Take control, or give it up.
    Control {
        /// Take it.
        take: bool,
    },
    /// Pause or go on.
    Run {
        /// True to pause, false to go on.
        paused: bool,
    },
    /// One step while paused.
    Step {},
    /// Back to the start.
    Reset {},
    /// To another place of a recording.
    Seek {
        /// Time in the recording \[s\].
        time: f64,
    },
    /// Slow motion.
    Speed {
        /// Simulated over real time.
        value: f64,
    },
    /// Another scene.
    Scene {
        /// Name of the scene.
        name: String,
    },
    /// Other hands.
    Hands {
        /// Hands that are asked for.
        which: Hands,
        /// Lengths of the hands.
        #[serde(default)]
        lengths: Lengths,
    },
    /// The script moves the hands again.
    Script {},
    /// Hands grip what is under them.
    Grip {
        /// Kind of grip.
        #[serde(default)]
        kind: GripKind,
        /// Name of the object; the nearest body if none is given.
        #[serde(default)]
        object: Option<String>,
        /// With what force \[N\]; enough for the object's weight if none is given.
        #[serde(default)]
        force: Option<f64>,
        /// Side of the hand; all hands if none is given.
        #[serde(default)]
        side: Option<Side>,
    },
    /// Hands open.
    Release {
        /// Side of the hand; all hands if none is given.
        #[serde(default)]
        side: Option<Side>,
    },
    /// A setting.
    Set {
        /// Key of the setting.
        key: String,
        /// To what.
        value: SettingValue,
    },
    /// Let forces through to the devices.
    Arm {
        /// Also when this client has gone. Without it forces last while it is there and says
        /// `hold`.
        #[serde(default)]
        keep: bool,
    },
    /// The client that armed is still there.
    Hold {},
    /// No force until armed again. Anybody may say so.
    Stop {},
    /// A question whether anybody is there.
    Ping {
        /// The client's time \[s\].
        t: f64,
    },
}

/// Lengths of hands from wrist to middle fingertip \[m\]; `None` is the model's own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Lengths {
    /// Length of the left hand \[m\].
    #[serde(default)]
    pub left: Option<f64>,
    /// Length of the right hand \[m\].
    #[serde(default)]
    pub right: Option<f64>,
}

impl Command {
    /// Slowest motion.
    pub const SPEED_MIN: f64 = 0.02;

    /// Reads a text message.
    ///
    /// # Errors
    /// It is no command, or a number in it is out of range; the text says why.
    pub fn read(text: &str) -> Result<Self, String> {
        if text.len() > TEXT_BYTES_MAX {
            return Err(format!(
                "a message of {} bytes; at most {TEXT_BYTES_MAX} are taken",
                text.len()
            ));
        }
        let command: Self =
            serde_json::from_str(text).map_err(|e| brief(&format!("not a command: {e}")))?;
        command.check()?;
        Ok(command)
    }

    fn check(&self) -> Result<(), String> {
        match self {
            Self::Speed { value } if !(Self::SPEED_MIN..=1.0).contains(value) => {
                Err(format!("speed {}; expected {} to 1", plain(*value), Self::SPEED_MIN))
            }
            Self::Seek { time } if !(time.is_finite() && *time >= 0.0) => {
                Err(format!("place {}; expected 0 s or more", plain(*time)))
            }
            Self::Grip { force: Some(force), .. } if !(*force > 0.0 && *force <= FORCE_MAX) => {
                Err(format!(
                    "force {} N; expected more than 0 and at most {FORCE_MAX} N",
                    plain(*force)
                ))
            }
            Self::Hands { lengths, .. } => {
                let bad = |l: &&f64| !(HAND_MIN..=HAND_MAX).contains(*l);
                match lengths.left.iter().chain(&lengths.right).find(bad) {
                    Some(l) => Err(format!(
                        "a hand {} m long; expected {HAND_MIN} to {HAND_MAX} m from wrist to middle \
                         fingertip",
                        plain(*l)
                    )),
                    None => Ok(()),
                }
            }
            _ => Ok(()),
        }
    }
}

/// Shortest hand \[m\].
const HAND_MIN: f64 = 0.08;
/// Longest hand \[m\].
const HAND_MAX: f64 = 0.30;
