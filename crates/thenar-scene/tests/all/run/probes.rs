//! Goal: loads act and probes measure what they say. Method: bodies whose answers are known from
//! theory, as scene files.

use std::path::Path;
use thenar_core::model::BodyId;
use thenar_core::{Pose, Quat};
use thenar_scene::build::BuiltHand;
use thenar_scene::session::Session;

fn load(text: &str) -> Session {
    let text = format!("version = 1\n{text}");
    Session::from_text(&text, Path::new("test.toml"), &[]).unwrap_or_else(|e| panic!("{e}"))
}

fn value(session: &mut Session, column: &str) -> f64 {
    let at = session.columns().iter().position(|c| c.name == column);
    let at = at.unwrap_or_else(|| panic!("no column {column}"));
    session.probe()[at]
}

fn run(session: &mut Session) {
    for _ in 0..session.steps_wanted() {
        assert!(!session.step(&mut ()).non_finite);
    }
}

#[track_caller]
fn near(got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance, "got {got}, expected {expected} ± {tolerance}");
}

/// The 240 Kuhn tetrahedra of validation case B3 have one answer: 0.522496 mm at full load.
#[test]
fn the_cantilever_of_the_documentation_sinks_as_its_mesh_must() {
    let text = include_str!("../../../../../docs/scene.md");
    let example = text.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let mut session = Session::from_text(example, Path::new("bar.toml"), &[]).unwrap();
    run(&mut session);
    near(value(&mut session, "end.y"), -0.522496e-6, 1e-5 * 0.522496e-6);
}

const BLOCK: &str = r#"
gravity = [0, 0, 0]
time_step = 10.0
duration = 100.0
solver = { cg_tolerance = 1e-13, cg_iterations_max = 5000 }
[[soft]]
name = "block"
shape = { kind = "lattice", size = [0.02, 0.02, 0.02], cells = [3, 3, 3], jitter = 0.15 }
material = { young = 50e3, poisson = 0.45 }
contact = false
"#;

