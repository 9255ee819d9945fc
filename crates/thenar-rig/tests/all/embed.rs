//! Goal: any closed mesh becomes a soft body of its own mass and shape. Method: bodies whose
//! volume and mass distribution are known in closed form.

use thenar_core::Vec3;
use thenar_core::model::{Law, Material};
use thenar_rig::TriMesh;
use thenar_rig::embed::{EmbedOptions, Embedded, embed};
use thenar_rig::lattice::tet;
use thenar_rig::mesh::shapes;

fn material(density: f64) -> Material {
    Material { law: Law::Corotational, young: 2e4, poisson: 0.3, density }
}

fn mass(body: &Embedded) -> f64 {
    let flesh = &body.flesh;
    (flesh.tets.iter().zip(&flesh.materials))
        .map(|(t, m)| m.density * tet::volume(&t.map(|n| flesh.nodes[n as usize])))
        .sum()
}

#[test]
fn a_box_keeps_volume_mass_and_place() {
    let half = Vec3::new(0.05, 0.03, 0.02);
    let volume = 8.0 * half.x * half.y * half.z;
    for tets in [100, 600, 3000] {
        let options = EmbedOptions { tets, ..EmbedOptions::default() };
        let body = embed(&shapes::cuboid(&half), &options, |_| material(300.0)).unwrap();
        assert!((body.flesh.tets.len() as f64 / tets as f64 - 1.0).abs() < 0.15);
        assert!((mass(&body) / (300.0 * volume) - 1.0).abs() < 1e-9);
        assert!((body.node_volumes.iter().sum::<f64>() / volume - 1.0).abs() < 1e-9);

        // The centre of mass of the lumped nodes is the box's, to a tenth of an element.
        let centre = (body.flesh.nodes.iter().zip(&body.node_volumes))
            .map(|(x, v)| x * (v / volume))
            .sum::<Vec3>();
        assert!(centre.norm() < 0.1 * (volume / tets as f64).cbrt(), "{centre:?}");

        // Each surface vertex comes back where it was.
        let source = shapes::cuboid(&half);
        let mut positions = vec![Vec3::zeros(); source.positions.len()];
        body.render.positions(&body.flesh.tets, &body.flesh.nodes, &mut positions);
        for (a, b) in positions.iter().zip(&source.positions) {
            assert!((a - b).norm() < 1e-12);
        }
    }
}

#[test]
fn graded_material_weighs_its_integral() {
    // A ball whose density grows linearly outwards from ρ0 to ρ1: mass = 4π R³ (ρ0/12 + ρ1/4).
    let (radius, inner, outer) = (0.04, 200.0, 500.0);
    let ball = shapes::sphere(radius, 24);
    let at = |p: &Vec3| material(inner + (outer - inner) * (p.norm() / radius).min(1.0));
    let options = EmbedOptions { tets: 4000, ..EmbedOptions::default() };
    let body = embed(&ball, &options, at).unwrap();
    let exact = 4.0 * std::f64::consts::PI * radius.powi(3) * (inner / 12.0 + outer / 4.0);
    // The mesh is a polyhedron inside the ball, and the integral is sampled.
    assert!((mass(&body) / exact - 1.0).abs() < 0.01, "{} {exact}", mass(&body));
}

/// Two long bars side by side with a narrow gap, joined at one end: a tuning fork.
fn fork(gap: f64) -> TriMesh {
    let (width, length, stem) = (0.01, 0.06, 0.02);
    let (x, y) = (width + gap / 2.0, gap / 2.0);
    // Outline counter-clockwise, swept along z.
    let outline = [
        (-x, 0.0),
        (x, 0.0),
        (x, length),
        (y, length),
        (y, stem),
        (-y, stem),
        (-y, length),
        (-x, length),
    ];
    let n = outline.len() as u32;
    let mut positions = Vec::new();
    for z in [0.0, width] {
        positions.extend(outline.map(|(x, y)| Vec3::new(x, y, z)));
    }
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([[i, j, n + j], [i, n + j, n + i]]);
    }
    // The outline as quadrilaterals (0 1 4 5 with its sides, and the two bars).
    for [a, b, c] in [[0, 1, 4], [0, 4, 5], [1, 2, 4], [2, 3, 4], [0, 5, 7], [5, 6, 7]] {
        triangles.push([a, c, b]);
        triangles.push([n + a, n + b, n + c]);
    }
    TriMesh::new(positions, triangles).unwrap()
}

#[test]
fn parts_that_share_lattice_cells_are_not_glued() {
    // A gap of a tenth of a millimetre between bars covered by elements of several millimetres.
    let mesh = fork(1e-4);
    assert!((mesh.volume() - (0.0201 * 0.02 + 2.0 * 0.01 * 0.04) * 0.01).abs() < 1e-12);
    let options = EmbedOptions { tets: 300, ..EmbedOptions::default() };
    let body = embed(&mesh, &options, |_| material(300.0)).unwrap();

    // Remove all elements that reach within an element's size of the bars' roots: the two bars
    // must fall apart.
    let flesh = &body.flesh;
    let above = |t: &[u32; 4]| t.iter().all(|&n| flesh.nodes[n as usize].y > 0.030);
    let mut label: Vec<usize> = (0..flesh.nodes.len()).collect();
    loop {
        let before = label.clone();
        for t in flesh.tets.iter().filter(|t| above(t)) {
            let least = t.iter().map(|&n| label[n as usize]).min().unwrap();
            t.iter().for_each(|&n| label[n as usize] = least);
        }
        if label == before {
            break;
        }
    }
    let used: std::collections::BTreeSet<usize> =
        flesh.tets.iter().filter(|t| above(t)).map(|t| label[t[0] as usize]).collect();
    assert_eq!(used.len(), 2, "the bars form {} parts", used.len());
}

#[test]
fn an_open_or_inverted_mesh_is_an_error() {
    let mut inverted = shapes::cuboid(&Vec3::new(0.1, 0.1, 0.1));
    inverted.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let error = embed(&inverted, &EmbedOptions::default(), |_| material(1.0)).unwrap_err();
    assert!(error.to_string().contains("inside out"), "{error}");
    let none = EmbedOptions { tets: 0, ..EmbedOptions::default() };
    assert!(embed(&shapes::cuboid(&Vec3::repeat(0.1)), &none, |_| material(1.0)).is_err());
}
