//! The crate that programs add, as a program uses it.

use thenar::{
    Body, Coupling, Drive, Grip, GripKind, Hand, HandPose, Pose, Quat, Rigid, Scene, Soft, Twist,
    Vec3,
};

/// The paper's hand high over a plane, a steel ball of 50 g on it, and a soft block beside.
fn scene() -> Scene {
    let mut scene = Scene::new();
    scene.add(Rigid::plane().named("table").friction(0.6));
    scene.add(Rigid::sphere(0.02).named("ball").at([0.1, 0.02, 0.0]).mass(0.05));
    scene.add(Soft::block([0.03, 0.02, 0.03], [3, 2, 3]).at([-0.1, 0.0101, 0.0]).young(4e4));
    scene.add(Hand::right().paper().at([0.0, 0.3, 0.0]));
    scene
}

#[test]
fn a_scene_in_code_is_the_scene_of_its_text() {
    let text = r#"
        version = 1
        time_step = 0.005

        [[rigid]]
        name = "table"
        shape = { kind = "plane" }
        motion = "fixed"
        friction = 0.6

        [[rigid]]
        name = "ball"
        shape = { kind = "sphere", radius = 0.02 }
        position = [0.1, 0.02, 0.0]
        mass = 0.05

        [[soft]]
        name = "lattice-1"
        shape = { kind = "lattice", size = [0.03, 0.02, 0.03], cells = [3, 2, 3] }
        position = [-0.1, 0.0101, 0.0]
        material = { young = 4e4 }

        [[hand]]
        name = "hand-1"
        model = "right"
        preset = "paper"
        position = [0.0, 0.3, 0.0]
    "#;
    let made = scene();
    let mut hashes = Vec::new();
    for scene in [made.clone(), Scene::from_toml(&made.to_toml()), Scene::from_toml(text)] {
        let mut sim = scene.build().unwrap();
        sim.run(0.1);
        assert_eq!(sim.time().to_bits(), (0..20).fold(0.0, |t, _| t + 0.005_f64).to_bits());
        hashes.push(sim.state_hash());
    }
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:x?}");
    let mut other = made;
    other.set("hand.0.position", "[0.0, 0.31, 0.0]").time_step(0.01).gravity([0.0, -1.62, 0.0]);
    let mut sim = other.build().unwrap();
    assert_eq!(sim.time_step(), 0.01);
    let mut twin = Scene::from_toml(&other.to_toml()).build().unwrap();
    assert_eq!((twin.run(0.02), twin.state_hash()), (sim.run(0.02), sim.state_hash()));
    sim.restart();
    // A tenth of a second of free fall from rest: v = g t, within what the solver leaves (1e-5
    // m/s).
    let ball = sim.rigid_named("ball").unwrap();
    sim.rigid_mut(ball).place(Pose::translation(0.1, 0.5, 0.0), Twist::default());
    sim.run(0.1);
    let velocity = sim.rigid(ball).velocity().linear;
    assert!((velocity - Vec3::new(0.0, -0.162, 0.0)).norm() < 1e-5, "{velocity} m/s");
}

/// Weight is borne by the contacts: statics.
#[test]
fn a_ball_that_rests_is_borne_by_its_table() {
    let mut sim = scene().build().unwrap();
    let report = sim.run(0.5);
    assert!(!report.contact_unconverged && !report.non_finite);
    let (table, ball) = (sim.rigid_named("table").unwrap(), sim.rigid_named("ball").unwrap());
    let (weight, of_ball) = (0.05 * 9.81, sim.rigid(ball));
    assert_eq!(of_ball.mass(), 0.05);
    let wrench = of_ball.contact_wrench();
    assert!((wrench.force.y - weight).abs() < 1e-3 * weight, "{wrench:?}");
    assert!(wrench.torque.norm() < 1e-3 * weight * 0.02, "{wrench:?}");
    assert!(of_ball.velocity().linear.norm() < 1e-4);
    let between =
        |a: Body, b: Body| sim.contacts().filter(move |c| c.bodies == [a, b] || c.bodies == [b, a]);
    let pressed: f64 = between(table.into(), ball.into()).map(|c| c.normal_force()).sum();
    assert!((pressed - weight).abs() < 1e-3 * weight, "{pressed} N");
    // So is the block, by pressure on an area.
    let block = sim.soft_named("lattice-1").unwrap();
    let weight = sim.soft(block).mass() * 9.81;
    assert!((sim.soft(block).mass() - 1000.0 * 0.03 * 0.02 * 0.03).abs() < 1e-9);
    let borne: f64 = between(table.into(), block.into()).map(|c| c.pressure() * c.area).sum();
    assert!((borne - weight).abs() < 1e-3 * weight, "{borne} N of {weight} N");
    let [low, high] = [f64::min, f64::max].map(|of| {
        sim.soft(block).vertices().iter().map(|x| x.y).fold(sim.soft(block).centre().y, of)
    });
    assert!(low > -1e-4 && high < 0.0202, "from {low} m to {high} m");
}

