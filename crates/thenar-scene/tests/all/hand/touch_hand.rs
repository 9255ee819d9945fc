//! Goal: the hand for touch behaves like a hand. Method: its index pad is pressed on a plate and
//! measured against people; it makes a fist, at short and long steps, and what became of its flesh
//! is counted.

use std::path::Path;
use thenar_scene::session::Session;

const SCENES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes");

/// An index pad, its bones held, and a plate tilted by 30° that comes up to it at 5 mm/s along its
/// normal.
fn press(side: &str, seconds: f64) -> Session {
    // Where the plate's middle is when its face meets the pad, about; of the mirrored hand
    // mirrored.
    let x = if side == "left" { 0.0197 } else { -0.0197 };
    let start = [x, -0.023_991, -0.178_75];
    let (sin, cos) = 30f64.to_radians().sin_cos();
    let way = 5e-3 * seconds;
    let end = [x, start[1] + way * cos, start[2] + way * sin];
    let text = format!(
        "version = 1\ngravity = [0, 0, 0]\ntime_step = 0.005\nduration = {seconds}\n\
         [[hand]]\nname = \"hand\"\npreset = \"touch\"\nmodel = \"{side}\"\nself_contact = false\n\
         bone_drive = {{ stiffness = 1e6, damping = 1e3, angular_stiffness = 1e3, angular_damping = 1 }}\n\
         palm_drive = {{ stiffness = 1e6, damping = 1e3, angular_stiffness = 1e4, angular_damping = 10 }}\n\
         [[rigid]]\nname = \"plate\"\nshape = {{ kind = \"box\", size = [0.024, 0.01, 0.04] }}\n\
         motion = \"scripted\"\nposition = {start:?}\n\
         rotation = {{ axis = [1, 0, 0], angle_deg = 30 }}\ninterpolation = \"linear\"\nfriction = 0.6\n\
         keyframes = [{{ time = 0, position = {start:?} }}, {{ time = {seconds}, position = {end:?} }}]\n\
         [[probe]]\nname = \"press\"\nmeasure = \"contact\"\nbodies = [\"hand\", \"plate\"]\n"
    );
    Session::from_text(&text, Path::new("press.toml"), &[]).unwrap_or_else(|e| panic!("{e}"))
}

/// Depth \[m\] from first touch, force \[N\] and area \[m²\] of each step of the press.
fn curve(session: &mut Session) -> Vec<[f64; 3]> {
    let column = |name: &str| {
        let columns = session.columns();
        columns.iter().position(|c| c.name == name).unwrap_or_else(|| panic!("no {name}"))
    };
    let force = ["press.fx", "press.fy", "press.fz"].map(column);
    let area = column("press.area");
    let mut rows: Vec<[f64; 3]> = Vec::new();
    for _ in 0..session.steps_wanted() {
        session.step(&mut ());
        let values = session.probe();
        let norm = force.map(|c| values[c] * values[c]).iter().sum::<f64>().sqrt();
        let area = values[area];
        let way = 5e-3 * session.world().time();
        if norm > 0.01 || !rows.is_empty() {
            rows.push([way, norm, area]);
        }
    }
    let first = rows.first().expect("the plate meets the pad")[0];
    rows.iter().map(|[way, f, a]| [way - first, *f, *a]).collect()
}

/// The row at which a force is reached first.
fn at(curve: &[[f64; 3]], force: f64) -> usize {
    curve.iter().position(|row| row[1] >= force).unwrap_or_else(|| panic!("{force} N not reached"))
}

/// Slope of the force over seven steps around a row \[N/m\], by least squares.
fn stiffness(curve: &[[f64; 3]], row: usize) -> f64 {
    let near = &curve[row - 3..row + 4];
    let mean = |k: usize| near.iter().map(|r| r[k]).sum::<f64>() / near.len() as f64;
    let (depth, force) = (mean(0), mean(1));
    let both: f64 = near.iter().map(|r| (r[0] - depth) * (r[1] - force)).sum();
    both / near.iter().map(|r| (r[0] - depth).powi(2)).sum::<f64>()
}

/// Serina, Mote and Rempel 1997 (twenty people): the pad sinks by 1.0 to 2.5 mm at 1 N, and is at 5
/// N at least three times as stiff as at 0.5 N; between a cone's area and a flat punch's, that of
/// contact grows with a power of the force of 0.35 to 0.55.
#[test]
fn a_pad_gives_way_as_those_of_people_do() {
    for side in ["right", "left"] {
        let curve = curve(&mut press(side, 1.5));
        let depth = curve[at(&curve, 1.0)][0];
        assert!((1.0e-3..2.5e-3).contains(&depth), "{side}: {depth} m at 1 N");
        let [soft, hard] = [0.5, 5.0].map(|force| stiffness(&curve, at(&curve, force)));
        assert!(hard >= 3.0 * soft, "{side}: {soft} N/m at 0.5 N, {hard} at 5 N");
        let [low, high] = [0.5, 5.0].map(|force| curve[at(&curve, force)][2]);
        let exponent = (high / low).log10();
        assert!((0.35..0.55).contains(&exponent), "{side}: {low} to {high} m², {exponent}");
    }
}

/// A closed fist crushes flesh between fingers and palm. Nothing passes through, no more than an
/// element in three hundred is flat, and after the hand has opened its flesh has forgotten it.
#[test]
fn a_fist_crushes_nothing_for_good() {
    for h in [0.005, 1.0 / 60.0] {
        let changes = [format!("time_step={h}"), "hand.hand.preset=touch".to_owned()];
        let scene = Path::new(SCENES).join("fist.toml");
        let mut session = Session::load(&scene, &changes).unwrap_or_else(|e| panic!("{e}"));
        let tets = session.world().desc().softs[0].flesh.tets.len() as u32;
        assert!(tets > 2500, "the hand has {tets} tetrahedra");
        let at_rest = session.world().energy(session.input()).elastic;
        let (mut highest, mut last) = (0.0f64, u32::MAX);
        for _ in 0..session.steps_wanted() {
            let report = session.step(&mut ());
            assert!(!report.non_finite && !report.fell_back && report.contacts_dropped == 0);
            assert!(report.penetration_max < 2e-4, "{h} s: {report:?}");
            assert!(report.inverted_tets <= tets / 300, "{h} s: {report:?}");
            highest = highest.max(session.world().energy(session.input()).elastic);
            last = report.inverted_tets;
        }
        assert_eq!(last, 0, "{h} s");
        // What the drives' springs of 0.3 N m/rad give up: 15 joints, of which none is off by more
        // than half a radian.
        assert!(highest < 15.0 * 0.5 * 0.3 * 0.25, "{h} s: {highest} J of flesh");
        let end = session.world().energy(session.input()).elastic;
        assert!(end < at_rest + 0.01 * highest, "{h} s: {end} J after, {at_rest} J before");
    }
}
