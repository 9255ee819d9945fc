//! Goal: a hand written as JSON is complete and adds up, so that another simulator starts from the
//! same body. Method: read it with a reader that knows nothing of the writer, and integrate.

use serde_json::Value;
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_rig::export::hand_json;
use thenar_rig::hand::HandOptions;
use thenar_rig::uniform_hand;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

fn vectors(value: &Value) -> Vec<Vec3> {
    let list = value.as_array().expect("a list").iter();
    list.map(|row| Vec3::from_column_slice(&numbers(row))).collect()
}

fn indices(value: &Value) -> Vec<Vec<usize>> {
    let row = |row: &Value| numbers(row).iter().map(|&x| x as usize).collect();
    value.as_array().expect("a list").iter().map(row).collect()
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-9 * b.abs().max(1e-9)
}

#[test]
fn a_hand_in_json_adds_up() {
    let hand = uniform_hand(Side::Right, 600).expect("the shipped hand");
    let document: Value = serde_json::from_str(&hand_json(&hand).expect("exported")).expect("JSON");
    let flesh = &document["flesh"];
    let nodes = vectors(&flesh["nodes"]);
    let tets = indices(&flesh["tets"]);
    let density = numbers(&flesh["density"]);

    // Volumes and masses, integrated here by the divergence of x over each tetrahedron's faces.
    let (mut volume, mut mass) = (0.0, 0.0);
    for (tet, density) in tets.iter().zip(&density) {
        let x: Vec<Vec3> = tet.iter().map(|&i| nodes[i]).collect();
        let faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let part: f64 = faces.iter().map(|f| x[f[0]].dot(&x[f[1]].cross(&x[f[2]])) / 6.0).sum();
        assert!(part > 0.0);
        volume += part;
        mass += density * part;
    }
    assert!(near(numbers(&flesh["tet_volumes"]).iter().sum(), volume));
    assert!(near(numbers(&flesh["node_masses"]).iter().sum(), mass));

    // Flesh and bones weigh what the material's density, which is the whole hand's, says. The
    // nodes' volumes are those of the body inside the lattice.
    let inside: f64 = numbers(&flesh["node_volumes"]).iter().sum();
    assert!(inside < volume && inside > 0.5 * volume, "{inside} of {volume}");
    let bones = document["bones"].as_array().expect("bones");
    let bone_mass: f64 = bones.iter().filter_map(|b| b["mass"].as_f64()).sum();
    let whole = HandOptions::paper().material.density * inside;
    assert!((mass + bone_mass - whole).abs() < 0.02 * whole, "{mass} + {bone_mass}, {whole}");

    // Weights sum to one over bones that exist; surface points lie in tetrahedra that exist.
    for (bones_of, weights) in indices(&flesh["binding_bones"])
        .iter()
        .zip(flesh["binding_weights"].as_array().expect("weights"))
    {
        assert!(bones_of.iter().all(|&b| b < bones.len()));
        assert!(near(numbers(weights).iter().sum(), 1.0));
    }
    let surface = &document["collision"];
    assert!(numbers(&surface["tets"]).iter().all(|&t| (t as usize) < tets.len()));
    for weights in surface["weights"].as_array().expect("weights") {
        assert!(near(numbers(weights).iter().sum(), 1.0));
    }
}

/// Both frames of a joint lie at the same place at rest, which places and turns the poses right.
#[test]
fn the_joints_of_a_hand_in_json_close() {
    let hand = uniform_hand(Side::Left, 600).expect("the shipped hand");
    let document: Value = serde_json::from_str(&hand_json(&hand).expect("exported")).expect("JSON");
    let bones = document["bones"].as_array().expect("bones");
    let joints = document["joints"].as_array().expect("joints");
    assert_eq!((bones.len(), joints.len()), (16, 15));

    // p + q r q*, from the components, without the crate's own rotations.
    let place = |pose: &Value, point: &Vec3| {
        let (p, q) = (numbers(&pose["position"]), numbers(&pose["rotation"]));
        assert!(near(q.iter().map(|x| x * x).sum(), 1.0));
        let (u, w) = (Vec3::new(q[0], q[1], q[2]), q[3]);
        let t = u.cross(point) * 2.0;
        Vec3::from_column_slice(&p) + point + t * w + u.cross(&t)
    };
    for joint in joints {
        let of = |end: &str| &bones[joint[end].as_u64().expect("an index") as usize]["pose"];
        let at = |frame: &str| Vec3::from_column_slice(&numbers(&joint[frame]["position"]));
        let from_parent = place(of("parent"), &at("pose_in_parent"));
        let from_child = place(of("child"), &at("pose_in_child"));
        assert!((from_parent - from_child).norm() < 1e-12, "{}", joint["name"]);
    }
}
