//! Goal: the program keeps its promises to scripts: exit codes, report keys, table headers, whole
//! files or none. Method: it is run as a user runs it.

use crate::stage::{Folder, err, out};
use serde_json::Value;

#[test]
fn a_run_reports_every_promised_figure() {
    let folder = Folder::new("report");
    let args = ["run", "soft-cube", "--seconds", "0.3", "--report", "r.json", "--quiet"];
    let output = folder.thenar(&args);
    assert!(output.status.success(), "{}", err(&output));
    assert!(output.stdout.is_empty(), "quiet");
    let report: Value = serde_json::from_str(&folder.text("r.json")).unwrap();
    let mut numbers: Vec<String> = [
        "/dt_s",
        "/steps",
        "/wall_s",
        "/realtime_factor",
        "/tets",
        "/nodes",
        "/contacts_max",
        "/contacts_dropped_max",
        "/divided",
        "/max_joint_gap_m",
        "/max_penetration_m",
        "/inverted_tets_max",
        "/inverted_longest_s",
        "/non_finite",
        "/energy_j/initial",
        "/energy_j/final",
        "/energy_j/max",
    ]
    .map(String::from)
    .to_vec();
    for stage in ["skeleton", "flesh", "detect", "contact", "embed", "total"] {
        numbers.extend(["median_us", "p99_us", "max_us"].map(|k| format!("/stages/{stage}/{k}")));
    }
    for finger in ["thumb", "index", "middle", "ring", "little"] {
        numbers.extend(
            ["normal_n", "shear_n", "area_m2", "pressure_mean_pa"]
                .map(|k| format!("/fingers/{finger}/{k}")),
        );
    }
    for key in numbers {
        assert!(report.pointer(&key).is_some_and(Value::is_number), "{key}");
    }
    for key in ["scene", "solver", "state_hash"] {
        assert!(report[key].is_string(), "{key}");
    }
    assert_eq!(report["report_version"], 7);
    assert_eq!(report["scene"], "soft-cube");
    assert_eq!(report["steps"], 150);
    assert_eq!(report["tets"], 320);
    assert_eq!(report["nodes"], 125);
    assert!(report["contacts_max"].as_u64().unwrap() > 0, "the cube has landed");
    let stages = &report["stages"];
    let median = |stage: &str| stages[stage]["median_us"].as_f64().unwrap();
    assert!(median("total") >= median("flesh") && median("flesh") > 0.0);
    assert!(stages["total"]["max_us"].as_f64() >= stages["total"]["p99_us"].as_f64());
    assert_eq!(folder.files(), ["r.json"]);
}

#[test]
fn the_same_run_gives_the_same_state() {
    let folder = Folder::new("hash");
    for file in ["a.json", "b.json"] {
        let output =
            folder.thenar(&["run", "falling-box", "--seconds", "0.2", "-q", "--report", file]);
        assert!(output.status.success(), "{}", err(&output));
    }
    let hash = |file: &str| {
        serde_json::from_str::<Value>(&folder.text(file)).unwrap()["state_hash"].clone()
    };
    assert_eq!(hash("a.json"), hash("b.json"));
}

#[test]
fn tables_have_headers_with_units_and_a_row_for_the_start() {
    let folder = Folder::new("table");
    for file in ["t.csv", "t.jsonl"] {
        let args = ["run", "finger-pendulum", "--seconds", "0.001", "-q", "--probe", file];
        assert!(folder.thenar(&args).status.success());
    }
    let csv = folder.text("t.csv");
    let lines: Vec<&str> = csv.lines().collect();
    assert!(lines[0].starts_with("time [s],tip.x [m],tip.y [m],tip.z [m],knuckle.angle0 [rad]"));
    assert_eq!(lines.len(), 1 + 11);
    let first: Vec<f64> = lines[1].split(',').map(|x| x.parse().unwrap()).collect();
    assert_eq!(first[0], 0.0);
    assert!((first[1] - 0.095).abs() < 1e-12, "{first:?}");
    let jsonl = folder.text("t.jsonl");
    let rows: Vec<Value> = jsonl.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    assert_eq!(rows[0]["version"], 2);
    assert_eq!(rows[0]["units"]["tip.x"], "m");
    assert_eq!(rows.len(), 1 + 11);
    // The parser of this test rounds the last digit.
    assert!((rows[1]["tip.x"].as_f64().unwrap() - first[1]).abs() < 1e-15);
}

