//! Two rigid bodies: what touches where they are and, after a step, what overlapped on their way.

use crate::contact::collector::{Collector, feature_key};
use crate::contact::deepening::Since;
use crate::contact::manifold::Manifold;
use crate::contact::rigid_body::{Placed, RigidBody};
use crate::contact::rigid_pair::{self, Reach, RigidSide};
use crate::contact::soft_rigid::KEY_RIGID;
use crate::contact::{Contact, Shape, Site};

/// Most looks at two bodies on their way, one a thickness: at 60 steps a second those of a card of
/// 0.4 mm that goes 1.5 m/s. Of a longer way they lie farther apart.
const LOOKS_MAX: f64 = 64.0;

/// Two rigid bodies and their numbers.
pub(super) struct TwoRigid<'a> {
    bodies: [(&'a RigidBody, u32); 2],
    /// Thickness of the thinner one \[m\]; unbounded beside a plane, which nothing comes through.
    thickness: f64,
}

impl<'a> TwoRigid<'a> {
    pub fn new(bodies: [(&'a RigidBody, u32); 2]) -> Self {
        let is_plane = |(body, _): &(&RigidBody, u32)| matches!(body.shape, Shape::HalfSpace);
        let thickness = bodies[0].0.thickness.min(bodies[1].0.thickness);
        let is_bounded = thickness > 0.0 && !bodies.iter().any(is_plane);
        Self { bodies, thickness: if is_bounded { thickness } else { f64::INFINITY } }
    }

    /// Overlaps that are never passed over \[m\]: what lies deeper than half its thickness is
    /// nearer to the far side.
    fn slack(&self) -> f64 {
        0.5 * self.thickness
    }

    /// Returns the distance that the two have moved past each other \[m\], if it suffices for an
    /// overlap that counts.
    pub fn past(&self, since: &Since) -> Option<f64> {
        let past = since.past(self.bodies[0].1, self.bodies[1].1);
        (past > since.known.slack.min(self.slack())).then_some(past)
    }

    /// Delivers the contacts of both at these places.
    pub fn find(
        &self,
        placed: [&Placed; 2],
        reach: Reach,
        friction: f64,
        manifold: &mut Manifold,
        out: &mut Collector,
    ) {
        let [(a, i), (b, j)] = self.bodies;
        let [side_a, side_b] =
            [(a, placed[0]), (b, placed[1])].map(|(body, placed)| RigidSide { body, placed });
        rigid_pair::find(side_a, side_b, reach, manifold);
        for p in manifold.points() {
            let site = |body: u32, placed: &Placed| Site::Rigid {
                body,
                offset_W: p.position_W - placed.center_of_mass,
            };
            let contact = Contact {
                key: feature_key([KEY_RIGID, i, j, p.feature]),
                a: site(i, placed[0]),
                b: site(j, placed[1]),
                position_W: p.position_W,
                normal_W: p.normal_W,
                gap: p.gap,
                friction,
            };
            out.push_within(contact, self.slack());
        }
    }

    /// Measures what overlapped on the way of both, which have moved by `past` \[m\]: of bodies
    /// thinner than that nothing does at its end, if they came through each other.
    pub fn measure_way(
        &self,
        since: &Since,
        past: f64,
        manifold: &mut Manifold,
        out: &mut Collector,
    ) {
        let looks = (past / self.thickness).ceil().min(LOOKS_MAX) as u32;
        for k in 1..looks {
            let s = f64::from(k) / f64::from(looks);
            let [a, b] = self.bodies.map(|(body, i)| body.place(&since.place(i, s), 0.0));
            if a.swept_W.overlaps(&b.swept_W) {
                self.find([&a, &b], Reach { h: 0.0, margin: 0.0 }, 0.0, manifold, out);
            }
        }
    }
}