#[test]
fn a_hand_follows_poses_and_feels_what_it_presses() {
    let mut sim = scene().build().unwrap();
    let hand = sim.hand_named("hand-1").unwrap();
    assert_eq!(sim.hands().collect::<Vec<_>>(), [hand]);
    let bones: Vec<_> = sim.hand(hand).bones().map(|(name, ..)| name).collect();
    assert_eq!((bones.len(), bones[0]), (16, "palm"));
    assert!(
        sim.hand(hand)
            .triangles()
            .iter()
            .flatten()
            .all(|&v| { (v as usize) < sim.hand(hand).vertices().len() })
    );
    for _ in 0..400 {
        let height = (0.3 - 0.2 * sim.time()).max(0.02);
        let pose = HandPose::flat(Pose::translation(0.0, height, 0.0));
        sim.hand_mut(hand).follow(&pose).unwrap();
        sim.step();
    }
    let wrist = sim.hand(hand).wrist();
    assert!((wrist.position.y - 0.02).abs() < 0.02 && wrist.rotation.angle() < 0.2, "{wrist:?}");
    let felt: f64 = sim.loads(hand).iter().map(|load| load.normal).sum();
    let of_hand = |body: &Body| body.hand() == Some(hand);
    let pressed: f64 = sim
        .contacts()
        .map(|c| c.normal_force() * c.bodies.iter().filter(|body| of_hand(body)).count() as f64)
        .sum();
    assert!(felt > 1.0 && (felt - pressed).abs() < 1e-9 * felt, "{felt} N of {pressed} N");
    assert!(sim.loads(hand).iter().any(|load| load.area > 1e-5 && load.pressure > 0.0));
    let bad = HandPose::flat(Pose::translation(f64::NAN, 0.0, 0.0));
    let before = sim.state_hash();
    assert!(sim.hand_mut(hand).follow(&bad).is_err());
    assert_eq!(sim.state_hash(), before);
}

#[test]
fn a_state_goes_on_with_the_same_bits_and_enters_no_other_scene() {
    let mut sim = scene().build().unwrap();
    let hand = sim.hand_named("hand-1").unwrap();
    let pose = HandPose::flat(Pose::translation(0.0, 0.28, 0.0));
    sim.hand_mut(hand).follow(&pose).unwrap();
    sim.run(0.05);
    let state = sim.state();
    let run = |sim: &mut thenar::Simulation| {
        sim.hand_mut(hand).follow(&pose).unwrap();
        sim.run(0.05);
        sim.state_hash()
    };
    let first = run(&mut sim);
    sim.set_state(&state).unwrap();
    assert_eq!(run(&mut sim), first);
    let mut twin = scene().build().unwrap();
    twin.set_state(&state).unwrap();
    assert_eq!(run(&mut twin), first);
    let mut other = scene();
    other.set("rigid.ball.mass", 0.06);
    let mut other = other.build().unwrap();
    let before = other.state_hash();
    assert!(other.set_state(&state).is_err() && other.set_state(&state[..9]).is_err());
    assert_eq!(other.state_hash(), before);
    sim.restart();
    assert_eq!((sim.time(), sim.report().contacts), (0.0, 0));
}

#[test]
fn what_is_wrong_is_said_with_its_key() {
    let mut scene = Scene::new();
    scene.add(Rigid::sphere(-0.02));
    let said = scene.build().unwrap_err().to_string();
    assert!(said.contains("rigid[0].shape.radius") && said.contains("-0.02"), "{said}");
    let mut scene = Scene::new();
    scene.add(Rigid::plane().named("table"));
    scene.add(Rigid::sphere(0.02).named("table"));
    let said = scene.build().unwrap_err().to_string();
    assert!(said.contains("rigid[1].name") && said.contains("table"), "{said}");
    let mut scene = Scene::new();
    scene.add(Rigid::sphere(0.02).set("colour", "[2, 0, 0]"));
    assert!(scene.build().unwrap_err().to_string().contains("rigid[0].colour"));
    let said = Scene::named("bred-grasp").unwrap_err().to_string();
    assert!(said.contains("bred-grasp") && said.contains("bread-grasp"), "{said}");
    let said = Scene::from_file("no/such.toml").unwrap_err().to_string();
    assert!(said.contains("no/such.toml"), "{said}");
    let mut sim = self::scene().build().unwrap();
    let hand = sim.hand_named("hand-1").unwrap();
    let own = Body::Skin(hand, thenar::Digit::Palm);
    let said = sim.hand_mut(hand).grip(own, GripKind::Pinch, None).unwrap_err().to_string();
    assert!(said.contains("hand-1") && said.contains("cannot be gripped"), "{said}");
    assert!(sim.set("friction", -1.0).is_err() && sim.set("friction", 0.4).is_ok());
}

