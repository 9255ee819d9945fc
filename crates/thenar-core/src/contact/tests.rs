//! Whole searches on small scenes: expected contacts are worked out by hand.

use crate::contact::{
    Contact, Detector, Reach, RigidPlace, SearchReport, SeenSides, Shape, Site, SurfaceState,
};
use crate::math::{Mat3, Pose, Quat, Vec3};
use crate::model::{
    BodyId, BodyParts, EmbeddedSurface, Flesh, JointDesc, JointKind, Motion, PairRule, RigidDesc,
    SoftDesc, SurfaceVertex, WorldDesc,
};
use crate::random::Random;

/// A world, its state, and a detector for it.
pub(super) struct Scene {
    pub desc: WorldDesc,
    pub places: Vec<RigidPlace>,
    pub surfaces: Vec<(Vec<Vec3>, Vec<Vec3>)>,
}

impl Scene {
    pub fn new() -> Self {
        Self { desc: WorldDesc::default(), places: Vec::new(), surfaces: Vec::new() }
    }

    pub fn rigid(&mut self, motion: Motion, shape: Shape, pose_WB: Pose) -> u32 {
        self.places.push(RigidPlace {
            pose_WB,
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        });
        self.desc.add_rigid(RigidDesc {
            name: String::new(),
            motion,
            mass: 1.0,
            inertia: Mat3::identity(),
            pose_WB,
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
            shape: Some(shape),
            pose_BS: Pose::identity(),
            friction: 0.5,
        })
    }

    /// A closed surface whose vertices stand for themselves.
    pub fn soft(&mut self, (points, triangles): (Vec<Vec3>, Vec<[u32; 3]>)) -> u32 {
        let vertex = |i: usize| SurfaceVertex { tet: i as u32, weights: [1.0, 0.0, 0.0, 0.0] };
        let flesh = Flesh {
            tets: (0..points.len() as u32).map(|i| [i; 4]).collect(),
            nodes: points.clone(),
            materials: Vec::new(),
            relaxation: Vec::new(),
            mass_damping: 0.0,
            stiffness_damping: 0.0,
            fixed: Vec::new(),
            collision: EmbeddedSurface {
                vertices: (0..points.len()).map(vertex).collect(),
                triangles,
            },
            friction: 0.8,
        };
        self.surfaces.push((points.clone(), vec![Vec3::zeros(); points.len()]));
        self.desc.add_soft(SoftDesc {
            name: String::new(),
            flesh,
            pose_WM: Pose::identity(),
            velocity_W: Vec3::zeros(),
            coupling: None,
        })
    }

    /// The next search of a row of them: `sides` goes from one to the next.
    pub fn find_next(
        &self,
        detector: &mut Detector,
        sides: &mut SeenSides,
        h: f64,
        out: &mut Vec<Contact>,
    ) -> SearchReport {
        let positions: Vec<Vec3> = self.surfaces.iter().flat_map(|s| s.0.clone()).collect();
        let velocities: Vec<Vec3> = self.surfaces.iter().flat_map(|s| s.1.clone()).collect();
        let surfaces = SurfaceState { positions: &positions, velocities: &velocities };
        let mut now = SeenSides::with_capacity(detector.sides_max());
        let reach = Reach { h, margin: 1e-3 };
        let found = detector.find(reach, &self.places, surfaces, sides, &mut now, out);
        *sides = now;
        found
    }

    /// The areas of these contacts with bodies where they are.
    pub fn areas(&self, contacts: &[Contact]) -> Vec<f64> {
        let positions: Vec<Vec3> = self.surfaces.iter().flat_map(|s| s.0.clone()).collect();
        let mut areas = vec![0.0; contacts.len()];
        let no_force_W = |_| Vec3::zeros();
        Detector::new(&self.desc).areas(&self.places, &positions, contacts, &mut areas, no_force_W);
        areas
    }

    /// The least areas of contacts of the first soft surface where each bears a normal force \[N\].
    pub fn areas_under(&self, contacts: &[Contact], load: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut areas = self.areas(contacts);
        let x = &self.surfaces[0].0;
        Detector::new(&self.desc).stand_for(x, contacts, &mut areas, load);
        areas
    }

    pub fn find(&self, h: f64) -> Vec<Contact> {
        let mut out = Vec::new();
        self.find_next(&mut Detector::new(&self.desc), &mut SeenSides::default(), h, &mut out);
        out
    }
}

