mod errors;

use super::super::plan::PlanBone;
use super::*;
use std::f64::consts::PI;
use thenar_core::model::JointKind;
use thenar_core::shape::Shape;
use thenar_core::{Mat3, Pose, Vec3};

const BALL: &str = "<geom size='0.1'/>";

fn read(text: &str) -> Plan {
    read_mjcf(text, Path::new(".")).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// A model of these bodies after this head.
fn model(head: &str, bodies: &str) -> String {
    format!("<mujoco model='m'>\n{head}\n<worldbody>{bodies}</worldbody></mujoco>")
}

/// A root ball with this inside.
fn on_ball(inside: &str) -> String {
    format!("<body name='base'>{BALL}{inside}</body>")
}

fn bone<'a>(plan: &'a Plan, name: &str) -> &'a PlanBone {
    plan.bones.iter().find(|bone| bone.name == name).unwrap()
}

fn near(a: &Vec3, b: [f64; 3]) {
    assert!((a - Vec3::from(b)).norm() < 1e-9, "{a} {b:?}");
}

/// The file's (x, y, z) is the figure's (x, z, -y).
#[test]
fn bodies_stand_upright_with_their_joints_in_place() {
    let text = model(
        "",
        &format!(
            "<body name='base' pos='0 0 1'><freejoint/>{BALL}<body name='a' pos='0.5 0.2 0'>\
             <joint name='j' pos='0.1 0 0' axis='0 2 0' range='-90 45' stiffness='3' springref='30' damping='0.2'/>\
             {BALL}</body><body pos='0 0 1'><joint type='ball' damping='7'/>{BALL}</body></body>"
        ),
    );
    let plan = read(&text);
    assert_eq!((plan.name.as_str(), plan.bones.len()), ("m", 3));
    assert!(plan.bones[0].joint.is_none() && plan.notes.is_empty(), "{:?}", plan.notes);
    near(&plan.bones[0].pose_ML.position, [0.0, 1.0, 0.0]);
    let a = bone(&plan, "a");
    near(&a.pose_ML.position, [0.5, 1.0, -0.2]);
    let joint = a.joint.as_ref().unwrap();
    near(&joint.pose_MJ.position, [0.6, 1.0, -0.2]);
    near(&joint.pose_MJ.vector(&Vec3::x()), [0.0, 0.0, -1.0]);
    let axis = joint.axes[0];
    let limit = axis.limit.unwrap();
    assert!((limit.min + PI / 2.0).abs() < 1e-12 && (limit.max - PI / 4.0).abs() < 1e-12);
    assert!((axis.rest_angle - PI / 6.0).abs() < 1e-12);
    assert_eq!((axis.stiffness, axis.damping), (3.0, 0.2));
    // Nameless things get names.
    let other = bone(&plan, "body 2");
    near(&other.pose_ML.position, [0.0, 2.0, 0.0]);
    let joint = other.joint.as_ref().unwrap();
    assert_eq!((joint.name.as_str(), joint.kind), ("body 2", JointKind::Ball));
    assert_eq!(joint.axes[0].damping, 7.0);
}

#[test]
fn angles_are_degrees_unless_the_compiler_says_radian() {
    let limit = |compiler: &str, joint: &str| {
        let inside = format!("<body name='a'><joint {joint}/>{BALL}</body>");
        let plan = read(&model(compiler, &on_ball(&inside)));
        bone(&plan, "a").joint.as_ref().unwrap().axes[0].limit.map(|l| (l.min, l.max))
    };
    let radian = "<compiler angle='radian'/>";
    assert_eq!(limit(radian, "range='-0.5 1'"), Some((-0.5, 1.0)));
    assert_eq!(limit(radian, "range='-0.5 1' limited='false'"), None);
    assert_eq!(limit(radian, ""), None);
    let manual = "<compiler angle='radian' autolimits='false'/>";
    assert_eq!(limit(manual, "range='-0.5 1'"), None);
    assert_eq!(limit(manual, "range='-0.5 1' limited='true'"), Some((-0.5, 1.0)));
    // The placement in the file is at the angle `ref`.
    assert_eq!(limit(radian, "range='-0.5 1' ref='0.25'"), Some((-0.75, 0.75)));
    let (min, max) = limit("", "range='-90 180'").unwrap();
    assert!((min + PI / 2.0).abs() < 1e-12 && (max - PI).abs() < 1e-12);
}

