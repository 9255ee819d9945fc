//! Goal: a client that knows only `docs/protocol.md` sees what the simulation computes. Method: the
//! messages of real sessions, read by a decoder written from the document, against the session.

use crate::decoder::{Model, Snapshot};
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::model::BodyId;
use thenar_scene::session::{Session, builtin, builtins};
use thenar_serve::protocol::{Pace, Snapshots, model};

/// Numbers of size 1 m travel with 24 bits.
const ROUNDING: f64 = 2e-7;

/// A shipped scene, with the paper's hand if it has one.
fn session(name: &str) -> Session {
    let scene = builtin(name).unwrap();
    let paper = scene.text.contains("[[hand]]").then(|| "hand.0.preset=paper".to_owned());
    Session::from_text(scene.text, Path::new(&format!("{name}.toml")), paper.as_slice()).unwrap()
}

fn messages(session: &Session, pace: &Pace) -> (Model, Snapshot) {
    let sent = model(session, session.name(), pace.epoch).unwrap();
    (Model::read(&sent), Snapshot::read(Snapshots::default().write(session, pace)))
}

fn near(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= ROUNDING * (1.0 + b.abs()))
}

fn xyz(v: &Vec3) -> [f64; 3] {
    [v.x, v.y, v.z]
}

/// A session in the midst of touching, if its scene touches at all.
fn touching(name: &str, seconds: f64) -> Session {
    let mut session = session(name);
    while session.world().time() < seconds {
        session.step(&mut ());
    }
    session
}

#[test]
fn every_scene_travels_whole() {
    for scene in builtins() {
        let session = touching(scene.name, 0.1);
        let (model, snapshot) = messages(&session, &Pace { epoch: 7, ..Pace::default() });
        assert_eq!((model.epoch, snapshot.epoch), (7, 7));
        let world = session.world();
        let desc = world.desc();
        assert_eq!(model.json["scene"], scene.name);
        assert_eq!(model.json["title"], session.scene().title.clone().unwrap().as_str());
        assert_eq!(model.count("/rigids"), desc.rigids.len());
        assert_eq!(snapshot.rigids.len(), desc.rigids.len());
        assert_eq!(model.count("/hands"), session.hands().len());
        assert_eq!(snapshot.loads.len(), session.hands().len());
        assert_eq!(u64::from(snapshot.steps), session.steps());
        assert!((snapshot.time - world.time()).abs() < 1e-12);
        for (i, sent) in snapshot.rigids.iter().enumerate() {
            let (pose, q) =
                (world.rigid_pose(i as u32), world.rigid_pose(i as u32).rotation.coords);
            assert!(near(&sent[..3], &xyz(&pose.position)), "{}", scene.name);
            assert!(near(&sent[3..], &[q.x, q.y, q.z, q.w]), "{}", scene.name);
        }
        // The surface a client places is the surface that touches.
        for (soft, desc) in desc.softs.iter().enumerate() {
            assert_eq!(model.array(&format!("/softs/{soft}/tets")).len(), desc.flesh.tets.len());
            let placed = snapshot.embed(&model, soft, "collision");
            let own = world.collision_vertices(soft as u32);
            assert_eq!(placed.len(), own.len());
            for (placed, own) in placed.iter().zip(own) {
                assert!(near(placed, &xyz(own)), "{} {placed:?} {own}", scene.name);
            }
        }
    }
}

#[test]
fn the_render_surface_is_that_of_the_rig() {
    let session = touching("bread-grasp", 0.05);
    let (model, snapshot) = messages(&session, &Pace::default());
    let hand = &session.hands()[0].model;
    let soft = session.hands()[0].flesh().unwrap();
    let mut own = vec![Vec3::zeros(); hand.render.vertices.len()];
    hand.render.positions(&hand.flesh.tets, session.world().nodes(soft), &mut own);
    let placed = snapshot.embed(&model, soft as usize, "render");
    assert!(placed.len() > 10_000);
    for (placed, own) in placed.iter().zip(&own) {
        assert!(near(placed, &xyz(own)));
    }
    let triangles = model.array(&format!("/softs/{soft}/render/triangles"));
    assert_eq!(triangles.len(), hand.render.triangles.len());
    assert!(triangles.iter().flatten().all(|v| (*v as usize) < placed.len()));
}

