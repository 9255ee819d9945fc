use super::super::plan::PlanBone;
use super::*;
use thenar_core::Mat3;
use thenar_core::model::JointKind;
use thenar_core::random::Random;
use thenar_core::shape::Shape;

const BALL: &str = "<collision><geometry><sphere radius='0.1'/></geometry></collision>";
const MASS: &str = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>";

/// A robot of links `base`, `a`, `b`, ... of these contents and of joints between them.
fn robot(links: &[&str], joints: &str) -> String {
    let names = ["base", "a", "b", "c", "d"];
    let link = |(name, inside): (&str, &&str)| format!("<link name='{name}'>{inside}</link>\n");
    let links: String = names.into_iter().zip(links).map(link).collect();
    format!("<robot name='r'>\n{links}{joints}</robot>")
}

/// A joint named after its child.
fn joint(kind: &str, parent: &str, child: &str, inside: &str) -> String {
    format!(
        "<joint name='to {child}' type='{kind}'><parent link='{parent}'/><child link='{child}'/>{inside}</joint>\n"
    )
}

fn read(text: &str) -> Plan {
    read_urdf(text, Path::new(".")).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn error(text: &str) -> String {
    read_urdf(text, Path::new(".")).unwrap_err().to_string()
}

fn bone<'a>(plan: &'a Plan, name: &str) -> &'a PlanBone {
    plan.bones.iter().find(|bone| bone.name == name).unwrap()
}

fn near(a: &Vec3, b: [f64; 3]) {
    assert!((a - Vec3::from(b)).norm() < 1e-9, "{a} {b:?}");
}

/// The file's (x, y, z) is the figure's (x, z, -y).
#[test]
fn an_arm_stands_upright_with_its_joints_in_place() {
    let origin = |xyz: &str| format!("<origin xyz='{xyz}'/><axis xyz='0 2 0'/>");
    let shoulder =
        origin("0 0 1") + "<limit lower='-0.5' upper='1.5' effort='9'/><dynamics damping='0.3'/>";
    let text = robot(
        &[BALL, BALL, BALL],
        &(joint("continuous", "a", "b", &origin("0.5 0.2 0"))
            + &joint("revolute", "base", "a", &shoulder)),
    );
    let plan = read(&text);
    let names: Vec<&str> = plan.bones.iter().map(|bone| bone.name.as_str()).collect();
    assert_eq!((plan.name.as_str(), names), ("r", vec!["base", "a", "b"]));
    assert!(plan.bones[0].parent.is_none() && plan.bones[0].joint.is_none());
    assert_eq!([plan.bones[1].parent, plan.bones[2].parent], [Some(0), Some(1)]);
    near(&plan.bones[1].pose_ML.position, [0.0, 1.0, 0.0]);
    near(&plan.bones[2].pose_ML.position, [0.5, 1.0, -0.2]);
    let [a, b] = [1, 2].map(|k| plan.bones[k].joint.clone().unwrap());
    assert_eq!((a.kind, a.name.as_str()), (JointKind::Hinge, "to a"));
    near(&(a.pose_MJ.rotation * Vec3::x()), [0.0, 0.0, -1.0]);
    near(&b.pose_MJ.position, [0.5, 1.0, -0.2]);
    let limit = a.axes[0].limit.unwrap();
    assert_eq!((limit.min, limit.max, a.axes[0].damping), (-0.5, 1.5, 0.3));
    assert!(b.axes[0].limit.is_none());
    assert_eq!(plan.notes.len(), 1);
    assert!(plan.notes[0].contains("effort and velocity"), "{:?}", plan.notes);
}

/// A quarter turn about z swaps the moments of x and y; upright, those of y and z change places.
#[test]
fn inertia_is_turned_with_its_frame() {
    let text = robot(
        &["<inertial><origin xyz='1 2 3' rpy='0 0 1.5707963267948966'/><mass value='4'/>\
           <inertia ixx='1' iyy='2' izz='2.5' ixy='0' ixz='0' iyz='0'/></inertial>"],
        "",
    );
    let mass = read(&text).bones[0].mass.unwrap();
    assert_eq!(mass.mass, 4.0);
    near(&mass.centre_M, [1.0, 3.0, -2.0]);
    let expected = Mat3::from_diagonal(&Vec3::new(2.0, 2.5, 1.0));
    assert!((mass.inertia_M.unwrap() - expected).norm() < 1e-12);
}