/// A quarter turn about z, written in every way, takes x to y, which upright is -z.
#[test]
fn turns_are_read_however_they_are_written() {
    let turned = |compiler: &str, turn: &str| {
        let plan = read(&model(compiler, &format!("<body {turn}>{BALL}</body>")));
        plan.bones[0].pose_ML
    };
    for turn in
        ["quat='1 0 0 1'", "axisangle='0 0 3 90'", "xyaxes='0 2 0 -1 5 0'", "euler='0 0 90'"]
    {
        near(&turned("", turn).vector(&Vec3::x()), [0.0, 0.0, -1.0]);
        near(&turned("", turn).vector(&Vec3::z()), [0.0, 1.0, 0.0]);
    }
    // z to x: x goes to -z, which upright is down.
    near(&turned("", "zaxis='4 0 0'").vector(&Vec3::z()), [1.0, 0.0, 0.0]);
    near(&turned("", "zaxis='4 0 0'").vector(&Vec3::x()), [0.0, -1.0, 0.0]);
    near(&turned("", "zaxis='0 0 -1'").vector(&Vec3::z()), [0.0, -1.0, 0.0]);
    // About x, then the turned y: z goes to -y, then stays in the plane across the new y = z.
    let moving = turned("", "euler='90 90 0'");
    near(&moving.vector(&Vec3::y()), [0.0, 1.0, 0.0]);
    near(&moving.vector(&Vec3::z()), [1.0, 0.0, 0.0]);
    // About x, then the fixed y: y goes to z, then to x.
    let fixed = turned("<compiler eulerseq='XYZ'/>", "euler='90 90 0'");
    near(&fixed.vector(&Vec3::y()), [1.0, 0.0, 0.0]);
    let radian = turned("<compiler angle='radian'/>", "euler='0 0 1.5707963267948966'");
    near(&radian.vector(&Vec3::x()), [0.0, 0.0, -1.0]);
}

#[test]
fn geoms_lie_as_the_format_says() {
    let plan = read(&model(
        "",
        "<body><geom type='capsule' size='0.05' fromto='0.1 0 0 0.4 0 0'/>\
         <geom type='box' size='0.1' fromto='0 0 0 0 0 1'/>\
         <geom type='cylinder' size='0.1 0.3' pos='0 1 0'/>\
         <geom type='ellipsoid' size='0.1 0.2 0.3' euler='90 0 0'/></body>",
    ));
    let [pill, block, rod, egg] = &plan.bones[0].solids[..] else { panic!("four solids") };
    let Shape::Capsule { radius, half_length } = pill.shape else { panic!("a capsule") };
    assert!((radius - 0.05).abs() < 1e-12 && (half_length - 0.15).abs() < 1e-12);
    near(&pill.pose_MS.position, [0.25, 0.0, 0.0]);
    near(&pill.pose_MS.vector(&Vec3::y()), [-1.0, 0.0, 0.0]);
    assert_eq!(block.shape, Shape::Cuboid { half: Vec3::new(0.1, 0.1, 0.5) });
    near(&block.pose_MS.position, [0.0, 0.5, 0.0]);
    assert_eq!(rod.shape, Shape::Cylinder { radius: 0.1, half_length: 0.3 });
    near(&rod.pose_MS.position, [0.0, 0.0, -1.0]);
    near(&rod.pose_MS.vector(&Vec3::y()), [0.0, 1.0, 0.0]);
    assert_eq!(egg.shape, Shape::Ellipsoid { half: Vec3::new(0.1, 0.2, 0.3) });
    near(&egg.pose_MS.vector(&Vec3::y()), [0.0, 1.0, 0.0]);
}

#[test]
fn classes_inherit_and_elements_override() {
    let head = "<compiler angle='radian'/>\
        <default><joint damping='0.1' axis='0 1 0'/><geom size='0.1'/>\
        <default class='arm'><joint damping='0.5'/><default class='hand'><joint range='-1 2'/></default>\
        </default><default class='thin'><geom size='0.02 0.3' type='capsule'/></default></default>";
    let plan = read(&model(
        head,
        "<body name='base' childclass='arm'><geom class='thin' quat='1 0 0 0'/>\
         <body name='a'><joint/><geom/>\
         <body name='b' childclass='hand'><joint damping='9'/><geom size='0.4'/>\
         <body name='c'><joint class='main'/><geom/></body></body></body></body>",
    ));
    let axis = |name: &str| bone(&plan, name).joint.as_ref().unwrap().axes[0];
    assert_eq!((axis("a").damping, axis("a").limit), (0.5, None));
    assert_eq!((axis("b").damping, axis("b").limit.unwrap().max), (9.0, 2.0));
    assert_eq!((axis("c").damping, axis("c").limit), (0.1, None));
    near(&bone(&plan, "c").joint.as_ref().unwrap().pose_MJ.vector(&Vec3::x()), [0.0, 0.0, -1.0]);
    let shape = |name: &str| bone(&plan, name).solids[0].shape.clone();
    assert_eq!(shape("base"), Shape::Capsule { radius: 0.02, half_length: 0.3 });
    assert_eq!(
        (shape("a"), shape("b")),
        (Shape::Sphere { radius: 0.1 }, Shape::Sphere { radius: 0.4 })
    );
}

