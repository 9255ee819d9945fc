//! Grips of objects of many shapes and weights, without a `force`. A share of those that are known
//! to keep the object runs here; `THENAR_CASES=all` runs all, and prints a line for each.

use crate::stage::{Held, Stage, hold, open};
use thenar_scene::grip::GripKind;
use thenar_testing::{cases_wanted, one_in};

/// Kinds, each with its hand.
const GRIPS: [(GripKind, &str, &str); 3] = [
    (GripKind::Pinch, "touch", "right"),
    (GripKind::Tripod, "touch", "left"),
    (GripKind::Power, "paper", "right"),
];
/// An object rises above the middle of the pads by this at most [m]: more would be in the hand as
/// the scene begins. The tip of a cone, which is between fingers, rises by three times as much.
const ABOVE: f64 = 0.015;
/// The end of the hold [s]: a force that falls as pads take up the load has settled by then.
const UNTIL: f64 = 7.0;
/// Drives give way to a weight by less than this [m].
const GIVES_WAY: f64 = 8e-3;
/// Slower motion is not slip [m/s].
const SLIP_MAX: f64 = 1e-4;
/// Ratio of a force that adapts to the one foreseen at most; a step may end a little above. The
/// force foreseen is twice the slip limit, and 0.2 N at least.
const RISE_MAX: f64 = 4.0 * 1.05;

/// Shape that stands on the peg: lengths [mm], angle about the vertical [degrees].
#[derive(Clone, Copy, Debug)]
enum Shape {
    Cuboid([f64; 3], f64),
    Ball(f64),
    /// Upright: radius and length.
    Cylinder(f64, f64),
    /// Level, aslant to the hand: radius and length.
    Rod(f64, f64),
    Ellipsoid([f64; 3]),
    /// Upright: radius and height.
    Cone(f64, f64),
    /// Two balls on an upright rod of half their radius: radius, and distance of their middles.
    DumbBell(f64, f64),
}
use Shape::{Ball, Cone, Cuboid, Cylinder, DumbBell, Ellipsoid, Rod};

impl Shape {
    /// Fields of a body in a scene file.
    fn text(self) -> String {
        let round = |kind: &str, radius: f64, length: f64| {
            let [radius, length] = [radius, length].map(|x| 1e-3 * x);
            format!("{{ kind = \"{kind}\", radius = {radius}, length = {length} }}")
        };
        let size = |kind: &str, size: [f64; 3]| {
            format!("{{ kind = \"{kind}\", size = {:?} }}", size.map(|x| 1e-3 * x))
        };
        let ball = |radius: f64| format!("{{ kind = \"sphere\", radius = {} }}", 1e-3 * radius);
        let turned = |axis: &str, angle_deg: f64| {
            format!("\nrotation = {{ axis = {axis}, angle_deg = {angle_deg} }}")
        };
        let shape = match self {
            Cuboid(lengths, angle_deg) => size("box", lengths) + &turned("[0, 1, 0]", angle_deg),
            Ball(radius) => ball(radius),
            Cylinder(radius, length) => round("cylinder", radius, length),
            Rod(radius, length) => {
                round("cylinder", radius, length) + &turned("[0.8, 0, -0.6]", 90.0)
            }
            Ellipsoid(lengths) => size("ellipsoid", lengths),
            Cone(radius, height) => round("cone", radius, height).replace("length", "height"),
            DumbBell(radius, apart) => {
                let at = |y: f64| {
                    let [ball, y] = [ball(radius), (5e-4 * y).to_string()];
                    format!("{{ shape = {ball}, frame = {{ position = [0, {y}, 0] }} }}")
                };
                let rod = round("cylinder", 0.5 * radius, apart);
                let parts = [at(apart), at(-apart), format!("{{ shape = {rod} }}")].join(", ");
                format!("{{ kind = \"compound\", parts = [{parts}] }}")
            }
        };
        format!("shape = {shape}")
    }

    /// Width between pads, a cone's at its base, and twice the height of its origin above the peg
    /// [m].
    fn size(self) -> [f64; 2] {
        let mm = match self {
            Cuboid([x, y, z], _) | Ellipsoid([x, y, z]) => [x.min(z), y],
            Ball(radius) | Rod(radius, _) => [2.0 * radius; 2],
            Cylinder(radius, length) => [2.0 * radius, length],
            Cone(radius, height) => [2.0 * radius, 0.5 * height],
            DumbBell(radius, apart) => [2.0 * radius, apart + 2.0 * radius],
        };
        mm.map(|x| 1e-3 * x)
    }

    /// How much lower than the middle of the pads its origin is [m].
    fn drop(self) -> f64 {
        let above = match self {
            Cone(_, height) => 0.75e-3 * height - 3.0 * ABOVE,
            _ => 0.5 * self.size()[1] - ABOVE,
        };
        above.max(0.0)
    }
}

/// End of a grip, the worst first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum End {
    Lost,
    Slips,
    Sags,
    Kept,
}
use End::{Kept, Lost, Sags, Slips};

impl End {
    fn of(held: &Held) -> Self {
        let low = 0.1 - held.lift;
        match () {
            () if low > 0.05 => Lost,
            () if held.slip > SLIP_MAX => Slips,
            () if low.abs() > GIVES_WAY => Sags,
            () => Kept,
        }
    }
}

