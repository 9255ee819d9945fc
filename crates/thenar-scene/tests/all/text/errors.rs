//! Goal: every mistake in a scene is answered with its file, line, column and key, and with what
//! was expected. Method: one mistake at a time in a small scene; the whole message is compared.

use std::path::Path;
use thenar_scene::session::Session;

/// The message for a scene text.
fn message(text: &str) -> String {
    match Session::from_text(text, Path::new("s.toml"), &[]) {
        Ok(_) => panic!("accepted:\n{text}"),
        Err(e) => e.to_string(),
    }
}

/// Each text follows a first line `version = 1`.
#[track_caller]
fn check(text: &str, expected: &str) {
    assert_eq!(message(&format!("version = 1\n{text}")), format!("s.toml:{expected}"));
}

#[test]
fn text_that_is_no_toml() {
    assert!(message("version = ").starts_with("s.toml:1:1"), "{}", message("version = "));
    assert!(message("a = 1\na = 2").starts_with("s.toml:2:1: not valid TOML: duplicate key"));
    let deep = format!("version = {}1{}", "[".repeat(5000), "]".repeat(5000));
    assert!(message(&deep).contains("not valid TOML"));
    assert!(message("version = 99999999999999999999").contains("too large"));
}

#[test]
fn missing_and_unknown_keys() {
    assert_eq!(message(""), "s.toml:1:1: the key `version` is missing");
    check("tim_step = 1", "2:1: `tim_step`: unknown key; did you mean `time_step`?");
    check("[[rigid]]\nmass = 1", "2:1: `rigid[0]`: the key `name` is missing");
    check(
        "[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, 1]\nzoom = 2",
        "5:1: `camera.zoom`: unknown key; expected one of: position, target, up, fov_deg",
    );
    check(
        "[[rigid]]\nname = \"a\"\nshape = { kind = \"box\", radius = 1 }",
        "4:25: `rigid[0].shape.radius`: unknown key; expected one of: size",
    );
}

#[test]
fn wrong_kinds_of_values() {
    check(
        "time_step = \"1\"",
        "2:13: `time_step`: expected a finite number from 1e-7 to 10, got the string \"1\"",
    );
    check("gravity = [0, 1]", "2:11: `gravity`: expected an array of 3, got an array of 2");
    check("gravity = 9.81", "2:11: `gravity`: expected an array of 3, got 9.81");
    check(
        "gravity = [0, true, 0]",
        "2:15: `gravity[1]`: expected a finite number between -10000 and 10000, both excluded, got true",
    );
    check(
        "title = \"\"",
        "2:9: `title`: expected text that is not empty and without control characters, got the string \"\"",
    );
    check("camera = 1", "2:10: `camera`: expected a table, got 1");
    check("rigid = 1", "2:9: `rigid`: expected an array, got 1");
    check("title = 1979-05-27", "2:9: `title`: expected a string, got the date 1979-05-27");
    check(
        "[solver]\ncone = \"circlar\"",
        "3:8: `solver.cone`: expected one of \"circular\", \"linearised\", got the string \"circlar\"; did you mean \"circular\"?",
    );
    check(
        "[solver]\nkind = \"monolitic\"",
        "3:8: `solver.kind`: expected one of \"monolithic\", \"two-step\", got the string \"monolitic\"; did you mean \"monolithic\"?",
    );
    check(
        "[solver]\ncg_iterations_max = 1.5",
        "3:21: `solver.cg_iterations_max`: expected a whole number from 1 to 1e6, got 1.5",
    );
    check(
        "[[rigid]]\nname = \"a\"\nshape = {}",
        "4:9: `rigid[0].shape`: the key `kind` is missing; expected one of \"box\", \"sphere\", \"capsule\", \"cylinder\", \"ellipsoid\", \"cone\", \"compound\", \"plane\", \"car\", \"mesh\"",
    );
}

#[test]
fn numbers_out_of_bounds() {
    check("time_step = 0", "2:13: `time_step`: expected a finite number from 1e-7 to 10, got 0");
    check(
        "time_step = nan",
        "2:13: `time_step`: expected a finite number from 1e-7 to 10, got NaN",
    );
    check(
        "gravity = [0, inf, 0]",
        "2:15: `gravity[1]`: expected a finite number between -10000 and 10000, both excluded, got inf",
    );
    check(
        "[[rigid]]\nname = \"a\"\nmass = -1",
        "4:8: `rigid[0].mass`: expected a finite number from 1e-9 to 1e6, got -1",
    );
    check(
        "[[rigid]]\nname = \"a\"\ndensity = 0",
        "4:11: `rigid[0].density`: expected a finite number from 0.001 to 1e5, got 0",
    );
    check(
        "[[rigid]]\nname = \"a\"\nshape = { kind = \"sphere\", radius = 1e-5 }",
        "4:37: `rigid[0].shape.radius`: expected a finite number from 1e-4 to 100, got 1e-5",
    );
    let soft = "[[soft]]\nname = \"s\"\nshape = { kind = \"lattice\", size = [1, 1, 1], cells = [1, 1, 1] }\n";
    check(
        &format!("{soft}material = {{ poisson = 0.5 }}"),
        "5:24: `soft[0].material.poisson`: expected a finite number between -1 and 0.5, both excluded, got 0.5",
    );
    check(
        &format!("{soft}material = {{ young = -5e4 }}"),
        "5:22: `soft[0].material.young`: expected a finite number from 0.1 to 1e12, got -50000",
    );
}

