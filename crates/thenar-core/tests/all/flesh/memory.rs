//! Goal: tissue with memory relaxes as its Prony series says, loses the energy of a press, and
//! neither brakes nor drives what floats. Method: cubes through whole steps of a world, against
//! closed forms and quadratures.

use crate::common::{FLESH, bar, body};
use std::f64::consts::PI;
use thenar_core::model::{
    Binding, Coupling, EmbeddedSurface, FixedNode, Flesh, Law, Material, Motion, Relaxation,
    Skinning, SoftDesc, Springs, WorldDesc,
};
use thenar_core::{Mat3, Pose, Quat, Vec3, World};

/// Of Pawluk and Howe's time constants.
const TABLE: [[f64; 2]; 3] = [[0.3, 4e-3], [0.2, 0.07], [0.2, 1.4]];
const PULP: [[f64; 2]; 3] = [[0.7, 4e-3], [0.15, 0.07], [0.08, 1.4]];
const EDGE: f64 = 0.01;

/// `g∞ + Σ gᵢ exp(-t/τᵢ)`.
fn exact(terms: &[[f64; 2]], t: f64) -> f64 {
    1.0 - terms.iter().map(|[g, tau]| g * (1.0 - (-t / tau).exp())).sum::<f64>()
}

fn cube(material: Material, terms: &[[f64; 2]]) -> Flesh {
    let mut flesh = bar(Vec3::repeat(EDGE), [1, 1, 1], material);
    flesh.relaxation = vec![Relaxation::new(terms).unwrap(); flesh.tets.len()];
    flesh
}

fn soft(flesh: Flesh) -> SoftDesc {
    SoftDesc {
        name: "cube".into(),
        flesh,
        pose_WM: Pose::identity(),
        velocity_W: Vec3::zeros(),
        coupling: None,
    }
}

fn hold_all(flesh: &mut Flesh) {
    let all = 0..flesh.nodes.len() as u32;
    flesh.fixed = all.map(|node| FixedNode { node, axes: [true; 3] }).collect();
}

fn world(desc: SoftDesc, h: f64) -> World {
    let mut world = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
    world.solver.velocity_tolerance = 1e-13;
    world.add_soft(desc);
    World::new(world).unwrap()
}

fn run(world: &mut World, steps: usize) {
    let input = world.input();
    (0..steps).for_each(|_| _ = world.step(&input, &mut ()));
}

fn moved(world: &World, F: &Mat3) -> Vec<Vec3> {
    world.nodes(0).iter().map(|x| F * x).collect()
}

/// Stress in the first element along y, as a part of the elastic one: 1 - Σp/T.
fn left(world: &World, elastic: f64) -> f64 {
    let terms = world.desc().softs[0].flesh.relaxation[0].terms().len();
    1.0 - world.state().faded[..terms].iter().map(|p| p[1]).sum::<f64>() / elastic
}

/// A strain that jumps between two steps relaxes by the closed form, whatever the step.
#[test]
fn a_held_strain_relaxes_exactly_at_every_step() {
    let published = [0.798685, 0.696578, 0.534143, 0.397908, 0.305623];
    for (t, want) in [4e-3, 1e-2, 0.1, 1.0, 5.0].into_iter().zip(published) {
        assert!((exact(&TABLE, t) - want).abs() < 1e-6, "{t} s");
    }
    let material = Material { poisson: 0.0, ..FLESH };
    let elastic = 0.02 * material.young;
    for (h, steps) in
        [(1e-3, [4, 10, 100, 1000]), (5e-3, [1, 2, 20, 200]), (0.0167, [1, 6, 60, 300])]
    {
        let mut flesh = cube(material, &TABLE);
        hold_all(&mut flesh);
        let mut world = world(soft(flesh), h);
        run(&mut world, 3);
        let stretched = moved(&world, &Mat3::from_diagonal(&Vec3::new(1.0, 1.02, 1.0)));
        world.set_nodes(0, &stretched);
        let mut made = 0;
        for n in steps {
            run(&mut world, n - made);
            made = n;
            let error = left(&world, elastic) - exact(&TABLE, n as f64 * h);
            assert!(error.abs() < 1e-9, "{h} s, {n} steps: {error:e}");
        }
    }
}

