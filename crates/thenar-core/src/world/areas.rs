//! Over what area contacts touch at the end of a step.

use crate::world::World;

impl World {
    /// Gives each contact its area, with bodies where they are now.
    pub(super) fn measure_areas(&mut self) {
        let Self { state, scratch, detector, places, .. } = self;
        for (place, pose_WB) in places.iter_mut().zip(&state.poses_WB) {
            place.pose_WB = *pose_WB;
        }
        scratch.areas.resize(scratch.contacts.len(), 0.0);
        let found = &scratch.found[..scratch.contacts.len().min(scratch.found.len())];
        let contacts = &scratch.contacts;
        let force_W = |i: usize| contacts[i].force_W;
        detector.areas(places, &scratch.vertices, found, &mut scratch.areas, force_W);
        for (contact, area) in scratch.contacts.iter_mut().zip(&scratch.areas) {
            contact.area = *area;
        }
    }
}