#[test]
fn names_that_stand_for_nothing_or_for_two_things() {
    let two = "[[rigid]]\nname = \"ball\"\nmass = 1\ninertia = [1, 1, 1]\n";
    check(&format!("{two}{two}"), "7:8: `rigid[1].name`: the name \"ball\" is already taken");
    check(
        &format!("{two}[[probe]]\nname = \"p\"\nmeasure = \"pose\"\nbody = \"bal\""),
        "9:8: `probe[0].body`: no rigid body is named \"bal\"; did you mean \"ball\"?",
    );
    check(
        &format!("{two}[[load]]\nkind = \"pressure\"\nbody = \"ball\"\nfaces = {{}}\npressure = 1"),
        "8:8: `load[0].body`: no soft body or hand is named \"ball\"; there are none",
    );
    check(
        "[[rigid]]\nname = \"a,b\"\nmass = 1",
        "3:8: `rigid[0].name`: expected a name of at most 64 letters, digits, '-', '_', '.' and spaces, got \"a,b\"",
    );
}

#[test]
fn bodies_that_cannot_be() {
    check(
        "[[rigid]]\nname = \"a\"",
        "3:8: `rigid[0].name`: a dynamic body needs `mass` or `density`",
    );
    check(
        "[[rigid]]\nname = \"a\"\nmass = 1",
        "3:8: `rigid[0].name`: a dynamic body without a shape needs `inertia`",
    );
    check(
        "[[rigid]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 5]",
        "5:11: `rigid[0].inertia`: no body has such an inertia: its largest principal moment 5e0 exceeds the sum of the others",
    );
    check(
        "[[rigid]]\nname = \"a\"\nmass = 1\nshape = { kind = \"plane\" }",
        "3:8: `rigid[0].name`: a plane cannot be dynamic; set motion = \"fixed\" or \"scripted\"",
    );
    check(
        "[[rigid]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 1]\nrotation = { axis = [0, 0, 0], angle = 1 }",
        "6:12: `rigid[0].rotation`: expected an axis that is not zero",
    );
    check(
        "[[rigid]]\nname = \"a\"\nmotion = \"fixed\"\nvelocity = [1, 0, 0]",
        "3:8: `rigid[0].name`: a fixed body has no velocity; set motion = \"scripted\"",
    );
    let tets = "[[soft]]\nname = \"s\"\n[soft.shape]\nkind = \"tets\"\nnodes = [[0,0,0],[1,0,0],[0,1,0],[0,0,1],[1,1,0]]\n";
    check(
        &format!("{tets}tets = [[0,1,2,4]]"),
        "7:8: `soft[0].shape.tets`: tetrahedron 0 is flat: its volume is 0e0 m³",
    );
    check(
        &format!("{tets}tets = [[0,1,2,9]]"),
        "7:8: `soft[0].shape.tets`: tetrahedron 0 names node 9, but there are only 5",
    );
    check(
        &format!("{tets}tets = [[0,1,2,3]]"),
        "7:8: `soft[0].shape.tets`: node 4 belongs to no tetrahedron",
    );
}

#[test]
fn mesh_files_that_are_not_there_or_no_meshes() {
    check(
        "[[soft]]\nname = \"s\"\nshape = { kind = \"mesh\", file = \"none.obj\" }",
        "4:33: `soft[0].shape.file`: cannot read none.obj: No such file or directory (os error 2)",
    );
    check(
        "[[rigid]]\nname = \"s\"\nmass = 1\nshape = { kind = \"mesh\", file = \"Cargo.toml\" }",
        "5:33: `rigid[0].shape.file`: Cargo.toml: unknown kind of mesh file (.glb, .obj, .stl, .ply and .off are known)",
    );
    check(
        "[[hand]]\nname = \"h\"\nmodel = \"middle\"",
        "4:9: `hand[0].model`: expected \"right\", \"left\", or the path of a .thenar or .glb file, got \"middle\"",
    );
}

