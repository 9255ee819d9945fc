//! Profiles out of files: the shipped one, with the user's keys laid over it.

use super::Address;
use crate::LinkError;
use serde::de::DeserializeOwned;
use std::path::PathBuf;
use thenar::model::Side;
use toml::{Table, Value};

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
    let file = match &address.profile {
        Some(file) => Some(file.clone()),
        None => user_file(driver, address.side).filter(|file| file.exists()),
    };
    let text = match &file {
        None => String::new(),
        Some(file) => std::fs::read_to_string(file).map_err(|error| LinkError::Setting {
            what: format!("profile {}", file.display()),
            cause: error.to_string(),
        })?,
    };
    let what =
        file.map_or_else(|| format!("profile of {driver}"), |f| format!("profile {}", f.display()));
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

/// Where a user's profile for this driver is kept, whether or not there is one: for this side if
/// that exists, else for both. `None` where the system has no place for settings.
pub fn user_file(driver: &str, side: Option<Side>) -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
    let folder = set("THENAR_CONFIG")
        .or_else(|| Some(set("XDG_CONFIG_HOME").or_else(|| set("APPDATA"))?.join("thenar")))
        .or_else(|| Some(set("HOME")?.join(".config/thenar")))?
        .join("devices");
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
    text.split('\n').map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
}
