//! Goal: joints that mimic another are moved by its motor alone, share its torque, and hold one
//! another. Method: a gripper of two fingers, written here as URDF; what they do is held against a
//! rigid linkage and against the two springs that stand for it.

use std::path::PathBuf;
use thenar_scene::session::Session;

/// A palm and two fingers side by side, of which the right one turns by `law` of the left one's
/// angle.
fn urdf(law: &str) -> String {
    let finger = |name: &str, x: f64, mimic: &str| {
        format!(
            "<link name='{name}'><inertial><origin xyz='0 0 -0.03'/><mass value='0.02'/>\
             <inertia ixx='6e-6' iyy='6e-6' izz='1e-6'/></inertial><collision><origin xyz='0 0 -0.03'/>\
             <geometry><box size='0.012 0.012 0.06'/></geometry></collision></link>\
             <joint name='{name}_joint' type='revolute'><parent link='palm'/><child link='{name}'/>\
             <origin xyz='{x} 0 0'/><axis xyz='0 1 0'/><limit lower='-0.9' upper='0.9'/>{mimic}</joint>"
        )
    };
    let palm = "<link name='palm'><inertial><mass value='0.2'/><inertia ixx='1e-4' iyy='1e-4' izz='1e-4'/>\
        </inertial><collision><origin xyz='0 0 0.015'/><geometry><box size='0.1 0.02 0.02'/></geometry></collision></link>";
    format!(
        "<robot name='g'>{palm}{}{}</robot>",
        finger("left", -0.035, ""),
        finger("right", 0.035, &format!("<mimic joint='left_joint' {law}/>"))
    )
}

/// A scene of that gripper, whose palm is held, without weight; `more` are lines of its figure.
struct Gripper {
    folder: PathBuf,
}

