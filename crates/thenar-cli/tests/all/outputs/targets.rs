//! Targets that are no plain files.

use super::{COMMANDS, names, stocked};
use crate::stage::{Folder, err, out};
use std::fs::{self, Permissions};
use std::io::{BufRead, BufReader};
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::os::unix::net::UnixListener;
use std::process::{Command, Stdio};

#[test]
fn every_output_writes_through_links_and_keeps_permissions() {
    for command in COMMANDS {
        let folder = stocked("links");
        let ending = if ["--picture", "--movie"].iter().any(|option| command.contains(option)) {
            "png"
        } else {
            "csv"
        };
        let [real_name, link_name] = ["real", "link"].map(|name| format!("{name}.{ending}"));
        let [real, link] = [&real_name, &link_name].map(|name| folder.0.join(name));
        fs::write(&real, "old").unwrap();
        fs::set_permissions(&real, Permissions::from_mode(0o640)).unwrap();
        symlink(&real_name, &link).unwrap();
        let before = names(&folder.0);
        let output = folder.thenar(&[command, &[link_name.as_str()]].concat());
        assert!(output.status.success(), "{command:?}: {}", err(&output));
        assert!(link.is_symlink(), "{command:?}");
        let written = fs::metadata(&real).unwrap();
        assert!(written.len() > 20 && written.permissions().mode() & 0o777 == 0o640, "{command:?}");
        assert_eq!(names(&folder.0), before, "{command:?}");
    }
}

#[test]
fn every_output_is_written_to_devices_and_refuses_folders_and_sockets() {
    let folder = stocked("special");
    fs::create_dir(folder.0.join("folder")).unwrap();
    symlink("folder", folder.0.join("to-folder")).unwrap();
    let _listener = UnixListener::bind(folder.0.join("socket")).unwrap();
    let before = names(&folder.0);
    for command in COMMANDS {
        let output = folder.thenar(&[command, &["/dev/null"]].concat());
        assert!(output.status.success(), "{command:?}: {}", err(&output));
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        for (target, told) in [("folder", "folder"), ("to-folder", "folder"), ("socket", "socket")]
        {
            let output = folder.thenar(&[command, &[target]].concat());
            assert_eq!(output.status.code(), Some(2), "{command:?}: {}", err(&output));
            let told = format!("error: cannot write {target}: it is a {told}\n");
            assert_eq!(err(&output), told, "{command:?}");
        }
        assert_eq!(names(&folder.0), before, "{command:?}");
    }
    assert!(fs::metadata(folder.0.join("socket")).unwrap().file_type().is_socket());
    assert!(names(&folder.0.join("folder")).is_empty());
}

#[test]
fn every_output_says_when_the_device_is_full() {
    let folder = stocked("full-device");
    let before = names(&folder.0);
    for command in COMMANDS {
        let output = folder.thenar(&[command, &["/dev/full"]].concat());
        let told = err(&output);
        assert_eq!(output.status.code(), Some(1), "{command:?}: {told}");
        assert_eq!(told.lines().count(), 1, "{command:?}: {told}");
        assert!(told.contains("/dev/full: No space left"), "{command:?}: {told}");
        assert_eq!(names(&folder.0), before, "{command:?}");
    }
}

#[test]
fn a_table_goes_to_standard_output_and_to_pipes() {
    let folder = Folder::new("stdout");
    let run = ["run", "finger-pendulum", "--seconds", "0.001", "-q", "--probe"];
    assert!(folder.thenar(&[&run[..], &["t.csv"]].concat()).status.success());
    let table = folder.text("t.csv");
    for name in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"] {
        let piped = folder.thenar(&[&run[..], &[name]].concat());
        assert_eq!((out(&piped), err(&piped)), (table.clone(), String::new()), "{name}");
    }
    // Into a file the summary follows the table, and neither overwrites the other.
    let file = fs::File::create(folder.0.join("all.txt")).unwrap();
    let run = ["run", "finger-pendulum", "--seconds", "0.001", "--probe", "/dev/stdout"];
    assert!(folder.command(&run).stdout(file).status().unwrap().success());
    let all = folder.text("all.txt");
    assert!(all.starts_with(&table) && all[table.len()..].contains("  state "), "{all}");
    // The shell's `>(...)`.
    let program = env!("CARGO_BIN_EXE_thenar");
    let script = format!("'{program}' {} >(cat > through.csv); wait", &run[..5].join(" "));
    let bash = Command::new("bash").args(["-c", &script]).current_dir(&folder.0).output();
    if let Ok(bash) = bash {
        assert!(bash.status.success(), "{}", err(&bash));
        assert_eq!(folder.text("through.csv"), table);
    }
}

