//! Goal: every shape that a scene can name becomes the body that it says. Method: one scene with
//! all of them; masses against closed formulas, and where a compound's parts lie.

use std::f64::consts::PI;
use std::path::Path;
use thenar_core::Vec3;
use thenar_core::shape::Shape;
use thenar_scene::session::Session;

const SCENE: &str = r#"
version = 1
[[rigid]]
name = "cylinder"
shape = { kind = "cylinder", radius = 0.01, length = 0.03 }
density = 1000
[[rigid]]
name = "ellipsoid"
shape = { kind = "ellipsoid", size = [0.02, 0.04, 0.06] }
density = 1000
position = [0.1, 0, 0]
[[rigid]]
name = "cone"
shape = { kind = "cone", radius = 0.01, height = 0.03 }
density = 1000
position = [0.2, 0, 0]
[[rigid]]
name = "hammer"
density = 1000
position = [0.3, 0.1, 0]
[rigid.shape]
kind = "compound"
[[rigid.shape.parts]]
shape = { kind = "box", size = [0.02, 0.02, 0.02] }
[[rigid.shape.parts]]
shape = { kind = "box", size = [0.02, 0.02, 0.02] }
frame = { position = [0.02, 0, 0] }
"#;

fn open(text: &str) -> Result<Session, String> {
    Session::from_text(text, Path::new("s.toml"), &[]).map_err(|e| e.to_string())
}

#[test]
fn new_shapes_weigh_what_their_volume_does() {
    let session = open(SCENE).unwrap();
    let rigids = &session.world().desc().rigids;
    let volumes = [PI * 1e-4 * 0.03, 4.0 / 3.0 * PI * 6e-6, PI * 1e-4 * 0.01, 1.6e-5];
    for (rigid, volume) in rigids.iter().zip(volumes) {
        assert!((rigid.mass / (1000.0 * volume) - 1.0).abs() < 1e-12, "{}", rigid.name);
    }
    // Two cubes side by side are one block, about its own middle.
    let hammer = &rigids[3];
    assert!((hammer.pose_WB.position - Vec3::new(0.31, 0.1, 0.0)).norm() < 1e-15);
    let square = Vec3::new(0.04, 0.02, 0.02).map(|x| x * x);
    for k in 0..3 {
        let block = hammer.mass / 12.0 * (square.sum() - square[k]);
        assert!((hammer.inertia[(k, k)] / block - 1.0).abs() < 1e-12);
    }
    let Some(shape @ Shape::Compound(_)) = &hammer.shape else { panic!("a compound") };
    assert!((shape.distance(&Vec3::new(0.05, 0.0, 0.0)).value - 0.03).abs() < 1e-15);
}

#[test]
fn compounds_of_planes_and_compounds_are_refused() {
    let with = |parts: &str| {
        let text = format!(
            "version = 1\n[[rigid]]\nname = \"a\"\nmass = 1\nshape = {{ kind = \"compound\", parts = [{parts}] }}"
        );
        open(&text).map(|_| ()).unwrap_err()
    };
    assert!(with("").contains("at least one part"), "{}", with(""));
    let plane = with("{ shape = { kind = \"plane\" } }");
    assert!(plane.contains("no plane, car or compound"), "{plane}");
    let nested = with("{ shape = { kind = \"compound\", parts = [] } }");
    assert!(nested.contains("no plane, car or compound"), "{nested}");
}
