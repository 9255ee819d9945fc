//! Goal: a scene says how fine a hand is and what holds its flesh by one word, and each part of that by its own key.
//! Method: the models of scenes with and without the keys are compared.

use std::path::Path;
use thenar::model::CouplingKind;
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
fn the_default_is_the_papers() {
    let (plain, paper) = (hand(""), hand("preset = \"paper\""));
    assert_eq!(plain.model.flesh.nodes, paper.model.flesh.nodes);
    assert_eq!(plain.coupling, CouplingKind::Uniform);
    assert_eq!(plain.coupling_stiffness, 2e9);
    // 597 tetrahedra and 1441 triangles in the paper.
    assert!((540..660).contains(&plain.model.flesh.tets.len()));
    assert!((1300..=1441).contains(&plain.model.flesh.collision.triangles.len()));
}

#[test]
fn one_word_gives_a_hand_for_touch() {
    let touch = hand("preset = \"touch\"");
    assert_eq!(touch.coupling, CouplingKind::Bone);
    assert!((2500..3500).contains(&touch.model.flesh.tets.len()));
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

/// Patches go with flesh that hangs on bone, single tetrahedra with the paper's coupling, unless a scene says.
#[test]
fn elements_go_with_the_coupling() {
    let patches = |keys: &str| {
        let session =
            open(&format!("{keys}\ndetail = 0.25")).unwrap_or_else(|e| panic!("{keys}: {e}"));
        !session.world().desc().patches.is_empty()
    };
    assert!(patches("preset = \"touch\"") && patches("coupling = \"bone\""));
    assert!(!patches("") && !patches("preset = \"touch\"\ncoupling = \"uniform\""));
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
