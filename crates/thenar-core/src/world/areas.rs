//! Over what area contacts touch at the end of a step.

use crate::world::World;
use crate::world::readout::Readout;

impl World {
    /// Gives each contact its area, with bodies where they are now.
    pub(super) fn measure_areas(&mut self) {
        let Self { state, scratch, readout, detector, places, .. } = self;
        let Readout { contacts, sites, vertices, .. } = readout;
        let areas = &mut scratch.areas;
        for (place, pose_WB) in places.iter_mut().zip(&state.poses_WB) {
            place.pose_WB = *pose_WB;
        }
        areas.resize(contacts.len(), 0.0);
        let sites = &sites[..contacts.len().min(sites.len())];
        let force_W = |i: usize| contacts[i].force_W;
        detector.areas(places, vertices, sites, areas, force_W);
        for (contact, area) in contacts.iter_mut().zip(areas.iter()) {
            contact.area = *area;
        }
    }
}
