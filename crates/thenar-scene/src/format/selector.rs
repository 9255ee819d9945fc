//! Selectors of nodes, faces or elements of a soft body.

use crate::math::Vec3;
use crate::text::{table, words};

words! {
    /// A side of the rest shape's bounding box.
    pub enum SideWord {
        /// Smallest x.
        "x-min" => XMin,
        /// Largest x.
        "x-max" => XMax,
        /// Smallest y.
        "y-min" => YMin,
        /// Largest y.
        "y-max" => YMax,
        /// Smallest z.
        "z-min" => ZMin,
        /// Largest z.
        "z-max" => ZMax,
    }
}

table! {
    /// A spherical shell.
    pub struct Shell {
        /// Centre of the shell, model frame [m]. Default [0, 0, 0].
        centre: Vec3 where PLACE = Vec3::zeros();
        /// Inner radius [m]. Default 0.
        radius_min: f64 where PLACE = 0.0;
        /// Outer radius [m].
        radius_max: f64 where PLACE;
    }
}

table! {
    /// Nodes, boundary faces (by all three nodes) or elements (by centre) of a soft body at
    /// rest, in its model frame. What is meant fulfils every condition given; with none, all.
    pub struct Selector {
        /// On this side of the bounding box.
        side: Option<SideWord>;
        /// Not below this corner [m].
        box_min: Option<Vec3> where PLACE;
        /// Not above this corner [m].
        box_max: Option<Vec3> where PLACE;
        /// Within this shell.
        shell: Option<Shell>;
        /// On the boundary of the body (true) or inside it (false).
        boundary: Option<bool>;
        /// With one of these indices.
        indices: Option<Vec<u32>> where INDEX;
        /// Nearest to this point, one only [m].
        nearest: Option<Vec3> where PLACE;
        /// Distance from a side or box up to which a node counts [m]. Default 1e-6.
        tolerance: f64 where PLACE = 1e-6;
    }
}