#[test]
fn shapes_lie_as_the_format_says() {
    let text = robot(
        &["<collision><origin xyz='0 0 0.1' rpy='0 1.5707963267948966 0'/><geometry>\
           <cylinder radius='0.1' length='0.4'/></geometry></collision>\
           <collision><geometry><box size='0.2 0.4 0.6'/></geometry></collision>\
           <collision><geometry><capsule radius='0.05' length='0.3'/></geometry></collision>\
           <visual><geometry><mesh filename='nowhere.dae'/></geometry></visual>"],
        "",
    );
    let plan = read(&text);
    let [rod, block, pill] = &plan.bones[0].solids[..] else { panic!("three solids") };
    assert_eq!(rod.shape, Shape::Cylinder { radius: 0.1, half_length: 0.2 });
    near(&rod.pose_MS.position, [0.0, 0.1, 0.0]);
    // Along z, turned about y onto x, which upright stays.
    near(&rod.pose_MS.vector(&Vec3::y()), [1.0, 0.0, 0.0]);
    assert_eq!(block.shape, Shape::Cuboid { half: Vec3::new(0.1, 0.2, 0.3) });
    near(&block.pose_MS.vector(&Vec3::z()), [0.0, 1.0, 0.0]);
    assert_eq!(pill.shape, Shape::Capsule { radius: 0.05, half_length: 0.15 });
    near(&pill.pose_MS.vector(&Vec3::y()), [0.0, 1.0, 0.0]);
    let drawn = robot(&["<visual><geometry><sphere radius='2'/></geometry></visual>"], "");
    assert_eq!(read(&drawn).bones[0].solids[0].shape, Shape::Sphere { radius: 2.0 });
}

/// 1 kg at 0 and 3 kg at 0.4 m along x: the centre at 0.3 m, and 1·0.3² + 3·0.1² = 0.12 across.
#[test]
fn fixed_links_become_parts_of_their_parents_by_steiner() {
    let inertial = |m: f64, i: f64| {
        format!(
            "<inertial><mass value='{m}'/><inertia ixx='{i}' iyy='{i}' izz='{i}'/></inertial>{BALL}"
        )
    };
    let (one, three) = (inertial(1.0, 0.1), inertial(3.0, 0.2));
    let joints = joint("fixed", "base", "a", "<origin xyz='0.2 0 0'/>")
        + &joint("fixed", "a", "b", "<origin xyz='0.2 0 0'/>")
        + &joint("continuous", "b", "c", "<origin xyz='0 0 1'/>");
    let plan = read(&robot(&[&one, "", &three, BALL], &joints));
    assert_eq!(plan.bones.len(), 2);
    assert_eq!((plan.bones[1].name.as_str(), plan.bones[1].parent), ("c", Some(0)));
    near(&plan.bones[1].pose_ML.position, [0.4, 1.0, 0.0]);
    let base = &plan.bones[0];
    near(&base.solids[1].pose_MS.position, [0.4, 0.0, 0.0]);
    let mass = base.mass.unwrap();
    assert!((mass.mass - 4.0).abs() < 1e-12);
    near(&mass.centre_M, [0.3, 0.0, 0.0]);
    let expected = Mat3::from_diagonal(&Vec3::new(0.3, 0.42, 0.42));
    assert!((mass.inertia_M.unwrap() - expected).norm() < 1e-12);
    assert_eq!(plan.notes, ["2 fixed links became parts of their parents: \"a\" and \"b\""]);
}

