//! Script of the runtime: lines of a file, a key and its value, read again at every poll.
//!
//! | key | value |
//! |---|---|
//! | `without` | an extension that the runtime lacks; once per line |
//! | `hands` | `both` (default), `left`, `none`: those that are seen |
//! | `blind` | number of a joint whose place is not known |
//! | `tracks` | `no`: the headset has no hand tracking |
//! | `stage` | `no`: there is no stage, only the local space |
//! | `session` | `run` (default), `stop`, `exit`, `lose`, `lose_instance` |
//! | `fail` | a function's name and the number of the error that it gives; once per line |

use std::fs::OpenOptions;
use std::io::Write;

/// Names the file.
pub const VARIABLE: &str = "THENAR_XR_SCRIPT";

/// Contents of a script.
#[derive(Clone, Debug)]
pub struct Script {
    /// Extensions that are lacking.
    pub without: Vec<String>,
    /// Left, right.
    pub seen: [bool; 2],
    /// A joint whose place is not known.
    pub blind: Option<usize>,
    /// The headset has hand tracking.
    pub tracks: bool,
    /// True if there is a stage.
    pub stage: bool,
    /// Fate of the session.
    pub session: String,
    /// Functions that fail, and how.
    pub fails: Vec<(String, i32)>,
}

impl Script {
    /// Reads the file that the environment names; one that is not there says nothing.
    pub fn read() -> Self {
        let path = std::env::var_os(VARIABLE);
        Self::parse(&path.and_then(|path| std::fs::read_to_string(path).ok()).unwrap_or_default())
    }

    fn parse(text: &str) -> Self {
        let mut script = Self {
            without: Vec::new(),
            seen: [true; 2],
            blind: None,
            tracks: true,
            stage: true,
            session: "run".into(),
            fails: Vec::new(),
        };
        for line in text.lines() {
            let mut words = line.split_whitespace();
            let (key, value) = (words.next().unwrap_or(""), words.next().unwrap_or(""));
            match key {
                "without" => script.without.push(value.into()),
                "hands" => script.seen = [value != "none", value == "both"],
                "blind" => script.blind = value.parse().ok(),
                "tracks" => script.tracks = value != "no",
                "stage" => script.stage = value != "no",
                "session" => script.session = value.into(),
                "fail" => {
                    let code = words.next().and_then(|code| code.parse().ok());
                    script.fails.push((value.into(), code.unwrap_or(-2)));
                }
                "" => {}
                other => log(&format!("violation: the script says `{other}`")),
            }
        }
        script
    }
}

/// Writes a line into the file beside the script, `SCRIPT.log`.
pub fn log(line: &str) {
    let Some(mut path) = std::env::var_os(VARIABLE) else { return };
    path.push(".log");
    if let Ok(mut file) = OpenOptions::new().append(true).create(true).open(path) {
        let _ = file.write_all(format!("{line}\n").as_bytes());
    }
}