/// What has no name gets a free one, and a way of moving leaves nothing behind of the one before.
#[test]
fn parts_go_together_in_any_order() {
    let mut scene = Scene::new();
    let named = scene.add(Rigid::sphere(0.01).named("sphere-2").at([0.0, 1.0, 0.0]));
    let soft = scene.add(Soft::ball(0.02).named("sphere-3").at([0.2, 1.0, 0.0]));
    let other = scene.add(Rigid::sphere(0.01).at([0.1, 1.0, 0.0]).set("mass", 0.02));
    let still = || Rigid::sphere(0.01).thrown(Twist::linear(Vec3::x()));
    let up = [(0.0, Pose::translation(0.4, 1.0, 0.0))];
    let parts = [
        still().fixed().at([0.3, 1.0, 0.0]),
        still().moved(up).fixed().at([0.4, 1.0, 0.0]),
        still().pulled(Drive::palm(), up).moved(up),
        still().fixed().pulled(Drive::palm(), up).at([0.5, 1.0, 0.0]),
    ];
    let parts = parts.map(|part| scene.add(part));
    scene.add(
        Hand::left().paper().coupling(Coupling { stiffness: Some(3e9), ..Coupling::uniform() }),
    );
    let sim = scene.build().unwrap();
    assert_eq!(sim.rigid(named).name(), "sphere-2");
    assert_eq!((sim.rigid(other).name(), sim.rigid(other).mass()), ("sphere-4", 0.02));
    assert_eq!(sim.soft(soft).name(), "sphere-3");
    let water = 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * 1e-6;
    assert!((sim.rigid(parts[3]).mass() - water).abs() < 1e-9);
    // A handle of another scene, which has more, grips nothing here.
    let mut more = Scene::new();
    let foreign = (0..20).map(|_| more.add(Rigid::sphere(0.01))).last().unwrap();
    let mut sim = sim;
    let hand = sim.hands().next().unwrap();
    assert!(sim.hand_mut(hand).grip(foreign, GripKind::Pinch, None).is_err());
    let palm = [(thenar::Digit::Palm, Vec3::zeros())];
    assert!(sim.hand(hand).reaching(Pose::identity(), &palm).is_err());
}

/// Names that are given go first, wherever in the order, and by whatever way: a part's own, or a
/// change of the scene.
#[test]
fn names_that_no_one_gave_make_room_for_those_that_were_given() {
    let ball = |k: usize| Rigid::sphere(0.01).at([0.1 * k as f64, 1.0, 0.0]);
    let mut scene = Scene::new();
    let first = scene.add(ball(0));
    let second = scene.add(ball(1));
    let named = scene.add(ball(2).named("sphere-1"));
    let soft = scene.add(Soft::ball(0.02).named("sphere-4").at([0.0, 2.0, 0.0]));
    let changed = scene.add(ball(3).named("other"));
    scene.set("rigid.other.name", "sphere-3").set("rigid.sphere-1.density", 1200.0);
    let sim = scene.build().unwrap();
    // The first would be sphere-1, then sphere-2, which the second gets no more; 3 and 4 are given.
    let names = [first, second, named, changed].map(|ball| sim.rigid(ball).name().to_owned());
    assert_eq!(names, ["sphere-2", "sphere-5", "sphere-1", "sphere-3"]);
    assert_eq!(sim.soft(soft).name(), "sphere-4");
    let mass = 1200.0 * 4.0 / 3.0 * std::f64::consts::PI * 0.01_f64.powi(3);
    assert!((sim.rigid(named).mass() / mass - 1.0).abs() < 1e-9);
    // The text has the names of the simulation.
    let twin = Scene::from_toml(&scene.to_toml()).build().unwrap();
    assert_eq!(twin.state_hash(), sim.state_hash());
    assert!(twin.rigids().map(|ball| twin.rigid(ball).name()).eq(names.iter().map(String::as_str)));
    assert_eq!(Scene::from_toml(&self::scene().to_toml()), self::scene());
    assert_ne!(scene, self::scene());
}

