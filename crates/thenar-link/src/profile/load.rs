//! Profiles out of files: the shipped one, with the user's keys laid over it.

use super::Address;
use crate::LinkError;
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};
use thenar_core::model::Side;
use thenar_input::{InputError, brief, read_text};
use thenar_output::write_whole;
use toml::{Table, Value};
use toml_edit::{DocumentMut, Item, TableLike, TomlError};

/// Largest profile \[bytes\]; the longest that is shipped has five thousand.
const PROFILE_BYTES_MAX: u64 = 1 << 20;

/// A profile that can tell what is wrong with its numbers.
pub trait Check: DeserializeOwned {
    /// Refuses a value: its key, and why.
    fn check(&self) -> Result<(), (String, String)>;

    /// Lays an address's side over that of the file.
    fn set_side(&mut self, side: Side);
}

/// The profile of `driver` for this address: `shipped`, changed by the file that the address names
/// or else by the user's own, if there is one.
///
/// # Errors
/// The file cannot be read, is no TOML, has a key that does not exist or a value that does not fit.
pub fn load<P: Check>(driver: &str, shipped: &str, address: &Address) -> Result<P, LinkError> {
    let (file, what) = source(driver, address);
    let text = match &file {
        None => String::new(),
        Some(file) => read_text(file, PROFILE_BYTES_MAX)
            .map_err(|error| LinkError::Setting { what: what.clone(), cause: error.to_string() })?,
    };
    let mut profile: P =
        merged(shipped, &text).map_err(|cause| LinkError::Setting { what: what.clone(), cause })?;
    if let Some(side) = address.side {
        profile.set_side(side);
    }
    profile
        .check()
        .map_err(|(key, cause)| LinkError::Setting { what: format!("{what}, {key}"), cause })?;
    Ok(profile)
}

/// The file over the shipped profile of `driver`, if there is one, and a name for the whole.
fn source(driver: &str, address: &Address) -> (Option<PathBuf>, String) {
    let own = || user_file(driver, address.side).filter(|file| file.exists());
    let file = address.profile.clone().or_else(own);
    let name = match &file {
        Some(file) => format!("profile {}", file.display()),
        None => format!("profile of {driver}"),
    };
    (file, name)
}

/// Name in messages of the profile that [`load`] reads.
pub fn profile_name(driver: &str, address: &Address) -> String {
    source(driver, address).1
}

/// Folder of this person's settings; `None` where the system has no place for them.
pub fn settings_folder() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    set("THENAR_CONFIG")
        .or_else(|| Some(set("XDG_CONFIG_HOME").or_else(|| set("APPDATA"))?.join("thenar")))
        .or_else(|| Some(set("HOME")?.join(".config/thenar")))
}

/// Path of a user's profile for this driver, whether or not there is one: for this side if that
/// exists, else for both. `None` where the system has no place for settings.
pub fn user_file(driver: &str, side: Option<Side>) -> Option<PathBuf> {
    let folder = settings_folder()?.join("devices");
    let of_side = side.map(|side| match side {
        Side::Left => folder.join(format!("{driver}-left.toml")),
        Side::Right => folder.join(format!("{driver}-right.toml")),
    });
    Some(
        of_side
            .filter(|file| file.exists())
            .unwrap_or_else(|| folder.join(format!("{driver}.toml"))),
    )
}

/// A file of settings that stands for itself.
pub(crate) fn read_table<T: DeserializeOwned>(file: &Path) -> Result<T, String> {
    let text = read_text(file, PROFILE_BYTES_MAX).map_err(|error| error.to_string())?;
    merged("", &text)
}

/// The user's keys over the shipped ones. Whatever is wrong is the user's: the shipped file is
/// tested.
fn merged<P: DeserializeOwned>(shipped: &str, user: &str) -> Result<P, String> {
    let parse = |text: &str| text.parse::<Table>().map_err(|error| one_line(&error.to_string()));
    let mut table = parse(shipped)?;
    let changes = parse(user)?;
    lay_over(&mut table, changes);
    Value::Table(table).try_into().map_err(|error: toml::de::Error| one_line(&error.to_string()))
}

fn lay_over(below: &mut Table, above: Table) {
    for (key, value) in above {
        match (below.get_mut(&key), value) {
            (Some(Value::Table(below)), Value::Table(above)) => lay_over(below, above),
            (_, value) => {
                below.insert(key, value);
            }
        }
    }
}

