//! Files that are wrong.

use super::*;
use thenar_core::random::Random;

fn error(text: &str) -> String {
    read_mjcf(text, Path::new(".")).unwrap_err().to_string()
}

/// The error of a body `a` with this inside, on a ball.
fn inside(a: &str) -> String {
    error(&model("", &on_ball(&format!("<body name='a'>{a}</body>"))))
}

/// The error of a body `a` on a hinge with this inside.
fn hinged(a: &str) -> String {
    inside(&format!("<joint name='j'/>{a}"))
}

fn says(error: String, expected: &str) {
    assert!(error.contains(expected), "{error}\n{expected}");
}

#[test]
fn joints_that_cannot_be_simulated_are_named() {
    let slide = inside(&format!("<joint name='s' type='slide'/>{BALL}"));
    says(slide, "joint \"s\" of body \"a\" slides, and sliding joints are not simulated");
    let free = inside(&format!("<freejoint name='f'/>{BALL}"));
    says(free, "joint \"f\" frees body \"a\" from its parent");
    let askew = hinged(&format!("<joint name='k' axis='1 0 1'/>{BALL}"));
    says(askew.clone(), "body \"a\" has 2 joints that cannot be simulated as one");
    says(askew, "the hinges \"j\" and \"k\" are not at right angles");
    let apart = hinged(&format!("<joint name='k' axis='1 0 0' pos='0 0.5 0'/>{BALL}"));
    says(apart, "do not meet in one point");
    let four = "<joint axis='1 0 0'/><joint axis='0 1 0'/><joint axis='0 0 1'/>";
    says(hinged(&format!("{four}{BALL}")), "more than three hinges");
    says(hinged(&format!("<joint type='ball'/>{BALL}")), "a ball joint turns freely already");
    says(hinged(""), "body \"a\" moves and has neither mass nor geometry");
    says(
        error(&model("", "<body name='r'/>")),
        "the root body \"r\" has neither mass nor geometry",
    );
    says(hinged(&format!("<joint name='j'/>{BALL}")), "another joint \"j\"");
}

#[test]
fn wrong_values_are_named() {
    says(inside(&format!("<joint axis='0 0 0'/>{BALL}")), "<joint>: axis must be of some length");
    says(inside(&format!("<joint range='1 1'/>{BALL}")), "range must be a smaller and a larger");
    says(inside(&format!("<joint limited='true'/>{BALL}")), "range is missing");
    says(inside(&format!("<joint damping='-1'/>{BALL}")), "damping must be at least 0, not \"-1\"");
    says(inside(&format!("<joint type='screw'/>{BALL}")), "one of free, ball, slide, hinge");
    says(hinged("<geom/>"), "size is missing");
    says(hinged("<geom size='0'/>"), "size must be 1 positive lengths for a sphere");
    says(hinged("<geom type='box' size='1 2'/>"), "size must be 3 positive lengths for a box");
    says(
        hinged("<geom name='g' type='plane' size='1 1 1'/>"),
        "geom \"g\" of body \"a\" is a plane",
    );
    says(hinged("<geom type='hfield'/>"), "is a hfield");
    says(hinged("<geom size='1' fromto='0 0 0 1 1 1'/>"), "not for a sphere");
    let point = "<geom type='capsule' size='1' fromto='0 0 0 0 0 0'/>";
    says(hinged(point), "fromto must be two different points");
    says(hinged("<geom type='mesh'/>"), "mesh is missing");
    says(hinged("<geom mesh='m'/>"), "a sphere fitted to a mesh is not read");
    says(hinged("<geom size='1' quat='0 0 0 0'/>"), "quat must be of some length");
    says(hinged("<geom size='1' euler='0 0 0' zaxis='0 0 1'/>"), "zaxis and euler are both given");
    says(hinged("<geom size='1' class='x'/>"), "there is no class \"x\"");
    let inertia = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 0'/>";
    says(hinged(inertia), "body \"a\": the inertia is not positive definite");
    says(hinged("<inertial pos='0 0 0' mass='-1'/>"), "body \"a\": mass must be at least 0");
    says(hinged("<geom size='1' pos='1e300 0 0'/>"), "body \"a\" has a place beyond");
}

#[test]
fn what_is_not_read_is_named_with_what_helps() {
    let flat = "save the model as one file (mj_saveLastXML does)";
    says(error("<mujoco><include file='x'/></mujoco>"), flat);
    says(inside("<include file='x'/>"), flat);
    for tag in ["replicate", "composite", "flexcomp", "attach"] {
        says(inside(&format!("<{tag}/>")), &format!("<{tag}>: this makes bodies"));
        says(error(&model("", &format!("<{tag}/>"))), &format!("<{tag}>: this makes bodies"));
    }
    says(error(&model("<compiler coordinate='global'/>", "")), "only local coordinates");
    says(error(&model("<compiler eulerseq='xy'/>", "")), "three of the letters");
    says(error(&model("<compiler angle='grad'/>", "")), "one of degree, radian, not \"grad\"");
    says(error(&model("", "")), "there is no <body> in <worldbody>");
    says(error("<robot/>"), "this is URDF");
    says(error("<x/>"), "begins with <mujoco>");
    let twice = "<default><default class='c'/><default class='c'/></default>";
    says(error(&model(twice, "")), "another class \"c\"");
    let mesh = "<asset><mesh name='m' vertex='0 0 0'/></asset>";
    let geom = model(mesh, "<body><geom type='mesh' mesh='m'/></body>");
    says(error(&geom), "name a mesh file");
    let deep: String = (0..60).map(|k| format!("<default class='{k}'>")).collect();
    let deep = format!("<default>{deep}{}</default>", "</default>".repeat(60));
    says(error(&model(&deep, "")), "classes nest deeper than 50");
}

/// Cut anywhere, and with any byte changed, the file is read or refused.
#[test]
fn damaged_files_are_no_reason_to_panic() {
    let head = "<compiler eulerseq='zyx'/><default><geom density='9'/><default class='c'>\
        <joint range='10 20'/></default></default>";
    let text = model(
        head,
        "<body name='r' euler='1 2 3'><geom size='.1'/><body name='a' childclass='c' pos='0 0 1'>\
         <joint axis='0 0 1'/><joint axis='1 0 0' ref='2'/><frame quat='1 0 0 1'>\
         <geom type='capsule' size='.1' fromto='0 0 0 0 0 1'/></frame>\
         <body><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></body></body>",
    );
    assert_eq!(read(&text).bones.len(), 2);
    for end in 0..text.len() {
        assert!(read_mjcf(&text[..end], Path::new(".")).is_err());
    }
    let mut random = Random::new(7);
    for _ in 0..4000 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..=random.below(3) {
            let at = random.below(bytes.len());
            bytes[at] = b"0123456789.-e<>'/ abcdefghijklmnop"[random.below(34)];
        }
        let _ = read_mjcf(&String::from_utf8_lossy(&bytes), Path::new("."));
    }
    let bodies = format!("{}{}", "<body>".repeat(1000), "</body>".repeat(1000));
    says(error(&model("", &bodies)), "deeper than 500 levels");
    let chain = format!("<joint/>{BALL}<body>").repeat(480);
    let chain = format!("<body>{chain}{}{BALL}</body>", "</body>".repeat(480));
    assert_eq!(read(&model("", &chain.replacen("<joint/>", "", 1))).bones.len(), 480);
}