/// A cube of edge `size` about the origin, each face a lattice of n × n cells.
pub(super) fn cube(size: f64, n: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let mut points: Vec<Vec3> = Vec::new();
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            let mut index = |i: u32, j: u32| {
                let mut p = Vec3::zeros();
                p[axis] = 0.5 * side * size;
                p[(axis + 1) % 3] = size * (f64::from(i) / f64::from(n) - 0.5);
                p[(axis + 2) % 3] = size * (f64::from(j) / f64::from(n) - 0.5);
                let known = points.iter().position(|q| (q - p).norm() < 1e-9 * size);
                known.unwrap_or_else(|| {
                    points.push(p);
                    points.len() - 1
                }) as u32
            };
            for i in 0..n {
                for j in 0..n {
                    let q = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                    let q = if side > 0.0 { q } else { [q[0], q[3], q[2], q[1]] };
                    triangles.extend([[q[0], q[1], q[2]], [q[0], q[2], q[3]]]);
                }
            }
        }
    }
    (points, triangles)
}

pub(super) fn boxed(half: f64) -> Shape {
    Shape::Cuboid { half: Vec3::repeat(half) }
}

pub(super) fn moved(points: &mut [Vec3], by: Vec3) {
    points.iter_mut().for_each(|p| *p += by);
}

#[test]
fn the_test_cube_is_closed_and_faces_outward() {
    let (points, triangles) = cube(2.0, 3);
    let volume: f64 = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| points[v as usize]);
            a.dot(&b.cross(&c)) / 6.0
        })
        .sum();
    assert!((volume - 8.0).abs() < 1e-12);
    assert_eq!((points.len(), triangles.len()), (56, 108));
}

/// The lower face of a cube on a plane: every lower vertex, with areas that sum to the face.
#[test]
fn a_soft_cube_on_a_plane_touches_with_its_lower_face() {
    let mut scene = Scene::new();
    scene.rigid(Motion::Prescribed, Shape::HalfSpace, Pose::identity());
    scene.soft(cube(0.04, 4));
    moved(&mut scene.surfaces[0].0, Vec3::new(0.3, 0.02 - 1e-4, -0.2));
    let contacts = scene.find(1e-3);
    assert_eq!(contacts.len(), 25);
    for c in &contacts {
        assert!((c.gap + 1e-4).abs() < 1e-15 && c.normal_W == Vec3::y());
        assert!((c.friction - (0.5f64 * 0.8).sqrt()).abs() < 1e-15);
        let Site::Soft(point) = c.a else { panic!("A is the soft side") };
        assert_eq!(c.position_W, scene.surfaces[0].0[point.vertices[0] as usize]);
    }
    let areas = scene.areas(&contacts);
    let (area, strip) = (areas.iter().sum::<f64>(), 4.0 * 0.04 * (1e-4 + 20e-6));
    // Of the walls what is below, or nearer than 20 um.
    assert!((area - 0.04 * 0.04 - strip).abs() < 1e-9, "{area} m²");
}

/// A thin static plate and a soft cube falling at 5 m/s, 1/60 s steps: contacts exist before it
/// crosses, at every height from which it would.
#[test]
fn a_fast_soft_cube_is_announced_to_a_thin_plate() {
    for i in 0..16 {
        let height = 5e-3 * f64::from(i) + 2e-3;
        let mut scene = Scene::new();
        let plate = Shape::Cuboid { half: Vec3::new(0.1, 0.001, 0.1) };
        scene.rigid(Motion::Prescribed, plate, Pose::translation(10.0, 0.0, -10.0));
        scene.soft(cube(0.02, 2));
        moved(&mut scene.surfaces[0].0, Vec3::new(10.0, 0.011 + height, -10.0));
        scene.surfaces[0].1.fill(Vec3::new(0.0, -5.0, 0.0));
        let contacts = scene.find(1.0 / 60.0);
        let lower: Vec<_> = contacts.iter().filter(|c| (c.gap - height).abs() < 1e-9).collect();
        assert_eq!(lower.len(), 9, "height {height}");
        assert!(contacts.iter().all(|c| (c.normal_W - Vec3::y()).norm() < 1e-9));
    }
}

