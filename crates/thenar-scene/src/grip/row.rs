//! Places of fingers beside each other on what the thumb is opposite to.
//!
//! ```text
//!   in line: as far apart as knuckles are        gathered: each beside the next, around what bends away
//!      o    o    o    o                                 o  o  o  o
//!   ___|____|____|____|___                              \ (    ) /
//! ```
//!
//! Fingers stand in line where the surface goes on, in a row that is turned where the object is
//! narrow. Where it does not go on for all of them, they gather as those of a person do who holds a
//! small ball: each pad lies beside the next as near as fingers get, around the surface as far as
//! it bends away.

use super::opposition::{Opposition, PADS_MAX};
use super::surface::{Sample, nearest};
use thenar_core::model::BodyId;
use thenar_core::{Vec3, World};

/// A finger in line has a place of its own where the surface goes on: no farther off than this, as
/// part of the distance of fingers.
const BESIDE: f64 = 0.6;
/// Least cosine between the normal at a place in line and the line from the thumb: 60°.
const FACES: f64 = 0.5;
/// Least cosine of a finger that gathers: 75°. It presses half way between the line and its normal,
/// 38° off that, the cone of friction of dry skin.
const GATHERS: f64 = 0.26;
/// Turns of the row of fingers that are tried \[degrees\], first those that take the little finger
/// to the palm's side, with either hand: along a thing that is too narrow across.
const TURNS_DEG: [f64; 5] = [0.0, 35.0, -35.0, 70.0, -70.0];
/// The surface goes on where it does so for this part of a pad's radius.
const EDGE: f64 = 0.25;
/// Times that a step along the surface is made as long as fingers are apart.
const STEPS: usize = 4;
/// Error of the length of a step that is accepted, as part of it.
const STEP_ERROR: f64 = 0.1;

/// Ground of the fingers: a place in their middle, and the line to it from the thumb.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// Pads of the grip, and their stances.
    pub opposition: &'a Opposition,
    /// World that has the object.
    pub world: &'a World,
    /// The object.
    pub object: BodyId,
    /// Opposite to the thumb.
    pub middle: Sample,
    /// From the thumb to there.
    pub way: Vec3,
}

impl Ground<'_> {
    /// Places of the fingers, the row along `across_W` where that is possible.
    pub fn row(&self, across_W: &Vec3) -> [Option<Sample>; PADS_MAX] {
        let across = (across_W - self.way * self.way.dot(across_W)).try_normalize(1e-9);
        let across = across.unwrap_or_else(|| self.way.cross(&self.middle.normal.yzx()));
        let count = self.opposition.pads() - 1;
        let found = |places: &[Option<Sample>; PADS_MAX]| places.iter().flatten().count();
        let mut most = [None; PADS_MAX];
        for turn_deg in TURNS_DEG {
            let (sin, cos) = f64::to_radians(turn_deg).sin_cos();
            let across = across * cos + self.way.cross(&across) * (self.opposition.turn() * sin);
            let mut places = [None; PADS_MAX];
            for (i, place) in places.iter_mut().enumerate().take(count) {
                *place = self.in_line(&across, i);
            }
            if found(&places) > found(&most) {
                most = places;
            }
            if found(&most) == count {
                return most;
            }
        }
        let gathered = self.gathered(&across, count);
        if found(&gathered) > found(&most) {
            most = gathered;
        }
        // On the narrowest things one finger presses.
        if found(&most) == 0 {
            most[0] = Some(self.middle);
        }
        most
    }

    /// Place of finger `i` beside the fingers' middle; `None` where the surface does not go on.
    fn in_line(&self, across: &Vec3, i: usize) -> Option<Sample> {
        let offset = self.opposition.offset(i);
        if offset == 0.0 {
            return Some(self.middle);
        }
        let wanted = self.middle.point + across * offset;
        let found = nearest(self.world, self.object, &wanted)?;
        let near = (found.point - wanted).norm() < BESIDE * self.opposition.spacing;
        let faces = near && found.normal.dot(&self.way) > FACES;
        (faces && self.goes_on(&found, &(across * offset), i)).then_some(found)
    }

    /// Places of fingers that gather, from the middle outwards.
    fn gathered(&self, across: &Vec3, count: usize) -> [Option<Sample>; PADS_MAX] {
        let mut places = [None; PADS_MAX];
        let radius = |i: usize| self.opposition.fingers[i].pad.radius;
        for outwards in [1.0, -1.0] {
            let mut last: Option<(usize, Sample)> = None;
            // Fingers on this side of the middle, the inner ones first.
            for k in 0..count {
                let i = if outwards > 0.0 { k } else { count - 1 - k };
                let side = self.opposition.offset(i) * outwards;
                if side < 0.0 {
                    continue;
                }
                let out = across * outwards;
                places[i] = match last {
                    None if side == 0.0 => Some(self.middle),
                    None => self.beside(&self.middle, out, (i, [radius(i); 2]), 0.5),
                    Some((j, from)) => self.beside(&from, out, (i, [radius(j), radius(i)]), 1.0),
                };
                let Some(place) = places[i] else { break };
                last = Some((i, place));
            }
        }
        places
    }

    /// The place of finger `i` along `across` from another at which pads of these radii, or the
    /// part of them that is asked, lie beside each other; `None` where the surface ends before.
    fn beside(
        &self,
        from: &Sample,
        across: Vec3,
        (i, radii): (usize, [f64; 2]),
        part: f64,
    ) -> Option<Sample> {
        let (apart, along_it) = (part * (radii[0] + radii[1]), along(from, &across)?);
        let centre = |at: &Sample, radius: f64| at.point + at.normal * radius;
        let (mut way, mut found) = (apart, None);
        for _ in 0..STEPS {
            let place = nearest(self.world, self.object, &(from.point + along_it * way))?;
            let step = (centre(&place, radii[1]) - centre(from, radii[0])).norm();
            found = ((step / apart - 1.0).abs() < STEP_ERROR).then_some(place);
            if found.is_some() {
                break;
            }
            way *= apart / step.max(0.25 * apart);
        }
        let place = found.filter(|place| place.normal.dot(&self.way) > GATHERS)?;
        self.goes_on(&place, &across, i).then_some(place)
    }

    /// True where the surface goes on beside a place of finger `i`, away from the other fingers: a
    /// pad on an edge slips off it.
    fn goes_on(&self, place: &Sample, across: &Vec3, i: usize) -> bool {
        let Some(along) = along(place, across) else { return false };
        let beyond = place.point + along * (EDGE * self.opposition.fingers[i].pad.radius);
        nearest(self.world, self.object, &beyond)
            .is_some_and(|beyond| beyond.normal.dot(&place.normal) > FACES)
    }
}

/// Along the surface at a place, as near to `across` as that goes.
fn along(at: &Sample, across: &Vec3) -> Option<Vec3> {
    (across - at.normal * at.normal.dot(across)).try_normalize(1e-6)
}
