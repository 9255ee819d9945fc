//! Goal: a command's last line says what a newcomer needs to know next: whether to trust a run, and whether what was built is
//! kept. Method: it is run as a user runs it.

use crate::stage::{Folder, err, out};
use serde_json::Value;

/// A ball of 20 mm radius whose middle is so far above a table \[m\].
fn ball_above_table(height: f64) -> String {
    format!(
        "version = 1
        [[rigid]]
        name = \"table\"
        shape = {{ kind = \"plane\" }}
        motion = \"fixed\"
        [[rigid]]
        name = \"ball\"
        shape = {{ kind = \"sphere\", radius = 0.02 }}
        mass = 0.1
        position = [0, {height}, 0]"
    )
}

/// The last line of a run of 0.1 s in 50 steps, and what its report says of trust.
fn judged(folder: &Folder, height: f64) -> (String, Value) {
    std::fs::write(folder.0.join("s.toml"), ball_above_table(height)).unwrap();
    let args = ["run", "s.toml", "--seconds", "0.1", "--set", "time_step=0.002"];
    let output = folder.thenar(&[&args[..], &["--report", "r.json"]].concat());
    assert!(output.status.success(), "{}", err(&output));
    let report: Value = serde_json::from_str(&folder.text("r.json")).unwrap();
    (out(&output).lines().last().unwrap().trim().to_owned(), report["trust"].clone())
}

/// The ball rests on the table from the start.
#[test]
fn a_clean_run_ends_in_trust() {
    let folder = Folder::new("trust");
    let (line, trust) = judged(&folder, 0.02);
    let begin = "trust: yes: contact met its accuracy in all 50 steps; nothing was ";
    assert!(line.starts_with(begin), "{line}");
    assert_eq!(trust["verdict"], "yes");
    assert_eq!(trust["doubtful"].as_array().unwrap().len(), 0);
    assert_eq!(trust["reasons"].as_array().unwrap().len(), 2);
    // In 0.1 s it falls by 49 mm, of the 80 mm that it is above the table.
    let (line, _) = judged(&folder, 0.1);
    assert_eq!(line, "trust: yes: nothing touched in 50 steps, and none of them went wrong");
}

/// The middle is 10.1 mm above the table: 9.9 mm of the radius are below it.
#[test]
fn an_overlap_at_the_start_makes_forces_doubtful() {
    let folder = Folder::new("doubt");
    let (line, trust) = judged(&folder, 0.0101);
    let started = "started 9.900 mm inside each other";
    assert!(line.starts_with("trust: forces are doubtful: ") && line.contains(started), "{line}");
    assert_eq!(trust["verdict"], "doubtful");
    assert_eq!(trust["doubtful"], serde_json::json!(["forces"]));
    let reasons = trust["reasons"].as_array().unwrap();
    assert!(reasons[0].as_str().unwrap().ends_with(started), "{reasons:?}");
    let said: Vec<&str> = reasons.iter().map(|reason| reason.as_str().unwrap()).collect();
    assert_eq!(line, format!("trust: forces are doubtful: {}", said.join("; ")));
}

#[test]
fn a_model_that_is_not_kept_is_said_to_be_lost() {
    let folder = Folder::new("kept");
    let obj = "v 0 0 0\nv 0.06 0 0\nv 0 0.06 0\nv 0 0 0.06\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::fs::write(folder.0.join("t.obj"), obj).unwrap();
    let last = |more: &[&str]| {
        let output = folder.thenar(&[&["build", "t.obj", "--rigid"], more].concat());
        assert_eq!(output.status.code(), Some(0), "{}", err(&output));
        out(&output).lines().last().unwrap().to_owned()
    };
    assert_eq!(last(&[]), "note: nothing written; add -o FILE to keep it");
    assert_eq!(last(&["--vtk", "files"]), "note: no model written; add -o FILE to keep it");
    assert!(!folder.0.join("t.thenar").exists());
    assert_eq!(last(&["-o", "t.thenar"]), "wrote the rigid body to t.thenar");
}