/// A vertex pressed past the middle of the plate keeps the side it came from.
#[test]
fn the_side_is_kept() {
    let mut scene = Scene::new();
    let plate = Shape::Cuboid { half: Vec3::new(0.1, 0.001, 0.1) };
    scene.rigid(Motion::Prescribed, plate, Pose::identity());
    scene.soft(cube(0.02, 2));
    moved(&mut scene.surfaces[0].0, Vec3::new(0.0, 0.0112, 0.0));
    let mut detector = Detector::new(&scene.desc);
    let (mut sides, mut out) = (SeenSides::default(), Vec::new());
    for _ in 0..12 {
        scene.find_next(&mut detector, &mut sides, 1e-3, &mut out);
        for c in &out {
            assert_eq!(c.normal_W, Vec3::y(), "gap {}", c.gap);
        }
        moved(&mut scene.surfaces[0].0, Vec3::new(0.0, -0.00025, 0.0));
    }
    let deepest = out.iter().map(|c| c.gap).fold(0.0, f64::min);
    assert!((deepest - (0.0002 - 11.0 * 0.00025)).abs() < 1e-8, "{deepest}");
}

/// A sphere and a corner that come between the vertices of a coarse soft face.
#[test]
fn small_and_sharp_things_between_vertices_are_found() {
    let gap = 2e-4;
    let sphere = (Shape::Sphere { radius: 0.002 }, 0.002, Quat::identity());
    let corner = Quat::rotation_between(&Vec3::repeat(1.0), &-Vec3::y()).expect("not opposite");
    let half = 0.002;
    let pointed = (boxed(half), half * 3.0_f64.sqrt(), corner);
    let capsule = Shape::Capsule { radius: 0.001, half_length: 0.002 };
    let lying = Quat::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_2);
    for (shape, height, rotation) in [sphere, pointed, (capsule, 0.001, lying)] {
        for sign in [1.0, -1.0] {
            let mut scene = Scene::new();
            let place = Vec3::new(0.004, 0.02 + height + sign * gap, 0.007);
            scene.rigid(Motion::Dynamic, shape.clone(), Pose::new(place, rotation));
            scene.soft(cube(0.04, 2));
            let contacts = scene.find(1e-3);
            // Edges of the face that come near are candidates, farther away.
            let deepest = contacts.iter().min_by(|a, b| a.gap.total_cmp(&b.gap));
            let c = deepest.unwrap_or_else(|| panic!("{shape:?} touches nothing"));
            assert!((c.gap - sign * gap).abs() < 1e-12, "{shape:?}: {}", c.gap);
            assert!((c.normal_W + Vec3::y()).norm() < 1e-9, "{shape:?} {}", c.normal_W);
            let pressing = contacts.iter().filter(|c| c.gap < 1e-12).count();
            let ends = if matches!(shape, Shape::Capsule { .. }) { 2 } else { 1 };
            assert_eq!(pressing, if sign < 0.0 { ends } else { 0 }, "{shape:?}");
        }
    }
}

/// A long edge that presses into a thin slab from below comes near its upper side too, from
/// within; only the side it came through may push back.
#[test]
fn an_edge_in_a_thin_slab_is_not_pushed_out_of_its_far_side() {
    let (depth, half) = (3e-4, Vec3::new(0.004, 0.004, 0.01));
    let mut scene = Scene::new();
    let edge_up = Quat::from_axis_angle(&Vec3::z_axis(), std::f64::consts::FRAC_PI_4);
    let place = Vec3::new(0.003, -0.002 + depth - half.x * 2.0_f64.sqrt(), 0.0);
    scene.rigid(Motion::Dynamic, Shape::Cuboid { half }, Pose::new(place, edge_up));
    scene.soft(cube(0.04, 2));
    // 4 mm thick, with triangles of 20 mm.
    scene.surfaces[0].0.iter_mut().for_each(|p| p.y *= 0.1);
    let contacts = scene.find(1e-3);
    assert!(!contacts.is_empty());
    for c in &contacts {
        assert!((c.gap + depth).abs() < 1e-9, "{}", c.gap);
        assert!((c.normal_W - Vec3::y()).norm() < 1e-9, "{}", c.normal_W);
    }
}