/// A strain that rises evenly within a step ends it at the mean of G over the step, so between what
/// a jump at its beginning and one at its end would leave.
#[test]
fn a_strain_that_rises_in_a_step_is_the_mean_of_jumps_in_it() {
    let material = Material { poisson: 0.0, density: 1e-3, ..FLESH };
    for h in [1e-3, 5e-3, 0.0167] {
        let mut press = Press::new(cube(material, &TABLE), h);
        let force = |press: &mut Press, dx: f64| press.step(dx) / (material.young * EDGE);
        let first = force(&mut press, 1e-4) / 1e-4;
        let mean = 1.0
            - TABLE
                .iter()
                .map(|[g, tau]| g * (1.0 - tau / h * (1.0 - (-h / tau).exp())))
                .sum::<f64>();
        // The springs that hold the cube to the plate are 1e5 times as stiff as the cube.
        assert!((first - mean).abs() < 3e-5, "{h}: {first} {mean}");
        assert!(first < exact(&TABLE, 0.0) && first > exact(&TABLE, h));
        for n in 2..20 {
            let now = force(&mut press, 0.0) / 1e-4;
            let [late, early] = [n - 1, n].map(|n| exact(&TABLE, f64::from(n) * h));
            assert!(now < late && now > early, "{h}, {n}: {early} {now} {late}");
        }
    }
}

/// A cube on a held base under a plate that its upper nodes are bound to.
struct Press {
    world: World,
    speed: f64,
}

impl Press {
    fn new(mut flesh: Flesh, h: f64) -> Self {
        let nodes = flesh.nodes.clone();
        let low = (0..nodes.len() as u32).filter(|n| nodes[*n as usize].y == 0.0);
        flesh.fixed = low.map(|node| FixedNode { node, axes: [true; 3] }).collect();
        let young = flesh.materials[0].young;
        let bound = |x: &Vec3| if x.y > 0.0 { 2.5e4 * young * EDGE } else { 0.0 };
        let coupling = Coupling {
            bindings: vec![Binding { bones: [0, 0], weights: [1.0, 0.0] }; nodes.len()],
            springs: Springs::PerNode(nodes.iter().map(bound).collect()),
            damping_time: 0.0,
            skinning: Skinning::Linear,
        };
        let mut desc = WorldDesc { time_step: h, gravity: Vec3::zeros(), ..WorldDesc::default() };
        desc.solver.velocity_tolerance = 1e-13;
        let mut plate = body("plate", 1.0, [1.0; 3], Vec3::new(0.005, EDGE, 0.005));
        plate.motion = Motion::Prescribed;
        desc.add_rigid(plate);
        desc.add_soft(SoftDesc { coupling: Some(coupling), ..soft(flesh) });
        Self { world: World::new(desc).unwrap(), speed: 0.0 }
    }

    /// Presses by so much more \[m\]; gives the force that the cube puts on the plate \[N\].
    fn step(&mut self, down: f64) -> f64 {
        self.speed = down / self.world.time_step();
        let mut input = self.world.input();
        input.prescribed[0][0] = Vec3::y() * -self.speed;
        self.world.step(&input, &mut ());
        self.world.coupling_wrench(0)[0].y
    }

    /// Part of the work of a half-sine press by `depth` in time `length` that does not come back. A
    /// plate that does not stick gets none back from where the force would pull.
    fn loss(mut self, depth: f64, length: f64) -> f64 {
        let steps = (length / self.world.time_step()).round() as usize;
        let (mut spent, mut back, mut before, mut x0) = (0.0, 0.0, 0.0, 0.0);
        for k in 1..=steps {
            let x = depth * (PI * k as f64 / steps as f64).sin();
            let force = self.step(x - x0).max(0.0);
            let work = 0.5 * (force + before) * (x - x0);
            if work > 0.0 {
                spent += work
            } else {
                back -= work
            }
            (before, x0) = (force, x);
        }
        1.0 - back / spent
    }
}

/// T5 of the linear law. The figures are a quadrature of the hereditary integral with 200 000
/// intervals.
#[test]
fn a_press_loses_what_the_hereditary_integral_says() {
    let material = Material { poisson: 0.0, density: 1e-3, ..FLESH };
    let cases = [(0.02, 0.777), (0.05, 0.7851), (0.1, 0.7428), (0.3, 0.7207), (1.0, 0.6456)];
    for (length, want) in cases {
        for (parts, tolerance) in [(200, 2e-3), (20, 0.02)] {
            let press = Press::new(cube(material, &PULP), length / f64::from(parts));
            let loss = press.loss(0.002, length);
            assert!((loss - want).abs() < tolerance, "{length} s in {parts}: {loss} {want}");
        }
    }
    // Without memory nothing is lost.
    let elastic = Press::new(cube(material, &[]), 1e-3).loss(0.002, 0.1);
    assert!(elastic.abs() < 1e-6, "{elastic}");
}

