//! Goal: no stage of building is deaf or dear, whatever the mesh. Method: meshes of very many
//! pieces, or of very many triangles around one vertex; what stages say is counted, and a watch
//! that says no after so many words must be obeyed at once.

use std::cell::{Cell, RefCell};
use std::f64::consts::TAU;
use std::rc::Rc;
use thenar_core::Vec3;
use thenar_rig::embed::closed_surface;
use thenar_rig::mesh::{GridOptions, decimate, shapes};
use thenar_rig::object::{ImportOptions, Weight, rigid_from_mesh};
use thenar_rig::work::{Progress, STAGE_MAX, watched};
use thenar_rig::{RigError, TriMesh};

/// The result of `build`, and all that was said meanwhile.
fn listen<T>(build: impl FnOnce() -> T) -> (T, Vec<Progress>) {
    let said: Rc<RefCell<Vec<Progress>>> = Rc::default();
    let heard = Rc::clone(&said);
    let made = watched(
        move |progress| {
            heard.borrow_mut().push(progress);
            true
        },
        build,
    );
    (made, said.take())
}

/// Work of all stages of this name.
fn work(said: &[Progress], name: &str) -> f64 {
    said.iter().filter(|p| p.stage == name && p.done == 0.0).map(|p| p.work).sum()
}

/// Says no to the words `build` says, first to the first, then to the second and so on, and expects
/// no further word and no other result.
fn is_obeyed<T: std::fmt::Debug>(build: impl Fn() -> Result<T, RigError>, words: usize) {
    for allowed in 0..words {
        let said = Rc::new(Cell::new(0));
        let heard = Rc::clone(&said);
        let made = watched(
            move |_| {
                heard.set(heard.get() + 1);
                heard.get() <= allowed
            },
            &build,
        );
        assert!(matches!(made, Err(RigError::Stopped)), "{allowed}: {:?}", made.map(|_| ()));
        assert_eq!(said.get(), allowed + 1);
    }
}

/// A tetrahedron with corners at the origin and on the axes, moved and scaled.
fn tetrahedron(place: Vec3, size: f64) -> TriMesh {
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    TriMesh {
        positions: corners.map(|p| place + p * size).to_vec(),
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    }
}

fn all(pieces: impl Iterator<Item = TriMesh>) -> TriMesh {
    let mut mesh = TriMesh::default();
    pieces.for_each(|piece| mesh.append(&piece));
    mesh
}

/// As many tetrahedra beside each other in a cube, `n³`, all inside out.
fn apart(n: usize) -> TriMesh {
    let at = |k: usize| Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64);
    let mut mesh = all((0..n * n * n).map(|k| tetrahedron(at(k) * 0.02, 0.01)));
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

/// So many tetrahedra, each around the next, all inside out.
fn nested(n: usize) -> TriMesh {
    // Centred on (1, 1, 1) / 4 of the size, so that corners keep off the next one's faces.
    let size = |k: usize| 1.0 - 0.9 * k as f64 / n as f64;
    let mut mesh = all((0..n).map(|k| tetrahedron(Vec3::repeat(-0.25 * size(k)), size(k))));
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}

/// Pieces that lie beside each other turn outward, all four triangles of each, at a cost in
/// proportion to their number.
#[test]
fn many_pieces_are_turned_at_a_cost_of_their_number() {
    for n in [8, 16, 28] {
        let mut mesh = apart(n);
        let (turned, said) = listen(|| mesh.orient());
        let turned = turned.unwrap();
        assert_eq!((turned.flipped_triangles, turned.cavities), (4 * n.pow(3), 0));
        // Only its own box holds a piece: one look each, and rounding up to whole probes.
        let each = work(&said, "finding cavities") / n.pow(3) as f64;
        assert!(each <= 2.0 + 64.0 / n.pow(3) as f64, "{n}: {each}");
    }
}