#[test]
fn joints_and_selectors_that_cannot_be() {
    let pair = "[[rigid]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 1]\n[[rigid]]\nname = \"b\"\nmass = 1\ninertia = [1, 1, 1]\n";
    let joint = |rest: &str| {
        format!("{pair}[[joint]]\nname = \"j\"\nparent = \"a\"\nchild = \"b\"\n{rest}")
    };
    check(
        &joint("kind = \"hinge\"\nanchor = [0, 0, 0]"),
        "11:8: `joint[0].name`: a hinge needs `axis`",
    );
    check(
        &joint("kind = \"hinge\"\naxis = [0, 0, 1]"),
        "11:8: `joint[0].name`: the key `anchor` is missing",
    );
    check(
        &joint("kind = \"universal\"\nanchor = [0, 0, 0]\naxes = [[1, 0, 0], [1, 1, 0]]"),
        "16:8: `joint[0].axes`: expected two axes at right angles to each other",
    );
    check(
        &joint("kind = \"hinge\"\nanchor = [0, 0, 0]\naxis = [0, 0, 1]\nangles = [1, 2]"),
        "17:10: `joint[0].angles`: expected 1 values, one for each angle of a Hinge joint, got 2",
    );
    check(
        "[[soft]]\nname = \"s\"\nshape = { kind = \"lattice\", size = [1, 1, 1], cells = [1, 1, 1] }\nfixed = [{ nodes = { box_min = [5, 5, 5] } }]",
        "5:20: `soft[0].fixed[0].nodes`: no nodes fulfil these conditions",
    );
}

#[test]
fn overrides_are_named_as_given() {
    let load = |set: &str| {
        Session::from_text("version = 1", Path::new("s.toml"), &[set.into()])
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        load("time_step=-1"),
        "override `time_step=-1`: `time_step`: expected a finite number from 1e-7 to 10, got -1"
    );
    assert_eq!(
        load("nothing"),
        "override `nothing`: expected key=value, e.g. solver.cone=\"linearised\""
    );
    assert_eq!(
        load("durtion=1"),
        "override `durtion=1`: `durtion`: unknown key; did you mean `duration`?"
    );
}

#[test]
fn files_that_are_not_there() {
    let error = Session::load(Path::new("nowhere/s.toml"), &[]).unwrap_err().to_string();
    assert_eq!(error, "nowhere/s.toml: No such file or directory (os error 2)");
}

/// Materials outside their sense.
#[test]
fn materials_that_no_tissue_has() {
    let body = |material: &str| {
        format!(
            "[[soft]]\nname = \"a\"\nshape = {{ kind = \"ball\", radius = 0.1 }}\n\
             stiffness_damping = 0.01\nmaterial = {{ {material} }}"
        )
    };
    let check = |terms: &str, expected: &str| {
        check(&body(&format!("relaxation = {terms}")), expected);
    };
    check(
        "[[0.5, 1], [0.5, 2]]",
        "6:27: `soft[0].material.relaxation`: the weights must sum to less than 1, so that some stress stays, got 1",
    );
    check(
        "[[0.1, 1], [0.1, 1], [0.1, 1], [0.1, 1], [0.1, 1]]",
        "6:27: `soft[0].material.relaxation`: expected at most 4 terms, got 5",
    );
    check(
        "[[0.5, -1]]",
        "6:34: `soft[0].material.relaxation[0][1]`: expected a finite number > 0, got -1",
    );
    check(
        "[[0.5]]",
        "6:28: `soft[0].material.relaxation[0]`: expected an array of 2, got an array of 1",
    );
    check(
        "[[0.5, 1]]",
        "6:27: `soft[0].material.relaxation`: expected `relaxation` or `stiffness_damping`, not both: tissue with memory is damped by it, and nothing is damped twice",
    );
    let check = |material: &str, expected: &str| {
        self::check(&body(material), &format!("6:{expected}"));
    };
    check(
        "law = \"ogden\"",
        "20: `soft[0].material.law`: Ogden's law needs its exponent, `alpha`, from 4 to 20",
    );
    check("alpha = 8", "22: `soft[0].material.alpha`: only `law = \"ogden\"` has an exponent");
    check(
        "law = \"ogden\", alpha = 2",
        "37: `soft[0].material.alpha`: expected a finite number from 4 to 20, got 2",
    );
    check("young = 1, mu = 1", "30: `soft[0].material.mu`: expected `young` or `mu`, not both");
    check(
        "poisson = 0.5",
        "24: `soft[0].material.poisson`: expected a finite number between -1 and 0.5, both excluded, got 0.5",
    );
}