/// Two soft cubes, one on the other, shifted so that no vertices coincide.
#[test]
fn soft_cubes_touch_both_ways() {
    let mut scene = Scene::new();
    scene.soft(cube(0.04, 4));
    scene.soft(cube(0.03, 3));
    moved(&mut scene.surfaces[1].0, Vec3::new(0.001, 0.035 - 1e-4, 0.001));
    let contacts = scene.find(1e-3);
    // All 16 lower vertices of the upper cube, and the 9 upper vertices of the lower cube that
    // lie under it. Else only its rim touches, where edges of the lower cube pass below it.
    let is_vertex = |c: &&Contact| match c.a {
        Site::Soft(a) => a.weights[0] == 1.0,
        Site::Rigid { .. } => false,
    };
    assert_eq!(contacts.iter().filter(is_vertex).count(), 25);
    for c in contacts.iter().filter(|c| !is_vertex(c)) {
        let at = c.position_W - Vec3::new(0.001, 0.0, 0.001);
        assert!((at.x.abs().max(at.z.abs()) - 0.015).abs() < 1e-12, "{at}");
    }
    for c in &contacts {
        assert!((c.gap + 1e-4).abs() < 1e-12);
        let Site::Soft(a) = c.a else { panic!("soft") };
        let up = if a.soft == 1 { 1.0 } else { -1.0 };
        assert!((c.normal_W - up * Vec3::y()).norm() < 1e-9);
    }
}

/// A cube that is folded inside out, its bottom drawn out through its top, has outer places that
/// look inward. What another cube has on their far side is not inside it.
#[test]
fn what_is_beside_a_fold_is_not_held_by_it() {
    for height in [0.0205, 0.025, 0.03, 0.04] {
        let mut scene = Scene::new();
        scene.soft(cube(0.04, 4));
        scene.soft(cube(0.03, 3));
        let folded = &mut scene.surfaces[0].0;
        let drawn = folded.iter_mut().find(|p| (**p + 0.02 * Vec3::y()).norm() < 1e-9);
        drawn.expect("a vertex of the bottom").y = height;
        let pressed = 5e-4;
        moved(&mut scene.surfaces[1].0, Vec3::new(0.0185, 0.035 - pressed, 0.001));
        let contacts = scene.find(1e-3);
        let pressing = contacts.iter().filter(|c| c.gap < 0.0).count();
        assert!(pressing >= 8, "{height}: {pressing}");
        for c in &contacts {
            assert!(c.gap > -1.01 * pressed, "{height}: {c:?}");
        }
    }
}

/// An edge of one cube cuts into that of another, from less than counts as got in to more. No
/// contact is deeper than the cut, nor where the cube is inside out, as crushed flesh may be, and
/// its edge looks the wrong way.
#[test]
fn edges_that_cut_each_other_are_as_deep_as_they_are() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let (out, along) = (Vec3::new(half, half, 0.0), Vec3::new(half, -half, 0.0));
    let places = [(1.3e-3, 1.7e-3), (-2.1e-3, 0.4e-3), (4e-3, -3e-3)];
    let cases = places.into_iter().flat_map(|place| [(1.0, place), (-1.0, place)]);
    for depth in [1e-5, 3e-5, 6e-5, 1e-4, 1.5e-4, 3e-4] {
        for (side, (shift, aside)) in cases.clone() {
            let mut scene = Scene::new();
            scene.soft(cube(0.04, 8));
            scene.soft(cube(0.03, 3));
            let corner = Vec3::new(0.02, 0.02, 0.0) - depth * out;
            for p in &mut scene.surfaces[1].0 {
                // From the middle of its edge, along z, that now lies across the other's; mirrored
                // it is inside out.
                let q = *p + Vec3::new(0.015, 0.015, 0.0);
                let (high, beside) = (half * (q.x + q.y), half * (q.x - q.y));
                let across = (beside + aside) * Vec3::z() - side * (q.z + shift) * along;
                *p = corner + high * out + across;
            }
            let contacts = scene.find(1e-3);
            let deepest = contacts.iter().map(|c| -c.gap).fold(0.0, f64::max);
            assert!(deepest < 1.5 * depth, "{depth}, {side}, {shift}: {deepest}");
            assert!(side < 0.0 || deepest > 0.5 * depth, "{depth}, {shift}: {deepest}");
        }
    }
}

#[test]
fn bones_take_the_rules_of_their_flesh() {
    let frictions = |pairs: &[([BodyId; 2], Option<f64>)]| {
        let mut scene = Scene::new();
        scene.rigid(Motion::Dynamic, boxed(0.1), Pose::identity());
        scene.rigid(Motion::Dynamic, boxed(0.1), Pose::translation(0.0, 0.199, 0.0));
        let bones = vec![(0, 1)];
        scene.desc.parts.push(BodyParts { soft: 0, vertices: Vec::new(), bones });
        let rule = |&(bodies, friction): &([BodyId; 2], Option<f64>)| PairRule { bodies, friction };
        scene.desc.pairs = pairs.iter().map(rule).collect();
        let found = scene.find(1e-3);
        assert!(found.iter().all(|c| c.friction == found[0].friction));
        found.first().map(|c| c.friction)
    };
    let [bone, other, flesh] = [BodyId::Rigid(0), BodyId::Rigid(1), BodyId::Soft(0)];
    assert!(frictions(&[]).is_some());
    assert_eq!(frictions(&[([flesh, other], Some(0.125))]), Some(0.125));
    assert_eq!(frictions(&[([other, flesh], None)]), None);
    // What is said of the bone itself comes first, wherever it stands.
    let own = ([other, bone], Some(0.25));
    assert_eq!(frictions(&[own, ([flesh, other], Some(0.125))]), Some(0.25));
    assert_eq!(frictions(&[([flesh, other], None), own]), Some(0.25));
}

