//! The file as a whole.

use super::{Camera, Figure, Hand, Joint, Load, PairFriction, Probe, Rigid, Soft, SolverTable};
use crate::math::Vec3;
use crate::text::{Located, table};

table! {
    /// A scene: what exists, what acts on it, and what is measured.
    pub struct Scene {
        /// Version of the format: 1.
        version: u32 where VERSION;
        /// One line that says what is to be seen.
        title: Option<String>;
        /// More words.
        description: Option<String>;
        /// Gravity, world [m/s²]. Default [0, -9.81, 0].
        gravity: Vec3 where GRAVITY = Vec3::new(0.0, -9.81, 0.0);
        /// Time step [s]. Default 0.001.
        time_step: f64 where TIME_STEP = 1e-3;
        /// Simulated time of a run [s]. Default 1.
        duration: f64 where DURATION = 1.0;
        /// Time between rows of the probe table [s]; rows fall on the nearest step. Default: every
        /// step.
        probe_interval: Option<f64> where DURATION;
        /// Solver settings.
        solver: Option<SolverTable>;
        /// Viewpoint of pictures.
        camera: Option<Camera>;
        /// The hands.
        hand: Vec<Hand>;
        /// Other jointed bodies of flesh.
        figure: Vec<Figure>;
        /// Rigid bodies.
        rigid: Vec<Rigid>;
        /// Joints between rigid bodies.
        joint: Vec<Joint>;
        /// Soft bodies.
        soft: Vec<Soft>;
        /// Forces, torques, tractions and pressures.
        load: Vec<Load>;
        /// Contact settings of pairs of bodies.
        pair: Vec<Pair>;
        /// Quantities to measure.
        probe: Vec<Probe>;
    }
}

table! {
    /// Contact between two bodies, where it differs from the default: Coulomb friction with the
    /// geometric mean of the two coefficients.
    pub struct Pair {
        /// The two bodies' names. A hand's name stands for its flesh.
        bodies: [Located<String>; 2];
        /// Coulomb friction coefficient of this pair, or the name of a shipped table of skin on a
        /// material, by load as in `friction_by_load`.
        friction: Option<PairFriction> where FRICTION;
        /// Instead of `friction`: coefficients that depend on load, as [load [N], coefficient], by
        /// rising load; straight lines between, constant outside. The load is the sum of the normal
        /// forces of the whole patch in the step before: between the two bodies, or, of a hand,
        /// between one finger (or the palm) and the other body.
        friction_by_load: Option<Located<Vec<[f64; 2]>>> where PRESSING;
        /// False lets the two pass through each other. Default true.
        contact: bool = true;
    }
}