/// ΔV/V = -3 (1 - 2ν) p / E for a small pressure.
#[test]
fn pressure_shrinks_a_free_block() {
    let (p, e, nu) = (5.0, 50e3, 0.45);
    let mut session = load(&format!(
        "{BLOCK}fixed = [
            {{ nodes = {{ indices = [0] }}, axes = \"xyz\" }},
            {{ nodes = {{ indices = [3] }}, axes = \"yz\" }},
            {{ nodes = {{ indices = [12] }}, axes = \"z\" }},
        ]
        [[load]]
        kind = \"pressure\"
        body = \"block\"
        faces = {{}}
        pressure = {p}
        [[probe]]
        name = \"v\"
        measure = \"volume\"
        body = \"block\"
        [[probe]]
        name = \"s\"
        measure = \"stress\"
        body = \"block\""
    ));
    near(value(&mut session, "v.volume"), 8e-6, 1e-18);
    run(&mut session);
    let change = value(&mut session, "v.volume") / 8e-6 - 1.0;
    let expected = -3.0 * (1.0 - 2.0 * nu) * p / e;
    near(change, expected, 1e-3 * expected.abs());
    for column in ["s.xx", "s.yy", "s.zz"] {
        near(value(&mut session, column), -p, 1e-3 * p);
    }
    near(value(&mut session, "s.spread"), 0.0, 1e-3 * p);
    near(value(&mut session, "s.von_mises"), 0.0, 1e-3 * p);
}

/// A corotational bar stretched by λ with free sides: P = E (λ - 1), sides 1 - ν (λ - 1).
#[test]
fn a_stretched_block_has_the_stress_of_its_law() {
    let stretch = 0.8;
    let mut session = load(&format!(
        "{BLOCK}deform = [{{ matrix = [[{stretch}, 0, 0], [0, 1, 0], [0, 0, 1]] }}]
        fixed = [
            {{ nodes = {{ side = \"x-min\" }}, axes = \"x\" }},
            {{ nodes = {{ side = \"x-max\" }}, axes = \"x\" }},
            {{ nodes = {{ indices = [0] }}, axes = \"yz\" }},
            {{ nodes = {{ indices = [12] }}, axes = \"z\" }},
        ]
        [[probe]]
        name = \"p\"
        measure = \"stress\"
        body = \"block\"
        stress = \"nominal\"
        [[probe]]
        name = \"top\"
        measure = \"nodes\"
        body = \"block\"
        nodes = {{ side = \"y-max\" }}
        [[probe]]
        name = \"bottom\"
        measure = \"nodes\"
        body = \"block\"
        nodes = {{ side = \"y-min\" }}"
    ));
    run(&mut session);
    near(value(&mut session, "p.xx"), -10e3, 1e-4);
    near(value(&mut session, "p.yy"), 0.0, 1e-4);
    let height = value(&mut session, "top.y") - value(&mut session, "bottom.y");
    near(height / 0.02, 1.09, 1e-8);
}

/// The twist of a load is its torque, and turns the face about the axis.
#[test]
fn a_twist_is_a_pure_torque() {
    let mut session = load(
        "gravity = [0, 0, 0]
        time_step = 0.001
        duration = 0.01
        [[soft]]
        name = \"block\"
        shape = { kind = \"lattice\", size = [0.02, 0.01, 0.01], cells = [2, 3, 3] }
        contact = false
        [[load]]
        kind = \"twist\"
        body = \"block\"
        faces = { side = \"x-max\" }
        torque = [2e-5, 0, 0]
        [[probe]]
        name = \"m\"
        measure = \"momentum\"
        [[probe]]
        name = \"end\"
        measure = \"rotation\"
        body = \"block\"
        nodes = { side = \"x-max\" }",
    );
    session.step(&mut ());
    // After one step the angular momentum is torque × time.
    near(value(&mut session, "m.lx"), 2e-8, 2e-11);
    for column in ["m.px", "m.py", "m.pz", "m.ly", "m.lz"] {
        near(value(&mut session, column), 0.0, 2e-11);
    }
    run(&mut session);
    assert!(value(&mut session, "end.rx") > 1e-3);
    // The mesh is not symmetric, so a little sideways turn remains.
    near(value(&mut session, "end.ry"), 0.0, 0.1 * value(&mut session, "end.rx"));
}

/// A rotated start pose is measured as that rotation, also by a flat face alone.
#[test]
fn rotations_of_nodes_are_measured() {
    let mut session = load(
        "[[soft]]
        name = \"block\"
        shape = { kind = \"lattice\", size = [0.02, 0.01, 0.01], cells = [2, 3, 3] }
        deform = [{ matrix = [[0, -1, 0], [1, 0, 0], [0, 0, 1]] }]
        [[probe]]
        name = \"all\"
        measure = \"rotation\"
        body = \"block\"
        [[probe]]
        name = \"face\"
        measure = \"rotation\"
        body = \"block\"
        nodes = { side = \"y-max\" }
        [[probe]]
        name = \"r\"
        measure = \"radius\"
        body = \"block\"
        nodes = { side = \"x-max\" }
        axis = [1, 0, 0]",
    );
    for name in ["all", "face"] {
        near(value(&mut session, &format!("{name}.rx")), 0.0, 1e-9);
        near(value(&mut session, &format!("{name}.rz")), std::f64::consts::FRAC_PI_2, 1e-9);
    }
    // The face x = 0.01 now lies at y = 0.01; mean over 4×4 nodes of √(0.01² + z²).
    let z = [-0.005, -0.005 / 3.0, 0.005 / 3.0, 0.005f64];
    let mean = z.iter().map(|z| (1e-4 + z * z).sqrt()).sum::<f64>() / 4.0;
    near(value(&mut session, "r.mean"), mean, 1e-12);
}

/// Mass on a spring and damper, backward Euler: x(0.1 s) = 3.782747 mm with steps of 1 ms.
#[test]
fn a_drive_is_a_damped_spring() {
    let mut session = load(
        "gravity = [0, 0, 0]
        time_step = 0.001
        duration = 0.1
        [[rigid]]
        name = \"mass\"
        mass = 0.02
        inertia = [1e-6, 1e-6, 1e-6]
        position = [0.01, 0, 0]
        drive = { stiffness = 100, damping = 0.2 }
        keyframes = [{ time = 0, position = [0, 0, 0] }]
        [[probe]]
        name = \"mass\"
        measure = \"point\"
        body = \"mass\"
        [[probe]]
        name = \"f\"
        measure = \"drive-force\"
        body = \"mass\"",
    );
    // The first force is k x less nothing: the mass is at rest.
    near(value(&mut session, "f.fx"), -1.0, 1e-12);
    run(&mut session);
    near(value(&mut session, "mass.x"), 3.782747e-3, 1e-9);
}

/// Scripted bodies are where their keyframes say, to round-off, and their ramped force acts.
#[test]
fn scripts_and_profiles_keep_time() {
    let mut session = load(
        "gravity = [0, 0, 0]
        time_step = 0.01
        duration = 1.0
        [[rigid]]
        name = \"arm\"
        motion = \"scripted\"
        interpolation = \"linear\"
        keyframes = [
            { time = 0, position = [0, 0, 0] },
            { time = 1, position = [0, 1, 0], rotation = { axis = [1, 0, 0], angle_deg = 90 } },
        ]
        [[rigid]]
        name = \"free\"
        mass = 2.0
        inertia = [1, 1, 1]
        [[load]]
        kind = \"force\"
        body = \"free\"
        force = [4, 0, 0]
        profile = { kind = \"ramp\", full = 0.5, until = 0.75 }
        [[probe]]
        name = \"arm\"
        measure = \"pose\"
        body = \"arm\"
        [[probe]]
        name = \"free\"
        measure = \"velocity\"
        body = \"free\"",
    );
    run(&mut session);
    near(value(&mut session, "arm.y"), 1.0, 1e-12);
    near(value(&mut session, "arm.qx"), 0.5f64.sqrt(), 1e-9);
    // Impulse by steps: 4 N × (Σ_{k=1}^{50} k/50 + 25) × 0.01 s over 2 kg.
    near(value(&mut session, "free.vx"), 4.0 * (25.5 + 25.0) * 0.01 / 2.0, 1e-9);
}

/// Random torques between bodies leave the momentum of the whole alone.
#[test]
fn random_joint_torques_are_internal() {
    let text = include_str!("../../../../../docs/scene.md");
    let example = text.split("```toml\n").nth(5).unwrap().split("```").next().unwrap();
    assert!(example.contains("random"));
    let mut session = Session::from_text(example, Path::new("chain.toml"), &[]).unwrap();
    run(&mut session);
    let [_, rate] = session.world().rigid_velocity(1);
    assert!(rate.norm() > 1e-3, "nothing moved");
    for column in ["all.px", "all.py", "all.pz"] {
        near(value(&mut session, column), 0.0, 1e-12);
    }
    for column in ["all.lx", "all.ly", "all.lz"] {
        near(value(&mut session, column), 0.0, 1e-9);
    }
}

/// A box at rest on a table presses with its weight, half a centimetre from where it is heavy.
#[test]
fn contact_carries_the_weight() {
    let mut session = load(
        "time_step = 0.002
        duration = 0.4
        [[rigid]]
        name = \"table\"
        shape = { kind = \"plane\" }
        motion = \"fixed\"
        [[rigid]]
        name = \"box\"
        shape = { kind = \"box\", size = [0.06, 0.04, 0.08] }
        mass = 0.3
        position = [1, 0.02, 2]
        [[load]]
        kind = \"force\"
        body = \"box\"
        force = [0, -1, 0]
        point = [0.01, 0, 0]
        [[probe]]
        name = \"c\"
        measure = \"contact\"
        bodies = [\"table\", \"box\"]",
    );
    run(&mut session);
    let weight = 0.3 * 9.81 + 1.0;
    near(value(&mut session, "c.fy"), -weight, 0.01 * weight); // on the table
    near(value(&mut session, "c.normal"), weight, 0.01 * weight);
    near(value(&mut session, "c.shear"), 0.0, 0.01 * weight);
    // Moments about z: the centre of pressure lies towards the extra force.
    near(value(&mut session, "c.cx"), 1.0 + 0.01 / weight, 2e-4);
    near(value(&mut session, "c.cz"), 2.0, 2e-4);
}

/// A hand whose palm is held, with the tip of the index finger at the origin, pad down.
fn hand_at_its_fingertip() -> String {
    let hand = |place: &str| {
        format!(
            "gravity = [0, 0, 0]
            duration = 0.4
            time_step = 0.005
            [[hand]]
            preset = \"paper\"
            name = \"hand\"
            {place}"
        )
    };
    let session = load(&hand(""));
    let BuiltHand { model, handle, .. } = &session.hands()[0];
    let tip = model.bones.iter().position(|b| b.name == "index-distal").unwrap();
    let [start_B, end_B] = model.bones[tip].ends_B;
    let pose_WB = session.world().rigid_pose(handle.bones.start + tip as u32);
    let pose = (pose_WB * Pose::new((start_B + end_B) / 2.0, Quat::identity())).inverse();
    let ([x, y, z], q) = (pose.position.into(), pose.rotation);
    let (axis, angle) = q.axis_angle().unwrap();
    let (ax, ay, az, angle) = (axis.x, axis.y, axis.z, angle.to_degrees());
    hand(&format!(
        "position = [{x}, {y}, {z}]
        rotation = {{ axis = [{ax}, {ay}, {az}], angle_deg = {angle} }}"
    ))
}

/// 200 N on the tip of an index finger between two plates crush its flesh, so that the bone bears
/// most: the contact of the hand with a plate is all that the plate feels, on whichever side of the
/// pair the hand is.
#[test]
fn the_bones_of_a_hand_count_in_its_contact() {
    let hand = hand_at_its_fingertip();
    let mut session = load(&format!(
        "{hand}
        [[rigid]]
        name = \"lower\"
        shape = {{ kind = \"box\", size = [0.018, 0.01, 0.016] }}
        motion = \"fixed\"
        position = [0, -0.015, 0]
        [[rigid]]
        name = \"upper\"
        shape = {{ kind = \"box\", size = [0.018, 0.01, 0.016] }}
        mass = 0.0226
        inertia = [1e3, 1e3, 1e3]
        position = [0, 0.015, 0]
        [[load]]
        kind = \"force\"
        body = \"upper\"
        force = [0, -200, 0]
        profile = {{ kind = \"ramp\", full = 0.2 }}
        [[probe]]
        name = \"c\"
        measure = \"contact\"
        bodies = [\"hand\", \"lower\"]
        [[probe]]
        name = \"back\"
        measure = \"contact\"
        bodies = [\"lower\", \"hand\"]
        [[probe]]
        name = \"on plate\"
        measure = \"contact-force\"
        body = \"lower\""
    ));
    run(&mut session);
    for axis in ["fx", "fy", "fz"] {
        let probes = ["c", "back", "on plate"];
        let [c, back, plate] = probes.map(|p| value(&mut session, &format!("{p}.{axis}")));
        near(c, -plate, 1e-9 * plate.abs());
        near(back, plate, 1e-9 * plate.abs());
    }
    // The plate's load, less what the drives of the finger hold.
    near(value(&mut session, "c.fy"), 190.0, 12.0);
    let [normal, sum] = ["c.normal", "c.normal_sum"].map(|column| value(&mut session, column));
    assert!(sum >= normal && normal > 180.0, "{normal} N of {sum} N");
    // Pressure is that on the skin; what the bone bears is told in forces alone.
    let [area, mean] = ["c.area", "c.pressure_mean"].map(|column| value(&mut session, column));
    let world = session.world();
    let lower = world.desc().rigids.iter().position(|r| r.name == "lower").unwrap() as u32;
    let on_plate = world.contacts().iter().filter(|c| c.bodies.contains(&BodyId::Rigid(lower)));
    let on_skin = on_plate.filter(|c| c.bodies.iter().any(|b| matches!(b, BodyId::Soft(_))));
    let skin: f64 = on_skin.map(|c| c.force_W.dot(&c.normal_W)).sum();
    assert!(skin > 10.0 && sum - skin > 50.0, "the skin bears {skin} N of {sum} N");
    near(mean * area, skin, 1e-9 * skin);
}

/// A ball pressed into a pad: no bone bears anything, so the mean pressure times the area is the
/// load.
#[test]
fn mean_pressure_times_area_is_the_load() {
    for depth in [0.5e-3, 1.5e-3] {
        let mut session = load(&format!(
            "gravity = [0, 0, 0]
            duration = 0.3
            time_step = 0.005
            [[soft]]
            name = \"pad\"
            shape = {{ kind = \"lattice\", size = [0.03, 0.012, 0.03], cells = [12, 5, 12] }}
            material = {{ young = 50e3, poisson = 0.45 }}
            stiffness_damping = 0.01
            fixed = [{{ nodes = {{ side = \"y-min\" }}, axes = \"xyz\" }}]
            [[rigid]]
            name = \"ball\"
            shape = {{ kind = \"sphere\", radius = 0.01 }}
            motion = \"scripted\"
            keyframes = [
                {{ time = 0, position = [0, 0.0165, 0] }},
                {{ time = 0.2, position = [0, {}, 0] }},
            ]
            [[probe]]
            name = \"c\"
            measure = \"contact\"
            bodies = [\"pad\", \"ball\"]",
            0.016 - depth
        ));
        run(&mut session);
        let [area, mean, load] =
            ["c.area", "c.pressure_mean", "c.normal_sum"].map(|c| value(&mut session, c));
        assert!(load > 0.01 && area > 1e-6, "{load} N on {area} m²");
        near(mean * area, load, 0.01 * load);
    }
}

/// Every solver setting arrives in the world.
#[test]
fn solver_settings_arrive() {
    use thenar_core::model::{Cone, FleshInStep1, JointLimits, SolverKind, SolverSettings};
    let given = "[solver]
        kind = \"two-step\"
        cone = \"linearised\"
        limits = \"springs\"
        step1_flesh = \"frozen\"
        velocity_tolerance = 1e-7
        cg_tolerance = 1e-9
        cg_iterations_max = 11
        contact_tolerance = 1e-7
        contact_sweeps_max = 13
        contact_work_max = 2e7
        contact_inner_passes = 17
        contact_margin = 0.002
        step_halvings_max = 5
        close_joints = false";
    let expected = SolverSettings {
        kind: SolverKind::TwoStep,
        cone: Cone::Linearised,
        limits: JointLimits::Springs,
        velocity_tolerance: 1e-7,
        step1_flesh: FleshInStep1::Frozen,
        cg_tolerance: 1e-9,
        cg_iterations_max: 11,
        contact_tolerance: 1e-7,
        contact_work_max: Some(20_000_000),
        contact_sweeps_max: 13,
        contact_inner_passes: 17,
        contact_margin: 0.002,
        step_halvings_max: 5,
        close_joints: false,
    };
    assert_eq!(load(given).world().desc().solver, expected);
    assert_eq!(load("").world().desc().solver, SolverSettings::default());
}

/// 5 N m on the index finger's first joint, palm held: its bounds give way by less than 0.01°, and
/// bear all of the load once the finger rests.
#[test]
fn a_knuckle_holds_five_newton_metres() {
    for (torque, flesh) in [(5.0, false), (-5.0, false), (5.0, true)] {
        let mut session = load(&format!(
            "gravity = [0, 0, 0]
            duration = 0.6
            time_step = 0.002
            [solver]
            kind = \"monolithic\"
            [[hand]]
            preset = \"paper\"
            name = \"hand\"
            flesh = {flesh}
            bone_drive = {{ stiffness = 0 }}
            palm_drive = {{ stiffness = 1e4, damping = 100, angular_stiffness = 1e3,
                angular_damping = 10 }}
            [[load]]
            kind = \"joint-torque\"
            joints = [\"hand/index-mcp\"]
            torque = {torque}
            [[probe]]
            name = \"knuckle\"
            measure = \"joint\"
            joint = \"hand/index-mcp\""
        ));
        run(&mut session);
        let joint = |j: &&thenar_core::model::JointDesc| j.name == "hand/index-mcp";
        let limit = session.world().desc().joints.iter().find(joint).unwrap().axes[1].limit;
        let limit = limit.unwrap();
        let bound = if torque > 0.0 { limit.max } else { limit.min };
        near(value(&mut session, "knuckle.angle1"), bound, 0.01_f64.to_radians());
        // The joint's own spring bears some hundredths, the paper's stiff flesh bent by a right
        // angle, and crushed in the crease, some tenths.
        let others = if flesh { 0.8 } else { 0.1 };
        near(value(&mut session, "knuckle.limit_torque1"), -torque, others);
    }
}
