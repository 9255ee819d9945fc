//! The view for pictures.

use crate::math::Vec3;
use crate::text::table;

table! {
    /// Viewpoint of a picture.
    pub struct Camera {
        /// The eye, world [m].
        position: Vec3 where PLACE;
        /// Point that the eye looks at, world [m].
        target: Vec3 where PLACE;
        /// Direction that is up in the picture. Default [0, 1, 0].
        up: Vec3 where PLACE = Vec3::y();
        /// Vertical field of view [degrees]. Default 35.
        fov_deg: f64 where FOV_DEG = 35.0;
    }
}
