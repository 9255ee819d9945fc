//! Writes the shipped right hand as JSON, and, if asked for, in the form that engines are compared
//! on as a model of Thenar's: `export TETS FILE.json [FILE.thenar]`.

use std::path::Path;
use std::process::ExitCode;
use thenar_core::model::Side;
use thenar_peers::simple::simplified;
use thenar_rig::export::write_hand_json;
use thenar_rig::{Model, RigError, write_model};

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let ([tets, file], model) = match words.as_slice() {
        [tets, file] => ([tets, file], None),
        [tets, file, model] => ([tets, file], Some(model)),
        _ => {
            eprintln!("usage: export TETS FILE.json [FILE.thenar]");
            return ExitCode::from(2);
        }
    };
    let Ok(tets) = tets.parse() else {
        eprintln!("{tets} is no number of tetrahedra");
        return ExitCode::from(2);
    };
    match export(tets, Path::new(file), model.map(Path::new)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::FAILURE
        }
    }
}

fn export(tets: usize, file: &Path, model: Option<&Path>) -> Result<(), RigError> {
    let hand = thenar_rig::uniform_hand(Side::Right, tets)?;
    write_hand_json(file, &hand)?;
    match model {
        Some(model) => write_model(model, &Model::Hand(simplified(hand))),
        None => Ok(()),
    }
}
