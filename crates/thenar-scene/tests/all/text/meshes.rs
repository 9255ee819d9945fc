//! Goal: an author who puts a mesh file into a scene reads a question about its unit, and how to
//! close it. Method: one tetrahedron of 130 mm, in files in millimetres and in metres, whole and
//! open, as bodies of all kinds.

use std::fs::write;
use thenar_core::model::Side;
use thenar_core::{Pose, Vec3};
use thenar_output::TemporaryFolder;
use thenar_rig::TriMesh;
use thenar_rig::export::{GlbMesh, Skeleton, VertexSkin, glb};
use thenar_rig::glb::read_skinned_glb;
use thenar_rig::hand::asset;
use thenar_rig::mesh::shapes;
use thenar_scene::session::Session;

/// A tetrahedron whose longest edges along the axes measure 130; of each face its letter.
const CORNERS: &str = "v 0 0 0\nv 130 0 0\nv 0 130 0\nv 0 0 130\n";
const FACES: [&str; 4] = ["f 1 3 2\n", "f 1 2 4\n", "f 1 4 3\n", "f 2 3 4\n"];

const RIGID: &str = "[[rigid]]\nname = \"a\"\nmass = 0.3\nshape = { kind = \"mesh\", file = \"it.obj\", grid = 8 }\n";
const SOFT: &str =
    "[[soft]]\nname = \"b\"\nshape = { kind = \"mesh\", file = \"it.obj\", tets = 20 }\n";
const COMPOUND: &str = "[[rigid]]\nname = \"c\"\nmass = 1\n[rigid.shape]\nkind = \"compound\"\nparts = [\n\
    { shape = { kind = \"sphere\", radius = 0.01 } },\n\
    { shape = { kind = \"mesh\", file = \"it.obj\", grid = 8 }, frame = { position = [0, 0.1, 0] } },\n]\n";
const TETS: &str = "[[soft]]\nname = \"d\"\nshape = { kind = \"tet-file\", file = \"it.toml\" }\n";

/// A folder with the tetrahedron as a mesh of these faces, and as an element.
fn folder(faces: &[&str]) -> TemporaryFolder {
    let folder = TemporaryFolder::new("thenar-scene-meshes").unwrap();
    write(folder.path().join("it.obj"), CORNERS.to_string() + &faces.concat()).unwrap();
    let tets = "nodes = [[0,0,0],[130,0,0],[0,130,0],[0,0,130]]\ntets = [[0,1,2,3]]\n";
    write(folder.path().join("it.toml"), tets).unwrap();
    folder
}

fn open(folder: &TemporaryFolder, body: &str) -> Result<Session, String> {
    let text = format!("version = 1\ngravity = [0, 0, 0]\n{body}");
    Session::from_text(&text, &folder.path().join("s.toml"), &[]).map_err(|e| e.to_string())
}

/// The questions about units that a scene with this body gets.
fn asked(folder: &TemporaryFolder, body: &str) -> Vec<String> {
    let session = open(folder, body).unwrap_or_else(|e| panic!("{e}"));
    session.warnings().into_iter().filter(|warning| warning.contains(" measures ")).collect()
}

#[test]
fn a_mesh_in_millimetres_is_asked_about_with_the_key_to_write() {
    let folder = folder(&FACES);
    let bodies = [
        (RIGID, "`rigid[0].shape.file`: it.obj", "300.00 g"),
        (SOFT, "`soft[0].shape.file`: it.obj", "e8 kg"),
        (COMPOUND, "`rigid[0].shape.parts[1].shape.file`: it.obj", "130.000 m: are"),
        (TETS, "`soft[0].shape.file`: it.toml", "e8 kg"),
    ];
    for (body, place, mass) in bodies {
        let told = asked(&folder, body);
        let [told] = &told[..] else { panic!("{body}: {told:?}") };
        assert!(told.starts_with(place) && told.contains(mass), "{told}");
        assert!(told.contains("130.000 m x 130.000 m x 130.000 m"), "{told}");
        assert!(told.contains("are these millimetres?"), "{told}");
        assert!(told.contains("give scale = 0.001, and it is 130.00 mm long"), "{told}");
        // The advice works.
        let mended = body.replace(".obj\"", ".obj\", scale = 0.001");
        let mended = mended.replace(".toml\"", ".toml\", scale = 0.001");
        assert_eq!(asked(&folder, &mended), [""; 0], "{body}");
    }
}