fn one_line(text: &str) -> String {
    let lines = text.split('\n').map(str::trim).filter(|line| !line.is_empty()).map(brief);
    brief(&lines.collect::<Vec<_>>().join(" "))
}

/// Puts `above` into a person's own text: comments, order and spaces stay.
fn write_over(below: &mut dyn TableLike, above: &Table) {
    for (key, value) in above {
        match (below.get_mut(key), value) {
            (Some(item), Value::Table(above)) if item.is_table_like() => {
                if let Some(below) = item.as_table_like_mut() {
                    write_over(below, above);
                }
            }
            (Some(Item::Value(old)), value) if !value.is_table() => {
                let mut new = edited(value);
                *new.decor_mut() = old.decor().clone();
                *old = new;
            }
            (_, Value::Table(above)) => {
                let mut table = toml_edit::Table::new();
                write_over(&mut table, above);
                // A header of its own only for what it holds itself.
                table.set_implicit(above.values().all(Value::is_table));
                below.insert(key, Item::Table(table));
            }
            (_, value) => _ = below.insert(key, Item::Value(edited(value))),
        }
    }
}

/// A value as the editor writes it.
fn edited(value: &Value) -> toml_edit::Value {
    match value {
        Value::String(text) => text.into(),
        Value::Integer(number) => (*number).into(),
        Value::Float(number) => (*number).into(),
        Value::Boolean(truth) => (*truth).into(),
        Value::Datetime(time) => (*time).into(),
        Value::Array(values) => values.iter().map(edited).collect::<toml_edit::Array>().into(),
        Value::Table(table) => {
            let pairs = table.iter().map(|(key, value)| (key.as_str(), edited(value)));
            pairs.collect::<toml_edit::InlineTable>().into()
        }
    }
}