/// Every builder's keys are read: a key that is not there is refused, so that a scene of all of
/// them opens.
#[test]
fn all_builders_write_what_scenes_read() {
    let turn = Quat::from_euler_angles(0.1, 0.2, 0.3);
    let up = |y: f64| Pose::new(Vec3::new(0.0, y, 0.0), turn);
    let shapes = [
        Rigid::cuboid([0.02, 0.03, 0.04]),
        Rigid::capsule(0.01, 0.03),
        Rigid::cylinder(0.01, 0.03).density(500.0),
        Rigid::ellipsoid([0.02, 0.03, 0.04]),
        Rigid::cone(0.02, 0.03).mass(0.2),
        Rigid::car(),
        Rigid::compound([(Rigid::sphere(0.01), up(0.0)), (Rigid::capsule(0.005, 0.04), up(0.02))]),
    ];
    let mut scene = Scene::new();
    for (k, shape) in shapes.into_iter().enumerate() {
        let at = [0.2 * k as f64, 1.0, 0.0];
        let thrown = Twist { linear: Vec3::x(), angular: Vec3::y() };
        scene.add(shape.at(at).turned(turn).thrown(thrown));
    }
    scene.add(Rigid::sphere(0.02).moved([(0.0, up(2.0)), (1.0, up(2.1))]));
    scene.add(Rigid::sphere(0.02).pulled(Drive::palm(), [(0.0, up(3.0)), (1.0, up(3.1))]));
    scene.add(Soft::bread().named("loaf").at([0.0, 0.5, 0.0]).turned(turn).density(300.0));
    scene.add(Soft::ball(0.02).at([0.5, 0.5, 0.0]).poisson(0.45).friction(0.8));
    let grip = Grip::of("loaf", GripKind::Power).at(0.5).until(1.0).force(3.0);
    let hand = Hand::left().paper().named("left").at([0.0, -1.0, 0.0]).turned(turn);
    let hand = hand.length(0.18).coupling(Coupling::uniform()).friction(0.7).grip(grip);
    let hand = scene.add(hand.drives(Drive::palm(), Drive::bone()).set("self_contact", false));
    let mut sim = scene.build().unwrap();
    assert_eq!((sim.rigids().count(), sim.softs().count(), sim.hands().count()), (9, 2, 1));
    assert_eq!((sim.hand(hand).name(), sim.hand(hand).side()), ("left", Some(thenar::Side::Left)));
    sim.run(0.01);
    // Scripted at minimum jerk, its velocity is zero at the start: hardly moved after a hundredth
    // of the way.
    let moved = sim.rigid_named("sphere-8").unwrap();
    assert!((sim.rigid(moved).pose().position.y - 2.0).abs() < 1e-5);
    let wrist = sim.hand(hand).wrist().position;
    let reach = sim.hand(hand).vertices().iter().map(|x| (x - wrist).norm()).fold(0.0, f64::max);
    assert!((reach - 0.18).abs() < 0.03, "{reach} m long");
}

/// Inverse kinematics, live: the index finger's pad comes down on a ball that stands beside the
/// others, and presses it.
#[test]
fn a_fingertip_goes_where_it_is_wanted() {
    let mut scene = Scene::new();
    scene.add(Rigid::plane());
    let ball = Rigid::sphere(0.015).at([-0.02, 0.1, -0.13]).fixed();
    let ball = scene.add(ball);
    let hand = scene.add(Hand::right().paper().at([0.0, 0.5, 0.0]));
    let mut sim = scene.build().unwrap();
    let wrist = Pose::translation(0.0, 0.16, 0.0);
    let reach = |sim: &thenar::Simulation, place: Vec3| {
        sim.hand(hand).reaching(wrist, &[(thenar::Digit::Index, place)]).unwrap()
    };
    let (pose, miss) = reach(&sim, Vec3::new(-0.02, 0.11, -0.13));
    assert!(miss < 1e-3, "{miss} m off");
    for _ in 0..400 {
        sim.hand_mut(hand).follow(&pose).unwrap();
        sim.step();
    }
    let loads = sim.loads(hand);
    let index = loads.iter().find(|load| load.digit == thenar::Digit::Index).unwrap();
    assert!(index.normal > 0.1, "{loads:?}");
    let on_ball = |c: &thenar::Contact| c.bodies.contains(&ball.into()) && c.normal_force() > 0.0;
    for contact in sim.contacts().filter(on_ball) {
        let digits = contact.bodies.map(|body| match body {
            Body::Skin(_, digit) | Body::Bone(_, digit) => digit,
            _ => thenar::Digit::Index,
        });
        assert_eq!(digits, [thenar::Digit::Index; 2], "{contact:?}");
    }
    // Beyond the finger's length it ends as far off as told.
    let (_, miss) = reach(&sim, Vec3::new(0.0, 0.16, -0.5));
    assert!(miss > 0.2 && miss < 0.45, "{miss} m off");
}
