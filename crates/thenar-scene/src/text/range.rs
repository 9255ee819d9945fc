//! Bounds of numbers, with words for messages.

use crate::session::FORCE_MAX;
use thenar_core::model::OGDEN_ALPHA;
use thenar_core::world::GRAVITY_MAX;
use thenar_input::plain;
use thenar_rig::hand::{DETAILS, LENGTHS};

/// An interval of admissible numbers. Numbers must be finite in any case.
#[derive(Debug)]
pub struct Range {
    /// Smallest value.
    pub min: f64,
    /// Largest value.
    pub max: f64,
    /// `min` itself is not admissible.
    pub open_min: bool,
    /// `max` itself is not admissible.
    pub open_max: bool,
}

const fn closed(min: f64, max: f64) -> Range {
    Range { min, max, open_min: false, open_max: false }
}

impl Range {
    /// Any finite number.
    pub const ANY: &'static Range = &closed(f64::NEG_INFINITY, f64::INFINITY);
    /// At least zero.
    pub const NOT_NEGATIVE: &'static Range = &closed(0.0, f64::INFINITY);
    /// More than zero.
    pub const POSITIVE: &'static Range =
        &Range { min: 0.0, max: f64::INFINITY, open_min: true, open_max: false };
    /// Time step \[s\].
    pub const TIME_STEP: &'static Range = &closed(1e-7, 10.0);
    /// Duration \[s\].
    pub const DURATION: &'static Range = &closed(0.0, 1e6);
    /// A length of a body \[m\]: 0.1 mm to 100 m.
    pub const SIZE: &'static Range = &closed(1e-4, 100.0);
    /// Thickness of a sheet \[m\]: 1 µm to 10 cm.
    pub const THICKNESS: &'static Range = &closed(1e-6, 0.1);
    /// A depth under the skin \[m\].
    pub const DEPTH: &'static Range = &closed(0.0, 1.0);
    /// A line tension \[N/m\].
    pub const TENSION: &'static Range = &closed(0.0, 1e6);
    /// A strain.
    pub const STRAIN: &'static Range = &closed(0.0, 10.0);
    /// A place \[m\].
    pub const PLACE: &'static Range = &closed(-1e4, 1e4);
    /// A speed \[m/s\] or \[rad/s\].
    pub const RATE: &'static Range = &closed(-1e5, 1e5);
    /// Gravity \[m/s²\].
    pub const GRAVITY: &'static Range =
        &Range { min: -GRAVITY_MAX, max: GRAVITY_MAX, open_min: true, open_max: true };
    /// Mass \[kg\].
    pub const MASS: &'static Range = &closed(1e-9, 1e6);
    /// Density \[kg/m³\].
    pub const DENSITY: &'static Range = &closed(1e-3, 1e5);
    /// Young's modulus \[Pa\].
    pub const YOUNG: &'static Range = &closed(1e-1, 1e12);
    /// Poisson's ratio.
    pub const POISSON: &'static Range =
        &Range { min: -1.0, max: 0.5, open_min: true, open_max: true };
    /// Ogden's exponent.
    pub const OGDEN: &'static Range = &closed(OGDEN_ALPHA[0], OGDEN_ALPHA[1]);
    /// Friction coefficient.
    pub const FRICTION: &'static Range = &closed(0.0, 100.0);
    /// A normal force \[N\], or a coefficient at it.
    pub const PRESSING: &'static Range = &closed(0.0, 1e6);
    /// With which a hand grips \[N\].
    pub const GRIP_FORCE: &'static Range =
        &Range { min: 0.0, max: FORCE_MAX, open_min: true, open_max: false };
    /// An angle \[rad\].
    pub const ANGLE: &'static Range = &closed(-1e4, 1e4);
    /// An angle of a joint, to either side \[degrees\].
    pub const HALF_TURN_DEG: &'static Range = &closed(-180.0, 180.0);
    /// A part of a whole.
    pub const FRACTION: &'static Range = &closed(0.0, 1.0);
    /// A component of a unit vector.
    pub const UNIT: &'static Range = &closed(-1.0, 1.0);
    /// A relative tolerance.
    pub const TOLERANCE: &'static Range = &closed(1e-16, 1.0);
    /// A number of multiply-adds.
    pub const WORK: &'static Range = &closed(1.0, 1e15);
    /// A number of iterations.
    pub const ITERATIONS: &'static Range = &closed(1.0, 1e6);
    /// A number of halvings of a step.
    pub const HALVINGS: &'static Range = &closed(0.0, 10.0);
    /// Cells along one edge.
    pub const CELLS: &'static Range = &closed(1.0, 400.0);
    /// A number of tetrahedra asked for.
    pub const TETS: &'static Range = &closed(20.0, 200_000.0);
    /// Fineness of a graded mesh.
    pub const DETAIL: &'static Range = &closed(DETAILS[0], DETAILS[1]);
    /// The version of the format.
    pub const VERSION: &'static Range = &closed(1.0, 1.0);
    /// A field of view \[degrees\].
    pub const FOV_DEG: &'static Range = &closed(1.0, 170.0);
    /// A contact margin \[m\].
    pub const MARGIN: &'static Range = &closed(0.0, 0.1);
    /// A stiffness, a damping or a frequency.
    pub const SPRING: &'static Range = &closed(0.0, 1e15);
    /// A factor on coordinates.
    pub const SCALE: &'static Range = &closed(1e-6, 1e6);
    /// A moment of inertia \[kg m²\]; products may be negative.
    pub const INERTIA: &'static Range = &closed(-1e9, 1e9);
    /// A part of a cell.
    pub const JITTER: &'static Range = &closed(0.0, 0.15);
    /// A radius that may be zero \[m\].
    pub const CORE: &'static Range = &closed(0.0, 100.0);
    /// Subdivision of an icosahedron's edges.
    pub const FREQUENCY: &'static Range = &closed(1.0, 200.0);
    /// Cells of a distance grid.
    pub const GRID: &'static Range = &closed(4.0, 256.0);
    /// A ratio of sizes.
    pub const GRADING: &'static Range = &closed(0.01, 100.0);
    /// The length of a hand \[m\].
    pub const HAND_LENGTH: &'static Range = &closed(LENGTHS[0], LENGTHS[1]);
    /// Time between random draws \[s\].
    pub const INTERVAL: &'static Range = &closed(1e-4, 1e3);
    /// A force, torque, traction or pressure.
    pub const LOAD: &'static Range = &closed(-1e12, 1e12);
    /// An index or a seed.
    pub const INDEX: &'static Range = &closed(0.0, 4_294_967_295.0);

    /// True when `x` is finite and inside.
    pub fn contains(&self, x: f64) -> bool {
        let above = if self.open_min { x > self.min } else { x >= self.min };
        let below = if self.open_max { x < self.max } else { x <= self.max };
        x.is_finite() && above && below
    }

    /// For example ` > 0` or ` from 0.0001 to 100`; empty for any number.
    pub fn words(&self) -> String {
        let (min, max) = (self.min, self.max);
        match (min.is_finite(), max.is_finite()) {
            (false, false) => String::new(),
            (true, false) => format!(" {} {}", if self.open_min { ">" } else { ">=" }, plain(min)),
            (false, true) => format!(" {} {}", if self.open_max { "<" } else { "<=" }, plain(max)),
            (true, true) if self.open_min || self.open_max => {
                format!(" between {min} and {max}, both excluded")
            }
            (true, true) => format!(" from {} to {}", plain(min), plain(max)),
        }
    }
}
