//! Goal: a command's last line says what a newcomer needs to know next: whether to trust a run, and
//! whether what was built is kept. Method: it is run as a user runs it.

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

/// A cube of 50 mm and 20 kPa under a force for 0.3 s. At no thickness it resists with 432 times
/// its modulus: 8.6 MPa, or 21.6 kN on its face of 25 cm². With 20 kN it comes to rest above that,
/// and swings through it for two steps or so; with 40 kN it stays inside out until the force ends,
/// and comes right after that.
#[test]
fn flesh_inside_out_in_the_middle_of_a_run_makes_shapes_doubtful() {
    let folder = Folder::new("inverted");
    let pressed = |force: f64| {
        let scene = format!(
            "version = 1
            time_step = 0.01
            gravity = [0, 0, 0]
            [[soft]]
            name = \"cube\"
            shape = {{ kind = \"lattice\", size = [0.05, 0.05, 0.05], cells = [1, 1, 1], split = \"five\" }}
            material = {{ young = 20e3, poisson = 0.0, density = 1000 }}
            stiffness_damping = 0.02
            [[soft.fixed]]
            nodes = {{ side = \"y-min\" }}
            [[soft.fixed]]
            nodes = {{ side = \"y-max\" }}
            axes = \"xz\"
            [[load]]
            kind = \"traction\"
            body = \"cube\"
            faces = {{ side = \"y-max\" }}
            total = [0, {}, 0]
            profile = {{ kind = \"constant\", until = 0.3 }}",
            -force
        );
        std::fs::write(folder.0.join("s.toml"), scene).unwrap();
        let output = folder.thenar(&["run", "s.toml", "--seconds", "0.8", "--report", "r.json"]);
        assert!(output.status.success(), "{}", err(&output));
        let report: Value = serde_json::from_str(&folder.text("r.json")).unwrap();
        let longest = report["inverted_longest_s"].as_f64().unwrap();
        (out(&output).lines().last().unwrap().trim().to_owned(), longest, report["trust"].clone())
    };
    let (line, longest, trust) = pressed(40e3);
    let said = "trust: shapes are doubtful: up to 5 of 5 tetrahedra were inside out, for up to ";
    assert_eq!(line, format!("{said}{longest:.3} s"));
    assert!((0.25..0.7).contains(&longest), "{longest} s");
    assert_eq!(trust["doubtful"], serde_json::json!(["shapes"]));
    let (line, longest, _) = pressed(20e3);
    assert!(line.starts_with("trust: yes: ") && longest < 0.05, "{line}, {longest} s");
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