#[test]
fn skinning_from_the_sent_weights_gives_the_targets() {
    let session = touching("bread-grasp", 1.0);
    let (model, snapshot) = messages(&session, &Pace::default());
    let soft = session.hands()[0].flesh().unwrap();
    let pointer = |what: &str| format!("/softs/{soft}/skin/{what}");
    let (bones, weights, offsets) = (
        model.array(&pointer("bones")),
        model.array(&pointer("weights")),
        model.array(&pointer("offsets")),
    );
    let mut own = vec![Vec3::zeros(); bones.len()];
    session.world().skin_targets(soft, &mut own);
    for n in 0..bones.len() {
        let mut target = Vec3::zeros();
        for k in 0..2 {
            let [x, y, z, a, b, c, d] = snapshot.rigids[bones[n][k] as usize];
            let turn = thenar_core::Quat::new_normalize(nalgebra::Quaternion::new(d, a, b, c));
            let offset = Vec3::from_row_slice(&offsets[n][3 * k..3 * k + 3]);
            target += (Vec3::new(x, y, z) + turn * offset) * weights[n][k];
        }
        assert!((target - own[n]).norm() < 1e-6, "{n}: {target} {}", own[n]);
    }
}

#[test]
fn contacts_and_loads_add_up() {
    let session = touching("bread-grasp", 2.0);
    let (model, snapshot) = messages(&session, &Pace::default());
    // Those that carry force.
    let all = session.world().contacts().iter();
    let contacts: Vec<_> = all.filter(|c| c.force_W.norm() > 1e-6).collect();
    // Two of each digit that presses, at least.
    assert!(contacts.len() >= 10 && snapshot.contacts.len() == contacts.len());
    let number = |id: BodyId| match id {
        BodyId::Rigid(i) => i as u16,
        BodyId::Soft(i) => 32768 + i as u16,
    };
    for (sent, own) in snapshot.contacts.iter().zip(contacts) {
        assert_eq!(sent.bodies, own.bodies.map(number));
        assert_eq!(sent.vertices, own.vertices.map(|v| v.map_or(65535, |v| v as u16)));
        assert!(near(&sent.place, &xyz(&own.position_W)) && near(&sent.force, &xyz(&own.force_W)));
        let off = (Vec3::from(sent.normal) - own.normal_W).norm();
        assert!(off < 1e-4, "{:?} {}", sent.normal, own.normal_W);
        assert!(near(&[sent.area, sent.slip, sent.gap], &[own.area, own.slip_W.norm(), own.gap]));
    }
    // Loads again, from the sent contacts and the sent parts of the hand.
    let soft = session.hands()[0].flesh().unwrap();
    let digits = model.array("/hands/0/collision_digits");
    let mut normal = [0.0; 6];
    let mut area = [0.0; 6];
    for contact in &snapshot.contacts {
        for side in 0..2 {
            if contact.bodies[side] == 32768 + soft as u16 {
                let digit = digits[contact.vertices[side] as usize][0] as usize;
                normal[digit] += contact.normal_force();
            }
        }
    }
    // What touches without bearing load is not sent, but counts.
    for contact in session.world().contacts() {
        for side in 0..2 {
            if let (true, Some(v)) =
                (contact.bodies[side] == BodyId::Soft(soft), contact.vertices[side])
            {
                area[digits[v as usize][0] as usize] += contact.area;
            }
        }
    }
    for digit in 0..6 {
        assert!((snapshot.loads[0][4 * digit] - normal[digit]).abs() < 1e-3);
        assert!((snapshot.loads[0][4 * digit + 2] - area[digit]).abs() < 1e-7);
        // Nothing is crushed: skin bears all, over all of its area.
        let pressed = snapshot.loads[0][4 * digit + 3] * area[digit];
        assert!((pressed - normal[digit]).abs() < 1e-3 * (1.0 + normal[digit]));
    }
    assert!(normal[1..].iter().sum::<f64>() > 0.2, "the fingers hold the bread: {normal:?}");
}

