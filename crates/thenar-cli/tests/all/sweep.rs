//! Goal: `thenar sweep` keeps its promises: every case once, whatever is cut, shared or threaded;
//! the bits of `thenar run`; one clear error for what makes no sense. Method: the program is run
//! and killed as a user would, and its tables are read back.

use crate::stage::{self, Folder, err, out, state};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

/// A grain that a force moves: 1e12 N gives numbers that are not finite, as its position leaves all
/// bounds.
const SCENE: &str = "version = 1\nduration = 0.1\ntime_step = 0.01\n[[rigid]]\nname = \"a\"\nmass = 1e-9\n\
                     shape = { kind = \"sphere\", radius = 0.02 }\n\
                     [[load]]\nkind = \"force\"\nbody = \"a\"\nforce = [0, 0, 0]\n\
                     [[probe]]\nname = \"v\"\nmeasure = \"velocity\"\nbody = \"a\"\n";

/// A force at random, with a seed.
const NOISE: &str = "[[load]]\nkind = \"force\"\nbody = \"a\"\nforce = [1e-9, 0, 0]\n\
                     profile = { kind = \"random\", seed = 1, interval = 0.02 }\n";

fn stocked(name: &str) -> Folder {
    let folder = Folder::new(&format!("sweep-{name}"));
    std::fs::write(folder.0.join("s.toml"), SCENE).unwrap();
    folder
}

type Row = BTreeMap<String, String>;

/// The rows of a table, each cell with all its bits.
fn rows(file: &Path) -> Vec<Row> {
    let reader = SerializedFileReader::new(std::fs::File::open(file).unwrap()).unwrap();
    let cell = |(name, field): (&String, &Field)| {
        let text = match field {
            Field::Double(x) => format!("{x:?} {:016x}", x.to_bits()),
            other => other.to_string(),
        };
        (name.clone(), text)
    };
    let row = |row: parquet::record::Row| row.get_column_iter().map(cell).collect();
    reader.get_row_iter(None).unwrap().map(|r| row(r.unwrap())).collect()
}

fn json(folder: &Folder, file: &str) -> Value {
    serde_json::from_str(&folder.text(file)).unwrap()
}

/// Nine cases, of which no two are the same.
const GRID: [&str; 6] = [
    "sweep",
    "s.toml",
    "--vary",
    "rigid.a.mass=1,2.5,4",
    "--vary",
    "gravity=[0,-9.81,0],[0,-1,0],[1,0,0]",
];

