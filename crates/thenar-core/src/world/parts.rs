//! A step that contact does not carry through is made in parts.
//!
//! Contact of a step is linear: planes where surfaces are met at its start, moved by velocities of
//! its end. Bodies that turn, or flesh that folds, by more than that within the step end it in an
//! overlap of which no row spoke. And some steps change so much that the solver does not meet the
//! law of contact. Such a step is taken back and made in halves, each linear about a start of its
//! own, and these again where need be. After a part that went well the next is twice as long again
//! where the halving allows, and the shortest is made once more with contact that looks as far as
//! anything went in it, so that what happens once costs little.

use crate::contact::{Displacements, KnownDepths, Site, SurfaceState};
use crate::math::Vec3;
use crate::model::SolverKind;
use crate::solver::Failure;
use crate::world::{StepReport, World, push_out};

/// Half of what a step looks ahead for: overlaps that grow by more than this part of the contact
/// margin were not foreseen. Those that were there before no halving mends.
const UNFORESEEN: f64 = 0.5;
/// An error of this many tolerances is no rounding of the answer: at the default tolerance 1 mm/s,
/// which in the longest usual step of 16.7 ms moves a point by a sixtieth of the contact margin.
const MISS: f64 = 100.0;

/// Farthest that contact looks when it looks again, in margins: two fingers' widths; beyond, all of
/// a hand would be met.
const REACH_MAX: f64 = 32.0;

/// Most halvings for the sake of elements that are asked one by one. Each part may let in as much
/// energy as the motion within it, so that many short ones together let in a burst: an element of
/// Ogden's law drawn out threefold came to seven times its energy in parts of a thirty-second. What
/// is unforeseen in an eighth is cut short.
const FLESH_HALVINGS_MAX: u32 = 3;

/// Most halvings of a step: it then has a thousand parts, and is made three thousand times at most.
pub const HALVINGS_MAX: u32 = 10;

/// A part of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepPart {
    /// Length \[s\].
    pub h: f64,
    /// Time from the end of the part to that of the step \[s\].
    pub left: f64,
    /// Contact looks so far at least \[m\].
    pub reach: f64,
}

/// The parts of one step, one after the other: counted in units of the shortest.
#[derive(Clone, Copy, Debug)]
pub struct StepParts {
    /// The step \[s\].
    h: f64,
    units: u32,
    done: u32,
    length: u32,
    reach: f64,
    /// Number of times that a part was taken back: at most twice for each of the shortest, so that
    /// a step costs three times these.
    retries: u32,
}

impl StepParts {
    /// One part, the whole step.
    pub fn whole(h: f64, halvings_max: u32) -> Self {
        let units = 1 << halvings_max.min(HALVINGS_MAX);
        Self { h, units, done: 0, length: units, reach: 0.0, retries: 0 }
    }

    /// The part to be made; `None` when the step is done.
    pub fn next(&self) -> Option<StepPart> {
        let time = |units: u32| self.h * (f64::from(units) / f64::from(self.units));
        let left = self.units - self.done;
        (left > 0).then(|| StepPart {
            h: time(self.length),
            left: time(left - self.length),
            reach: self.reach,
        })
    }

    /// Makes the part to be made once more: half as long, or, when that is not to be, with contact
    /// that looks as far as anything went in the attempt before. False when it was that already, or
    /// retries run out.
    pub fn retry(&mut self, travel: f64) -> bool {
        if self.units == 1 || self.retries == 2 * self.units {
            return false;
        }
        self.retries += 1;
        if self.length > 1 {
            self.length /= 2;
            return true;
        }
        std::mem::replace(&mut self.reach, travel) == 0.0 && travel > 0.0
    }

    /// Makes it once more for what elements did that are asked one by one, which neither parts
    /// below an eighth of the step mend nor contact that looks farther. False when it is as short,
    /// or retries run out.
    pub fn retry_flesh(&mut self) -> bool {
        self.length > self.units >> FLESH_HALVINGS_MAX && self.retry(0.0)
    }

    /// The part is done. The next is twice as long where halving the step has such a part here.
    pub fn accept(&mut self) {
        self.done += self.length;
        self.reach = 0.0;
        if self.done.is_multiple_of(2 * self.length) {
            self.length = (2 * self.length).min(self.units - self.done);
        }
    }
}

impl World {
    /// True when contact carried the part just made through. Looks for overlaps, and reports them,
    /// only where something was near and has moved far enough to make one.
    pub(super) fn was_carried(&mut self, report: &mut StepReport) -> bool {
        if report.non_finite {
            return true;
        }
        let settings = &self.desc.solver;
        let monolithic = settings.kind == SolverKind::Monolithic;
        let missed = monolithic && report.contact_residual > MISS * settings.velocity_tolerance;
        // What was cut short is not made better by more of it.
        let missed = missed && !self.solver.was_cut_short();
        let unforeseen = UNFORESEEN * push_out::margin(settings);
        // No halving makes room for contacts: a crowd that is too large for a step is as much so
        // for its parts.
        let crowded = matches!(report.failure, Some(Failure::TooManyContacts { .. }));
        // Two bodies come together by the travel of both. What is thinner than that may have come
        // through something that contact did not find.
        let (past, thinnest) = (2.0 * self.travel(), self.detector.thinnest());
        let was_near = !self.scratch.found.is_empty() || past > thinnest;
        if !was_near || past <= unforeseen.min(0.5 * thinnest) {
            return crowded || !missed;
        }
        let depth = self.deepening(unforeseen);
        report.penetration_max = report.penetration_max.max(depth);
        crowded || !missed && depth == 0.0
    }