/// A step solves for the stress of its end: mass times acceleration is the force of what it leaves,
/// to first order in a strain of 1e-7. That needs each part of the tangent.
#[test]
fn a_step_ends_in_balance_with_what_it_remembers() {
    for law in [Law::Corotational, Law::StableNeoHookean] {
        let material = Material { law, young: 1e4, ..FLESH };
        for h in [1e-3, 5e-3, 0.0167] {
            let mut world = world(soft(cube(material, &TABLE)), h);
            let pull = Mat3::new(1.0, 2e-7, 0.0, 0.0, 1.0 + 1e-7, 0.0, 1e-7, 0.0, 1.0);
            let sheared = moved(&world, &pull);
            world.set_nodes(0, &sheared);
            run(&mut world, 2);
            let before = world.node_velocities(0).to_vec();
            let mut input = world.input();
            // Without torque: a turn would change strains of this size by its square.
            let load = Mat3::new(2.0, -1.0, 0.5, -1.0, 3.0, 0.0, 0.5, 0.0, -1.0) * 1e-6;
            for (force, x) in input.node_forces.iter_mut().zip(world.nodes(0)) {
                *force = load * (x - Vec3::repeat(0.5 * EDGE));
            }
            world.step(&input, &mut ());
            let inner = inner_forces(&world);
            let scale: f64 = inner.iter().map(|f| f.norm()).sum();
            for (n, m) in world.node_masses(0).iter().enumerate() {
                let gained = (world.node_velocities(0)[n] - before[n]) * (*m / h);
                let off = gained - input.node_forces[n] - inner[n];
                assert!(off.norm() < 1e-4 * scale, "{law:?} {h}: {} of {scale}", off.norm());
            }
        }
    }
}

/// Forces of the flesh at this instant.
fn inner_forces(world: &World) -> Vec<Vec3> {
    let (model, state) = (world.model(), world.state());
    let mut A = model.pattern.clone();
    let mut b = vec![Vec3::zeros(); A.rows()];
    let rest = vec![Vec3::zeros(); state.x.len()];
    // So short that nothing fades in it.
    let h = 1e-13;
    model.flesh.assemble(&state.x, &rest, &state.faded, h, 0, &mut A, &mut b);
    b.iter().map(|b| b / h).collect()
}

/// Stress that is stored along other axes than those of the strain turns nothing, not even where
/// elements are turned inside out; and a turn of the whole turns its forces.
#[test]
fn stored_stress_makes_no_torque_and_turns_with_the_body() {
    for law in [Law::Corotational, Law::NeoHookean, Law::StableNeoHookean] {
        let mut flesh = cube(Material { law, ..FLESH }, &PULP);
        hold_all(&mut flesh);
        let mut world = world(soft(flesh), 0.02);
        let rest = world.nodes(0).to_vec();
        let place = |world: &mut World, F: &Mat3| {
            let x: Vec<Vec3> = rest.iter().map(|x| F * x).collect();
            world.set_nodes(0, &x);
        };
        place(&mut world, &Mat3::new(1.2, 0.4, 0.0, 0.0, 0.9, -0.3, 0.0, 0.2, 0.8));
        run(&mut world, 5);
        let turn = *Quat::from_scaled_axis(Vec3::new(0.7, -1.9, 0.4)).to_rotation_matrix().matrix();
        let shapes = [
            Mat3::identity(),
            Mat3::new(0.8, 0.0, 0.3, 0.1, 1.3, 0.0, 0.0, 0.0, 1.0),
            Mat3::from_diagonal(&Vec3::new(1.1, 0.9, -0.5)),
            Mat3::new(1.0, 0.2, 0.0, 0.0, 0.9, 0.1, 0.0, 0.0, -0.89),
            Mat3::from_diagonal(&Vec3::new(1.0, 1e-7, 0.9)),
        ];
        for shape in shapes {
            place(&mut world, &shape);
            let forces = inner_forces(&world);
            let scale: f64 = forces.iter().map(|f| f.norm()).sum();
            let mut forgetful = world.clone();
            forgetful.restart();
            place(&mut forgetful, &shape);
            let elastic = inner_forces(&forgetful);
            let stored: f64 = forces.iter().zip(elastic).map(|(f, e)| (f - e).norm()).sum();
            // Of a stress of about E on faces of the cube.
            let bound = 10.0 * FLESH.young * EDGE * EDGE;
            // Hyperelastic tissue stores none where it is crushed or inside out.
            let lives = law == Law::Corotational || shape.determinant() > 0.1;
            let held = if lives { stored > 0.01 * bound } else { stored == 0.0 };
            assert!(held && stored < bound, "{law:?} {stored} N");
            let net: Vec3 = forces.iter().sum();
            let torque: Vec3 = world.nodes(0).iter().zip(&forces).map(|(x, f)| x.cross(f)).sum();
            assert!(net.norm() < 1e-9 * scale, "{law:?}: {}", net.norm() / scale);
            assert!(
                torque.norm() < 1e-9 * scale * EDGE,
                "{law:?}: {}",
                torque.norm() / scale / EDGE
            );
            place(&mut world, &(turn * shape));
            for (turned, f) in inner_forces(&world).iter().zip(&forces) {
                assert!((turned - turn * f).norm() < 1e-6 * scale, "{law:?}");
            }
        }
    }
}