#[test]
fn a_model_tells_what_starts_inside_each_other() {
    let text = "version = 1
        [[rigid]]
        name = \"table\"
        shape = { kind = \"plane\" }
        motion = \"fixed\"
        [[rigid]]
        name = \"ball\"
        shape = { kind = \"sphere\", radius = 0.02 }
        mass = 0.1
        position = [0.1, 0.017, 0]";
    let mut session = Session::from_text(text, Path::new("s.toml"), &[]).unwrap();
    // It is about the start, whenever the model is sent.
    session.step(&mut ());
    let (model, _) = messages(&session, &Pace::default());
    let told = &model.json["overlaps"];
    assert_eq!(told.as_array().unwrap().len(), 1);
    assert!((told[0]["depth"].as_f64().unwrap() - 0.003).abs() < 1e-9, "{told}");
    assert!((told[0]["place"][0].as_f64().unwrap() - 0.1).abs() < 1e-9, "{told}");
    let bodies: Vec<_> = told[0]["bodies"].as_array().unwrap().iter().collect();
    assert!(bodies.len() == 2 && bodies.iter().any(|name| *name == "ball"), "{told}");
    let (plain, _) = messages(&self::session("falling-box"), &Pace::default());
    assert_eq!(plain.json["overlaps"], serde_json::json!([]));
}

#[test]
fn a_snapshot_says_what_the_loop_tells_it() {
    let session = touching("falling-box", 0.05);
    let energy = session.world().energy(session.input());
    let pace = Pace {
        flags: 17,
        epoch: 3,
        number: 41,
        cost_ms: 1.25,
        budget_ms: 20.0,
        speed: 0.5,
        pose: 99,
        energy,
    };
    let (_, snapshot) = messages(&session, &pace);
    assert_eq!((snapshot.flags, snapshot.number, snapshot.pose), (17, 41, 99));
    assert!(near(&[snapshot.cost_ms, snapshot.budget_ms, snapshot.speed], &[1.25, 20.0, 0.5]));
    assert!(near(&snapshot.energy, &[energy.total(), energy.kinetic, energy.elastic]));
    assert!(near(&[snapshot.penetration], &[session.report().penetration_max]));
    assert_eq!(snapshot.sweeps, session.report().contact_sweeps);
}

#[test]
fn tracked_poses_are_the_targets_of_the_bones() {
    let session = touching("free-motion", 0.5);
    let (model, snapshot) = messages(&session, &Pace::default());
    let hand = &session.hands()[0];
    assert_eq!(model.json["hands"][0]["target_start"], 0);
    assert_eq!(snapshot.targets.len(), hand.model.bones.len());
    for (bone, sent) in hand.handle.bones.clone().zip(&snapshot.targets) {
        let target = session.input().targets[bone as usize].unwrap().pose_WB;
        assert!(near(&sent[..3], &xyz(&target.position)));
    }
    // A body that nobody tracks has none.
    let (_, alone) = messages(&touching("soft-cube", 0.01), &Pace::default());
    assert!(alone.targets.iter().flatten().all(|x| x.is_nan()));
}

#[test]
fn a_hand_has_twenty_angles_within_their_limits() {
    let (model, _) = messages(&session("bread-grasp"), &Pace::default());
    let angles = model.json["hands"][0]["angles"].as_array().unwrap();
    assert_eq!(angles.len(), 20);
    for (k, angle) in angles.iter().enumerate() {
        let number = |key: &str| angle[key].as_f64().unwrap();
        assert!(number("min") < number("max"), "{k}");
        // The mesh was modelled with a hand at ease: its rest is inside what joints admit.
        assert!(number("min") - 1e-9 <= number("rest") && number("rest") <= number("max") + 1e-9);
        // Fingers close farther than they open; spread is the smaller range.
        if k % 4 != 1 && k >= 4 {
            assert!(number("max") > -number("min"), "{k} {angle}");
        }
    }
    assert_eq!(model.json["hands"][0]["side"], "right");
    let bones = model.json["hands"][0]["bones"].as_array().unwrap();
    assert_eq!(bones[0]["digit"], "palm");
    assert!((model.json["hands"][0]["length"].as_f64().unwrap() - 0.19).abs() < 0.03);
}

#[test]
fn looks_travel() {
    let (bread, _) = messages(&session("bread-grasp"), &Pace::default());
    let look = |i: usize| bread.json["softs"][i]["look"].as_str().unwrap();
    let (hand, loaf) = if look(0) == "skin" { (0, 1) } else { (1, 0) };
    assert_eq!((look(hand), look(loaf)), ("skin", "bread"));
    let colours = bread.array(&format!("/softs/{loaf}/render/colours"));
    assert!(colours.iter().all(|c| c[3] == 255.0 && c[0] > c[1] && c[1] > c[2]), "crust is brown");
    let (car, _) = messages(&session("car-grasp"), &Pace::default());
    let rigids = car.json["rigids"].as_array().unwrap();
    let painted = rigids.iter().position(|r| !r["mesh"]["colours"].is_null()).unwrap();
    let colours = car.array(&format!("/rigids/{painted}/mesh/colours"));
    let positions = car.array(&format!("/rigids/{painted}/mesh/positions"));
    assert_eq!(colours.len(), positions.len());
    assert!(colours.iter().any(|c| c != &colours[0]), "the car has more than one colour");
    assert_eq!(rigids.iter().filter(|r| r["kind"] == "bone").count(), 16);
    assert!(rigids.iter().any(|r| r["kind"] == "plane" && r["fixed"] == true));
}
