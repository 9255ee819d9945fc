//! Goal: a scene says how fine a hand is and what holds its flesh by one word, and each part of
//! that by its own key. Method: the models of scenes with and without the keys are compared.

use std::path::Path;
use thenar_core::model::{CouplingKind, Side};
use thenar_scene::build::BuiltHand;
use thenar_scene::session::Session;

fn open(keys: &str) -> Result<Session, String> {
    let text = format!("version = 1\n[[hand]]\nname = \"hand\"\n{keys}\n");
    Session::from_text(&text, Path::new("test.toml"), &[]).map_err(|e| e.to_string())
}

fn hand(keys: &str) -> BuiltHand {
    open(keys).unwrap_or_else(|e| panic!("{keys}: {e}")).hands()[0].clone()
}

#[test]
fn the_default_is_the_hand_for_touch() {
    let (plain, touch) = (hand(""), hand("preset = \"touch\""));
    assert_eq!(plain.model.flesh.nodes, touch.model.flesh.nodes);
    assert_eq!(plain.coupling, CouplingKind::Bone);
    assert_eq!(plain.coupling_stiffness, touch.coupling_stiffness);
    assert!((2500..3500).contains(&plain.model.flesh.tets.len()));
    // The library's is the same.
    let library = thenar_rig::default_hand(Side::Right).unwrap();
    assert_eq!(library.flesh.nodes, plain.model.flesh.nodes);
    assert_eq!(library.coupling, CouplingKind::Bone);
}

#[test]
fn the_papers_hand_has_its_sizes() {
    let paper = hand("preset = \"paper\"");
    assert_eq!(paper.coupling, CouplingKind::Uniform);
    assert_eq!(paper.coupling_stiffness, 2e9);
    // 597 tetrahedra and 1441 triangles in the paper.
    assert!((540..660).contains(&paper.model.flesh.tets.len()));
    assert!((1300..=1441).contains(&paper.model.flesh.collision.triangles.len()));
}

/// Scenes that were written when every hand was the paper's mean what they meant.
#[test]
fn what_is_about_the_papers_hand_makes_it_the_papers() {
    let counted = hand("tets = 300");
    assert_eq!((counted.coupling, counted.coupling_stiffness), (CouplingKind::Uniform, 2e9));
    let library = thenar_rig::uniform_hand(Side::Right, 300).unwrap();
    assert_eq!(counted.model.flesh.nodes, library.flesh.nodes);

    let paper = hand("preset = \"paper\"");
    let papers = |keys: &str, stiffness: f64| {
        let found = hand(keys);
        assert_eq!(found.model.flesh.nodes, paper.model.flesh.nodes, "{keys}");
        let coupling = (found.coupling, found.coupling_stiffness);
        assert_eq!(coupling, (CouplingKind::Uniform, stiffness), "{keys}");
    };
    papers("coupling = \"uniform\"", 2e9);
    papers("coupling_stiffness = 1e9", 1e9);
    papers("[solver]\nkind = \"two-step\"", 2e9);

    // Of flesh on bone it is the stiffness there.
    let bone = hand("coupling = \"bone\"\ncoupling_stiffness = 1e11\ndetail = 0.25");
    assert_eq!((bone.coupling, bone.coupling_stiffness), (CouplingKind::Bone, 1e11));
}

/// What the two-step solver does to springs in bone is said before it runs, and that silence means
/// the paper's hand.
#[test]
fn the_two_step_solver_is_told_of_with_the_hand_that_it_gets() {
    let two_step = |keys: &str, h: &str| {
        let text = format!(
            "version = 1\ntime_step = {h}\n[solver]\nkind = \"two-step\"\n[[hand]]\nname = \"hand\"\n{keys}\n"
        );
        Session::from_text(&text, Path::new("test.toml"), &[]).unwrap()
    };
    let silent = two_step("", "0.005");
    assert!(silent.warnings().is_empty(), "{:?}", silent.warnings());
    assert!(silent.notes().len() == 1 && silent.notes()[0].contains("the paper's"));
    let named = two_step("preset = \"paper\"", "0.005");
    assert!(named.warnings().is_empty() && named.notes().is_empty());
    let touch = two_step("preset = \"touch\"\ndetail = 0.25", "0.005");
    let [warning] = &touch.warnings()[..] else { panic!("{:?}", touch.warnings()) };
    assert!(warning.contains("`hand`") && warning.contains("preset = \"paper\""), "{warning}");
    assert!(touch.notes().is_empty());
    let short = two_step("preset = \"touch\"\ndetail = 0.25", "0.001");
    assert!(short.warnings().is_empty());
}

#[test]
fn keys_of_their_own_come_before_the_preset() {
    let coarse = hand("preset = \"touch\"\ndetail = 0.25");
    assert_eq!(coarse.coupling, CouplingKind::Bone);
    // Moduli of elements near joints are reduced; the largest is that of the material.
    let kappa = 2.2e5 * 50e3 / coarse.model.length.powi(2);
    assert!(
        (coarse.coupling_stiffness / kappa - 1.0).abs() < 0.01,
        "{}",
        coarse.coupling_stiffness
    );

    let counted = hand("preset = \"touch\"\ntets = 300\ncoupling = \"uniform\"");
    assert_eq!(counted.coupling, CouplingKind::Uniform);
    assert!((250..350).contains(&counted.model.flesh.tets.len()));

    let graded = hand("preset = \"paper\"\ndetail = 0.25\ncoupling_stiffness = 1e9");
    assert_eq!((graded.coupling, graded.coupling_stiffness), (CouplingKind::Uniform, 1e9));
    assert_eq!(graded.model.flesh.nodes, coarse.model.flesh.nodes);
    assert_ne!(graded.model.flesh.nodes, counted.model.flesh.nodes);
}

/// Patches go with flesh that hangs on bone, single tetrahedra with the paper's coupling, unless a
/// scene says.
#[test]
fn elements_go_with_the_coupling() {
    let patches = |keys: &str| {
        let session =
            open(&format!("{keys}\ndetail = 0.25")).unwrap_or_else(|e| panic!("{keys}: {e}"));
        !session.world().desc().patches.is_empty()
    };
    assert!(patches("preset = \"touch\"") && patches("coupling = \"bone\""));
    assert!(patches("") && !patches("preset = \"paper\""));
    assert!(!patches("preset = \"touch\"\ncoupling = \"uniform\""));
    assert!(patches("coupling = \"uniform\"\nelements = \"patches\""));
    assert!(!patches("preset = \"touch\"\nelements = \"tetrahedra\""));
}

#[test]
fn what_contradicts_is_refused_by_name() {
    let error = open("tets = 600\ndetail = 1").unwrap_err();
    assert!(error.contains("detail") && error.contains("tets"), "{error}");
    for detail in ["0.2", "2.5", "nan"] {
        let error = open(&format!("detail = {detail}")).unwrap_err();
        assert!(error.contains("detail"), "{error}");
    }
    let error = open("preset = \"papre\"").unwrap_err();
    assert!(error.contains("preset") && error.contains("paper"), "{error}");
}
