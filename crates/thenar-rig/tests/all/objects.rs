//! Rigid and deformable objects: counts, volumes and masses from theory; meshes of every quality.

use std::f64::consts::PI;
use thenar_core::Vec3;
use thenar_core::model::{Law, Material, Motion};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Quat};
use thenar_rig::TriMesh;
use thenar_rig::mesh::shapes;
use thenar_rig::object::*;

const GEL: Material =
    Material { law: Law::Corotational, young: 1e5, poisson: 0.3, density: 1000.0 };

fn gel(_: &Vec3) -> Material {
    GEL
}

fn volume(model: &SoftModel) -> f64 {
    let flesh = &model.flesh;
    let corners = |t: &[u32; 4]| t.map(|n| flesh.nodes[n as usize]);
    flesh
        .tets
        .iter()
        .map(|t| {
            let [a, b, c, d] = corners(t);
            let six = (b - a).dot(&(c - a).cross(&(d - a)));
            assert!(six > 0.0);
            six / 6.0
        })
        .sum()
}

/// Volume by the divergence theorem over the collision surface.
fn enclosed(model: &SoftModel) -> f64 {
    let surface = &model.flesh.collision;
    let mut positions = vec![Vec3::zeros(); surface.vertices.len()];
    surface.positions(&model.flesh.tets, &model.flesh.nodes, &mut positions);
    TriMesh { positions, triangles: surface.triangles.clone() }.volume()
}

#[test]
fn a_kuhn_box_has_the_counts_and_the_diagonal_of_b3() {
    let size = Vec3::new(0.1, 0.02, 0.02);
    let options = SoftOptions::default();
    for (cells, nodes, tets) in
        [([10, 2, 2], 99, 240), ([20, 4, 4], 525, 1920), ([40, 8, 8], 3321, 15360)]
    {
        let bar = lattice_box(&size, cells, Cubes::Kuhn6, gel, &options).unwrap();
        assert_eq!((bar.flesh.nodes.len(), bar.flesh.tets.len()), (nodes, tets));
        assert!((volume(&bar) / size.product() - 1.0).abs() < 1e-12);
        assert!((enclosed(&bar) / size.product() - 1.0).abs() < 1e-12);
        let [nx, ny, nz] = cells;
        assert_eq!(bar.flesh.collision.triangles.len() as u32, 4 * (nx * ny + ny * nz + nz * nx));
        // Every element contains the (1,1,1) diagonal of its cell.
        let cell = size.component_div(&Vec3::from(cells.map(f64::from)));
        for tet in &bar.flesh.tets {
            let x = tet.map(|n| bar.flesh.nodes[n as usize]);
            let is_diagonal = |a: &Vec3, b: &Vec3| (b - a - cell).norm() < 1e-9;
            let found = x.iter().any(|a| x.iter().any(|b| is_diagonal(a, b)));
            assert!(found);
        }
    }
    let five = lattice_box(&size, [10, 2, 2], Cubes::Five, gel, &options).unwrap();
    assert_eq!(five.flesh.tets.len(), 200);
    assert!((volume(&five) / size.product() - 1.0).abs() < 1e-12);
    assert!((enclosed(&five) / size.product() - 1.0).abs() < 1e-12);
}

#[test]
fn graded_planes_reach_both_ends_and_grow_by_the_ratio() {
    let planes = graded(0.0, 0.08, 0.0003, 1.25).unwrap();
    assert_eq!((planes[0], planes[planes.len() - 1]), (0.0, 0.08));
    let steps: Vec<f64> = planes.windows(2).map(|w| w[1] - w[0]).collect();
    assert!(steps[0] <= 0.0003 && steps[0] > 0.0002);
    assert!(steps.windows(2).all(|w| (w[1] / w[0] - 1.25).abs() < 1e-9));
    let down = graded(0.0, -0.08, 0.0003, 1.25).unwrap();
    assert!(down.iter().zip(&planes).all(|(a, b)| a == &-b));
    assert!(graded(0.0, 1.0, 1e-9, 1.0).is_err());
    let mut ys = graded(0.0, -0.01, 0.002, 1.5).unwrap();
    ys.reverse();
    let block =
        graded_block(&planes, &ys, &[-1.0, 0.0, 2.0], Cubes::Kuhn6, gel, &SoftOptions::default())
            .unwrap();
    assert!((volume(&block) / (0.08 * 0.01 * 3.0) - 1.0).abs() < 1e-12);
}