/// A floor of 130 mm cells may be a hall's; what moves may not.
#[test]
fn what_stands_still_may_be_a_room() {
    let folder = folder(&FACES);
    let hall = RIGID.replace(".obj\"", ".obj\", scale = 0.5");
    assert_eq!(asked(&folder, &hall).len(), 1);
    let hall = hall.replace("mass = 0.3", "motion = \"fixed\"");
    assert_eq!(asked(&folder, &hall), [""; 0]);
    assert_eq!(asked(&folder, &hall.replace("0.5", "1")).len(), 1);
}

/// Bodies stand in the order of the file, behind those of hands and figures.
#[test]
fn each_of_several_bodies_is_asked_about_by_its_own_file() {
    let folder = folder(&FACES);
    let fine = SOFT.replace(".obj\"", ".obj\", scale = 0.001").replace("\"b\"", "\"e\"");
    let figure = "[[figure]]\nname = \"f\"\nmodel = \"gripper\"\nflesh = 0.005\n";
    let body = format!("{RIGID}{fine}{SOFT}{figure}");
    let told = asked(&folder, &body);
    let places: Vec<&str> = told.iter().filter_map(|t| t.split(": ").next()).collect();
    assert_eq!(places, ["`rigid[0].shape.file`", "`soft[1].shape.file`"]);
}

#[test]
fn a_soft_body_of_an_open_mesh_is_refused_with_what_closes_it() {
    let folder = folder(&FACES[..3]);
    let error = open(&folder, SOFT).unwrap_err();
    assert!(error.contains("it.obj") && error.contains("around one hole"), "{error}");
    assert!(
        error.contains("`thenar build it.obj --soft --tets 20 -o it.thenar` closes"),
        "{error}"
    );
    let small = SOFT.replace(".obj\"", ".obj\", scale = 0.001");
    let error = open(&folder, &small).unwrap_err();
    assert!(error.contains("--soft --scale 0.001 --tets 20 -o it.thenar"), "{error}");
    assert!(error.contains("file = \"it.thenar\", without `scale`"), "{error}");
    let scaled = small.replace("it.obj", "it.thenar");
    let error = open(&folder, &scaled).unwrap_err();
    assert!(error.contains("its own size"), "{error}");
    // A rigid body's inside is found however open its mesh is.
    open(&folder, RIGID).unwrap();
}

/// A hand in a scene has a length and no scale.
#[test]
fn the_error_of_a_rig_in_millimetres_names_the_key_of_scenes() {
    let folder = folder(&FACES);
    write(folder.path().join("rig.glb"), hand_in_millimetres()).unwrap();
    let hand = "[[hand]]\nname = \"h\"\nmodel = \"rig.glb\"\npreset = \"paper\"\ntets = 100\n";
    let error = open(&folder, hand).unwrap_err();
    assert!(error.contains("are these millimetres") && error.contains("[[hand]]"), "{error}");
    let key = error.split("`length = ").nth(1).and_then(|rest| rest.split('`').next()).unwrap();
    open(&folder, &format!("{hand}length = {key}\n")).unwrap();
}

/// A rig whose joints have numbers for names is built by the scene's table of names, which no other
/// model takes.
#[test]
fn a_scene_names_the_joints_of_a_rig() {
    let folder = folder(&FACES);
    let names: Vec<String> = (0..25).map(|k| format!("n{k}")).collect();
    write(folder.path().join("rig.glb"), rig(1.0, Some(&names))).unwrap();
    let hand = "[[hand]]\nname = \"h\"\nmodel = \"rig.glb\"\npreset = \"paper\"\ntets = 100\n";
    let error = open(&folder, hand).unwrap_err();
    assert!(error.contains("no joint `wrist`"), "{error}");
    let own = read_skinned_glb(asset(Side::Right)).unwrap();
    let lines =
        own.joints.iter().zip(&names).map(|(joint, name)| format!("{} = \"{name}\"\n", joint.name));
    let table = format!("[hand.joint_names]\n{}", lines.collect::<String>());
    open(&folder, &format!("{hand}{table}")).unwrap();
    let error = open(&folder, &format!("[[hand]]\nname = \"h\"\n{table}")).unwrap_err();
    assert!(error.contains("joint_names") && error.contains(".glb"), "{error}");
    let error = open(&folder, &format!("{hand}[hand.joint_names]\nwrist = \"n99\"\n")).unwrap_err();
    assert!(error.contains("no joint \"n99\""), "{error}");
}