/// Lays `keys` over the profile in `file`, or begins one; what else is in it, comments included,
/// stays. The file is replaced whole or not at all.
///
/// # Errors
/// What is there is no TOML, or cannot be written.
pub fn save(file: &Path, keys: Table) -> Result<(), LinkError> {
    let refuse =
        |cause: String| LinkError::Setting { what: format!("profile {}", file.display()), cause };
    let old = match read_text(file, PROFILE_BYTES_MAX) {
        Err(InputError::System(error)) if error.kind() == std::io::ErrorKind::NotFound => {
            String::new()
        }
        result => result.map_err(|error| refuse(error.to_string()))?,
    };
    let mut document: DocumentMut =
        old.parse().map_err(|e: TomlError| refuse(one_line(&e.to_string())))?;
    write_over(document.as_table_mut(), &keys);
    let text = document.to_string();
    if let Some(folder) = file.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(|error| refuse(error.to_string()))?;
    }
    write_whole(file, text.as_bytes()).map_err(|error| refuse(error.cause.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lucidgloves::{Profile, SHIPPED};
    use thenar_core::random::Random;

    fn read(text: &str) -> Result<Profile, String> {
        let file = std::env::temp_dir().join(format!(
            "thenar-profile-{}-{:?}.toml",
            std::process::id(),
            std::thread::current().id()
        ));
        std::fs::write(&file, text).unwrap();
        let address = Address { profile: Some(file.clone()), ..Address::default() };
        let result = load("lucidgloves", SHIPPED, &address).map_err(|e| e.to_string());
        std::fs::remove_file(&file).unwrap();
        result.map_err(|told| told.replace(&*file.to_string_lossy(), "FILE"))
    }

    #[test]
    fn a_user_changes_single_keys() {
        let shipped = read("").unwrap();
        let mut expected = shipped.clone();
        expected.hand.length = 0.2;
        expected.index.raw = [0.1, 0.8];
        assert_eq!(read("hand.length = 0.2\n[index]\nraw = [0.1, 0.8]").unwrap(), expected);
    }

    #[test]
    fn errors_name_the_key() {
        for (text, told) in [
            ("hand.length = 2.0", "profile FILE, hand.length: 2 m is not a hand's"),
            ("hand.lenght = 0.2", "unknown field `lenght`"),
            ("[hand]\nside = \"up\"", "unknown variant `up`"),
            ("index.raw = [0.5, 0.5]", "profile FILE, index.raw: expected two values"),
            ("index.raw = 3", "index.raw"),
            ("index = 3", "index"),
            ("display.rated = nan", "profile FILE, display.rated: is NaN N"),
            ("display.user_fraction = 2.0", "display.user_fraction"),
            ("wrist.rotation = [0.0, 0.0, 0.0, 0.0]", "wrist.rotation: has length 0"),
            ("wrist.position = [9.0, 9.0, 9.0]", "wrist.position: expected three numbers within"),
            ("sensors.analog_max = 70000", "analog_max"),
            ("gloves = 1", "unknown field `gloves`"),
            ("a = = 1", "profile FILE: TOML parse error at line 1"),
            ("display.damping = 1e300", "display.damping: is 1e300, expected 0 to 100"),
            ("display.resolution = 1e300", "display.resolution: is 1e300, expected 0 to 0.01"),
            ("display.friction = inf", "display.friction: is inf, expected 0 to 100"),
            ("display.delay = 1.5", "display.delay: is 1.5, expected 0 to 1"),
            ("display.delay = -1.0", "display.delay: is -1.0, expected 0 to 1"),
            ("display.stiffness_max = 1e7", "display.stiffness_max: is 10000000.0 N/m"),
        ] {
            let message = read(text).unwrap_err();
            assert!(message.contains(told) && !message.contains('\n'), "{text}: {message}");
        }
    }

    /// Numbers of the shipped profile replaced, and its text damaged, in a seeded sequence: read,
    /// or refused in a line that names the file and repeats no more than some of it.
    #[test]
    fn damaged_profiles_are_read_or_refused() {
        let mut random = Random::new(0x5eed);
        let mut below = |n: usize| random.below(n);
        let numbers = ["0", "-1", "1e300", "nan", "inf", "1e-300", "4294967296", "\"a\"", "[]"];
        let (mut good, mut refused) = (0, 0);
        for round in 0..600 {
            let mut lines: Vec<String> = SHIPPED.lines().map(str::to_owned).collect();
            let at = below(lines.len());
            let line = lines[at].clone();
            match (round % 3, line.split_once('=')) {
                (0, Some((key, _))) => lines[at] = format!("{key}= {}", numbers[below(9)]),
                (1, _) => lines[at] = line.chars().filter(|_| below(9) > 0).collect(),
                _ => lines[at] = format!("{line}{}", "x".repeat(50_000)),
            }
            match read(&lines.join("\n")) {
                Ok(profile) => {
                    profile.check().unwrap();
                    good += 1;
                }
                Err(told) => {
                    assert!(told.starts_with("profile FILE") && told.len() < 2500, "{told}");
                    assert!(!told.contains('\n'), "{told}");
                    refused += 1;
                }
            }
        }
        assert!(good > 50 && refused > 100, "{good} {refused}");
    }

    #[test]
    fn saved_keys_join_what_is_there() {
        let folder = std::env::temp_dir().join(format!("thenar-save-{}", std::process::id()));
        let file = folder.join("deep/lucidgloves.toml");
        save(&file, "hand.length = 0.2\nindex.raw = [0.1, 0.9]".parse().unwrap()).unwrap();
        save(&file, "index.raw = [0.2, 0.8]".parse().unwrap()).unwrap();
        let table: Table = std::fs::read_to_string(&file).unwrap().parse().unwrap();
        assert_eq!(table, "hand.length = 0.2\nindex.raw = [0.2, 0.8]".parse().unwrap());
        // A person's own text stays, whichever way it is written.
        let own = "# Mine.\nhand.length = 0.2 # measured\n\n[index] # the long one\n# bent\nraw = \
                   [0.0, 1.0] # old\nsplay = 1.0\n\n[display]\nrated = 5.0 # weak springs\n";
        std::fs::write(&file, own).unwrap();
        let keys = "hand.length = 0.19\nindex.raw = [0.2, 0.8]\n[thumb]\nraw = [0.1, 0.7]\n";
        save(&file, keys.parse().unwrap()).unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        let new = own.replace("0.2 #", "0.19 #").replace("[0.0, 1.0]", "[0.2, 0.8]");
        assert_eq!(text, format!("{new}\n[thumb]\nraw = [0.1, 0.7]\n"));
        let inline = "sensors = { index_mpj = { gain = 1.0, offset = 2.0 } } # one line\n";
        std::fs::write(&file, inline).unwrap();
        save(&file, "sensors.index_mpj = { gain = 3.5, offset = 4.0 }".parse().unwrap()).unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        assert_eq!(text, inline.replace("1.0", "3.5").replace("2.0", "4.0"));
        std::fs::write(&file, "not toml").unwrap();
        assert!(save(&file, Table::new()).is_err());
        assert_eq!(std::fs::read_to_string(&file).unwrap(), "not toml", "nothing is lost");
        std::fs::remove_dir_all(&folder).unwrap();
    }
}
