//! Objects of many shapes and weights are gripped by one line, without a force. A share of the
//! grips that are known to hold runs here; `THENAR_CASES=all` runs all, and prints a line for each.

use crate::stage::{Held, Stage, hold, open};
use thenar_scene::grip::GripKind;
use thenar_testing::{cases_wanted, one_in};

/// The hand of each kind: for touch, its left, and the paper's.
const GRIPS: [(GripKind, &str, &str); 3] = [
    (GripKind::Pinch, "touch", "right"),
    (GripKind::Tripod, "touch", "left"),
    (GripKind::Power, "paper", "right"),
];
/// So much of an object is above the middle of the pads at most [m]: more would be in the hand as
/// the scene begins.
const ABOVE: f64 = 0.015;
/// The end of the hold [s]: a force that falls as pads take up the load has settled by then.
const UNTIL: f64 = 7.0;
/// By so much the drives give way to a weight [m].
const GIVES_WAY: f64 = 8e-3;
/// What goes on slower than this does not slip [m/s].
const SLIP_MAX: f64 = 1e-4;
/// A force that adapts is at most four times the one foreseen, which is twice the slip limit; a
/// step may end a little above.
const FORCE_MAX: f64 = 8.0 * 1.05;

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

    /// Width between pads, and height on the peg [m]; a cone's origin is at a quarter of it.
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
    (Cone(30.0, 80.0), 0.1, 0.9, [Kept, Sags, Lost]),
    (Cone(25.0, 40.0), 0.05, 1.0, [Lost, Lost, Lost]),
    (DumbBell(15.0, 40.0), 0.1, 0.8, [Kept, Kept, Kept]),
];

fn grip(case: usize) -> (String, Held, f64) {
    let (shape, mass, friction, _) = OBJECTS[case / GRIPS.len()];
    let (kind, preset, side) = GRIPS[case % GRIPS.len()];
    let h = [5e-3, 1e-2][case / GRIPS.len() % 2];
    let size = shape.size();
    let stage = Stage {
        side,
        object: format!("[[rigid]]\n{}\nmass = {mass}", shape.text()),
        size,
        drop: (0.5 * size[1] - ABOVE).max(0.0),
        friction,
        until: UNTIL,
        ..Stage::ball(preset, kind, 1.0, h)
    };
    let held = hold(&mut open(&stage.text().replace("force = 1\n", "")));
    let over = held.force / (mass * 9.81 / (2.0 * friction));
    (format!("{shape:?}, {kind:?} at {h} s"), held, over)
}

/// Nothing ends worse than is known, and what is kept is kept with a force that the law of grips
/// allows.
#[test]
fn plain_objects_are_kept() {
    let known = |case: &usize| OBJECTS[case / GRIPS.len()].3[case % GRIPS.len()];
    let every = 0..OBJECTS.len() * GRIPS.len();
    let whole = cases_wanted().is_some_and(|wanted| wanted == "all");
    let mut ends = Vec::new();
    for case in one_in(11, every.filter(|case| whole || known(case) == Kept)) {
        let (name, held, over) = grip(case);
        let end = End::of(&held);
        println!("{case:2} {end:?}, {over:.2} times the slip limit: {name}, {held:?}");
        assert!(end >= known(&case), "{name} was {:?}: {held:?}", known(&case));
        assert!(end < Kept || (1.0..FORCE_MAX).contains(&over), "{name}: {over}, {held:?}");
        ends.push((end, over));
    }
    let count = |is: &dyn Fn(&(End, f64)) -> bool| ends.iter().filter(|end| is(end)).count();
    println!(
        "{} of {} are kept, {} of them with 1.1 to 2 times the slip limit",
        count(&|(end, _)| *end == Kept),
        ends.len(),
        count(&|(end, over)| *end == Kept && (1.1..2.0).contains(over)),
    );
}