/// A hand beside a cube that encloses more is taken by its name; names that the file lacks are
/// reported with those that it has.
#[test]
fn a_scene_names_the_mesh_of_a_rig() {
    let folder = folder(&FACES);
    let cube = shapes::cuboid(&Vec3::repeat(0.2));
    write(folder.path().join("rig.glb"), rig_beside(1.0, None, &[("case", &cube)])).unwrap();
    let hand = "[[hand]]\nname = \"h\"\nmodel = \"rig.glb\"\npreset = \"paper\"\ntets = 100\n";
    let built = |key: &str| open(&folder, &format!("{hand}{key}\n"));
    built("mesh = \"hand\"").unwrap();
    built("mesh = [\"hand\"]").unwrap();
    let error = built("mesh = \"hnd\"").unwrap_err();
    assert!(
        error.contains("hand[0].mesh")
            && error.contains(
                "no skinned mesh \"hnd\"; it has \"hand\", \"case\"; did you mean \"hand\"?"
            ),
        "{error}"
    );
    assert!(built("mesh = []").unwrap_err().contains("the name of a mesh, or several"));
    let error = open(&folder, "[[hand]]\nname = \"h\"\nmesh = \"hand\"\n").unwrap_err();
    assert!(error.contains("mesh") && error.contains(".glb"), "{error}");
    let figure = |model: &str, mesh: &str| {
        let scene = format!(
            "[[figure]]\nname = \"f\"\ntets = 100\nmodel = \"{model}\"\nmesh = \"{mesh}\"\n"
        );
        open(&folder, &scene).unwrap_err()
    };
    let error = figure("rig.glb", "skirt");
    assert!(error.contains("figure[0].mesh") && error.contains("\"skirt\"; it has"), "{error}");
    assert!(figure("gripper", "x").contains("no meshes to choose from"));
}

/// A block of 2.36 in, read in metres, is asked about where a hand is to move it, and not where it
/// stands still.
#[test]
fn a_block_of_tonnes_is_asked_about_where_hands_are() {
    let folder = folder(&FACES);
    let corners = "v 0 0 0\nv 2.36 0 0\nv 0 2.36 0\nv 0 0 2.36\n";
    write(folder.path().join("it.obj"), corners.to_string() + &FACES.concat()).unwrap();
    let hand = "[[hand]]\nname = \"h\"\npreset = \"paper\"\ntets = 100\nposition = [0, 5, 0]\n";
    let block = RIGID.replace("mass = 0.3", "density = 3000");
    let both = format!("{block}{hand}");
    let told = asked(&folder, &both);
    let [told] = &told[..] else { panic!("{told:?}") };
    // A sixth of the cube, 2.19 m³.
    assert!(
        told.contains("weighs 6572") && told.contains("inches (scale = 0.0254: 59.94 mm"),
        "{told}"
    );
    assert!(asked(&folder, &block).is_empty(), "no hand is there");
    let still = both.replace("density = 3000", "motion = \"fixed\"");
    assert!(asked(&folder, &still).is_empty());
}

/// The built-in right hand as a file in millimetres.
fn hand_in_millimetres() -> Vec<u8> {
    rig(1e3, None)
}

/// The built-in right hand as a file at this scale, with its joints' own names or others.
fn rig(scale: f64, names: Option<&[String]>) -> Vec<u8> {
    rig_beside(scale, names, &[])
}

/// [`rig`] with other meshes on its first joint.
fn rig_beside(scale: f64, names: Option<&[String]>, others: &[(&str, &TriMesh)]) -> Vec<u8> {
    let own = read_skinned_glb(asset(Side::Right)).unwrap();
    let positions: Vec<Vec3> = own.mesh.positions.iter().map(|p| p * scale).collect();
    let place = |pose: &Pose| Pose::new(pose.position * scale, pose.rotation);
    let skeleton = Skeleton {
        names: match names {
            Some(names) => names.iter().map(String::as_str).collect(),
            None => own.joints.iter().map(|joint| joint.name.as_str()).collect(),
        },
        parents: vec![None; own.joints.len()],
        poses: own.joints.iter().map(|joint| place(&joint.pose)).collect(),
    };
    let first = VertexSkin { bones: [0; 4], weights: [1.0, 0.0, 0.0, 0.0] };
    let hand = TriMesh { positions, triangles: own.mesh.triangles.clone() };
    let meshes: Vec<(&str, &TriMesh)> =
        [("hand", &hand)].into_iter().chain(others.iter().copied()).collect();
    let skins: Vec<_> = meshes.iter().map(|(_, mesh)| vec![first; mesh.positions.len()]).collect();
    let written = meshes.iter().zip(&skins).map(|((name, mesh), skin)| GlbMesh {
        name,
        positions: &mesh.positions,
        triangles: &mesh.triangles,
        colour: [0.8; 3],
        skin: Some(skin),
    });
    glb(&written.collect::<Vec<_>>(), Some(&skeleton)).unwrap()
}