/// A block that was held sheared until its stress had faded, and is then let go in a spin: what is
/// left in it makes it swing, and neither brakes nor drives the spin. Its twin has no memory and
/// was never sheared.
#[test]
fn what_is_remembered_does_not_brake_a_spin() {
    let material = Material { law: Law::Corotational, young: 2e4, poisson: 0.3, density: 1000.0 };
    let spin = Vec3::new(0.0, 0.0, 12.0);
    let lost = |terms: &[[f64; 2]], shear: f64, h: f64| {
        let mut held = bar(Vec3::new(0.03, 0.03, 0.015), [2, 2, 1], material);
        held.relaxation = vec![Relaxation::new(terms).unwrap(); held.tets.len()];
        let free = soft(held.clone());
        hold_all(&mut held);
        let mut before = world(soft(held), h);
        let F = Mat3::new(1.0, shear, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0);
        let sheared = moved(&before, &F);
        before.set_nodes(0, &sheared);
        run(&mut before, (0.3 / h) as usize);
        let mut state = before.state().clone();
        let mut world = world(free, h);
        let masses = world.node_masses(0).to_vec();
        let mass: f64 = masses.iter().sum();
        let centre: Vec3 = state.x.iter().zip(&masses).map(|(x, m)| x * (*m / mass)).sum();
        for (v, x) in state.v.iter_mut().zip(&state.x) {
            *v = spin.cross(&(x - centre));
        }
        assert!(world.restore(&state));
        let about = |world: &World| world.momentum()[1];
        let (begin, energy) = (about(&world), world.energy(&world.input()).total());
        run(&mut world, (0.5 / h) as usize);
        let left = about(&world);
        let now = world.energy(&world.input()).total();
        // A step's motion along tangents stretches what turns, by (h ω)²/2: 0.2 % at 5 ms.
        let free = if terms.is_empty() { 0.01 } else { 0.0 };
        assert!(now <= energy * (1.0 + free), "{terms:?} {h}: {energy} {now}");
        (begin - left).norm() / begin.norm()
    };
    for h in [1e-3, 5e-3] {
        let elastic = lost(&[], 0.0, h);
        let remembering = lost(&[[0.8, 0.05]], 0.3, h);
        assert!(remembering < 1e-12 && elastic < 1e-3, "{h}: {remembering} {elastic}");
    }
}

/// A state holds all of memory: a world goes back to one with the same bits, and tells other memory
/// by its hash.
#[test]
fn a_state_brings_memory_back_to_the_bit() {
    let start = |terms: &[[f64; 2]]| {
        let mut world = world(soft(cube(FLESH, terms)), 5e-3);
        let stretched = moved(&world, &Mat3::from_diagonal(&Vec3::new(1.2, 0.9, 1.0)));
        world.set_nodes(0, &stretched);
        run(&mut world, 10);
        world
    };
    let mut world = start(&PULP);
    let kept = world.state().clone();
    run(&mut world, 25);
    let hash = world.state_hash();
    let mut other = start(&PULP);
    run(&mut other, 3);
    assert!(other.restore(&kept));
    assert_eq!(other.state().faded, kept.faded);
    run(&mut other, 25);
    assert_eq!(other.state_hash(), hash);
    let mut altered = kept.clone();
    altered.faded[5][2] += 1e-9;
    assert_ne!(altered.hash(), kept.hash());
    assert!(other.restore(&altered));
    run(&mut other, 25);
    assert_ne!(other.state_hash(), hash);
    // Of other memory no state is taken, one that is no number neither; a copy has no limits.
    let two = start(&PULP[..2]);
    assert!(!world.restore(two.state()));
    altered.faded[0][0] = f64::NAN;
    assert!(!world.restore(&altered));
    altered.copy_from(two.state());
    assert_eq!(altered.hash(), two.state_hash());
}

