//! Files that are none: pipes that nobody writes into, devices that give bytes for ever, folders.
//! Whatever the program reads by name, it refuses them at once with one line that names file and
//! cause. Also: messages repeat what they quote up to a bound.
#![cfg(unix)]

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

/// A program that takes longer is stopped, and the test fails.
const PATIENCE: Duration = Duration::from_secs(60);

struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("thenar-inputs-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }

    /// Anything but a plain file, under this name: a pipe, a link to a device, a folder.
    fn others(&self, name: &str) -> Vec<PathBuf> {
        let places = ["pipe", "zero", "folder"].map(|kind| {
            std::fs::create_dir_all(self.0.join(kind)).unwrap();
            self.0.join(kind).join(name)
        });
        thenar_testing::make_pipe(&places[0]);
        std::os::unix::fs::symlink("/dev/zero", &places[1]).unwrap();
        std::fs::create_dir_all(&places[2]).unwrap();
        places.to_vec()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

fn thenar(arguments: &[&str], input: Option<&[u8]>) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_thenar"))
        .args(arguments)
        .stdin(if input.is_some() { Stdio::piped() } else { Stdio::null() })
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    if let (Some(bytes), Some(mut pipe)) = (input, child.stdin.take()) {
        // It may end before it has read all.
        let _ = pipe.write_all(bytes);
    }
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > PATIENCE {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{arguments:?} does not end");
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    child.wait_with_output().unwrap()
}

/// Refused with one line on the error output, which names the file and what is wrong.
fn refused(arguments: &[&str], names: &[&str]) {
    let output = thenar(arguments, None);
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {text}");
    // On a slow machine building a hand before it says how far it is.
    let lines = text
        .trim_end()
        .lines()
        .filter(|line| !line.ends_with(" %") && !line.ends_with(" s so far"));
    assert_eq!(lines.count(), 1, "{arguments:?}: {text}");
    for name in names {
        assert!(text.contains(name), "{arguments:?}: {name:?} is not in {text}");
    }
    assert!(text.len() < 2000, "{} bytes", text.len());
}

const KINDS: [&str; 3] = ["a pipe", "a device", "a folder"];

fn text(path: &Path) -> &str {
    path.to_str().unwrap()
}

#[test]
fn what_the_command_line_names_is_a_plain_file() {
    let folder = Folder::new("command");
    let names =
        ["mesh.obj", "mesh.stl", "mesh.glb", "hand.glb", "scene.toml", "run.thrc", "p.toml"];
    for name in names {
        for (path, kind) in folder.others(name).iter().zip(KINDS) {
            let path = text(path);
            let given: &[&str] = match name {
                "hand.glb" => &["build", "--hand", path],
                "scene.toml" => &["run", path],
                "run.thrc" => &["replay", path],
                "p.toml" => &["build", "--hand", "right", "--joint-names", path],
                _ => &["build", "--rigid", path],
            };
            refused(given, &[path, kind]);
            if name == "mesh.obj" {
                refused(&["build", "--soft", path], &[path, kind]);
            }
        }
        for kind in ["pipe", "zero", "folder"] {
            let path = folder.0.join(kind).join(name);
            if kind == "folder" {
                std::fs::remove_dir(path).unwrap();
            } else {
                std::fs::remove_file(path).unwrap();
            }
        }
    }
}

/// Profiles and motions that addresses of devices name.
#[test]
fn what_a_device_is_opened_with_is_a_plain_file() {
    let folder = Folder::new("device");
    let drivers = ["lucidgloves", "cyberglove", "cyberglove3", "cybergrasp", "force-device"];
    for (path, kind) in folder.others("p.toml").iter().zip(KINDS) {
        for driver in drivers {
            let address = format!("{driver}:127.0.0.1:1?profile={}", text(path));
            refused(&["devices", "test", &address], &[text(path), kind]);
        }
        let address = format!("replay:{}", text(path));
        refused(&["devices", "test", &address], &[text(path), kind]);
        refused(&["touch", "finger-pendulum", "--device", &address], &[text(path), kind]);
    }
}

/// A pipe that somebody holds open for writing gives nothing, and has no end.
#[test]
fn a_pipe_with_a_silent_writer_is_refused_as_well() {
    let folder = Folder::new("writer");
    for name in ["m.obj", "m.stl", "h.glb", "m.thenar", "s.toml", "r.rec", "t.toml", "p.jsonl"] {
        let path = folder.0.join(name);
        thenar_testing::make_pipe(&path);
        // Opened for both, which does not wait for anybody.
        let writer = std::fs::OpenOptions::new().read(true).write(true).open(&path).unwrap();
        let body = match name {
            "m.thenar" => "[[rigid]]\nname='a'\nshape={kind='mesh',file='F'}\n",
            "m.obj" => "[[rigid]]\nname='a'\nmass=1\nshape={kind='mesh',file='F'}\n",
            "t.toml" => "[[soft]]\nname='a'\nshape={kind='tet-file',file='F'}\n",
            "p.jsonl" => "[[hand]]\nname='a'\nmotion={kind='file',file='F'}\n",
            _ => "",
        };
        let scene = format!("version=1\nduration=0.1\n{}", body.replace('F', text(&path)));
        let scene = folder.write("scene.toml", scene);
        let path = text(&path);
        match name {
            "m.stl" => refused(&["build", "--soft", path], &[path, "a pipe"]),
            "h.glb" => refused(&["build", "--hand", path], &[path, "a pipe"]),
            "s.toml" => refused(&["serve", path, "--port", "0"], &[path, "a pipe"]),
            "r.rec" => {
                refused(&["replay", path], &[path, "a pipe"]);
                refused(&["replay", path, "--serve", "--port", "0"], &[path, "a pipe"]);
            }
            _ => {
                refused(&["run", text(&scene)], &["scene.toml:", path, "a pipe"]);
                refused(&["serve", text(&scene), "--port", "0"], &["scene.toml:", path, "a pipe"]);
            }
        }
        drop(writer);
    }
}

#[test]
fn what_a_scene_names_is_a_plain_file() {
    let folder = Folder::new("scene");
    let cases = [
        ("a.obj", "[[rigid]]\nname='a'\nmass=1\nshape={kind='mesh',file='F'}\n"),
        ("b.thenar", "[[rigid]]\nname='a'\nshape={kind='mesh',file='F'}\n"),
        ("c.stl", "[[soft]]\nname='a'\nshape={kind='mesh',file='F'}\n"),
        ("d.thenar", "[[soft]]\nname='a'\nshape={kind='mesh',file='F'}\n"),
        ("e.toml", "[[soft]]\nname='a'\nshape={kind='tet-file',file='F'}\n"),
        ("f.glb", "[[hand]]\nname='a'\nmodel='F'\n"),
        ("g.thenar", "[[hand]]\nname='a'\nmodel='F'\n"),
        ("h.jsonl", "[[hand]]\nname='a'\nmotion={kind='file',file='F'}\n"),
        ("i.toml", "[[hand]]\nname='a'\nmotion={kind='file',file='F'}\n"),
    ];
    for (name, body) in cases {
        for (path, kind) in folder.others(name).iter().zip(KINDS) {
            let scene = format!("version=1\nduration=0.1\n{}", body.replace('F', text(path)));
            let scene = folder.write("scene.toml", scene);
            refused(&["run", text(&scene)], &["scene.toml:", text(path), kind]);
        }
        for kind in ["pipe", "zero"] {
            std::fs::remove_file(folder.0.join(kind).join(name)).unwrap();
        }
    }
}

#[test]
fn a_scene_may_be_piped_in() {
    let scene = b"version=1\nduration=0.01\n[[rigid]]\nname='a'\nmass=1\nshape={kind='sphere',radius=0.1}\n";
    let output = thenar(&["run", "/dev/stdin"], Some(scene));
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    // Up to the bound of scene files.
    let endless = [b'#'].repeat(9 << 20);
    let output = thenar(&["run", "/dev/stdin"], Some(&endless));
    assert_eq!(output.status.code(), Some(2));
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(text.contains("/dev/stdin: the file is larger than"), "{text}");
}

/// Messages quote a file up to a bound, however long its text.
#[test]
fn messages_repeat_what_they_quote_up_to_a_bound() {
    let folder = Folder::new("long");
    let long = "9".repeat(5_000_000);
    let mesh = folder.write("long.obj", format!("v 0 0 {long}x\n"));
    refused(&["build", "--rigid", text(&mesh)], &["long.obj", "line 1", "is not a finite number"]);
    let scene = |body: &str| folder.write("long.toml", format!("version=1\nduration=0.1\n{body}"));
    let name = "k".repeat(2_000_000);
    for (body, cause) in [
        (format!("{name}=1\n"), "unknown key"),
        (format!("gravity=[0,0,{}]\n", "9".repeat(2_000_000)), "too large"),
        (format!("title=\"{name}\u{1}\"\n"), "long.toml"),
        (format!("[[rigid]]\nname=\"{name}\"\n"), "name"),
        (format!("[[hand]]\nname='a'\nmodel=\"{name}\"\n"), "got"),
        (
            format!(
                "[[hand]]\nname='a'\nmotion={{kind='file',file='{}.toml'}}\n",
                "p/".repeat(2500)
            ),
            "p/p",
        ),
        (format!("x = [ {name} \n"), "TOML"),
    ] {
        refused(&["run", text(&scene(&body))], &["long.toml", cause]);
    }
    let path = folder.0.join("p/".repeat(2500)).join("mesh.obj");
    refused(&["build", "--rigid", text(&path)], &["mesh.obj", "too long"]);
    let motion = folder.write("long.jsonl", format!("{{\"format\":\"{}\"", "x".repeat(60_000)));
    let body = format!("[[hand]]\nname='a'\nmotion={{kind='file',file='{}'}}\n", text(&motion));
    refused(&["run", text(&scene(&body))], &["long.toml", "long.jsonl"]);
    let names = folder.write("names.toml", format!("wrist = {name}\n"));
    refused(&["build", "--hand", "right", "--joint-names", text(&names)], &["names.toml"]);
}

/// Overrides come from scripts and from recordings.
#[test]
fn overrides_are_as_deep_as_files_and_quoted_without_what_acts_on_a_terminal() {
    let deep = format!("{}b=1", "a.".repeat(50_000));
    for command in [&["run"][..], &["record"], &["serve", "--no-open"], &["compare"]] {
        let arguments = [command, &["falling-box", "--set", &deep]].concat();
        refused(&arguments, &["override", "too deep: the key has 50001 parts, at most 80"]);
    }
    let hostile = "solver.\u{1b}[31mcone\u{202e}=1\nerror: all is lost";
    let output = thenar(&["run", "falling-box", "--set", hostile], None);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{told}");
    assert!(told.contains("`solver.\\u{1b}[31mcone\\u{202e}=1\\nerror: all is lost`"), "{told}");
    assert_eq!(told.matches(|c: char| c.is_control() || c == '\u{202e}').count(), 1, "{told:?}");
}

/// A scene that would take too much memory is refused before it takes any, with both numbers.
#[test]
fn a_scene_of_gigabytes_is_refused() {
    let folder = Folder::new("large");
    let ball = "shape={kind='ball',radius=0.05,frequency=60,layers=9}\n";
    let lattice = "shape={kind='lattice',size=[1,1,1],cells=[100,100,100]}\n";
    let bread = "shape={kind='bread',cells=[100,50,50]}\n";
    for shape in [ball, lattice, bread] {
        let text_ = format!("version=1\nduration=0.1\n[[soft]]\nname='a'\n{shape}");
        let scene = folder.write("large.toml", text_);
        refused(&["run", text(&scene)], &["large.toml", "soft[0].shape", "tetrahedra", "850 MB"]);
    }
    // Many that are allowed each.
    let one = |i: usize| {
        format!("[[soft]]\nname='b{i}'\nshape={{kind='ball',radius=0.05,frequency=20}}\n")
    };
    let many: String = (0..6).map(one).collect();
    let scene = folder.write("many.toml", format!("version=1\nduration=0.1\n{many}"));
    refused(&["run", text(&scene)], &["many.toml", "soft[5].shape", "850 MB"]);
}