#[test]
fn two_hinges_of_a_body_are_a_universal_joint_and_three_a_ball() {
    let body = |joints: &str| on_ball(&format!("<body name='a' pos='1 0 0'>{joints}{BALL}</body>"));
    let two = "<joint name='spread' axis='0 0 1' range='-10 20'/>\
               <joint name='flex' axis='0 1 0' range='-30 40' pos='0 0.5 0'/>";
    let plan = read(&model("", &body(two)));
    let joint = bone(&plan, "a").joint.as_ref().unwrap();
    assert_eq!((joint.kind, joint.name.as_str()), (JointKind::Universal, "flex"));
    near(&joint.pose_MJ.position, [1.0, 0.0, 0.0]);
    near(&joint.pose_MJ.vector(&Vec3::y()), [0.0, 1.0, 0.0]);
    near(&joint.pose_MJ.vector(&Vec3::x()), [0.0, 0.0, -1.0]);
    let [spread, flex] = joint.axes.map(|axis| axis.limit.unwrap().max.to_degrees());
    assert!((spread - 20.0).abs() < 1e-9 && (flex - 40.0).abs() < 1e-9);
    let three = "<joint name='x' axis='1 0 0' damping='1'/><joint name='z' axis='0 0 1' damping='2'/>\
                 <joint name='y' axis='0 1 0' damping='6' range='-1 1'/>";
    let plan = read(&model("", &body(three)));
    let joint = bone(&plan, "a").joint.as_ref().unwrap();
    assert_eq!((joint.kind, joint.axes[0].damping), (JointKind::Ball, 3.0));
    assert!(joint.axes[0].limit.is_none());
    assert!(plan.notes[0].contains("\"x\", \"z\" and \"y\" became the ball joint \"y\""));
}

/// By q0 about the first axis and q1 about the second, the body turns as the file's joints turn it.
#[test]
fn a_universal_joint_at_rest_outside_of_zero_turns_in_the_order_of_the_file() {
    let text = model(
        "<compiler angle='radian'/>",
        &on_ball(&format!(
            "<body name='a'><joint axis='0 0 1' range='0.3 1'/><joint name='j' axis='0 1 0' range='0.2 1'/>\
             {BALL}<body name='b' pos='1 0 0'><joint/>{BALL}</body></body>"
        )),
    );
    let plan = read(&text);
    let about = |axis: Vec3, angle: f64| nalgebra::Rotation3::from_scaled_axis(axis * angle);
    let tip = about(Vec3::z(), 0.3) * about(Vec3::y(), 0.2) * Vec3::x();
    near(&bone(&plan, "b").pose_ML.position, [tip.x, tip.z, -tip.y]);
    let joint = bone(&plan, "a").joint.as_ref().unwrap();
    let second = about(Vec3::z(), 0.3) * Vec3::y();
    near(&joint.pose_MJ.vector(&Vec3::x()), [second.x, second.z, -second.y]);
    assert_eq!(joint.axes.map(|axis| axis.limit.unwrap().min), [0.0, 0.0]);
}

