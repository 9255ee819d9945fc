//! Goal: schema, reference and shipped scenes agree with the format. Method: what is generated
//! from the declarations is compared with the files in `docs/`; scenes are checked by the library
//! and, independently, against the schema. `THENAR_UPDATE=1 cargo test -p thenar-scene --test
//! all format::` writes the generated files anew.

use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use thenar_scene::reference;
use thenar_scene::session::Session;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn compare_or_update(file: &str, wanted: &str) {
    let path = root().join(file);
    if std::env::var_os("THENAR_UPDATE").is_some() {
        std::fs::write(&path, wanted).unwrap();
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(found == wanted, "{file} is out of date: run with THENAR_UPDATE=1");
}

#[test]
fn the_schema_is_up_to_date() {
    compare_or_update("docs/scene.schema.json", &reference::schema());
}

#[test]
fn the_schema_of_motion_files_is_up_to_date() {
    compare_or_update("docs/motion.schema.json", &reference::motion_schema());
}

#[test]
fn the_reference_is_up_to_date() {
    let text = std::fs::read_to_string(root().join("docs/scene.md")).unwrap();
    let (head, _) = text.split_once("\n## All keys\n").expect("the section `All keys`");
    let wanted = format!("{head}\n## All keys\n\n{}", reference::keys());
    compare_or_update("docs/scene.md", &wanted);
}

/// Names and ranges of a hand are those of the default right hand and of the program's own enums.
#[test]
fn the_reference_of_hands_is_up_to_date() {
    let hand = thenar_rig::default_hand(thenar_core::model::Side::Right).unwrap();
    let tables = reference::hand_tables(&hand, "the default right hand").unwrap();
    let text = std::fs::read_to_string(root().join("docs/hand.md")).unwrap();
    let (head, _) = text.split_once("\n## Names and ranges\n").expect("`Names and ranges`");
    compare_or_update("docs/hand.md", &format!("{head}\n## Names and ranges\n\n{tables}"));
}

/// Checks a value against the part of JSON Schema that we use.
fn check(schema: &Value, value: &Value, defs: &Value, at: &str) -> Result<(), String> {
    let fail = |why: &str| Err(format!("{at}: {why}: {value}"));
    if let Some(part) = schema["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
        return check(&defs[part], value, defs, at);
    }
    if let Some(variants) = schema["oneOf"].as_array() {
        let fits = variants.iter().filter(|v| check(v, value, defs, at).is_ok()).count();
        return if fits == 1 { Ok(()) } else { fail(&format!("fits {fits} of oneOf")) };
    }
    if let Some(word) = schema.get("const") {
        return if word == value { Ok(()) } else { fail("not the constant") };
    }
    if let Some(words) = schema["enum"].as_array() {
        return if words.contains(value) { Ok(()) } else { fail("none of the words") };
    }
    match schema["type"].as_str().unwrap_or("none") {
        "object" => {
            let Some(table) = value.as_object() else { return fail("not an object") };
            for key in schema["required"].as_array().into_iter().flatten() {
                if !table.contains_key(key.as_str().unwrap()) {
                    return fail(&format!("{key} is missing"));
                }
            }
            for (key, inner) in table {
                let known = &schema["properties"][key.as_str()];
                let other = &schema["additionalProperties"];
                let inner_schema = match (known.is_object(), other.is_object()) {
                    (true, _) => known,
                    (false, true) => other,
                    _ => return fail(&format!("unknown key {key}")),
                };
                check(inner_schema, inner, defs, &format!("{at}.{key}"))?;
            }
            Ok(())
        }
        "array" => {
            let Some(list) = value.as_array() else { return fail("not an array") };
            let n = schema["minItems"].as_u64();
            if n.is_some_and(|n| n as usize != list.len()) {
                return fail("wrong length");
            }
            list.iter()
                .enumerate()
                .try_for_each(|(i, v)| check(&schema["items"], v, defs, &format!("{at}[{i}]")))
        }
        "string" => {
            if value.is_string() {
                Ok(())
            } else {
                fail("not a string")
            }
        }
        "boolean" => {
            if value.is_boolean() {
                Ok(())
            } else {
                fail("not a boolean")
            }
        }
        kind @ ("number" | "integer") => {
            let Some(x) = value.as_f64() else { return fail("not a number") };
            let bound = |key: &str| schema[key].as_f64();
            let inside = bound("minimum").is_none_or(|m| x >= m)
                && bound("maximum").is_none_or(|m| x <= m)
                && bound("exclusiveMinimum").is_none_or(|m| x > m)
                && bound("exclusiveMaximum").is_none_or(|m| x < m)
                && (kind == "number" || value.is_i64());
            if inside { Ok(()) } else { fail("out of bounds") }
        }
        other => fail(&format!("schema of unknown type {other}")),
    }
}

fn check_text(text: &str) -> Result<(), String> {
    let schema: Value = serde_json::from_str(&reference::schema()).unwrap();
    let value: toml::Value = toml::from_str(text).map_err(|e| e.to_string())?;
    let value = serde_json::to_value(value).unwrap();
    let root = &schema["$ref"];
    assert!(root.is_string(), "the schema's root is a reference");
    check(&schema, &value, &schema["$defs"], "scene")
}

/// All scene files under a folder, in order.
fn scene_files(folder: &Path) -> Vec<PathBuf> {
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    let (folders, files): (Vec<_>, Vec<_>) = entries.into_iter().partition(|p| p.is_dir());
    let scenes = files.into_iter().filter(|p| p.extension().is_some_and(|e| e == "toml"));
    scenes.chain(folders.iter().flat_map(|f| scene_files(f))).collect()
}

#[test]
fn all_scenes_satisfy_the_schema_and_load() {
    let folders = ["crates/thenar-scene/scenes", "crates/thenar-cli/scenes"];
    let files: Vec<_> = folders.iter().flat_map(|f| scene_files(&root().join(f))).collect();
    assert!(files.len() > 50, "{files:?}");
    for file in files {
        let text = std::fs::read_to_string(&file).unwrap();
        if !text.contains("version") {
            continue; // nodes and tetrahedra, or a motion, for a scene beside it
        }
        check_text(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        let mut session = Session::load(&file, &[]).unwrap_or_else(|e| panic!("{e}"));
        assert!(!session.step(&mut ()).non_finite, "{}", file.display());
    }
}

/// An editor can offer the joints of a hand; those of model files have names of their own.
#[test]
fn the_schema_lists_the_joints_of_hands_and_takes_others() {
    let hand = thenar_rig::default_hand(thenar_core::model::Side::Right).unwrap();
    let mut own: Vec<&str> = hand.joints.iter().map(|joint| joint.name.as_str()).collect();
    own.sort_unstable();
    let schema: Value = serde_json::from_str(&reference::schema()).unwrap();
    let of = |part: &str, key: &str| schema["$defs"][part]["properties"][key].clone();
    let mut examples: Vec<String> =
        serde_json::from_value(of("HandJoint", "name")["examples"].clone()).unwrap();
    examples.sort_unstable();
    assert_eq!(examples, own);
    let joints = of("HandKey", "joints");
    let mut known: Vec<&String> = joints["properties"].as_object().unwrap().keys().collect();
    known.sort_unstable();
    assert_eq!(known, own);
    let scene = |joint: &str| {
        format!(
            "version = 1\n[[hand]]\nname = \"h\"\n[[hand.joint]]\nname = \"{joint}\"\n\
             [hand.motion]\nkind = \"keyframes\"\n[[hand.motion.key]]\ntime = 0\n\
             joints = {{ {joint} = {{ flexion_deg = 5 }} }}\n"
        )
    };
    for joint in ["index-mcp", "thumb-ip", "index-proximal", "claw-2"] {
        check_text(&scene(joint)).unwrap_or_else(|e| panic!("{e}"));
        thenar_scene::session::read(&scene(joint), &[]).unwrap_or_else(|e| panic!("{e:?}"));
    }
    let wrong = scene("index-mcp").replace("flexion_deg", "flexion");
    assert!(check_text(&wrong).is_err());
}

#[test]
fn the_schema_refuses_what_the_library_refuses() {
    let good = "version = 1\n[[rigid]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 1]\n";
    check_text(good).unwrap();
    for bad in [
        "",
        "version = 2",
        "version = 1\ngravty = [0, 0, 0]",
        "version = 1\ntime_step = 0",
        "version = 1\n[[rigid]]\nname = \"a\"\nmass = -1",
        "version = 1\n[[rigid]]\nname = \"a\"\nshape = { kind = \"cube\" }",
        "version = 1\n[[rigid]]\nmass = 1",
        "version = 1\ngravity = [0, 0]",
    ] {
        assert!(check_text(bad).is_err(), "schema takes {bad}");
        assert!(thenar_scene::session::read(bad, &[]).is_err(), "library takes {bad}");
    }
}

/// Checks a value against a part of the schema of motion files, or its root.
fn check_motion(part: Option<&str>, value: &Value) -> Result<(), String> {
    let schema: Value = serde_json::from_str(&reference::motion_schema()).unwrap();
    let root = part.map_or(&schema["$ref"], |part| &schema["$defs"][part]);
    let root = if root.is_string() { json!({ "$ref": root }) } else { root.clone() };
    check(&root, value, &schema["$defs"], "motion")
}

/// The schema of motion files takes and refuses what scenes do; the document's example is one of
/// them.
#[test]
fn the_schema_of_motion_files_is_what_scenes_read() {
    let text = std::fs::read_to_string(root().join("docs/hand.md")).unwrap();
    let (_, section) = text.split_once("## Motion files").unwrap();
    let example = section.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let folder = thenar_output::TemporaryFolder::new("thenar-motion-schema").unwrap();
    let scene = "version = 1\n[[hand]]\nname = \"h\"\npreset = \"paper\"\ntets = 100\n\
                 motion = { kind = \"file\", file = \"m.toml\" }\n";
    let taken = |motion: &str| {
        std::fs::write(folder.path().join("m.toml"), motion).unwrap();
        Session::from_text(scene, &folder.path().join("s.toml"), &[]).map(drop)
    };
    let fits = |motion: &str| {
        let value: toml::Value = toml::from_str(motion).unwrap();
        check_motion(None, &serde_json::to_value(value).unwrap())
    };
    for good in [example, "limits = \"clamp\"\n[[key]]\ntime = 0\npose = \"fist\"\n"] {
        fits(good).unwrap();
        taken(good).unwrap();
    }
    for bad in [
        "[[key]]\npose = \"open\"",
        "[[key]]\ntime = 0\npose = \"claw\"",
        "[[key]]\ntime = -1",
        "[[key]]\ntime = 0\ncurl = { index = 2 }",
        "[[key]]\ntime = 0\nwrst = {}",
        "limit = \"clamp\"",
    ] {
        assert!(fits(bad).is_err(), "the schema takes {bad}");
        let error = taken(bad).unwrap_err().to_string();
        assert!(error.contains("m.toml"), "{error}");
    }
}

/// The lines of a recording that the schema takes are those that are read.
#[test]
fn the_schema_of_recordings_is_what_is_read() {
    use thenar_scene::motion::{Recording, TRACKED_JOINTS};
    let header = json!({
        "format": "hand-joints-jsonl", "version": 1, "joints": TRACKED_JOINTS, "quat": "x,y,z,w",
    });
    let sample = json!({
        "t": 0.5, "hand": "left", "pos": vec![[0.0, 1.0, 0.0]; 25], "quat": vec![[0.0, 0.0, 0.0, 1.0]; 25],
    });
    let agree = |header: &Value, sample: &Value, good: bool| {
        let schema = check_motion(Some("RecordingHeader"), header)
            .and(check_motion(Some("RecordingSample"), sample));
        let text = format!("{header}\n{sample}\n");
        let read = Recording::read(text.as_bytes(), Path::new("r.jsonl"));
        assert_eq!((schema.is_ok(), read.is_ok()), (good, good), "{schema:?}, {read:?}: {text}");
    };
    agree(&header, &sample, true);
    let changed = |value: &Value, key: &str, to: Value| {
        let mut value = value.clone();
        value[key] = to;
        value
    };
    agree(&header, &changed(&sample, "radius", json!(vec![0.01; 25])), true);
    for (key, to) in [("format", json!("x")), ("version", json!(2)), ("joints", json!(["wrist"]))] {
        agree(&changed(&header, key, to), &sample, false);
    }
    for (key, to) in [
        ("t", json!("now")),
        ("hand", json!("both")),
        ("pos", json!([[0, 0, 0]])),
        ("quat", json!(vec![[0, 0, 1]; 25])),
        ("radius", json!(vec![-1.0; 25])),
    ] {
        agree(&header, &changed(&sample, key, to), false);
    }
}

#[test]
fn every_example_in_the_documentation_runs() {
    let text = std::fs::read_to_string(root().join("docs/scene.md")).unwrap();
    let examples: Vec<&str> = text
        .split("```toml\n")
        .skip(1)
        .map(|rest| rest.split("```").next().unwrap_or(rest))
        .collect();
    assert!(examples.len() >= 5);
    for example in examples {
        check_text(example).unwrap_or_else(|e| panic!("{e}\n{example}"));
        let mut session = Session::from_text(example, Path::new("docs/scene.md"), &[])
            .unwrap_or_else(|e| panic!("{e}\n{example}"));
        for _ in 0..3 {
            assert!(!session.step(&mut ()).non_finite, "{example}");
            assert!(session.probe().iter().all(|x| x.is_finite()));
        }
    }
}

/// Defaults that the library owns are stated in the documentation as they are.
#[test]
fn documented_solver_defaults_are_the_library_s() {
    let schema: Value = serde_json::from_str(&reference::schema()).unwrap();
    let keys = &schema["$defs"]["SolverTable"]["properties"];
    let stated = |key: &str| -> f64 {
        let text = keys[key]["description"].as_str().unwrap();
        text.rsplit("Default ").next().unwrap().trim_end_matches('.').parse().unwrap()
    };
    let s = thenar_core::model::SolverSettings::default();
    assert_eq!(stated("cg_tolerance"), s.cg_tolerance);
    assert_eq!(stated("cg_iterations_max"), f64::from(s.cg_iterations_max));
    assert_eq!(stated("contact_tolerance"), s.contact_tolerance);
    assert_eq!(stated("contact_sweeps_max"), f64::from(s.contact_sweeps_max));
    assert_eq!(stated("contact_inner_passes"), f64::from(s.contact_inner_passes));
    assert_eq!(stated("contact_margin"), s.contact_margin);
    assert_eq!(stated("step_halvings_max"), f64::from(s.step_halvings_max));
}