    /// Returns the distance for contact to look in another attempt at the part just made \[m\].
    pub(super) fn reach(&self) -> f64 {
        self.travel().min(REACH_MAX * push_out::margin(&self.desc.solver))
    }

    /// Returns the largest distance that anything has moved since the start of the part \[m\]; a
    /// plane that tilts does not count.
    fn travel(&self) -> f64 {
        let Self { state, scratch, detector, .. } = self;
        let before = &scratch.before;
        let nodes = state.x.iter().zip(&before.x).map(|(x, x0)| (x - x0).norm_squared());
        let poses = state.poses_WB.iter().zip(&before.poses_WB).enumerate();
        let bodies = poses.map(|(b, (pose, pose0))| {
            let turn = pose.rotation.angle_to(&pose0.rotation);
            (pose.position - pose0.position).norm() + turn * detector.radius(b)
        });
        bodies.fold(nodes.fold(0.0, f64::max).sqrt(), f64::max)
    }

    /// Deepest overlap now \[m\], of pairs that are deeper by more than `slack` than one of their
    /// bodies was anywhere at the start of the part.
    fn deepening(&mut self, slack: f64) -> f64 {
        // The vertices are those of the start of the part.
        let Self { scratch, model, state, .. } = self;
        for ((x, way), vertex) in
            scratch.vertices.iter_mut().zip(&mut scratch.vertex_ways).zip(&model.vertices)
        {
            let now = vertex.of(&state.x);
            *way = now - std::mem::replace(x, now);
        }
        let Self { state, scratch, detector, places, .. } = self;
        let (rigids, softs) = scratch.depths.split_at_mut(places.len());
        rigids.fill(0.0);
        softs.fill(0.0);
        for contact in &scratch.found {
            for site in [&contact.a, &contact.b] {
                let depth = match site {
                    Site::Rigid { body, .. } => &mut rigids[*body as usize],
                    Site::Soft(point) => &mut softs[point.soft as usize],
                };
                *depth = depth.max(-contact.gap);
            }
        }
        for (place, pose_WB) in places.iter_mut().zip(&state.poses_WB) {
            place.pose_WB = *pose_WB;
            place.velocity_W = Vec3::zeros();
            place.angular_velocity_W = Vec3::zeros();
        }
        scratch.vertex_velocities.fill(Vec3::zeros());
        let surfaces =
            SurfaceState { positions: &scratch.vertices, velocities: &scratch.vertex_velocities };
        let moved =
            Displacements { poses_WB: &scratch.before.poses_WB, vertices: &scratch.vertex_ways };
        let known = KnownDepths { rigids, softs, slack };
        detector.deepening(places, surfaces, &scratch.sides, known, moved)
    }

    /// Scales the impulses that contact and limits remember of the last step to one of another
    /// length.
    pub(super) fn remember_for(&mut self, h: f64, h_new: f64) {
        if h != h_new {
            self.state.scale_impulses(h_new / h);
        }
    }
}

impl StepReport {
    /// Adds the parts before to the report of this one.
    pub(super) fn after(mut self, parts: &Self) -> Self {
        self.failure = parts.failure.or(self.failure);
        self.fell_back |= parts.fell_back;
        self.cg_iterations += parts.cg_iterations;
        self.cg_residual = self.cg_residual.max(parts.cg_residual);
        self.contact_sweeps += parts.contact_sweeps;
        self.contact_residual = self.contact_residual.max(parts.contact_residual);
        self.contact_unconverged |= parts.contact_unconverged;
        self.contacts_dropped = self.contacts_dropped.max(parts.contacts_dropped);
        self.penetration_max = self.penetration_max.max(parts.penetration_max);
        self.inverted_tets = self.inverted_tets.max(parts.inverted_tets);
        self.non_finite |= parts.non_finite;
        self.taken_back &= parts.parts == 0 || parts.taken_back;
        self.parts += parts.parts;
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The lengths of the parts, in eighths, when those go well of which their begin and length say
    /// so.
    fn lengths(goes_well: impl Fn(u32, u32) -> bool) -> Vec<u32> {
        let mut parts = StepParts::whole(0.8, 3);
        let (mut made, mut begin) = (Vec::new(), 0);
        while let Some(part) = parts.next() {
            let length = (part.h * 10.0).round() as u32;
            assert!((part.left - 0.1 * f64::from(8 - begin - length)).abs() < 1e-15);
            if !goes_well(begin, length) && parts.retry(0.0) {
                continue;
            }
            parts.accept();
            made.push(length);
            begin += length;
        }
        assert_eq!(begin, 8);
        made
    }

    /// Flesh alone has no part shorter than an eighth of the step; none is made twice at that
    /// length.
    #[test]
    fn flesh_halves_a_step_three_times_at_most() {
        for (halvings, shortest) in [(0, 1.0), (2, 0.25), (3, 0.125), (5, 0.125), (10, 0.125)] {
            let mut parts = StepParts::whole(1.0, halvings);
            while parts.retry_flesh() {}
            assert_eq!(parts.next().map(|part| part.h), Some(shortest), "{halvings} halvings");
        }
    }

    #[test]
    fn parts_make_the_step_by_halving_only_where_need_be() {
        assert_eq!(lengths(|_, _| true), [8]);
        assert_eq!(lengths(|_, length| length <= 4), [4, 4]);
        assert_eq!(lengths(|_, _| false), [1; 8]);
        // What goes wrong at one place costs small parts there alone.
        let well =
            |at: u32| move |begin, length| length == 1 || !(begin..begin + length).contains(&at);
        assert_eq!(lengths(well(0)), [1, 1, 2, 4]);
        assert_eq!(lengths(well(3)), [2, 1, 1, 2, 2]);
        assert_eq!(lengths(well(7)), [4, 2, 1, 1]);
    }
}