/// 1 kg at 0 and 3 kg at 0.4 m along x: the centre at 0.3 m, and 1·0.3² + 3·0.1² = 0.12 across.
#[test]
fn bodies_without_a_joint_become_parts_of_their_parents_by_steiner() {
    let plan = read(&model(
        "",
        "<body name='base'><inertial pos='0 0 0' mass='1' diaginertia='0.1 0.1 0.1'/>\
         <frame pos='0.3 0 0'><body name='a' pos='0.1 0 0'>\
         <inertial pos='0 0 0' mass='3' fullinertia='0.2 0.2 0.2 0 0 0'/><geom size='0.1'/></body></frame></body>",
    ));
    assert_eq!(plan.bones.len(), 1);
    let mass = plan.bones[0].mass.unwrap();
    assert!((mass.mass - 4.0).abs() < 1e-12);
    near(&mass.centre_M, [0.3, 0.0, 0.0]);
    let expected = Mat3::from_diagonal(&Vec3::new(0.3, 0.42, 0.42));
    assert!((mass.inertia_M.unwrap() - expected).norm() < 1e-12);
    near(&plan.bones[0].solids[0].pose_MS.position, [0.4, 0.0, 0.0]);
    assert_eq!(plan.notes, ["1 fixed body became part of its parent: \"a\""]);
}

#[test]
fn masses_of_geoms_count_where_they_are_given() {
    let mass = |head: &str, body: &str| read(&model(head, body)).bones[0].mass;
    let ball = 4.0 / 3.0 * PI * 1e-3;
    assert!(mass("", "<body><geom size='0.1'/></body>").is_none());
    let close = |found: Option<super::super::plan::PlanMass>, expected: f64| {
        assert!((found.unwrap().mass - expected).abs() < 1e-9, "{found:?} {expected}");
    };
    close(mass("", "<body><geom size='0.1' density='500'/></body>"), 500.0 * ball);
    close(
        mass("", "<body><geom size='0.1' mass='2'/><geom size='0.1'/></body>"),
        2.0 + 1000.0 * ball,
    );
    let class = "<default><geom density='200'/></default>";
    close(mass(class, "<body><geom size='0.1'/></body>"), 200.0 * ball);
    let always = "<compiler inertiafromgeom='true'/>";
    let inertial = "<body><inertial pos='0 0 0' mass='9'/><geom size='0.1'/></body>";
    close(mass(always, inertial), 1000.0 * ball);
    close(mass("", inertial), 9.0);
    let groups = "<compiler inertiagrouprange='0 1'/>";
    close(
        mass(
            groups,
            "<body><geom size='0.1' mass='2'/><geom size='0.1' group='2' mass='5'/></body>",
        ),
        2.0,
    );
    // Unstated masses count beside a stated one, once fixed bodies are merged.
    let mixed = "<body><geom size='0.1'/><body><geom size='0.1' mass='3'/></body></body>";
    close(mass("", mixed), 3.0 + 1000.0 * ball);
    // Inertia about the centre: 2/5 m r² = 0.4 · 2 · 0.01.
    let found = mass("", "<body><geom size='0.1' mass='2' pos='1 0 0'/></body>").unwrap();
    assert!((found.inertia_M.unwrap() - Mat3::identity() * 0.008).norm() < 1e-12);
    near(&found.centre_M, [1.0, 0.0, 0.0]);
}

#[test]
fn what_is_only_drawn_is_taken_where_there_is_nothing_else() {
    let seen = "contype='0' conaffinity='0'";
    let both = format!("<body><geom size='0.1' {seen}/><geom size='0.2' contype='0'/></body>");
    let plan = read(&model("", &both));
    assert_eq!(plan.bones[0].solids.len(), 1);
    assert_eq!(plan.bones[0].solids[0].shape, Shape::Sphere { radius: 0.2 });
    let plan = read(&model("", &format!("<body><geom size='0.1' {seen}/></body>")));
    assert_eq!(plan.bones[0].solids.len(), 1);
}

#[test]
fn the_largest_body_is_the_figure_and_the_rest_is_told() {
    let text = model(
        "<option timestep='1'/><actuator/><sensor/>",
        &format!(
            "<geom type='plane' size='1 1 1'/><light/><body name='cup'>{BALL}</body>\
             <frame pos='0 0 2'><body name='base'><joint name='slide' type='slide'/>{BALL}\
             <body name='a'><joint type='ball' range='0 9' armature='1'/>{BALL}<site/></body></body></frame>"
        ),
    );
    let plan = read(&text);
    assert_eq!(plan.bones.len(), 2);
    near(&plan.bones[0].pose_ML.position, [0.0, 2.0, 0.0]);
    let notes = plan.notes.join("\n");
    for expected in [
        "other bodies of the world are passed over: \"cup\"",
        "geoms of the world are passed over: 1",
        "sections passed over: \"actuator\" and \"sensor\"",
        "a figure's root is free: \"slide\"",
        "ball joints lose their ranges: \"a\"",
        "passed over: \"armature\"",
    ] {
        assert!(notes.contains(expected), "{expected}\n{notes}");
    }
}