#[test]
fn two_hinges_around_a_weightless_link_are_a_universal_joint() {
    // Both axes pass through (0, 0, 1), though the second joint stands 0.3 m along its axis from
    // there.
    let joints = joint(
        "revolute",
        "base",
        "a",
        "<origin xyz='0 0 1'/><axis xyz='0 0 1'/><limit lower='-0.1' upper='0.2'/>",
    ) + &joint(
        "revolute",
        "a",
        "b",
        "<origin xyz='0.3 0 0'/><axis xyz='1 0 0'/><limit lower='-0.3' upper='0.4'/>",
    );
    let plan = read(&robot(&[BALL, "", BALL], &joints));
    assert_eq!(plan.bones.len(), 2);
    let b = bone(&plan, "b");
    assert_eq!(b.parent, Some(0));
    let joint = b.joint.as_ref().unwrap();
    assert_eq!((joint.kind, joint.name.as_str()), (JointKind::Universal, "to b"));
    near(&joint.pose_MJ.position, [0.0, 1.0, 0.0]);
    near(&joint.pose_MJ.vector(&Vec3::y()), [0.0, 1.0, 0.0]);
    near(&joint.pose_MJ.vector(&Vec3::x()), [1.0, 0.0, 0.0]);
    assert_eq!(joint.axes.map(|axis| axis.limit.unwrap().max), [0.2, 0.4]);
    assert!(plan.notes[0].contains("\"to a\" and \"to b\" became the universal joint \"to b\""));
}

#[test]
fn three_hinges_are_a_ball_joint_and_ball_joints_are_read() {
    let hinge = |parent: &str, child: &str, axis: &str| {
        joint(
            "continuous",
            parent,
            child,
            &format!("<axis xyz='{axis}'/><dynamics damping='0.3'/>"),
        )
    };
    let joints =
        hinge("base", "a", "0 0 1") + &hinge("a", "b", "1 0 0") + &hinge("b", "c", "0 1 0");
    let joints = joints + &joint("spherical", "c", "d", "<dynamics damping='2'/>");
    let plan = read(&robot(&[BALL, "", "", BALL, BALL], &joints));
    let [c, d] = ["c", "d"].map(|name| bone(&plan, name).joint.clone().unwrap());
    assert_eq!((c.kind, c.name.as_str()), (JointKind::Ball, "to c"));
    assert!((c.axes[0].damping - 0.3).abs() < 1e-12);
    assert_eq!((d.kind, d.axes[0].damping), (JointKind::Ball, 2.0));
    assert!(plan.notes[0].contains("no ranges"), "{:?}", plan.notes);
}

/// About z from 0.5 rad on: what lies 1 m along x turns by 0.5 rad.
#[test]
fn a_range_without_zero_moves_the_rest_pose() {
    let bent = "<axis xyz='0 0 1'/><limit lower='0.5' upper='1.5'/>";
    let joints = joint("revolute", "base", "a", bent)
        + &joint("continuous", "a", "b", "<origin xyz='1 0 0'/>");
    let plan = read(&robot(&[BALL, BALL, BALL], &joints));
    near(&bone(&plan, "b").pose_ML.position, [0.5_f64.cos(), 0.0, -(0.5_f64.sin())]);
    let limit = bone(&plan, "a").joint.as_ref().unwrap().axes[0].limit.unwrap();
    assert!(limit.min.abs() < 1e-12 && (limit.max - 1.0).abs() < 1e-12);
    assert!(plan.notes[0].contains("\"to a\" does not contain 0"), "{:?}", plan.notes);
}

#[test]
fn a_floating_root_is_left_out_and_sections_are_told() {
    let joints = joint("floating", "base", "a", "<origin xyz='9 9 9'/>")
        + &joint("continuous", "a", "b", "")
        + "<transmission/><gazebo/>";
    let plan = read(&robot(&["", BALL, BALL], &joints));
    assert_eq!((plan.bones.len(), plan.bones[0].name.as_str()), (2, "a"));
    near(&plan.bones[0].pose_ML.position, [0.0; 3]);
    let notes = plan.notes.join("\n");
    assert!(notes.contains("passed over: \"gazebo\" and \"transmission\""), "{notes}");
    assert!(notes.contains("\"base\" and its floating joint \"to a\""), "{notes}");
}