/// Other terms and moduli in a running world: a body in balance stays in it where it can.
#[test]
fn other_terms_go_on_from_what_was_remembered() {
    let terms: [&[[f64; 2]]; 4] = [
        &[[0.4, 0.02]],
        &[[0.2, 0.01], [0.2, 0.03]],
        &[[0.1, 0.02]; 4],
        &[[0.2, 0.03], [0.2, 1e-3]],
    ];
    for from in terms {
        for to in terms {
            let mut flesh = cube(FLESH, from);
            hold_all(&mut flesh);
            let mut world = world(soft(flesh), 2e-3);
            let shape = Mat3::new(1.1, 0.2, 0.0, 0.0, 0.9, 0.0, 0.0, 0.0, 1.0);
            let x = moved(&world, &shape);
            world.set_nodes(0, &x);
            run(&mut world, 300);
            let before = inner_forces(&world);
            let mut desc = world.desc().clone();
            let relaxation = Relaxation::new(to).unwrap();
            desc.softs[0].flesh.relaxation.fill(relaxation);
            desc.softs[0].flesh.materials.iter_mut().for_each(|m| m.young *= 2.0);
            world.retune(desc).unwrap();
            for (now, f) in inner_forces(&world).iter().zip(&before) {
                assert!((now - f * 2.0).norm() < 1e-6 * f.norm(), "{from:?} {to:?}");
            }
            run(&mut world, 5);
        }
    }
    // Memory that is given up, or given to one that had none.
    for (from, to) in [(&PULP[..], &[][..]), (&[], &PULP)] {
        let mut world = world(soft(cube(FLESH, from)), 2e-3);
        run(&mut world, 3);
        let mut desc = world.desc().clone();
        desc.softs[0].flesh.relaxation.fill(Relaxation::new(to).unwrap());
        world.retune(desc).unwrap();
        assert_eq!(world.state().faded.len(), 6 * to.len());
        run(&mut world, 3);
        assert!(world.state().is_finite());
    }
}

/// Elements with memory have no Rayleigh damping of stiffness; their neighbours keep it.
#[test]
fn nothing_is_damped_twice() {
    let mut flesh = cube(FLESH, &PULP);
    flesh.stiffness_damping = 0.01;
    let with = world(soft(flesh.clone()), 2e-3);
    flesh.relaxation[1] = Relaxation::NONE;
    let mixed = world(soft(flesh), 2e-3);
    assert!(with.model().flesh.stiffness_damping.iter().all(|d| *d == 0.0));
    let damping = &mixed.model().flesh.stiffness_damping;
    assert!(damping[1] == 0.01 && damping.iter().sum::<f64>() == 0.01);
}

/// One tetrahedron: a mesh of several can come to rest entangled, without any element inside out.
fn tetrahedron(material: Material, terms: &[[f64; 2]]) -> Flesh {
    let mut flesh = cube(material, terms);
    let corners = [Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()];
    flesh.nodes = corners.map(|x| x * EDGE).to_vec();
    flesh.tets = vec![[0, 1, 2, 3]];
    flesh.materials.truncate(1);
    flesh.relaxation.truncate(1);
    flesh.collision = EmbeddedSurface::default();
    flesh
}

/// Corotational flesh that was flattened, crushed or turned inside out, and remembers it, comes
/// right again at any step.
#[test]
fn inverted_tissue_with_memory_comes_right() {
    let shapes = [
        [1.0, 1.0, -1.0],
        [1.6, 1.5, -0.2],
        [1.0, 0.9, -0.899],
        [1.0, 1e-6, 1.0],
        [1.9, 2.1, 0.1],
        [0.4, 0.3, 0.4],
    ];
    for h in [1e-3, 5e-3, 0.0167] {
        for shape in shapes {
            let mut flesh = tetrahedron(FLESH, &PULP[..2]);
            flesh.mass_damping = 5.0;
            let mut world = world(soft(flesh), h);
            let x = moved(&world, &Mat3::from_diagonal(&Vec3::from(shape)));
            world.set_nodes(0, &x);
            let input = world.input();
            let inside_out = world.step(&input, &mut ()).inverted_tets;
            assert_eq!(inside_out, u32::from(shape[2] < 0.0));
            run(&mut world, (2.0 / h) as usize);
            let report = world.step(&input, &mut ());
            assert_eq!(report.inverted_tets, 0, "{h} {shape:?}");
            // Of a strain of 1e-3 at the most.
            let energy = world.energy(&input).elastic / (FLESH.young * EDGE.powi(3) / 6.0);
            assert!(energy < 1e-6, "{h} {shape:?} {energy}");
        }
    }
}