/// Of pieces within each other every second one is the wall of a cavity; each lies in all before
/// it, which is asked for.
#[test]
fn nested_pieces_alternate_and_their_price_is_known() {
    let n = 200;
    let mut mesh = nested(n);
    let (turned, said) = listen(|| mesh.orient());
    let turned = turned.unwrap();
    assert_eq!((turned.cavities, turned.flipped_triangles), (n / 2, 4 * n / 2));
    // n (n - 1) / 2 pairs of one box, one node and four triangles each, far apart in memory, which
    // takes four times as long; every fourth piece is probed.
    let expected = 4.0 * 6.0 * (n * (n - 1) / 2) as f64;
    let told = work(&said, "finding cavities");
    assert!((told / expected - 1.0).abs() < 0.05, "{told} {expected}");
}

/// Twenty thousand within each other would be 2e8 pairs of 24 comparisons: too much, which is said
/// in advance.
#[test]
fn what_is_nested_too_deeply_is_refused_before_it_is_looked_into() {
    let mut mesh = nested(20_000);
    let (turned, said) = listen(|| mesh.orient());
    assert!(turned.unwrap_err().to_string().contains("lie within each other"));
    assert_eq!(work(&said, "finding cavities"), 0.0);
}

/// A mesh that is to be one body is counted, not turned.
#[test]
fn parts_of_a_soft_body_are_counted_before_they_are_turned() {
    let (made, said) = listen(|| closed_surface(&apart(10)));
    assert!(made.unwrap_err().to_string().ends_with("has 1000 separate parts, expected one"));
    assert!(said.iter().all(|p| p.stage != "orienting the pieces of the mesh"));
}

/// Two apexes over a rim of `n` corners.
fn double_cone(n: u32) -> TriMesh {
    let mut mesh =
        TriMesh { positions: vec![Vec3::y() * 0.05, Vec3::y() * -0.05], triangles: vec![] };
    for k in 0..n {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(n)).sin_cos();
        mesh.positions.push(Vec3::new(0.05 * cos, 0.0, 0.05 * sin));
        let (a, b) = (2 + k, 2 + (k + 1) % n);
        mesh.triangles.extend([[0, b, a], [1, a, b]]);
    }
    mesh
}

/// An apex of very many triangles stays where it is, and the rim is thinned: of a fine polygon of
/// radius r the cones enclose 2 π r² h / 3 with r = h = 0.05 m.
#[test]
fn a_vertex_of_very_many_triangles_stays_and_costs_little() {
    for n in [5_000, 50_000] {
        let mesh = double_cone(n);
        let (thin, said) = listen(|| decimate(&mesh, 1500));
        let thin = thin.unwrap();
        assert!(thin.triangles.len() <= 1500);
        for apex in &mesh.positions[..2] {
            assert!(thin.positions.contains(apex));
        }
        let exact = 2.0 * TAU / 2.0 * 0.05f64.powi(3) / 3.0;
        assert!((thin.volume() / exact - 1.0).abs() < 1e-3, "{}", thin.volume() / exact);
        // A word for each million looks at triangles, of which a collapse of the rim takes less
        // than 200.
        assert!(said.len() <= 2 + 200 * n as usize / 1_000_000, "{n}: {}", said.len());
    }
}

/// Where a dozen vertices have almost as many triangles as may move, to offer their edges is dear:
/// a word comes for each million looks from the first on, and each is heard.
#[test]
fn an_end_is_heard_wherever_a_word_is_said() {
    let fans = all((0..12).map(|k| {
        let mut cone = double_cone(950);
        cone.positions.iter_mut().for_each(|p| p.x += 0.2 * f64::from(k));
        cone
    }));
    let (thin, said) = listen(|| decimate(&fans, 10_000));
    thin.unwrap();
    // Each spoke of 24 apexes is offered among 950 and 4 triangles.
    assert!(said.len() > 24 * 950 * 954 / 1_000_000, "{}", said.len());
    is_obeyed(|| decimate(&fans, 10_000), 12);
    let mut ball = shapes::sphere(0.03, 6);
    ball.append(&apart(3));
    let grid = GridOptions { cells: 8, values_max: 2000, ..GridOptions::default() };
    let options = ImportOptions { grid, ..ImportOptions::default() };
    let rigid = || rigid_from_mesh("x", &ball, Weight::Mass(1.0), &options);
    let (made, said) = listen(rigid);
    made.unwrap();
    is_obeyed(rigid, said.len());
    assert!(said.iter().all(|p| p.work < STAGE_MAX));
}