#[test]
fn pairs_that_may_not_touch_do_not() {
    let overlap = |edit: fn(&mut Scene)| {
        let mut scene = Scene::new();
        scene.rigid(Motion::Dynamic, boxed(0.1), Pose::identity());
        scene.rigid(Motion::Dynamic, boxed(0.1), Pose::translation(0.0, 0.199, 0.0));
        edit(&mut scene);
        scene.find(1e-3).len()
    };
    assert_eq!(overlap(|_| ()), 4);
    assert_eq!(
        overlap(|s| s.desc.rigids.iter_mut().for_each(|r| r.motion = Motion::Prescribed)),
        0
    );
    assert_eq!(overlap(|s| s.desc.rigids[1].shape = None), 0);
    let both = [BodyId::Rigid(1), BodyId::Rigid(0)];
    let rule = |friction| PairRule { bodies: both, friction };
    let mut scene = Scene::new();
    scene.rigid(Motion::Dynamic, boxed(0.1), Pose::identity());
    scene.rigid(Motion::Dynamic, boxed(0.1), Pose::translation(0.0, 0.199, 0.0));
    scene.desc.pairs = vec![rule(Some(0.125))];
    assert!(scene.find(1e-3).iter().all(|c| c.friction == 0.125));
    scene.desc.pairs = vec![rule(None)];
    assert!(scene.find(1e-3).is_empty());
    assert_eq!(
        overlap(|s| s.desc.joints.push(JointDesc {
            name: String::new(),
            kind: JointKind::Ball,
            parent: Some(0),
            child: 1,
            pose_PJ: Pose::identity(),
            pose_CK: Pose::identity(),
            axes: Default::default(),
            limit_stiffness: 0.0,
            limit_damping: 0.0,
        })),
        0
    );
}

/// A scene of every kind of pair, for invariance tests.
pub(super) fn mixed_scene() -> Scene {
    let mut scene = Scene::new();
    scene.rigid(Motion::Prescribed, Shape::HalfSpace, Pose::identity());
    let tilted = Quat::from_euler_angles(0.2, 0.3, -0.1);
    scene.rigid(Motion::Dynamic, boxed(0.02), Pose::translation(0.0, 0.0199, 0.0));
    scene.rigid(Motion::Dynamic, boxed(0.02), Pose::new(Vec3::new(0.004, 0.0625, 0.003), tilted));
    let capsule = Shape::Capsule { radius: 0.01, half_length: 0.02 };
    scene.rigid(Motion::Dynamic, capsule, Pose::new(Vec3::new(0.0305, 0.0295, 0.001), tilted));
    let ball = Shape::Sphere { radius: 0.015 };
    scene.rigid(Motion::Dynamic, ball, Pose::translation(-0.0345, 0.0153, 0.0));
    scene.soft(cube(0.04, 4));
    scene.soft(cube(0.03, 3));
    moved(&mut scene.surfaces[0].0, Vec3::new(0.003, 0.0199, 0.0395));
    moved(&mut scene.surfaces[1].0, Vec3::new(0.001, 0.0547, 0.0385));
    let mut random = Random::new(77);
    for place in &mut scene.places[1..] {
        place.velocity_W = random.vector(0.2);
        place.angular_velocity_W = random.vector(2.0);
    }
    for (positions, velocities) in &mut scene.surfaces {
        velocities.iter_mut().for_each(|v| *v = random.vector(0.2));
        positions.iter_mut().for_each(|p| *p += random.vector(1e-4));
    }
    scene
}

