//! Grips of hands.

use crate::text::{Located, table, words};

words! {
    /// Kind of grip on an object.
    pub enum GripWord {
        /// Pads of thumb and index finger.
        "pinch" => Pinch,
        /// The thumb's pad against those of index and middle finger.
        "tripod" => Tripod,
        /// The thumb's pad against those of all fingers.
        "power" => Power,
        /// All fingers bent around a handle, which hangs in them.
        "hook" => Hook,
        /// The thumb's pad on the side of the index finger.
        "lateral" => Lateral,
    }
}

table! {
    /// A grip: pads find places on the object, close on it, press with a force and hold it.
    pub struct GripTable {
        /// The rigid or soft body, which a hook needs. Left out, the pads press against each other.
        object: Option<Located<String>>;
        /// "pinch": pads of thumb and index finger; "tripod": and of the middle finger; "power":
        /// the thumb against all fingers; "hook": all fingers bent around a handle; "lateral": the
        /// thumb on the side of the index finger.
        kind: GripWord;
        /// Force of the two sides against each other [N]: half of the sum of the normal forces of
        /// the pads. Default: twice what keeps the object from slipping, m g / (2 friction), then
        /// as load asks; of a hook m g / 2; without an object 1.
        force: Option<f64> where GRIP_FORCE;
        /// Time at which the fingers set out [s].
        at: f64 where DURATION;
        /// Time at which they open [s]. Default: never.
        open: Option<f64> where DURATION;
    }
}