/// Objects with their masses [kg] and friction, and the known ends of the [`GRIPS`].
const OBJECTS: [(Shape, f64, f64, [End; 3]); 20] = [
    (Cuboid([20.0, 30.0, 20.0], 0.0), 0.02, 0.5, [Kept, Kept, Kept]),
    (Cuboid([40.0, 60.0, 40.0], 0.0), 0.1, 0.6, [Kept, Lost, Slips]),
    (Cuboid([30.0, 80.0, 60.0], 0.0), 0.2, 0.8, [Kept, Sags, Kept]),
    (Cuboid([15.0, 50.0, 50.0], 40.0), 0.05, 0.4, [Kept, Kept, Kept]),
    (Cuboid([50.0, 50.0, 50.0], 30.0), 0.15, 0.7, [Kept, Kept, Kept]),
    (Cylinder(10.0, 60.0), 0.04, 0.5, [Kept, Kept, Kept]),
    (Cylinder(25.0, 80.0), 0.3, 0.8, [Kept, Kept, Kept]),
    (Cylinder(33.0, 80.0), 0.33, 0.9, [Kept, Kept, Kept]),
    (Cylinder(15.0, 30.0), 0.05, 0.4, [Lost, Kept, Kept]),
    (Rod(12.0, 100.0), 0.1, 0.6, [Kept, Lost, Kept]),
    (Ball(8.0), 0.005, 0.5, [Lost, Kept, Lost]),
    (Ball(15.0), 0.03, 0.3, [Kept, Kept, Kept]),
    (Ball(33.0), 0.06, 0.6, [Kept, Kept, Kept]),
    (Ball(25.0), 0.5, 1.0, [Sags, Sags, Kept]),
    (Ellipsoid([30.0, 50.0, 30.0]), 0.05, 0.6, [Lost, Kept, Kept]),
    (Ellipsoid([60.0, 40.0, 40.0]), 0.08, 0.7, [Kept, Kept, Lost]),
    (Cone(15.0, 60.0), 0.03, 0.6, [Kept, Kept, Slips]),
    (Cone(30.0, 80.0), 0.1, 0.9, [Kept, Lost, Lost]),
    (Cone(25.0, 40.0), 0.05, 1.0, [Lost, Lost, Lost]),
    (DumbBell(15.0, 40.0), 0.1, 0.8, [Kept, Kept, Kept]),
];

/// Name of a grip, its end, and the slip limit `m g / (2 μ)` [N].
fn grip(case: usize) -> (String, Held, f64) {
    let (shape, mass, friction, _) = OBJECTS[case / GRIPS.len()];
    let (kind, preset, side) = GRIPS[case % GRIPS.len()];
    let h = [5e-3, 1e-2][case / GRIPS.len() % 2];
    let stage = Stage {
        side,
        object: format!("[[rigid]]\n{}\nmass = {mass}", shape.text()),
        size: shape.size(),
        drop: shape.drop(),
        friction,
        until: UNTIL,
        ..Stage::ball(preset, kind, 1.0, h)
    };
    let mut session = open(&stage.text().replace("force = 1\n", ""));
    let mut name = format!("{shape:?}, {kind:?} at {h} s");
    // The widest reach into the thumb at rest.
    if let Some(overlap) = session.start_overlaps().first() {
        name += &format!(" (begins {:.1} mm in the hand)", 1e3 * overlap.depth);
    }
    (name, hold(&mut session), mass * 9.81 / (2.0 * friction))
}

/// No grip ends worse than is known, and no object is kept with more force than the law of grips
/// allows.
#[test]
fn grips_of_plain_objects_end_no_worse_than_known() {
    let known = |case: &usize| OBJECTS[case / GRIPS.len()].3[case % GRIPS.len()];
    let every = 0..OBJECTS.len() * GRIPS.len();
    let whole = cases_wanted().is_some_and(|wanted| wanted == "all");
    let (mut ends, mut worse) = (Vec::new(), Vec::new());
    for case in one_in(10, every.filter(|case| whole || known(case) == Kept)) {
        let (name, held, limit) = grip(case);
        let (end, known, over) = (End::of(&held), known(&case), held.force / limit);
        let line = format!("{case:2} {end:?}, {over:.2} times the slip limit: {name}, {held:?}");
        let than = if end > known { ", better than is known" } else { "" };
        println!("{line}{than}");
        let allowed = limit..RISE_MAX * f64::max(2.0 * limit, 0.2);
        if end < known || (end == Kept && !allowed.contains(&held.force)) {
            worse.push(format!("{line}, was {known:?}"));
        }
        ends.push((end, over));
    }
    let count = |is: &dyn Fn(&(End, f64)) -> bool| ends.iter().filter(|end| is(end)).count();
    println!(
        "{} of {} are kept, {} of them with 1.1 to 2 times the slip limit",
        count(&|(end, _)| *end == Kept),
        ends.len(),
        count(&|(end, over)| *end == Kept && (1.1..2.0).contains(over)),
    );
    assert!(worse.is_empty(), "{worse:#?}");
}
