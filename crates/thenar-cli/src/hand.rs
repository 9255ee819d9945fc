//! `thenar hand`: the names and ranges of a hand, and those of a rig that is to be one.

use crate::build::{SideArg, mesh_bytes, names};
use crate::error::CliError;
use std::path::{Path, PathBuf};
use thenar_core::model::{HandModel, Side};
use thenar_input::{quoted, visible};
use thenar_rig::hand::{ListedJoint, NameMap, RigListing, rig_listing};
use thenar_rig::{Model, default_hand, read_model};
use thenar_scene::reference::hand_tables;

/// List the bones, joints, ranges, poses, grips and tracked joints of a hand, or the joints of a
/// rig.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Print all tables, in Markdown; of a rig, which of its joints are a hand's, as a file for
    /// --joint-names.
    #[arg(long, required = true)]
    list: bool,
    /// `right` or `left`, the built-in ones, a hand that `thenar build` made (.thenar), or a rig
    /// (.glb, .vrm).
    #[arg(value_name = "HAND", default_value = "right")]
    hand: String,
    /// Rig: the side to list, where it has both. Default: the right one.
    #[arg(long, value_enum, value_name = "SIDE")]
    side: Option<SideArg>,
    /// Rig: a TOML file of `webxr-joint = "name in the rig"` to try out.
    #[arg(long, value_name = "FILE.toml")]
    joint_names: Option<PathBuf>,
    /// Rig: name of the skinned mesh that is the hand, where the file has several.
    #[arg(long, value_name = "NAME")]
    mesh: Vec<String>,
}

/// Prints the tables.
///
/// # Errors
/// There is no such hand, or its file cannot be read.
pub fn run(args: &Args) -> Result<(), CliError> {
    let ends_in = |ending: &str| args.hand.to_ascii_lowercase().ends_with(ending);
    if ends_in(".glb") || ends_in(".vrm") {
        return list_rig(args);
    }
    if args.side.is_some() || args.joint_names.is_some() || !args.mesh.is_empty() {
        return Err(CliError::Input(
            "--side, --joint-names and --mesh are about rigs (.glb, .vrm); a hand has what it has"
                .into(),
        ));
    }
    let (hand, name) = match args.hand.as_str() {
        "right" => (default_hand(Side::Right)?, "the default right hand".to_owned()),
        "left" => (default_hand(Side::Left)?, "the default left hand".to_owned()),
        file => (read(file)?, format!("`{}`", thenar_input::brief(file))),
    };
    let tables = hand_tables(&hand, &name).map_err(|e| CliError::Input(e.to_string()))?;
    print!("{tables}");
    Ok(())
}

fn read(file: &str) -> Result<HandModel, CliError> {
    if !file.ends_with(".thenar") {
        return Err(CliError::Input(format!(
            "expected `right`, `left`, a hand that `thenar build` made (.thenar) or a rig (.glb, .vrm), got `{file}`"
        )));
    }
    match read_model(Path::new(file))? {
        Model::Hand(hand) => Ok(hand),
        _ => Err(CliError::Input(format!("{file} holds no hand"))),
    }
}

fn list_rig(args: &Args) -> Result<(), CliError> {
    let map = args.joint_names.as_deref().map_or(Ok(NameMap::new()), names)?;
    let bytes = mesh_bytes(Path::new(&args.hand))?;
    let listing = rig_listing(&bytes, &map, &args.mesh, args.side.map(SideArg::side))
        .map_err(|e| CliError::from(e.in_file(&args.hand)))?;
    print!("{}", rig_in_words(&args.hand, &listing));
    Ok(())
}

/// A rig's joints as a name map in TOML, with what is not found as comments.
fn rig_in_words(file: &str, listing: &RigListing) -> String {
    let file = visible(file);
    let mut text = format!(
        "# The joints of {file} as those of a hand: a file for `thenar build {file} --hand --joint-names FILE.toml`,\n\
         # or the table `joint_names` of a scene's [[hand]].\n"
    );
    if let Some(side) = listing.side {
        text += &format!("# Side by its names: {}.\n", side.name());
    }
    if listing.both_sides {
        text +=
            "# It has joints of both hands; `--side` lists, and builds, the one or the other.\n";
    }
    listing.joints.iter().for_each(|joint| text += &line(joint));
    let lost = listing.joints.iter().filter(|joint| joint.needed && joint.own.is_none()).count();
    text += &match lost {
        0 => "# Nothing that a hand needs is missing.\n".to_owned(),
        1 => "# 1 joint that a hand needs is missing.\n".to_owned(),
        lost => format!("# {lost} joints that a hand needs are missing.\n"),
    };
    if !listing.others.is_empty() {
        text += "# Other joints of the file:\n";
        listing.others.iter().for_each(|name| text += &format!("#   {}\n", quoted(name)));
    }
    text
}

fn line(joint: &ListedJoint) -> String {
    let name = &joint.name;
    match (&joint.own, joint.needed) {
        (Some(own), _) => format!("{name} = {}\n", toml::Value::String(own.clone())),
        (None, false) => format!("# {name} = \"\"  # not found: it is made\n"),
        (None, true) if joint.like.is_empty() => format!("# {name} = \"\"  # MISSING\n"),
        (None, true) => {
            let like: Vec<String> = joint.like.iter().map(|own| quoted(own)).collect();
            format!("# {name} = \"\"  # MISSING; of its digit are {}\n", like.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rig_is_listed_as_a_name_map() {
        let joint = |name: &str, own: Option<&str>, needed, like: &[&str]| ListedJoint {
            name: name.into(),
            own: own.map(str::to_owned),
            needed,
            like: like.iter().map(|own| own.to_string()).collect(),
        };
        let listing = RigListing {
            side: Some(Side::Right),
            both_sides: true,
            joints: vec![
                joint("wrist", Some("hand \"r\""), true, &[]),
                joint("thumb-metacarpal", None, true, &["thumb_1"]),
                joint("thumb-tip", None, false, &[]),
            ],
            others: vec!["root".into()],
        };
        let text = rig_in_words("x.glb", &listing);
        let map: NameMap = toml::from_str(&text).unwrap();
        assert_eq!(map, [("wrist".to_string(), "hand \"r\"".to_string())].into());
        for part in [
            "# thumb-metacarpal = \"\"  # MISSING; of its digit are \"thumb_1\"\n",
            "# thumb-tip = \"\"  # not found: it is made\n",
            "# 1 joint that a hand needs is missing.\n",
            "#   \"root\"\n",
            "both hands",
        ] {
            assert!(text.contains(part), "{text}");
        }
    }
}