/// In the file `b = 0.5 - 2 a`; `a` rests at 0.3 rad and `b` at 0, so that from the rest pose
/// `b = -0.1 - 2 a`. `c` and `d` make one universal joint, whose second axis follows `b`.
#[test]
fn mimics_follow_from_the_rest_pose() {
    let joints = joint("revolute", "base", "a", "<limit lower='0.3' upper='1'/>")
        + &joint("continuous", "base", "b", "<mimic joint='to a' multiplier='-2' offset='0.5'/>")
        + &joint("continuous", "b", "c", "<axis xyz='0 0 1'/>")
        + &joint("continuous", "c", "d", "<mimic joint='to b'/>");
    let plan = read(&robot(&[BALL, BALL, BALL, "", BALL], &joints));
    let of = |name: &str| {
        let place = plan.bones.iter().position(|bone| bone.name == name).unwrap();
        place as u32 - 1
    };
    let [first, second] = plan.mimics[..] else { panic!("{:?}", plan.mimics) };
    assert_eq!(first.ends(), [(of("a"), 0), (of("b"), 0)]);
    let near = |found: [f64; 5], expected: [f64; 5]| {
        found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12)
    };
    assert!(near(first.law, [-0.1, -2.0, 0.0, 0.0, 0.0]), "{:?}", first.law);
    assert_eq!(second.ends(), [(of("b"), 0), (of("d"), 1)]);
    assert!(near(second.law, [0.0, 1.0, 0.0, 0.0, 0.0]), "{:?}", second.law);
}

#[test]
fn mimics_that_cannot_be_are_told() {
    let hinge =
        |parent: &str, child: &str, inside: &str| joint("continuous", parent, child, inside);
    let two = |first: &str, second: &str| {
        robot(&[BALL, BALL, BALL], &(hinge("base", "a", first) + &hinge("base", "b", second)))
    };
    let unknown = error(&two("", "<mimic joint='to c'/>"));
    assert!(
        unknown.contains("<mimic>: joint \"to b\" mimics an unknown joint \"to c\"; did you mean"),
        "{unknown}"
    );
    let circle = error(&two("<mimic joint='to b'/>", "<mimic joint='to a'/>"));
    assert!(circle.contains("follows itself through others"), "{circle}");
    assert!(error(&two("<mimic joint='to a'/>", "")).contains("follows itself"));
    // What does not move, and a ball, neither lead nor follow.
    let fixed = joint("fixed", "base", "a", "") + &hinge("base", "b", "<mimic joint='to a'/>");
    let plan = read(&robot(&[BALL, BALL, BALL], &fixed));
    assert!(plan.mimics.is_empty());
    let notes = plan.notes.join("\n");
    assert!(
        notes.contains("joint \"to b\" does not follow \"to a\": both must be hinges"),
        "{notes}"
    );
}

