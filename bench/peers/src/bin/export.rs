//! Writes the shipped right hand as JSON: `export TETS FILE.json`.

use std::path::Path;
use std::process::ExitCode;
use thenar::model::Side;
use thenar_rig::export::write_hand_json;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let [tets, file] = words.as_slice() else {
        eprintln!("usage: export TETS FILE.json");
        return ExitCode::from(2);
    };
    let Ok(tets) = tets.parse() else {
        eprintln!("{tets} is no number of tetrahedra");
        return ExitCode::from(2);
    };
    let hand = thenar_rig::uniform_hand(Side::Right, tets);
    match hand.and_then(|hand| write_hand_json(Path::new(file), &hand)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(problem) => {
            eprintln!("{problem}");
            ExitCode::FAILURE
        }
    }
}
