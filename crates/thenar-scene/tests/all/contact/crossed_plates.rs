//! Goal: plates of which no corner lies over the other's face are held by their edges. Method: a
//! plate of 60 x 90 mm that is fixed, and one of 90 x 60 mm across it, as meshes of twelve
//! triangles, as boxes, or one of each: laid down a little askew it comes to rest on all four
//! crossings, as high as it is thick and level; thrown, it does not pass.

use std::path::PathBuf;
use thenar_scene::session::Session;

/// Sizes of the plate below and of the one above \[m\].
fn sizes(thickness: f64) -> [[f64; 3]; 2] {
    [[0.06, thickness, 0.09], [0.09, thickness, 0.06]]
}

/// A cuboid of twelve triangles, as OBJ.
fn cuboid(size: [f64; 3]) -> String {
    let mut text = String::new();
    for k in 0..8 {
        let at =
            |axis: usize| if k >> axis & 1 == 1 { 0.5 * size[axis] } else { -0.5 * size[axis] };
        text += &format!("v {} {} {}\n", at(0), at(1), at(2));
    }
    for quad in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]]
    {
        let [a, b, c, d] = quad;
        text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
    }
    text
}

/// A plate above another.
struct Case {
    /// Below and above: whether it is a mesh.
    meshes: [bool; 2],
    thickness: f64,
    h: f64,
    /// Clearance between the plates' middles less a thickness \[m\], tilt \[degrees\] and speed
    /// downwards \[m/s\].
    above: f64,
    tilt_deg: f64,
    speed: f64,
}

impl Case {
    fn open(&self) -> Session {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("crossed-plates");
        let folder = folder.join(format!("{:.0}-{:.0}", 1e6 * self.thickness, 1e6 * self.above));
        std::fs::create_dir_all(&folder).unwrap();
        let sizes = sizes(self.thickness);
        let shape = |k: usize| {
            let file = format!("plate{k}.obj");
            std::fs::write(folder.join(&file), cuboid(sizes[k])).unwrap();
            match self.meshes[k] {
                true => format!("{{ kind = \"mesh\", file = \"{file}\" }}"),
                false => format!("{{ kind = \"box\", size = {:?} }}", sizes[k]),
            }
        };
        let (below, above) = (shape(0), shape(1));
        let text = format!(
            "version = 1
            time_step = {}
            duration = 0.6
            [[rigid]]
            name = \"below\"
            shape = {below}
            motion = \"fixed\"
            [[rigid]]
            name = \"above\"
            shape = {above}
            mass = 0.05
            position = [0.004, {}, 0.003]
            rotation = {{ axis = [0.05, 0, 1], angle_deg = {} }}
            velocity = [0, {}, 0]",
            self.h,
            self.thickness + self.above,
            self.tilt_deg,
            -self.speed
        );
        Session::from_text(&text, &folder.join("plates.toml"), &[]).unwrap()
    }

    fn name(&self) -> String {
        let [below, above] = self.meshes.map(|mesh| if mesh { "mesh" } else { "box" });
        format!(
            "{above} on {below}, {} mm, {} ms, {} mm above, {}°, {} m/s",
            1e3 * self.thickness,
            1e3 * self.h,
            1e3 * self.above,
            self.tilt_deg,
            self.speed
        )
    }
}

const KINDS: [[bool; 2]; 4] = [[true, true], [true, false], [false, true], [false, false]];
const STEPS: [f64; 3] = [1e-3, 5e-3, 1.0 / 60.0];

#[test]
fn plates_laid_across_each_other_rest_on_their_edges() {
    for meshes in KINDS {
        for (thickness, tilt_deg) in [(0.0008, 0.8), (0.006, 0.8), (0.025, -0.5)] {
            for h in STEPS {
                let case = Case { meshes, thickness, h, above: 1.6e-3, tilt_deg, speed: 0.0 };
                let (mut session, name) = (case.open(), case.name());
                for k in 0..session.steps_wanted() {
                    session.step(&mut ());
                    let y = session.world().rigid_pose(1).position.y;
                    // Never deeper than a tenth of a millimetre.
                    assert!(y > thickness - 1e-4, "{name}, step {k}: {y} m");
                }
                let world = session.world();
                let [v, omega] = world.rigid_velocity(1);
                let up = world.rigid_pose(1).rotation * thenar_core::Vec3::y();
                let y = world.rigid_pose(1).position.y;
                assert!((y - thickness).abs() < 2e-5, "{name}: {y} m");
                assert!(v.norm() < 1e-3 && omega.norm() < 1e-2, "{name}: {v} m/s, {omega} rad/s");
                assert!(up.y > 1.0 - 1e-6, "{name}: stands {up}");
                let weight = 0.05 * world.desc().gravity.norm();
                let force: f64 = world.contacts().iter().map(|c| c.force_W.y.abs()).sum();
                assert!((force / weight - 1.0).abs() < 2e-3, "{name}: {force} N of {weight}");
            }
        }
    }
}

/// From 20 mm above, and thrown: nothing goes through, though a step is up to five thicknesses
/// long.
#[test]
fn plates_thrown_across_each_other_do_not_pass() {
    let case = |meshes, thickness, h, above, tilt_deg, speed| Case {
        meshes,
        thickness,
        h,
        above,
        tilt_deg,
        speed,
    };
    let mut cases = Vec::new();
    for meshes in KINDS {
        for h in STEPS {
            cases.push(case(meshes, 0.003, h, 0.02, 4.0, 0.0));
            cases.push(case(meshes, 0.003, h, 0.03, 2.0, 0.5));
        }
        cases.push(case(meshes, 0.0004, 1e-3, 0.06, 35.0, 1.0));
        cases.push(case(meshes, 0.0008, 1e-3, 0.06, 35.0, 1.0));
        // Far from level: what turns level within a step, and farther than it is thick, is looked
        // at on its way.
        for (thickness, h) in
            [(0.0008, 5e-3), (0.003, 5e-3), (0.003, 1.0 / 60.0), (0.006, 1.0 / 60.0)]
        {
            for speed in [0.3, 1.0, 2.4] {
                cases.push(case(meshes, thickness, h, 0.06, 35.0, speed));
            }
        }
        cases.push(case(meshes, 0.003, 1.0 / 60.0, 0.06, 35.0, 3.0));
    }
    let passes = |case: &Case| {
        let mut session = case.open();
        let place = |session: &Session| session.world().rigid_pose(1).position;
        let fell = (0..session.steps_wanted()).any(|_| {
            session.step(&mut ());
            let p = place(&session);
            p.y < -case.thickness && p.xz().norm() < 0.02
        });
        // What slid off does not count.
        let p = place(&session);
        fell || (p.y < 0.5 * case.thickness && p.xz().norm() < 0.02)
    };
    let passed: Vec<String> = cases.iter().filter(|case| passes(case)).map(Case::name).collect();
    assert!(passed.is_empty(), "{} of {} pass:\n{}", passed.len(), cases.len(), passed.join("\n"));
}