#[test]
fn a_grid_is_run_and_written_with_its_manifest() {
    let folder = stocked("grid");
    let done = folder.thenar(&[&GRID[..], &["--out", "d", "--probe"]].concat());
    assert!(done.status.success(), "{}", err(&done));
    assert!(out(&done).contains("9 cases"), "{}", out(&done));
    let table = rows(&folder.0.join("d/shard-1-of-1.parquet"));
    let cases: Vec<&str> = table.iter().map(|row| row["case"].as_str()).collect();
    assert_eq!(cases, ["0", "1", "2", "3", "4", "5", "6", "7", "8"]);
    // The last key changes fastest; free fall gives v = g t.
    assert!(table[4]["rigid.a.mass"].starts_with("2.5 "), "{:?}", table[4]);
    assert_eq!(table[4]["gravity"], "\"[0,-1,0]\"");
    let fall: f64 = table[4]["v.vy.last [m/s]"].split(' ').next().unwrap().parse().unwrap();
    assert!((fall + 0.1).abs() < 1e-12, "{fall}");
    // A row has the bits of the same run alone.
    let alone =
        folder.thenar(&["run", "s.toml", "--set", "rigid.a.mass=2.5", "--set", "gravity=[0,-1,0]"]);
    assert_eq!(table[4]["state_hash"], format!("\"{}\"", state(&alone)));
    let probes = folder.text("d/probes/4.csv");
    assert!(probes.starts_with("time [s],v.vx [m/s]") && probes.lines().count() == 12, "{probes}");

    let manifest = json(&folder, "d/shard-1-of-1.json");
    assert_eq!(manifest["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(
        (&manifest["cases"], &manifest["shards"], &manifest["shard"]),
        (&9.into(), &1.into(), &1.into())
    );
    assert_eq!(manifest["keys"][0], serde_json::json!(["rigid.a.mass", "number"]));
    assert_eq!(manifest["units"]["v.vy.last [m/s]"], "m/s");
    assert!(!folder.0.join("d/shard-1-of-1").exists(), "records go when the table is there");
    // Once more, nothing is run.
    let again = folder.thenar(&[&GRID[..], &["--out", "d", "--probe"]].concat());
    assert!(again.status.success() && out(&again) == out(&done), "{}", err(&again));
}

#[test]
fn threads_and_shards_change_no_bit() {
    let folder = stocked("bits");
    for (threads, name) in [("1", "one"), ("3", "three")] {
        let done =
            folder.thenar(&[&GRID[..], &["--out", name, "--threads", threads, "-q"]].concat());
        assert!(done.status.success(), "{}", err(&done));
    }
    let file = |name: &str| folder.0.join(name).join("shard-1-of-1.parquet");
    assert!(std::fs::read(file("one")).unwrap() == std::fs::read(file("three")).unwrap());
    let mut union = Vec::new();
    for k in [2, 4, 1, 3] {
        let shard = format!("{k}/4");
        let done =
            folder.thenar(&[&GRID[..], &["--out", "shards", "--shard", &shard, "-q"]].concat());
        assert!(done.status.success(), "{}", err(&done));
        union.extend(rows(&folder.0.join(format!("shards/shard-{k}-of-4.parquet"))));
    }
    union.sort_by_key(|row| row["case"].parse::<u32>().unwrap());
    assert_eq!(union, rows(&file("one")));
}

#[test]
fn a_table_and_seeds_make_cases() {
    let folder = stocked("table");
    std::fs::write(folder.0.join("t.csv"), "rigid.a.mass,duration\n1,0.02\n\"2\",0.03\n").unwrap();
    let seeded = format!("{SCENE}{NOISE}");
    std::fs::write(folder.0.join("j.toml"), seeded).unwrap();
    let done = folder
        .thenar(&["sweep", "j.toml", "--table", "t.csv", "--seeds", "4..6", "--out", "d", "-q"]);
    assert!(done.status.success(), "{}", err(&done));
    let table = rows(&folder.0.join("d/shard-1-of-1.parquet"));
    let told: Vec<_> = table
        .iter()
        .map(|r| (r["rigid.a.mass"].as_str(), r["seed"].as_str(), r["steps"].as_str()))
        .collect();
    assert_eq!(
        told,
        [
            ("1", "4", "2"),
            ("1", "5", "2"),
            ("1", "6", "2"),
            ("2", "4", "3"),
            ("2", "5", "3"),
            ("2", "6", "3")
        ]
    );
    let hashes: std::collections::BTreeSet<_> = table.iter().map(|r| &r["state_hash"]).collect();
    assert_eq!(hashes.len(), 6, "seeds matter");
    assert_eq!(json(&folder, "d/sweep.json")["seeds"], serde_json::json!([4, 5, 6]));
}

#[test]
fn a_case_that_fails_is_recorded_and_the_others_are_run() {
    let folder = stocked("failed");
    // The first blows up; the second cannot be built: its mesh is not there.
    let args = [
        "sweep",
        "s.toml",
        "--vary",
        "load.0.force=[1e12,0,0],[0,0,0]",
        "--vary",
        "rigid.a.shape={kind=\"sphere\",radius=0.02},{kind=\"mesh\",file=\"none.obj\"}",
        "--out",
        "d",
        "-q",
    ];
    for _ in 0..2 {
        let done = folder.thenar(&args);
        assert_eq!(done.status.code(), Some(1), "{}", err(&done));
        assert!(err(&done).contains("error: 3 of 4 cases failed"), "{}", err(&done));
        let table = rows(&folder.0.join("d/shard-1-of-1.parquet"));
        let failed: Vec<&str> = table.iter().map(|row| row["failed"].as_str()).collect();
        assert!(failed[0].contains("not finite"), "{failed:?}");
        assert!(failed[1].contains("none.obj") && failed[3].contains("none.obj"), "{failed:?}");
        assert_eq!(failed[2], "null");
        assert_eq!(table[3]["steps"], "null");
    }
}

#[test]
fn what_makes_no_sense_is_one_error() {
    let folder = stocked("wrong");
    std::fs::write(folder.0.join("t.csv"), "rigid.a.mass\n1\n").unwrap();
    std::fs::write(folder.0.join("no.csv"), "rigid.a.mass\n").unwrap();
    let mass = ["--vary", "rigid.a.mass=1,2"];
    let cases: [(&[&str], &str); 16] = [
        (&[], "nothing varies"),
        (&["--vary", "rigid.a.mass="], "there is no value"),
        (&["--vary", "rigid.a.masss=1"], "masss"),
        (&["--vary", "rigid.nobody.mass=1"], "`nobody` is neither the name nor the index"),
        (&["--vary", "rigid.a.mass=1,-2"], "override"),
        (
            &["--vary", "rigid.a.mass=1,2", "--vary", "rigid. a.mass=3"],
            "\"rigid.a.mass\" is given twice",
        ),
        (&["--vary", "rigid.a.mass=1", "--set", "rigid.a.mass=3"], "given twice"),
        (&["--vary", "rigid.a.mass=1", "--table", "t.csv"], "given twice"),
        (
            &[
                "--vary",
                "rigid.a.shape.radius=1",
                "--vary",
                "rigid.a.shape={kind=\"sphere\",radius=1}",
            ],
            "inside the other",
        ),
        (&["--table", "no.csv"], "no.csv:1: the table has no cases"),
        (&["--table", "none.csv"], "none.csv"),
        (&["--seeds", "1"], "the scene states no `seed`"),
        (&[mass[0], mass[1], "--shard", "3/2"], "got 3 of 2"),
        (&[mass[0], mass[1], "--shard", "x"], "expected K/N"),
        (&[mass[0], mass[1], "--seconds", "nan"], "--seconds"),
        (&[mass[0], mass[1], "--threads", "0"], "--threads"),
    ];
    for (args, told) in cases {
        let done = folder.thenar(&[&["sweep", "s.toml", "--out", "d"], args].concat());
        assert_eq!(done.status.code(), Some(2), "{args:?}: {}", err(&done));
        let first = err(&done).lines().next().unwrap_or_default().to_string();
        assert!(
            err(&done).contains(told) && first.starts_with("error: "),
            "{args:?}: {}",
            err(&done)
        );
        assert!(!folder.0.join("d").exists(), "{args:?}: nothing is begun");
    }
}

#[test]
fn the_folder_of_another_sweep_is_refused() {
    let folder = stocked("other");
    assert!(folder.thenar(&[&GRID[..], &["--out", "d", "-q"]].concat()).status.success());
    let others: [(&[&str], &str); 4] = [
        (&["--seconds", "0.05"], "its seconds is"),
        (&["--shard", "1/2"], "its shards is"),
        (&["--set", "duration=0.2"], "its set is"),
        (&["--vary", "duration=0.2"], "its cases is|its keys is|its vary is"),
    ];
    let before = std::fs::read(folder.0.join("d/shard-1-of-1.parquet")).unwrap();
    for (args, told) in others {
        let done = folder.thenar(&[&GRID[..], &["--out", "d", "-q"], args].concat());
        assert_eq!(done.status.code(), Some(2), "{args:?}");
        let error = err(&done);
        assert!(error.contains("d holds another sweep"), "{error}");
        assert!(told.split('|').any(|told| error.contains(told)), "{error}");
    }
    assert!(std::fs::read(folder.0.join("d/shard-1-of-1.parquet")).unwrap() == before);
}

/// A closed tetrahedron, `edge` metres along the axes.
fn tetrahedron(edge: f64) -> String {
    format!(
        "v 0 0 0\nv {edge} 0 0\nv 0 {edge} 0\nv 0 0 {edge}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    )
}

/// The same command goes on only with the same files, by what is in them.
#[test]
fn files_that_a_scene_names_are_part_of_the_sweep() {
    let folder = stocked("files");
    let mesh = |edge: f64| std::fs::write(folder.0.join("m.obj"), tetrahedron(edge)).unwrap();
    mesh(0.1);
    let shapes = "rigid.a.shape={kind=\"sphere\",radius=0.02},{kind=\"mesh\",file=\"m.obj\",grid=8},\
                  {kind=\"mesh\",file=\"none.obj\"}";
    let args = |shard| {
        ["sweep", "s.toml", "--vary", shapes, "--out", "d", "--shard", shard].map(String::from)
    };
    let run = |shard| folder.thenar(&args(shard).each_ref().map(String::as_str));
    let first = run("2/3");
    assert!(first.status.success(), "{}", err(&first));
    let text = folder.text("m.obj");
    let digest = ring::digest::digest(&ring::digest::SHA256, text.as_bytes());
    let hex: String = digest.as_ref().iter().map(|byte| format!("{byte:02x}")).collect();
    let files = &json(&folder, "d/sweep.json")["files"];
    assert_eq!(*files, serde_json::json!({ "m.obj": hex, "none.obj": null }));
    // Another machine, or another day, on which the file is another one.
    mesh(0.2);
    let other = run("1/3");
    assert_eq!(other.status.code(), Some(2), "{}", err(&other));
    let told = format!("d holds another sweep: its SHA-256 of m.obj is \"{hex}\", not ");
    assert!(err(&other).contains(&told), "{}", err(&other));
    std::fs::remove_file(folder.0.join("m.obj")).unwrap();
    assert!(err(&run("1/3")).contains(&format!("of m.obj is \"{hex}\", not \"null\"")));
    // One that was not there counts as such: cases have failed for want of it.
    mesh(0.1);
    std::fs::write(folder.0.join("none.obj"), tetrahedron(0.1)).unwrap();
    assert!(err(&run("1/3")).contains("its SHA-256 of none.obj is \"null\", not "));
    std::fs::remove_file(folder.0.join("none.obj")).unwrap();
    let again = run("1/3");
    assert!(again.status.success(), "{}", err(&again));
}

/// A hundred cases of some milliseconds each.
const MANY: [&str; 9] =
    ["sweep", "s.toml", "--seconds", "20", "--seeds", "1..100", "--out", "d", "-q"];

fn many(name: &str) -> Folder {
    let folder = stocked(name);
    std::fs::write(folder.0.join("s.toml"), format!("{SCENE}{NOISE}")).unwrap();
    folder
}

/// Numbers of the cases that have a record.
fn recorded(folder: &Folder) -> Vec<u64> {
    let Ok(entries) = std::fs::read_dir(folder.0.join("d/shard-1-of-1")) else { return Vec::new() };
    let name =
        |e: std::io::Result<std::fs::DirEntry>| e.unwrap().file_name().into_string().unwrap();
    entries.filter_map(|e| name(e).strip_suffix(".json").and_then(|n| n.parse().ok())).collect()
}

/// Signals a sweep again and again after more cases, and finishes it.
#[cfg(unix)]
fn cut_again_and_again(signal: &str) {
    let whole = many(&format!("whole{signal}"));
    assert!(whole.thenar(&MANY).status.success());
    let folder = many(&format!("cut{signal}"));
    let mut before = 0;
    for _ in 0..4 {
        let command = folder.command(&MANY).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
        let mut child = stage::Running(command.unwrap());
        let begun = Instant::now();
        while recorded(&folder).len() < before + 3 && child.0.try_wait().unwrap().is_none() {
            assert!(begun.elapsed() < Duration::from_secs(120));
            std::thread::sleep(Duration::from_millis(1));
        }
        let id = child.0.id().to_string();
        let _ = std::process::Command::new("kill").args([signal, &id]).output().unwrap();
        child.0.wait().unwrap();
        if signal != "-KILL" {
            let names = std::fs::read_dir(folder.0.join("d/shard-1-of-1"));
            let partial_files = names
                .into_iter()
                .flatten()
                .filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().contains(".part"));
            assert_eq!(partial_files.count(), 0);
        }
        // What was there has stayed.
        let now = recorded(&folder).len();
        assert!(now >= before, "{now} {before}");
        before = now;
    }
    let done = folder.thenar(&MANY);
    assert!(done.status.success(), "{}", err(&done));
    let file = "d/shard-1-of-1.parquet";
    assert!(
        std::fs::read(folder.0.join(file)).unwrap() == std::fs::read(whole.0.join(file)).unwrap()
    );
    assert_eq!(rows(&folder.0.join(file)).len(), 100);
}

#[test]
#[cfg(unix)]
fn a_sweep_that_is_killed_loses_nothing_and_doubles_nothing() {
    cut_again_and_again("-KILL");
}

#[test]
#[cfg(unix)]
fn a_sweep_that_is_asked_to_end_goes_on_later() {
    cut_again_and_again("-TERM");
    cut_again_and_again("-INT");
}

#[test]
fn a_record_that_is_there_is_not_run_again_and_a_damaged_one_is() {
    let folder = stocked("resumed");
    let done = folder.thenar(&[&GRID[..], &["--out", "d", "-q"]].concat());
    assert!(done.status.success(), "{}", err(&done));
    let file = folder.0.join("d/shard-1-of-1.parquet");
    let before = rows(&file);
    std::fs::remove_file(&file).unwrap();
    let records = folder.0.join("d/shard-1-of-1");
    std::fs::create_dir_all(&records).unwrap();
    std::fs::write(records.join("2.json"), r#"{"case":2,"failed":"a mark","row":[]}"#).unwrap();
    std::fs::write(records.join("3.json"), r#"{"case":3,"fail"#).unwrap();
    let done = folder.thenar(&[&GRID[..], &["--out", "d"]].concat());
    assert!(err(&done).contains("1 of 9 cases are there already"), "{}", err(&done));
    let after = rows(&file);
    assert_eq!(after[2]["failed"], "\"a mark\"");
    for case in [0, 1, 3, 4, 5, 6, 7, 8] {
        assert_eq!(after[case], before[case]);
    }
}

/// The limit counts blocks of 512 or 1024 bytes: no record fits, `sweep.json` does.
#[test]
#[cfg(unix)]
fn a_full_disk_is_one_error_and_leaves_no_draft() {
    let folder = stocked("full");
    assert!(folder.thenar(&[&GRID[..], &["--out", "d", "-q"]].concat()).status.success());
    std::fs::remove_file(folder.0.join("d/shard-1-of-1.parquet")).unwrap();
    let program = env!("CARGO_BIN_EXE_thenar");
    let words: Vec<String> = GRID.iter().map(|word| format!("'{word}'")).collect();
    let script = format!("ulimit -f 1; exec '{program}' {} --out d -q", words.join(" "));
    let done = std::process::Command::new("sh")
        .args(["-c", &script])
        .current_dir(&folder.0)
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(1), "{}", err(&done));
    assert!(
        err(&done).contains("cannot write") && err(&done).lines().count() == 1,
        "{}",
        err(&done)
    );
    assert!(recorded(&folder).is_empty());
    let done = folder.thenar(&[&GRID[..], &["--out", "d", "-q"]].concat());
    assert!(done.status.success(), "{}", err(&done));
}

/// Of four shards, one has the case that can be built; the others' tables have its columns all the
/// same.
#[test]
fn shards_whose_cases_all_failed_have_the_columns_of_the_others() {
    let folder = stocked("columns");
    let shapes =
        ["none.obj", "gone.obj", "lost.obj"].map(|f| format!("{{kind=\"mesh\",file=\"{f}\"}}"));
    let vary = format!("rigid.a.shape={},{{kind=\"sphere\",radius=0.02}}", shapes.join(","));
    let mut columns = Vec::new();
    for k in 1..=4 {
        let shard = format!("{k}/4");
        let done = folder
            .thenar(&["sweep", "s.toml", "--vary", &vary, "--out", "d", "--shard", &shard, "-q"]);
        assert_eq!(done.status.success(), k == 4, "{}", err(&done));
        let file = std::fs::File::open(folder.0.join(format!("d/shard-{k}-of-4.parquet"))).unwrap();
        let reader = SerializedFileReader::new(file).unwrap();
        let schema = reader.metadata().file_metadata().schema().clone();
        let manifest = json(&folder, &format!("d/shard-{k}-of-4.json"));
        columns.push((schema, manifest["units"].clone()));
    }
    let names: Vec<&str> = columns[3].0.get_fields().iter().map(|field| field.name()).collect();
    assert!(names.contains(&"v.vy.last [m/s]") && names.contains(&"state_hash"), "{names:?}");
    for k in 0..3 {
        assert!(columns[k] == columns[3], "{k}: {:?}", columns[k]);
    }
}

/// A second process finds the shard taken and changes nothing; a process that was killed keeps
/// nobody out.
#[test]
#[cfg(unix)]
fn two_processes_never_run_one_shard() {
    let whole = many("alone");
    assert!(whole.thenar(&MANY).status.success());
    let folder = many("twice");
    let command = folder.command(&MANY).stdout(Stdio::null()).stderr(Stdio::null()).spawn();
    let mut first = stage::Running(command.unwrap());
    let begun = Instant::now();
    while recorded(&folder).len() < 3 {
        assert!(
            first.0.try_wait().unwrap().is_none() && begun.elapsed() < Duration::from_secs(120)
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    // Stopped, so that it is in the midst of its work for as long as the test needs.
    let signal = |name: &str, id: u32| {
        std::process::Command::new("kill").args([name, &id.to_string()]).output().unwrap()
    };
    let id = first.0.id();
    signal("-STOP", id);
    let second = folder.thenar(&MANY);
    assert_eq!(second.status.code(), Some(2), "{}", err(&second));
    let told = format!("error: d: shard 1/1 is being run by process {id};");
    assert!(
        err(&second).starts_with(&told) && err(&second).lines().count() == 1,
        "{}",
        err(&second)
    );
    signal("-KILL", id);
    first.0.wait().unwrap();
    let there = recorded(&folder).len();
    assert!((3..100).contains(&there), "{there} cases were left for the next");
    let third = folder.thenar(&MANY);
    assert!(third.status.success(), "{}", err(&third));
    let file = "d/shard-1-of-1.parquet";
    assert!(
        std::fs::read(folder.0.join(file)).unwrap() == std::fs::read(whole.0.join(file)).unwrap()
    );
    assert!(!folder.0.join("d/shard-1-of-1.lock").exists());
}