#[test]
fn meshes_are_scaled_and_placed() {
    let folder = std::env::temp_dir().join(format!("thenar-urdf-mesh-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    // A tetrahedron with legs of 100 (millimetres), its corner at the origin.
    let off = "OFF 4 4 0\n0 0 0\n100 0 0\n0 100 0\n0 0 100\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
    std::fs::write(folder.join("t.off"), off).unwrap();
    let text = |file: &str, scale: &str| {
        robot(
            &[&format!(
                "<visual><origin xyz='0 0 1'/><geometry><mesh filename='{file}' scale='{scale}'/></geometry></visual>"
            )],
            "",
        )
    };
    let plan = read_urdf(&text("t.off", "0.001 0.001 -0.002"), &folder).unwrap();
    let solid = &plan.bones[0].solids[0];
    let Shape::Mesh(mesh) = &solid.shape else { panic!("a mesh") };
    let points: Vec<Vec3> = mesh.points.iter().map(|p| solid.pose_MS.point(p)).collect();
    for corner in [[0.0, 1.0, 0.0], [0.1, 1.0, 0.0], [0.0, 1.0, -0.1], [0.0, 0.8, 0.0]] {
        assert!(points.iter().any(|p| (p - Vec3::from(corner)).norm() < 1e-9), "{corner:?}");
    }
    // Mirrored, yet outside is outside.
    assert!(
        solid.shape.distance(&solid.pose_MS.inverse_point(&Vec3::new(0.02, 0.98, -0.02))).value
            < 0.0
    );
    let message = |text: &str| read_urdf(text, &folder).unwrap_err().to_string();
    assert!(message(&text("x.off", "1 1 1")).contains("\"x.off\" is neither in"));
    assert!(message(&text("t.off", "1 0 1")).contains("scale must not be zero"));
    std::fs::write(folder.join("t.dae"), "").unwrap();
    assert!(message(&text("t.dae", "1 1 1")).contains("convert it to STL, OBJ or PLY"));
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn errors_name_the_thing_and_the_cause() {
    let two = |kind: &str, inside: &str| robot(&[BALL, BALL], &joint(kind, "base", "a", inside));
    let slides = error(&two("prismatic", ""));
    assert!(slides.starts_with("line 4: <joint>: joint \"to a\" is prismatic"), "{slides}");
    assert!(slides.contains("sliding joints are not simulated: make it fixed or a hinge"));
    assert!(error(&two("planar", "")).contains("is planar"));
    assert!(error(&two("floating", "")).contains("\"to a\" floats"));
    assert!(error(&two("helical", "")).contains("unknown type \"helical\""));
    assert!(error(&two("revolute", "")).contains("\"to a\": <limit> is missing"));
    let turned = error(&two("revolute", "<limit lower='1' upper='-1'/>"));
    assert!(turned.contains("\"to a\": lower must be at most upper, not 1 and -1"), "{turned}");
    assert!(
        error(&two("continuous", "<axis xyz='0 0 0'/>")).contains("xyz must be of some length")
    );
    assert!(error(&two("continuous", "<axis xyz='0 0'/>")).contains("xyz must be 3 finite"));
    let damping = error(&two("continuous", "<dynamics damping='-1'/>"));
    assert!(damping.contains("\"to a\": damping must be at least 0"), "{damping}");

    let lone = |inside: &str| error(&robot(&[inside], ""));
    let inertia = |m: f64, i: f64| {
        lone(&format!(
            "<inertial><mass value='{m}'/><inertia ixx='1' iyy='1' izz='{i}'/></inertial>"
        ))
    };
    assert!(inertia(1.0, -1.0).contains("\"base\": the inertia is not positive definite"));
    assert!(inertia(-1.0, 1.0).contains("\"base\": mass must be at least 0, not -1"));
    let shape = |form: &str| lone(&format!("<visual><geometry>{form}</geometry></visual>"));
    assert!(shape("<cone/>").contains("<cone>: link \"base\" has a shape that is not known"));
    assert!(shape("").contains("\"base\": no shape"));
    assert!(shape("<sphere radius='0'/>").contains("radius must be positive, not 0"));
    assert!(shape("<box size='1 -1 1'/>").contains("positive along each axis"));
    assert!(shape("<box/>").contains("size is missing"));
    assert!(lone("").contains("root link \"base\" has neither mass nor geometry"));
    assert!(error("<robot/>").contains("no <link>"));
    assert!(error("<mujoco/>").contains("this is MJCF"));
    assert!(
        error("<robot xmlns:xacro='http://ros.org/wiki/xacro'><xacro:arm/></robot>")
            .contains("expand the file with xacro")
    );
    let far = two("continuous", "<origin xyz='1e300 0 0'/>");
    assert!(error(&far).contains("link \"a\" has a place beyond"));
}

#[test]
fn what_is_no_tree_is_told() {
    let hinge = |parent: &str, child: &str| joint("continuous", parent, child, "");
    let unknown = error(&robot(&[BALL, BALL], &hinge("bse", "a")));
    assert!(
        unknown.contains("joint \"to a\" names an unknown link \"bse\"; did you mean \"base\"?")
    );
    let roots = error(&robot(&[BALL, BALL, BALL], &hinge("base", "a")));
    assert!(roots.contains("2 links without a parent, which must be one: \"base\" and \"b\""));
    let cycle = hinge("a", "b") + &hinge("b", "a");
    assert!(error(&robot(&[BALL, BALL, BALL], &cycle)).contains("\" is its own ancestor"));
    let all = hinge("base", "a") + &hinge("a", "base");
    assert!(error(&robot(&[BALL, BALL], &all)).contains("\" is its own ancestor"));
    assert!(error(&robot(&[BALL], &hinge("base", "base"))).contains("\"base\" is its own parent"));
    let twice = hinge("base", "a") + &hinge("base", "a");
    assert!(error(&robot(&[BALL, BALL], &twice)).contains("another joint \"to a\""));
    let same = "<robot><link name='x'/><link name='x'/></robot>";
    assert!(error(same).contains("another link \"x\""));
    let parents = hinge("base", "b")
        + "<joint name='j' type='fixed'><parent link='a'/><child link='b'/></joint>";
    let parents = error(&robot(&[BALL, BALL, BALL], &parents));
    assert!(
        parents.contains("link \"b\" is the child of two joints, \"to b\" and \"j\""),
        "{parents}"
    );
}

#[test]
fn a_weightless_link_that_moves_alone_is_an_error() {
    let hinge =
        |parent: &str, child: &str, inside: &str| joint("continuous", parent, child, inside);
    let alone = "link \"a\" moves and has neither mass nor geometry";
    assert!(error(&robot(&[BALL, ""], &hinge("base", "a", ""))).contains(alone));
    let askew = hinge("base", "a", "") + &hinge("a", "b", "<axis xyz='1 1 0'/>");
    let askew = error(&robot(&[BALL, "", BALL], &askew));
    assert!(askew.contains(alone) && askew.contains("not at right angles"), "{askew}");
    let apart =
        hinge("base", "a", "") + &hinge("a", "b", "<origin xyz='0 0 0.5'/><axis xyz='0 1 0'/>");
    let apart = error(&robot(&[BALL, "", MASS], &apart));
    assert!(apart.contains(alone) && apart.contains("do not meet in one point"), "{apart}");
    let split = hinge("base", "a", "") + &hinge("a", "b", "") + &hinge("a", "c", "");
    assert!(error(&robot(&[BALL, "", BALL, BALL], &split)).contains(alone));
    let ball = joint("ball", "base", "a", "") + &hinge("a", "b", "");
    assert!(error(&robot(&[BALL, "", BALL], &ball)).contains(alone));
}

/// Cut anywhere, and with any byte changed, the file is read or refused.
#[test]
fn damaged_files_are_no_reason_to_panic() {
    let limit =
        "<origin xyz='0 0 1' rpy='0.1 0 0'/><axis xyz='0 0 1'/><limit lower='0.1' upper='1'/>";
    let joints = joint("revolute", "base", "a", limit)
        + &joint("revolute", "a", "b", "<axis xyz='1 0 0'/><limit lower='0' upper='1'/>")
        + &joint("fixed", "b", "c", "<origin xyz='1 2 3'/>");
    let text = robot(&[&format!("{MASS}{BALL}"), "", BALL, MASS], &joints);
    assert_eq!(read(&text).bones.len(), 2);
    for end in (0..text.len()).filter(|&end| text.is_char_boundary(end)) {
        assert!(read_urdf(&text[..end], Path::new(".")).is_err());
    }
    let mut random = Random::new(7);
    for _ in 0..4000 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..=random.below(3) {
            let at = random.below(bytes.len());
            bytes[at] = b"0123456789.-e<>'/ abcdefghijklmnop"[random.below(34)];
        }
        let _ = read_urdf(&String::from_utf8_lossy(&bytes), Path::new("."));
    }
    let deep = format!("<robot>{}{}</robot>", "<link>".repeat(1000), "</link>".repeat(1000));
    assert!(error(&deep).contains("deeper than 500 levels"));
}
