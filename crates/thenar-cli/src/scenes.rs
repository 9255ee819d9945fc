//! `thenar scenes`: what comes with the program.

use crate::error::CliError;
use thenar_scene::session::{builtins, read};

/// List the scenes that come with the program.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Print the text of this scene instead, to start an own one from.
    name: Option<String>,
}

/// Prints the list, or one scene.
///
/// # Errors
/// There is no scene of that name.
pub fn run(args: &Args) -> Result<(), CliError> {
    if let Some(name) = &args.name {
        let scene = thenar_scene::session::builtin(name)
            .ok_or_else(|| CliError::Input(format!("no scene is named `{name}`")))?;
        print!("{}", scene.text);
        return Ok(());
    }
    for scene in builtins() {
        let title = read(scene.text, &[]).ok().and_then(|s| s.title).unwrap_or_default();
        println!("{:24} {title}", scene.name);
    }
    Ok(())
}