impl Gripper {
    fn new(name: &str, law: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("thenar-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("gripper.urdf"), urdf(law)).unwrap();
        Self { folder }
    }

    fn open(&self, figure: &str, rest: &str) -> Result<Session, String> {
        let text = format!(
            "version = 1\ngravity = [0, 0, 0]\ntime_step = 0.002\n[[figure]]\nname = \"g\"\n\
             model = \"gripper.urdf\"\nflesh = 0.004\ntets = 300\nroot = \"fixed\"\nmaterial = {{ young = 5e3 }}\n\
             {figure}\n{rest}\n"
        );
        Session::from_text(&text, &self.folder.join("scene.toml"), &[]).map_err(|e| e.to_string())
    }

    fn runs(&self, figure: &str, rest: &str) -> Session {
        self.open(figure, rest).unwrap_or_else(|e| panic!("{e}"))
    }
}

impl Drop for Gripper {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}

/// Angles of left and right finger [rad].
fn angles(session: &Session) -> [f64; 2] {
    let joints = &session.world().desc().joints;
    ["left", "right"].map(|name| {
        let name = format!("g/{name}_joint");
        let joint = joints.iter().position(|joint| joint.name == name).unwrap();
        session.world().joint_angles(joint as u32)[0]
    })
}

fn run_to(session: &mut Session, time: f64) {
    while session.world().time() < time - 1e-9 {
        let report = session.step(&mut ());
        assert!(!report.non_finite && !report.fell_back, "{report:?}");
    }
}

/// 20 N m/rad beside bent flesh of some 0.05.
const MOTOR: &str = "joint = [{ name = \"left\", stiffness = [20], damping = [0.1] }]";

fn load(joint: &str, torque: f64) -> String {
    format!(
        "[[load]]\nkind = \"joint-torque\"\njoints = [\"g/{joint}_joint\"]\ntorque = {torque}\n"
    )
}

/// Keys lead the left finger; the right one is where the file's law says, on the way and at its
/// end.
#[test]
fn a_mimic_goes_where_its_law_says() {
    let gripper = Gripper::new("mimic-law", "multiplier='-0.5' offset='0.1'");
    let keys =
        "key = [{ time = 0, joints = { left = 0 } }, { time = 0.5, joints = { left = 40 } }]";
    let mut session = gripper.runs(&format!("{MOTOR}\n{keys}"), "");
    // It starts there, too.
    let [left, right] = angles(&session);
    assert!(left.abs() < 1e-9 && (right - 0.1).abs() < 1e-9, "{left} {right}");
    for (time, wanted) in [(0.25, 20.0_f64), (0.9, 40.0)] {
        run_to(&mut session, time);
        let [left, right] = angles(&session);
        assert!((left.to_degrees() - wanted).abs() < 1.0, "{left} rad at {time} s");
        assert!((right - (0.1 - 0.5 * left)).abs() < 0.5_f64.to_radians(), "{left} {right}");
    }
}

/// A load τ on the finger that mimics: of the rigid linkage both give way by τ/k. Here each has a
/// spring of k/2 and the link 4 k, so that `x_l = τ · 4k/(k/2 · 8.5 k) = 0.941 τ/k` and
/// `x_r = τ · 4.5k/(k/2 · 8.5 k) = 1.059 τ/k`. Bent flesh holds a little, too.
#[test]
fn a_load_on_a_mimic_turns_its_leader() {
    let gripper = Gripper::new("mimic-load", "multiplier='1'");
    let torque = 2.0;
    let mut session = gripper.runs(MOTOR, &load("right", torque));
    run_to(&mut session, 1.0);
    let [left, right] = angles(&session).map(|angle| angle * 20.0 / torque);
    assert!((left / 0.941 - 1.0).abs() < 0.04, "{left} τ/k");
    assert!((right / 1.059 - 1.0).abs() < 0.04, "{right} τ/k");
    let before = angles(&session);
    run_to(&mut session, 1.1);
    let after = angles(&session);
    assert!((0..2).all(|k| (after[k] - before[k]).abs() < 1e-5), "{before:?} {after:?}");
}

/// A linkage by two turns half of the torque: of a load on the mimic, twice arrives at the leader.
#[test]
fn a_gear_multiplies_torque() {
    let gripper = Gripper::new("mimic-gear", "multiplier='-2'");
    let torque = 0.5;
    let mut session = gripper.runs(MOTOR, &load("right", torque));
    run_to(&mut session, 1.0);
    let [left, right] = angles(&session);
    // Springs at the leader, in τ/k of the torque there, -2 τ; the mimic's own angle is -2 of its
    // place at the leader.
    let whole = -2.0 * torque / 20.0;
    assert!((left / (0.941 * whole) - 1.0).abs() < 0.04, "{left} rad");
    assert!((right / (-2.0 * 1.059 * whole) - 1.0).abs() < 0.04, "{right} rad");
}

/// The largest torque is that of the motor, which both fingers share: alone the mimic bears it
/// whole, and more drives both back.
#[test]
fn the_largest_torque_is_that_of_the_whole_train() {
    let gripper = Gripper::new("mimic-torque", "multiplier='1'");
    let motor = MOTOR.replace(" }]", ", torque_max = 0.5 }]");
    let pushed = |torque: f64| {
        let mut session = gripper.runs(&motor, &load("right", torque));
        // What is left of 0.2 N m drives both through the links' brake of 2 · 80 · 0.002 N m s/rad:
        // 0.6 rad/s.
        run_to(&mut session, 2.5);
        angles(&session)
    };
    let held = pushed(0.4);
    assert!(held.iter().all(|angle| (0.0..0.03).contains(angle)), "{held:?}");
    let driven = pushed(0.7);
    // To the ends of their ranges.
    assert!(driven.iter().all(|angle| *angle > 0.8), "{driven:?}");
}

#[test]
fn what_is_wrong_with_mimics_is_said() {
    let gripper = Gripper::new("mimic-errors", "multiplier='1'");
    let error = |figure: &str| gripper.open(figure, "").err().unwrap_or_default();
    let springless = error("");
    assert!(
        springless.contains("\"left_joint\" has joints that mimic it and no spring"),
        "{springless}"
    );
    let keyed = error(&format!("{MOTOR}\nkey = [{{ time = 0, joints = {{ right = 5 }} }}]"));
    assert!(keyed.contains("\"right_joint\" mimics \"left_joint\": give keys to that"), "{keyed}");
    // A name for all is meant for those that can be led.
    let all = format!("{MOTOR}\nkey = [{{ time = 0, joints = {{ \"*\" = 5 }} }}]");
    let session = gripper.runs(&all, "");
    assert!(angles(&session).iter().all(|angle| (angle.to_degrees() - 5.0).abs() < 1e-6));
}
