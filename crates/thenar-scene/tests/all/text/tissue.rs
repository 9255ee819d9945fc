//! Goal: scenes give tissue the laws that they say. Method: small scenes, and what is built from
//! them.

use std::path::Path;
use thenar_core::model::{Law, Relaxation};
use thenar_scene::session::Session;

fn open(text: &str) -> Session {
    Session::from_text(&format!("version = 1\n{text}"), Path::new("s.toml"), &[]).unwrap()
}

fn relaxations(session: &Session, soft: usize) -> Vec<usize> {
    let flesh = &session.world().desc().softs[soft].flesh;
    flesh.relaxation.iter().map(|r| r.terms().len()).collect()
}

#[test]
fn a_body_and_its_regions_have_their_own_memory() {
    let body = |memory: &str, region: &str| {
        open(&format!(
            r#"
            [[soft]]
            name = "pad"
            shape = {{ kind = "lattice", size = [0.02, 0.01, 0.01], cells = [2, 1, 1] }}
            material = {{ young = 4e4{memory} }}
            [[soft.region]]
            elements = {{ indices = [0] }}
            material = {{ poisson = 0.3{region} }}
            "#
        ))
    };
    let two = ", relaxation = [[0.3, 0.01], [0.2, 0.5]]";
    assert!(relaxations(&body("", ""), 0).is_empty());
    let counts = relaxations(&body(two, ""), 0);
    assert!(!counts.is_empty() && counts.iter().all(|n| *n == 2));
    for (memory, region, there) in [(two, ", relaxation = []", 2), ("", two, 0)] {
        let session = body(memory, region);
        let counts = relaxations(&session, 0);
        let [first, last] = [counts[0], counts[counts.len() - 1]];
        assert_eq!([first, last], [2 - there, there], "{counts:?}");
        assert_eq!(session.world().state().faded.len(), counts.iter().sum::<usize>());
    }
}

#[test]
fn a_hand_s_flesh_remembers_and_stays_what_it_is() {
    let hand = |material: &str| {
        open(&format!(
            "[[hand]]\npreset = \"paper\"\nname = \"h\"\ntets = 100\nmaterial = {{ {material} }}"
        ))
    };
    let (plain, with) = (hand("young = 3e4"), hand("young = 3e4, relaxation = [[0.5, 0.2]]"));
    let [a, b] = [&plain, &with].map(|s| &s.world().desc().softs[0].flesh);
    assert_eq!(a.materials, b.materials);
    assert!(a.relaxation.is_empty());
    assert_eq!(b.relaxation, vec![Relaxation::new(&[[0.5, 0.2]]).unwrap(); b.tets.len()]);
    // What settings do to moduli leaves memory as it is.
    let mut with = with;
    let young = thenar_scene::tuning::SettingValue::Number(6e4);
    with.set("hand_young", &young).unwrap();
    let flesh = &with.world().desc().softs[0].flesh;
    assert_eq!(flesh.relaxation.len(), flesh.tets.len());
}

#[test]
fn ogden_s_law_has_its_exponent_and_either_modulus() {
    let body = |material: &str| {
        let session = open(&format!(
            "[[soft]]\nname = \"a\"\nshape = {{ kind = \"ball\", radius = 0.1 }}\nmaterial = {{ {material} }}"
        ));
        session.world().desc().softs[0].flesh.materials[0]
    };
    let one = body("law = \"ogden\", alpha = 8.5, mu = 35.3e3, poisson = 0.49");
    assert_eq!(one.law, Law::Ogden { alpha: 8.5 });
    assert!((one.young - 2.98 * 35.3e3).abs() < 1e-9);
    let two = body("law = \"ogden\", alpha = 8.5, young = 1e4");
    assert_eq!((two.law, two.young), (Law::Ogden { alpha: 8.5 }, 1e4));
}