/// `b = 0.1 + a²` in the file, from its placement; coefficients that are left out are MuJoCo's.
/// Other constraints are reported.
#[test]
fn joints_follow_others_by_constraints() {
    let finger = |name: &str, joint: &str| format!("<body name='{name}'>{joint}{BALL}</body>");
    let fingers = finger("a", "<joint name='ja'/>")
        + &finger("b", "<joint name='jb'/>")
        + &finger("c", "<joint name='jc'/>")
        + &finger("d", "<joint name='jd' type='ball'/>");
    let head = "<equality><joint joint1='jb' joint2='ja' polycoef='0.1 0 1'/>\
        <joint joint1='jc' joint2='jb'/><joint joint1='jc' joint2='ja' active='false'/>\
        <joint joint1='jd' joint2='ja'/><joint joint1='ja'/><joint joint1='ja' joint2='far'/>\
        <connect body1='a' body2='b' anchor='0 0 0'/></equality>";
    let plan = read(&model(head, &on_ball(&fingers)));
    let found: Vec<_> = plan.mimics.iter().map(|mimic| (mimic.ends(), mimic.law)).collect();
    assert_eq!(
        found,
        [
            ([(0, 0), (1, 0)], [0.1, 0.0, 1.0, 0.0, 0.0]),
            ([(1, 0), (2, 0)], [0.0, 1.0, 0.0, 0.0, 0.0])
        ]
    );
    let notes = plan.notes.join("\n");
    for part in [
        "constraints passed over: \"connect\"",
        "\"jd\" does not follow \"ja\"",
        "\"ja\" is held at an angle by a constraint",
        "\"ja\" does not follow \"far\": the figure has no joint \"far\"",
    ] {
        assert!(notes.contains(part), "{part}\n{notes}");
    }
    let many = "<equality><joint joint1='jb' joint2='ja' polycoef='1 2 3 4 5 6'/></equality>";
    let error = read_mjcf(&model(many, &on_ball(&fingers)), Path::new(".")).unwrap_err();
    assert!(error.to_string().contains("at most 5 finite numbers"), "{error}");
}

/// A tetrahedron with legs of 100 from the corner (10, 0, 0), a quarter turn about z undone: x to
/// -y.
#[test]
fn meshes_are_found_changed_and_placed() {
    let folder = std::env::temp_dir().join(format!("thenar-mjcf-mesh-{}", std::process::id()));
    std::fs::create_dir_all(folder.join("meshes")).unwrap();
    let off =
        "OFF 4 4 0\n10 0 0\n110 0 0\n10 100 0\n10 0 100\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    std::fs::write(folder.join("meshes/t.off"), off).unwrap();
    let head = "<compiler meshdir='meshes'/><default><mesh scale='0.001 0.001 0.001'/></default>\
        <asset><mesh file='t.off' refpos='10 0 0' refquat='1 0 0 1'/></asset>";
    let geom = |mesh: &str| {
        model(head, &format!("<body><geom type='mesh' mesh='{mesh}' pos='0 0 1' mass='3'/></body>"))
    };
    let plan = read_mjcf(&geom("t"), &folder).unwrap();
    let solid = &plan.bones[0].solids[0];
    let Shape::Mesh(mesh) = &solid.shape else { panic!("a mesh") };
    let place: Pose = solid.pose_MS;
    let points: Vec<Vec3> = mesh.points.iter().map(|p| place.point(p)).collect();
    // In the file's axes: the corner, (0, -0.1, 0), (0.1, 0, 0) and (0, 0, 0.1), all 1 m up.
    for corner in [[0.0, 1.0, 0.0], [0.0, 1.0, 0.1], [0.1, 1.0, 0.0], [0.0, 1.1, 0.0]] {
        assert!(points.iter().any(|p| (p - Vec3::from(corner)).norm() < 1e-9), "{corner:?}");
    }
    let mass = plan.bones[0].mass.unwrap();
    assert!((mass.mass - 3.0).abs() < 1e-12);
    near(&mass.centre_M, [0.025, 1.025, 0.025]);
    let unknown = read_mjcf(&geom("s"), &folder).unwrap_err().to_string();
    assert!(unknown.contains("there is no mesh \"s\"; did you mean \"t\"?"), "{unknown}");
    std::fs::remove_dir_all(&folder).unwrap();
}