#[test]
fn balls_approach_their_volume_and_know_their_core() {
    let shell =
        Ball { outer: 8e-3, inner: 4e-3, frequency: 8, layers: 6, growth: 1.25, focus: 3.0 };
    let options = SoftOptions::default();
    let model = ball(&shell, gel, &options).unwrap();
    assert_eq!(model.flesh.tets.len(), 20 * 64 * 6 * 3);
    let on = |r: f64| model.flesh.nodes.iter().filter(|p| (p.norm() - r).abs() < 1e-9).count();
    assert_eq!((on(8e-3), on(4e-3)), (10 * 64 + 2, 10 * 64 + 2));
    assert!((volume(&model) - enclosed(&model)).abs() < 1e-12 * volume(&model));
    // Finer below: the pole's nearest neighbours are closer than the far pole's.
    let gap = |pole: f64| {
        let p = Vec3::new(0.0, pole * 8e-3, 0.0);
        let skin = model.flesh.nodes.iter().filter(|x| (x.norm() - 8e-3).abs() < 1e-9);
        let mut d: Vec<f64> = skin.map(|x| (x - p).norm()).collect();
        d.sort_unstable_by(f64::total_cmp);
        assert!(d[0] < 1e-9);
        d[1]
    };
    assert!(gap(-1.0) * 5.0 < gap(1.0), "{} {}", gap(-1.0), gap(1.0));

    let defect = |n: u32| {
        let full = ball(&Ball::even(1.0, 0.0, n), gel, &options).unwrap();
        1.0 - volume(&full) / (4.0 / 3.0 * PI)
    };
    let (coarse, fine) = (defect(4), defect(8));
    assert!(fine > 0.0 && (coarse / fine - 4.0).abs() < 0.3, "{coarse} {fine}");
}

#[test]
fn bad_tetrahedra_are_refused_with_the_cause() {
    let nodes = || vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z(), Vec3::repeat(1.0)];
    let error = |nodes: Vec<Vec3>, tets: Vec<[u32; 4]>, material: Material| {
        soft_from_tets("thing", nodes, tets, vec![material], &SoftOptions::default())
            .unwrap_err()
            .to_string()
    };
    let good = vec![[0, 1, 2, 3], [1, 2, 3, 4]];
    assert!(soft_from_tets("t", nodes(), good.clone(), vec![GEL], &SoftOptions::default()).is_ok());
    assert!(error(nodes(), vec![], GEL).contains("no tetrahedra"));
    assert!(error(nodes(), vec![[0, 1, 2, 9]], GEL).contains("names node 9"));
    assert!(error(nodes(), vec![[0, 2, 1, 3]], GEL).contains("tetrahedron 0 is inverted"));
    assert!(error(nodes(), vec![[0, 1, 1, 3]], GEL).contains("tetrahedron 0 is flat"));
    assert!(error(nodes(), vec![[0, 1, 2, 3]], GEL).contains("node 4 belongs to no"));
    let twice = vec![[0, 1, 2, 3], [1, 2, 3, 4], [0, 1, 2, 3]];
    assert!(error(nodes(), twice, GEL).contains("overlaps itself"));
    let mut two = nodes();
    two.truncate(4);
    two.extend(two.clone().iter().map(|p| p + Vec3::repeat(5.0)));
    assert!(error(two, vec![[0, 1, 2, 3], [4, 5, 6, 7]], GEL).contains("2 pieces"));
    let mut nan = nodes();
    nan[2].y = f64::NAN;
    assert!(error(nan, good.clone(), GEL).contains("node 2"));
    for (name, material) in [
        ("young", Material { young: 0.0, ..GEL }),
        ("density", Material { density: -1.0, ..GEL }),
        ("poisson", Material { poisson: 0.5, ..GEL }),
    ] {
        assert!(error(nodes(), good.clone(), material).contains(name));
    }
}