#[test]
fn what_overlaps_at_the_start_is_told_by_run_and_record() {
    let folder = Folder::new("overlap");
    let scene = "version = 1
        [[rigid]]
        name = \"table\"
        shape = { kind = \"plane\" }
        motion = \"fixed\"
        [[rigid]]
        name = \"ball\"
        shape = { kind = \"sphere\", radius = 0.02 }
        mass = 0.1
        position = [0, 0.017, 0]";
    std::fs::write(folder.0.join("s.toml"), scene).unwrap();
    let run: &[&str] = &["run", "s.toml", "--seconds", "0.01", "-q", "--report", "r.json"];
    let record: &[&str] = &["record", "s.toml", "--seconds", "0.01", "-q", "-o", "s.rec"];
    for args in [run, record] {
        let output = folder.thenar(args);
        let told = err(&output);
        assert!(output.status.success(), "{told}");
        let lines: Vec<&str> = told.lines().filter(|line| line.contains("overlap")).collect();
        assert_eq!(lines.len(), 1, "{told}");
        assert!(lines[0].starts_with("warning: ") && lines[0].contains("3.000 mm"), "{told}");
        assert!(lines[0].contains("ball") && lines[0].contains("table"), "{told}");
    }
    let report: Value = serde_json::from_str(&folder.text("r.json")).unwrap();
    let overlap = &report["start_overlaps"][0];
    assert!((overlap["depth_m"].as_f64().unwrap() - 0.003).abs() < 1e-9, "{overlap}");
    assert_eq!(overlap["bodies"].as_array().unwrap().len(), 2);
    assert_eq!(overlap["place_m"].as_array().unwrap().len(), 3);
    let apart =
        ["run", "s.toml", "--seconds", "0.01", "-q", "--set", "rigid.ball.position=[0,0.02,0]"];
    assert_eq!(err(&folder.thenar(&apart)), "");
}

#[test]
fn a_soak_prints_each_figure_with_its_limit() {
    let folder = Folder::new("soak");
    let args = ["soak", "--seconds", "0.2", "--time-step", "0.005"];
    let judged = out(&folder.thenar(&args));
    let figures = [
        ("steps taken back", "at most 0"),
        ("largest energy", "under 1000"),
        ("steps under 1 mm of penetration", "at least 99.9"),
        ("deepest penetration", "at most 5"),
        ("longest time above 1 mm", "under 0.1"),
        ("largest joint gap", "under 0.05"),
        ("steps that missed the contact accuracy", "under 5"),
        ("largest miss of it", "at most 0.001"),
    ];
    for (figure, limit) in figures {
        let line = judged.lines().find(|line| line.contains(figure)).expect(figure);
        assert!(line.ends_with(limit), "{line}");
    }
    let lax = folder.thenar(&[&args[..], &["--judge", "false"]].concat());
    assert!(lax.status.success());
    assert!(!out(&lax).contains("largest joint gap"));
    // A table that nobody can be above of: a plane at the lid's height.
    let low = ["soak", "--seconds", "0.1", "--set", "rigid.table.position=[0,0.5,0]"];
    let output = folder.thenar(&low);
    assert_eq!(output.status.code(), Some(2));
    assert!(err(&output).contains("no start without overlap"), "{}", err(&output));
}

#[test]
fn paraview_files_are_written() {
    let folder = Folder::new("vtk");
    let args =
        ["run", "soft-cube", "--seconds", "0.1", "-q", "--vtk", "out", "--vtk-interval", "0.05"];
    let output = folder.thenar(&args);
    assert!(output.status.success(), "{}", err(&output));
    let list = folder.text("out/soft-cube.pvd");
    for moment in ["timestep=\"0\"", "000002.vtu"] {
        assert!(list.contains(moment), "{list}");
    }
    assert!(folder.text("out/soft-cube-cube-flesh-000001.vtu").contains("<VTKFile"));
    assert!(folder.text("out/soft-cube-cube-contact-000001.vtp").contains("pressure [Pa]"));
}

#[test]
fn wrong_input_exits_with_2_and_leaves_nothing() {
    let folder = Folder::new("wrong-input");
    std::fs::write(folder.0.join("s.toml"), "version = 1\ntime_stp = 1\n").unwrap();
    let cases: [(&[&str], &str); 13] = [
        (
            &["run", "s.toml", "--report", "r.json"],
            "s.toml:2:1: `time_stp`: unknown key; did you mean `time_step`?",
        ),
        (&["run", "none.toml", "--probe", "p.csv"], "none.toml: No such file"),
        (&["run", "none"], "no scene `none`"),
        (&["run", "falling-box", "--seconds", "-1"], "--seconds"),
        (&["run", "falling-box", "--seconds", "nan"], "--seconds"),
        (
            &["run", "falling-box", "--set", "rigid.box.density=0"],
            "`rigid[1].density`: expected a finite number",
        ),
        (&["build", "none.glb", "--hand", "-o", "m.thenar"], "none.glb"),
        (&["build", "s.toml", "--rigid", "-o", "m.thenar"], "s.toml"),
        (
            &["build", "s.toml", "--rigid", "--young", "5"],
            "--young is that of a hand, a figure or a soft",
        ),
        (&["build", "s.toml", "--soft", "--length", "5"], "--length is that of a hand"),
        (&["run", "falling-box", "--picture", "p.jpg"], "its file ends in .png, not .jpg"),
        (&["run", "falling-box", "--picture", "p.png", "--at", "nan"], "--at must be 0 or more"),
        (
            &["run", "falling-box", "--seconds", "0.1", "--picture", "p.png", "--at", "0.2"],
            "--at 0.2 s is beyond the end of the run at 0.100 s",
        ),
    ];
    for (args, expected) in cases {
        let output = folder.thenar(args);
        assert_eq!(output.status.code(), Some(2), "{args:?}: {}", err(&output));
        assert!(err(&output).contains(expected), "{args:?}: {}", err(&output));
        assert_eq!(folder.files(), ["s.toml"], "{args:?}");
    }
    assert_eq!(folder.thenar(&["run"]).status.code(), Some(2));
    assert_eq!(folder.thenar(&["dance"]).status.code(), Some(2));
}

/// What a scene does not measure is known before its bodies are built: here one could not be.
#[test]
fn a_table_of_no_probes_is_refused_before_anything_is_built() {
    let folder = Folder::new("no-probes");
    let scene =
        "version = 1\n[[soft]]\nname = \"s\"\nshape = { kind = \"mesh\", file = \"none.obj\" }\n";
    std::fs::write(folder.0.join("s.toml"), scene).unwrap();
    let output = folder.thenar(&["run", "s.toml", "--probe", "p.csv"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(err(&output).contains("no probes to write"), "{}", err(&output));
}

#[test]
fn an_output_that_cannot_be_written_exits_with_1() {
    let folder = Folder::new("output");
    let output = folder.thenar(&["run", "falling-box", "--probe", "no/such/folder/p.csv"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(err(&output).contains("no/such/folder/p.csv"), "{}", err(&output));
}

#[test]
fn a_mesh_file_becomes_a_model_that_a_scene_uses() {
    let folder = Folder::new("build");
    // A tetrahedron with legs of 60 mm: 36 ml.
    let obj = "v 0 0 0\nv 0.06 0 0\nv 0 0.06 0\nv 0 0 0.06\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    std::fs::write(folder.0.join("t.obj"), obj).unwrap();
    for (kind, file) in [("--rigid", "r.thenar"), ("--soft", "s.thenar")] {
        let output = folder.thenar(&["build", "t.obj", kind, "--density", "500", "-o", file]);
        assert!(output.status.success(), "{kind}: {}", err(&output));
        let told = out(&output);
        assert!(!told.contains('{'), "words, with units: {told}");
        match kind {
            "--rigid" => assert!(told.contains("mass: 18.00 g, volume 36.000 ml"), "{told}"),
            _ => assert!(told.contains("elements: dihedral angles of "), "{told}"),
        }
    }
    let scene = r#"
        version = 1
        duration = 0.01
        gravity = [0, 0, 0]
        [[rigid]]
        name = "r"
        shape = { kind = "mesh", file = "r.thenar" }
        [[soft]]
        name = "s"
        shape = { kind = "mesh", file = "s.thenar" }
        position = [1, 0, 0]
        [[load]]
        kind = "force"
        body = "r"
        force = [0, 0.18, 0]
        [[probe]]
        name = "r"
        measure = "velocity"
        body = "r"
    "#;
    std::fs::write(folder.0.join("scene.toml"), scene).unwrap();
    let output = folder.thenar(&["run", "scene.toml", "-q", "--probe", "p.csv"]);
    assert!(output.status.success(), "{}", err(&output));
    let table = folder.text("p.csv");
    let last: Vec<f64> =
        table.lines().last().unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    // 36 ml at 500 kg/m³ are 18 g: 0.18 N give 10 m/s², after 10 ms 0.1 m/s.
    assert!((last[2] - 0.1).abs() < 1e-9, "{last:?}");
}

/// The program prints what the document says of the default hand, and of another hand that hand's
/// ranges.
#[test]
fn the_names_and_ranges_of_a_hand_are_printed() {
    let folder = Folder::new("hand-list");
    let printed = |args: &[&str]| {
        let output = folder.thenar(args);
        assert!(output.status.success(), "{}", err(&output));
        out(&output)
    };
    let document = include_str!("../../../../docs/hand.md");
    let (_, tables) = document.split_once("## Names and ranges\n\n").unwrap();
    assert_eq!(printed(&["hand", "--list"]), tables);
    let left = printed(&["hand", "--list", "left"]);
    assert!(left.contains("those of the default left hand"), "{left}");
    printed(&["build", "left", "--hand", "--tets", "100", "-o", "own.thenar"]);
    let own = printed(&["hand", "--list", "own.thenar"]);
    assert_eq!(own, left.replace("the default left hand", "`own.thenar`"));
    // The ranges of the file, not of a built-in hand.
    let mut model = thenar_rig::read_model(&folder.0.join("own.thenar")).unwrap();
    let thenar_rig::Model::Hand(hand) = &mut model else { panic!("no hand") };
    let tip = hand.bones.iter().position(|bone| bone.name == "thumb-distal").unwrap();
    let joint = hand.joints.iter_mut().find(|joint| joint.child as usize == tip).unwrap();
    let limit = joint.axes[0].limit.as_mut().unwrap();
    limit.max = 0.5_f64.min(limit.max);
    thenar_rig::write_model(&folder.0.join("stiff.thenar"), &model).unwrap();
    let stiff = printed(&["hand", "--list", "stiff.thenar"]);
    assert!(stiff.contains("| 3 | `thumb-ip` | flexion | -15 | 29 | -7 |"), "{stiff}");
    for (name, why) in [
        ("middle", "expected `right`, `left`"),
        ("own.glb", "own.glb"),
        ("none.thenar", "none.thenar"),
    ] {
        let output = folder.thenar(&["hand", "--list", name]);
        assert!(output.status.code() == Some(2) && err(&output).contains(why), "{output:?}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_a_run_with_whole_files() {
    let folder = Folder::new("interrupt");
    let args = ["run", "falling-box", "--seconds", "100000", "-q", "--report", "r.json"];
    let mut child = folder.command(&args).spawn().unwrap();
    std::thread::sleep(std::time::Duration::from_millis(500));
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().unwrap().success());
    let status = child.wait().unwrap();
    assert_eq!(status.code(), Some(1));
    let report: Value = serde_json::from_str(&folder.text("r.json")).unwrap();
    assert_eq!(report["interrupted"], true);
    assert!(report["steps"].as_u64().unwrap() > 0);
    assert_eq!(folder.files(), ["r.json"]);
}

#[test]
fn validation_prints_a_table_and_writes_it_whole() {
    let folder = Folder::new("validate");
    let output = folder.thenar(&["validate", "--case", "a1", "--case", "A9", "--json", "t.json"]);
    assert!(output.status.success(), "{}", err(&output));
    let table = out(&output);
    let place = |text: &str| table.find(text).unwrap_or_else(|| panic!("{text}:\n{table}"));
    assert!(place("expected") < place("A1 ") && place("A1 ") < place("A9 "), "{table}");
    let json: Value = serde_json::from_str(&folder.text("t.json")).unwrap();
    let fall = &json["cases"][0]["figures"][0];
    assert!((fall["got"].as_f64().unwrap() + 1.2287025).abs() < 1e-9, "{fall}");
    assert_eq!((&fall["result"], &fall["tolerance"]), (&"pass".into(), &"1e-9".into()));
    assert_eq!(folder.files(), ["t.json"]);
}

#[test]
fn an_unknown_validation_case_is_bad_usage() {
    let folder = Folder::new("validate-unknown");
    let output = folder.thenar(&["validate", "--case", "Z9", "--json", "t.json"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(err(&output).contains("no case `Z9`; there are A1, A2"), "{}", err(&output));
    assert!(folder.files().is_empty());
}
