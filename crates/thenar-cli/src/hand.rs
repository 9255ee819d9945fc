//! `thenar hand`: the names and ranges of a hand.

use crate::error::CliError;
use std::path::Path;
use thenar_core::model::{HandModel, Side};
use thenar_rig::{Model, default_hand, read_model};
use thenar_scene::reference::hand_tables;

/// List the bones, joints, ranges, poses, grips and tracked joints of a hand.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Print all tables, in Markdown.
    #[arg(long, required = true)]
    list: bool,
    /// `right` or `left`, the built-in ones, or a hand that `thenar build` made (.thenar).
    #[arg(value_name = "HAND", default_value = "right")]
    hand: String,
}

/// Prints the tables.
///
/// # Errors
/// There is no such hand, or its file cannot be read.
pub fn run(args: &Args) -> Result<(), CliError> {
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
            "expected `right`, `left` or a hand that `thenar build` made (.thenar), got `{file}`"
        )));
    }
    match read_model(Path::new(file))? {
        Model::Hand(hand) => Ok(hand),
        _ => Err(CliError::Input(format!("{file} holds no hand"))),
    }
}
