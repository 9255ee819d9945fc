//! Thenar's detector with two bodies: its narrow phase between rigid shapes, with the search for
//! near pairs before it.

use crate::placements::{Kind, Placement};
use crate::{Engine, MARGIN, Touch};
use std::cell::RefCell;
use std::rc::Rc;
use thenar_core::kernels::{Detector, Reach, RigidPlace, SeenSides, SurfaceState};
use thenar_core::model::{Motion, RigidDesc, WorldDesc};
use thenar_core::{Mat3, Pose, Vec3};

/// The detector's contacts have no public name: two closures share them.
pub struct Ours {
    search: Box<dyn FnMut(usize)>,
    touches: Box<dyn Fn(usize) -> Vec<Touch>>,
}

impl Ours {
    pub fn new(kind: &Kind, placements: &[Placement]) -> Self {
        let body = |i: usize, motion: Motion| RigidDesc {
            name: i.to_string(),
            motion,
            mass: 0.01,
            inertia: Mat3::identity() * 1e-6,
            pose_WB: Pose::identity(),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
            shape: Some(kind.shapes[i].clone()),
            pose_BS: Pose::identity(),
            friction: 0.5,
        };
        let rigids = vec![body(0, Motion::Dynamic), body(1, Motion::Prescribed)];
        let mut detector = Detector::new(&WorldDesc { rigids, ..WorldDesc::default() });
        let still = |pose_WB: Pose| RigidPlace {
            pose_WB,
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        };
        let places: Vec<_> = placements.iter().map(|p| p.poses.map(|q| q.map(still))).collect();
        let room = |_| Vec::with_capacity(detector.capacity());
        let found = Rc::new(RefCell::new(placements.iter().map(room).collect::<Vec<_>>()));
        let filled = Rc::clone(&found);
        let [before, mut now] = [(); 2].map(|()| SeenSides::with_capacity(0));
        let search = move |moved: usize| {
            let reach = Reach { h: 0.0, margin: MARGIN };
            for (places, found) in places.iter().zip(filled.borrow_mut().iter_mut()) {
                let none = SurfaceState { positions: &[], velocities: &[] };
                detector.find(reach, &places[moved], none, &before, &mut now, found);
            }
        };
        let touches = move |i: usize| {
            let touch = |at: Vec3, normal: Vec3, gap: f64| {
                let half = 0.5 * gap * normal;
                Touch { on_a: at + half, on_b: at - half, normal, gap }
            };
            found.borrow()[i].iter().map(|c| touch(c.position_W, c.normal_W, c.gap)).collect()
        };
        Self { search: Box::new(search), touches: Box::new(touches) }
    }
}

impl Engine for Ours {
    fn name(&self) -> &'static str {
        "Thenar"
    }

    fn search(&mut self, moved: usize, _: bool) {
        (self.search)(moved);
    }

    fn touches(&self, i: usize) -> Vec<Touch> {
        (self.touches)(i)
    }
}