/// Commands that print more than a line.
#[test]
fn nobody_has_to_read_what_is_printed() {
    let folder = stocked("head");
    let commands: [&[&str]; 8] = [
        &["scenes"],
        &["hand", "--list"],
        &["run", "finger-pendulum", "--seconds", "0.01"],
        &["replay", "r.rec"],
        &["build", "left", "--hand", "--tets", "100"],
        &["haptics", "map", "--human", "0.05,10,50", "--rates", "500,1000", "--delays", "0"],
        &["validate", "--case", "A1", "--case", "A2"],
        &["devices", "list"],
    ];
    for command in commands {
        let mut child = folder.command(command);
        let child = child.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
        let mut child = child.unwrap();
        // Closed before anything is printed, as by `| true`.
        drop(child.stdout.take());
        let ended = child.wait_with_output().unwrap();
        assert!(!err(&ended).contains("panicked"), "{command:?}: {}", err(&ended));
        assert!(matches!(ended.status.code(), Some(0 | 1)), "{command:?}: {}", ended.status);
    }
    // What is lost for another reason is told.
    if let Ok(full) = fs::OpenOptions::new().write(true).open("/dev/full") {
        let run = ["run", "finger-pendulum", "--seconds", "0.01"];
        let ended = folder.command(&run).stdout(full).stderr(Stdio::piped()).spawn().unwrap();
        let ended = ended.wait_with_output().unwrap();
        let told = "error: cannot write the standard output: No space left on device";
        assert!(ended.status.code() == Some(1) && err(&ended).starts_with(told), "{}", err(&ended));
    }
    // The error output may be closed as well.
    let mut child = folder.command(&["run", "none"]).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stderr.take());
    assert_eq!(child.wait().unwrap().code(), Some(2));
}

#[test]
fn a_recording_is_a_plain_file() {
    let folder = Folder::new("pipe-recording");
    thenar_testing::make_pipe(&folder.0.join("pipe"));
    for name in ["pipe", "/dev/zero", "."] {
        let output = folder.thenar(&["replay", name]);
        assert_eq!(output.status.code(), Some(2), "{name}");
        let what = err(&output);
        assert!(what.starts_with("error: ") && what.lines().count() == 1, "{what}");
        assert!(what.contains(name) && !what.contains("panicked"), "{what}");
        assert!(what.contains("plain file") || what.contains("not a Thenar recording"), "{what}");
    }
}

/// `| head -1` of what would go on for an hour.
#[test]
fn a_reader_that_stops_ends_what_only_prints() {
    let folder = Folder::new("head-long");
    let soak = ["soak", "--seconds", "0.05", "--time-step", &["0.005"; 2000].join(",")];
    let mut child = folder.command(&soak).stdout(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    assert!(first.contains("seed 1"), "{first}");
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

/// No signal ends the program: a file that may grow no further is a full disk.
#[test]
fn a_file_that_may_not_grow_leaves_the_old_one_and_no_draft() {
    let folder = stocked("ulimit");
    let long = folder.thenar(&["record", "falling-box", "--seconds", "2", "-q", "-o", "long.rec"]);
    assert!(long.status.success(), "{}", err(&long));
    let program = env!("CARGO_BIN_EXE_thenar");
    for command in [
        "run falling-box --seconds 2 -q --probe",
        "replay long.rec -q --csv",
        "replay long.rec -q --mcap",
        "build left --hand --tets 100 -o",
    ] {
        std::fs::write(folder.0.join("out"), "old").unwrap();
        let before = names(&folder.0);
        // 4 or 8 kB, as the shell counts.
        let script = format!("ulimit -f 8; exec '{program}' {command} out");
        let mut shell = std::process::Command::new("sh");
        let output = shell.args(["-c", &script]).current_dir(&folder.0).output().unwrap();
        let told = err(&output);
        assert_eq!(output.status.code(), Some(1), "{command}: {told}");
        assert_eq!(told.matches("error: ").count(), 1, "{command}: {told}");
        assert!(told.contains("File too large"), "{command}: {told}");
        assert_eq!(folder.text("out"), "old", "{command}");
        assert_eq!(names(&folder.0), before, "{command}");
    }
}