#[test]
fn a_closed_mesh_becomes_a_body_with_exact_mass() {
    let pose = Pose::new(Vec3::new(0.3, 2.0, -1.0), Quat::from_euler_angles(0.4, 0.9, -0.3));
    let mesh = shapes::cuboid(&Vec3::new(0.02, 0.03, 0.04)).transformed(&pose);
    let (model, report) =
        rigid_from_mesh("brick", &mesh, Weight::Density(2000.0), &ImportOptions::default())
            .unwrap();
    assert_eq!(report.interior, Interior::Closed);
    let mass = 2000.0 * 8.0 * 0.02 * 0.03 * 0.04;
    assert!((model.mass / mass - 1.0).abs() < 1e-9);
    let mut moments: Vec<f64> = model.inertia.symmetric_eigenvalues().iter().copied().collect();
    moments.sort_unstable_by(f64::total_cmp);
    let expected = [13e-4, 20e-4, 25e-4].map(|x| x * mass / 3.0);
    for (got, expected) in moments.iter().zip(expected) {
        assert!((got / expected - 1.0).abs() < 1e-9);
    }
    // Placing the mesh frame at the world's puts the centre of mass where the mesh has it.
    let desc = model.placed(&Pose::identity(), Motion::Dynamic);
    assert!((desc.pose_WB.position - pose.position).norm() < 1e-12);
    // Contact is with the box itself.
    let Shape::Mesh(shape) = &model.shape else { panic!("not a mesh") };
    assert_eq!((shape.points.len(), shape.triangles.len()), (8, 12));
    for p in &shape.points {
        let q = pose.inverse_vector(p).abs() - Vec3::new(0.02, 0.03, 0.04);
        assert!(q.max().abs() < 1e-9, "{q}");
    }
}

#[test]
fn inside_out_holed_and_shattered_spheres_weigh_the_same() {
    let ball = shapes::sphere(0.05, 16);
    let weigh = |mesh: &TriMesh| {
        rigid_from_mesh("ball", mesh, Weight::Density(1000.0), &ImportOptions::default()).unwrap()
    };
    let (_, closed) = weigh(&ball);
    assert!((closed.volume / ball.volume() - 1.0).abs() < 1e-9);

    let mut turned = ball.clone();
    turned.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    assert!((weigh(&turned).1.volume / ball.volume() - 1.0).abs() < 1e-9);

    // A hole of one thirtieth of the surface.
    let mut holed = ball.clone();
    holed.triangles.drain(0..170);
    let (_, report) = weigh(&holed);
    assert_eq!(report.interior, Interior::Winding);
    assert!((report.volume / ball.volume() - 1.0).abs() < 0.05, "{}", report.volume);

    // Unconnected triangles.
    let mut soup = TriMesh::default();
    for t in 0..ball.triangles.len() {
        let first = soup.positions.len() as u32;
        let shift = Vec3::new(1e-5 * (t % 7) as f64, 0.0, 0.0);
        soup.positions.extend(ball.corners(t).map(|p| p + shift));
        soup.triangles.push([first, first + 1, first + 2]);
    }
    let (_, report) = weigh(&soup);
    assert_eq!(report.interior, Interior::Winding);
    assert!((report.volume / ball.volume() - 1.0).abs() < 0.02, "{}", report.volume);
}

#[test]
fn a_sheet_becomes_a_shell_of_the_stated_thickness() {
    let square = TriMesh::new(
        vec![Vec3::zeros(), Vec3::x() * 0.2, Vec3::new(0.2, 0.1, 0.0), Vec3::y() * 0.1],
        vec![[0, 1, 2], [0, 2, 3]],
    )
    .unwrap();
    let options = ImportOptions { shell_thickness: Some(0.01), ..ImportOptions::default() };
    let (model, report) =
        rigid_from_mesh("card", &square, Weight::Density(700.0), &options).unwrap();
    assert_eq!(report.interior, Interior::Shell(0.01));
    // Plate, rim of half a cylinder around it, quarter spheres at its corners.
    let r = 0.005;
    let exact = 0.2 * 0.1 * 0.01 + 0.6 * PI * r * r / 2.0 + 4.0 / 3.0 * PI * r * r * r;
    assert!((report.volume / exact - 1.0).abs() < 0.02, "{} {exact}", report.volume);
    assert!((model.pose_MB.position - Vec3::new(0.1, 0.05, 0.0)).norm() < 1e-4);
}

#[test]
fn senseless_meshes_are_refused() {
    let error = |mesh: &TriMesh| {
        rigid_from_mesh("x", mesh, Weight::Mass(1.0), &ImportOptions::default())
            .unwrap_err()
            .to_string()
    };
    assert!(error(&shapes::sphere(1e5, 2)).contains("scale"));
    assert!(error(&shapes::sphere(1e-9, 2)).contains("scale"));
    let line = TriMesh {
        positions: vec![Vec3::zeros(), Vec3::x(), Vec3::x() * 2.0],
        triangles: vec![[0, 1, 2]],
    };
    assert!(error(&line).contains("without area"));
    let bad = rigid_from_mesh("x", &line, Weight::Mass(-1.0), &ImportOptions::default());
    assert!(bad.unwrap_err().to_string().contains("mass"));
}