/// Contacts stay the same when their scene is turned and carried ten metres away.
#[test]
fn contacts_do_not_depend_on_the_frame() {
    let scene = mixed_scene();
    let here = scene.find(1.0 / 60.0);
    assert!(here.len() > 60, "{}", here.len());
    let pose = Pose::new(Vec3::new(10.0, -7.0, 3.0), Quat::from_euler_angles(1.0, 0.4, -2.0));
    let mut there = mixed_scene();
    for place in &mut there.places {
        place.pose_WB = pose * place.pose_WB;
        place.velocity_W = pose.vector(&place.velocity_W);
        place.angular_velocity_W = pose.vector(&place.angular_velocity_W);
    }
    for (positions, velocities) in &mut there.surfaces {
        positions.iter_mut().for_each(|p| *p = pose.point(p));
        velocities.iter_mut().for_each(|v| *v = pose.vector(v));
    }
    let mut moved = there.find(1.0 / 60.0);
    moved.sort_by_key(|c| c.key);
    let mut here = here;
    here.sort_by_key(|c| c.key);
    assert_eq!(here.len(), moved.len());
    for (a, b) in here.iter().zip(&moved) {
        assert_eq!(a.key, b.key);
        assert!((a.gap - b.gap).abs() < 1e-12);
        assert!((pose.vector(&a.normal_W) - b.normal_W).norm() < 1e-9);
        assert!((pose.point(&a.position_W) - b.position_W).norm() < 1e-9);
    }
}

/// Two detectors give the same bits, and keys name contacts uniquely and for good.
#[test]
fn contacts_are_deterministic_and_keys_stable() {
    let mut scene = mixed_scene();
    let (mut one, mut two) = (Detector::new(&scene.desc), Detector::new(&scene.desc));
    let (mut a, mut b) = (Vec::new(), Vec::new());
    let mut last: Vec<u64> = Vec::new();
    for step in 0..20 {
        scene.find_next(&mut one, &mut SeenSides::default(), 1e-3, &mut a);
        scene.find_next(&mut two, &mut SeenSides::default(), 1e-3, &mut b);
        assert_eq!(a, b);
        let mut keys: Vec<u64> = a.iter().map(|c| c.key).collect();
        keys.sort_unstable();
        let all = keys.len();
        keys.dedup();
        assert_eq!(keys.len(), all, "a key twice");
        let stayed = keys.iter().filter(|k| last.binary_search(k).is_ok()).count();
        assert!(step == 0 || stayed * 10 > 9 * last.len(), "{stayed} of {}", last.len());
        last = keys;
        for place in &mut scene.places[1..] {
            place.pose_WB.position += 1e-4 * place.velocity_W;
        }
        for (positions, velocities) in &mut scene.surfaces {
            positions.iter_mut().zip(velocities).for_each(|(p, v)| *p += 1e-4 * *v);
        }
    }
}

/// A rigid side is held where the soft one is, so that opposite forces balance in torque too; the
/// contact's own point is no farther from either than its gap.
#[test]
fn rigid_offsets_lead_to_the_common_point() {
    let scene = mixed_scene();
    for c in scene.find(1e-3) {
        assert!((c.normal_W.norm() - 1.0).abs() < 1e-12);
        let at = |site: &Site| match site {
            Site::Rigid { body, offset_W } => {
                scene.places[*body as usize].pose_WB.position + offset_W
            }
            Site::Soft(point) => point.interpolate(&scene.surfaces[point.soft as usize].0),
        };
        let (a, b) = (at(&c.a), at(&c.b));
        if !matches!((c.a, c.b), (Site::Soft(_), Site::Soft(_))) {
            assert!((a - b).norm() < 1e-15);
        }
        for p in [a, b] {
            assert!((p - c.position_W).norm() <= c.gap.abs() + 1e-12);
        }
    }
}

#[test]
fn penetration_is_the_deepest_overlap() {
    let mut scene = Scene::new();
    scene.rigid(Motion::Prescribed, Shape::HalfSpace, Pose::identity());
    scene.rigid(Motion::Dynamic, boxed(0.1), Pose::translation(0.0, 0.097, 0.0));
    scene.soft(cube(0.04, 2));
    moved(&mut scene.surfaces[0].0, Vec3::new(1.0, 0.018, 0.0));
    let (positions, velocities) = &scene.surfaces[0];
    let states = SurfaceState { positions, velocities };
    let (mut detector, sides) = (Detector::new(&scene.desc), SeenSides::default());
    assert!((detector.penetration(&scene.places, states, &sides) - 0.003).abs() < 1e-12);
    scene.places[1].pose_WB.position.y = 0.1001;
    assert!((detector.penetration(&scene.places, states, &sides) - 0.002).abs() < 1e-12);
}
