//! Stance of a hand's pads against each other, whatever there is to grip: at every width that they
//! span.
//!
//! ```text
//!    thumb (or the palm, of a hook)         fingers
//!        point  |>----- width -----<|  point + across · (i - middle)
//!               ------> axis
//! ```

use super::crowd::{Link, links};
use super::hook::{Skin, skin};
use super::kind::GripKind;
use thenar_core::Vec3;
use thenar_core::model::{Digit, HandModel};
use thenar_core::readout::TaxelSkin;
use thenar_track::reach::{Angles, Chain, FREEDOMS_MAX, Goal, PadPlace, solve};

/// Widths are this far apart \[m\].
const STEP: f64 = 5e-3;
/// A width is spanned when the two sides are no farther off their places than this \[m\], what ease
/// and turn bend them by where digits are stretched, and no single finger than that: people's outer
/// fingers do not lie in line either.
const MISS_MAX: [f64; 2] = [8e-3, 15e-3];
/// Largest angle between facing pads \[rad\]: skin on dry, smooth things slips beyond about 40° to
/// either side.
const FACING_MAX: f64 = 1.45;
/// Widest that is tried \[m\].
const WIDTH_MAX: f64 = 0.25;
/// Width from which on the line between pads counts as much as each normal \[m\].
const READY: f64 = 0.03;
/// Rounds in which the two sides find each other.
const ROUNDS: usize = 60;
/// Most pads of a grip.
pub const PADS_MAX: usize = 5;

/// Part of the hand that opposes the fingers.
#[derive(Clone, Debug)]
pub enum Base {
    /// The thumb.
    Thumb(Box<Chain>),
    /// The palm below the knuckles: place \[m\] and direction out of its skin, in its own frame.
    Palm(Vec3, Vec3),
}

/// The pads of one kind of grip.
#[derive(Clone, Debug)]
pub struct Opposition {
    /// Kind of grip.
    pub kind: GripKind,
    /// Part of the hand that opposes the fingers.
    pub base: Base,
    /// Fingers, from the index finger outwards.
    pub fingers: Vec<Chain>,
    /// Skin of the fingers of a hook, in their order.
    pub skins: Vec<Skin>,
    /// Bones before the pads of a tripod, in the order of its fingers; none in the other kinds.
    pub links: Vec<Vec<Link>>,
    /// Distance of neighbouring fingers \[m\].
    pub spacing: f64,
    /// Stances of the pads, by rising width; at least one.
    pub spans: Vec<Span>,
}

/// Stance of the pads at one width, in the palm's frame.
#[derive(Clone, Copy, Debug)]
pub struct Span {
    /// Distance of the two sides \[m\].
    pub width: f64,
    /// The base's pad.
    pub base: Vec3,
    /// The fingers' pads, their middle.
    pub fingers: Vec3,
    /// From the base to the fingers.
    pub axis: Vec3,
    /// From the index finger to the next, at right angles to the axis.
    pub across: Vec3,
    /// Angles of the base, then of each finger.
    pub angles: [Angles; PADS_MAX],
}

impl Opposition {
    /// The pads of a hand for a kind; why not, where it lacks them.
    ///
    /// # Errors
    /// Names the digit that is missing.
    pub fn new(hand: &HandModel, kind: GripKind) -> Result<Self, String> {
        let missing = |digit: Digit| {
            format!("a {} needs the {} finger, which the hand lacks", kind.name(), digit.name())
        };
        let base = match kind.has_thumb() {
            true => Chain::new(hand, Digit::Thumb, PadPlace::Tip)
                .map(|thumb| Base::Thumb(Box::new(thumb)))
                .ok_or_else(|| format!("a {} needs a thumb, which the hand lacks", kind.name()))?,
            false => palm(hand).ok_or_else(|| missing(Digit::Index))?,
        };
        let mut fingers = Vec::new();
        for digit in kind.fingers() {
            fingers.push(Chain::new(hand, *digit, kind.place()).ok_or_else(|| missing(*digit))?);
        }
        let (first, last) = (knuckle(hand, Digit::Index), knuckle(hand, Digit::Little));
        let (Some(first), Some(last)) = (first, last) else { return Err(missing(Digit::Little)) };
        let spacing = (last - first).norm() / 3.0;
        let skins: Vec<Skin> = match kind {
            GripKind::Hook => fingers.iter().filter_map(|chain| skin(hand, chain)).collect(),
            _ => Vec::new(),
        };
        if kind == GripKind::Hook && skins.len() < fingers.len() {
            return Err("a hook needs fingers whose three joints bend".into());
        }
        let links = match kind {
            GripKind::Tripod => fingers.iter().map(|chain| links(hand, chain)).collect(),
            _ => Vec::new(),
        };
        let spans = Vec::new();
        let mut opposition = Self { kind, base, fingers, skins, links, spacing, spans };
        opposition.span(&(last - first));
        match opposition.spans.is_empty() {
            true => Err(format!("the pads of a {} do not meet on this hand", kind.name())),
            false => Ok(opposition),
        }
    }

    /// Angles at which pads of a kind press into each other by `depth` \[m\] where nothing is
    /// between them: joint of the hand, which of its angles, and the angle \[rad\].
    pub fn pressed(
        hand: &HandModel,
        kind: GripKind,
        depth: f64,
    ) -> Option<Vec<(usize, usize, f64)>> {
        let opposition = Self::new(hand, kind).ok()?;
        let mut angles = opposition.spans[0].angles;
        let (first, last) = (knuckle(hand, Digit::Index)?, knuckle(hand, Digit::Little)?);
        opposition.stand(-depth, &mut angles, &(last - first))?;
        let chains = (0..opposition.pads()).filter_map(|pad| Some((pad, opposition.chain(pad)?)));
        let own = chains.flat_map(|(pad, chain)| {
            let freedoms = chain.freedoms.iter().enumerate();
            freedoms.map(move |(k, freedom)| (freedom.joint, freedom.axis, angles[pad][k]))
        });
        Some(own.collect())
    }

    /// Returns the number of pads, the base's included.
    pub fn pads(&self) -> usize {
        self.fingers.len() + 1
    }

    /// The chain of a pad: 0 is the thumb, or of a hook none.
    pub fn chain(&self, pad: usize) -> Option<&Chain> {
        match (&self.base, pad) {
            (Base::Thumb(thumb), 0) => Some(thumb),
            (Base::Palm(..), 0) => None,
            _ => self.fingers.get(pad - 1),
        }
    }

    /// The largest width that its pads span \[m\].
    pub fn opening(&self) -> f64 {
        self.spans.last().map_or(0.0, |span| span.width)
    }

    /// Returns the stance of the pads at the width nearest to this one.
    pub fn at(&self, width: f64) -> &Span {
        let first = self.spans[0].width;
        let k = (((width - first) / STEP).round().max(0.0) as usize).min(self.spans.len() - 1);
        &self.spans[k]
    }

    /// Offset of finger `i` from the fingers' middle, along `across` \[m\].
    pub fn offset(&self, i: usize) -> f64 {
        self.spacing * (i as f64 - 0.5 * (self.fingers.len() as f64 - 1.0))
    }

    /// Sense about the line from base to fingers in which the row of fingers turns when the little
    /// finger goes to the palm's side: 1 in a right hand, -1 in a left one, its mirror image.
    pub fn turn(&self) -> f64 {
        let span = &self.spans[0];
        -span.axis.cross(&span.across).y.signum()
    }

    /// Names of what opposes and of the fingers, for messages.
    pub fn sides(&self) -> [&'static str; 2] {
        let base = if self.kind.has_thumb() { "thumb" } else { "palm" };
        let fingers = if self.fingers.len() == 1 { "index" } else { "fingers" };
        [base, fingers]
    }

    fn span(&mut self, knuckles: &Vec3) {
        let mut angles = [[0.0; FREEDOMS_MAX]; PADS_MAX];
        for (pad, angles) in angles.iter_mut().enumerate().take(self.pads()) {
            *angles = self.chain(pad).map_or([0.0; FREEDOMS_MAX], Chain::ease);
        }
        let mut width = 0.0;
        while width <= WIDTH_MAX {
            match self.stand(width, &mut angles, knuckles) {
                Some(span) => self.spans.push(span),
                // Many fingers do not meet the thumb in one place.
                None if self.spans.is_empty() => {}
                None => break,
            }
            width += STEP;
        }
    }

    /// Centre, normal and radius of the base's pad.
    fn base_at(&self, angles: &Angles) -> (Vec3, Vec3, f64) {
        match &self.base {
            Base::Thumb(thumb) => {
                let reached = thumb.reach(angles);
                (reached.centre, reached.normal, thumb.pad.radius)
            }
            Base::Palm(point, normal) => (*point, *normal, 0.0),
        }
    }

    /// Lets the pads find their stand at a width, from `angles`; `None` where they do not.
    fn stand(&self, width: f64, angles: &mut [Angles; PADS_MAX], knuckles: &Vec3) -> Option<Span> {
        let count = self.fingers.len() as f64;
        let mut found = None;
        for _ in 0..ROUNDS {
            let (base, normal, radius) = self.base_at(&angles[0]);
            let mut radius_far = 0.0;
            let mut fingers = Vec3::zeros();
            let mut axis = normal;
            for (finger, angles) in self.fingers.iter().zip(&angles[1..]) {
                let reached = finger.reach(angles);
                fingers += reached.centre / count;
                radius_far += finger.pad.radius / count;
                axis -= reached.normal / count;
            }
            // Far apart the line between the pads says more than how they are turned.
            let line = (fingers - base).try_normalize(1e-3).unwrap_or(axis);
            let axis = match &self.base {
                Base::Thumb(_) => (axis + line * (width / READY)).try_normalize(1e-9)?,
                Base::Palm(_, normal) => *normal,
            };
            let across = (knuckles - axis * axis.dot(knuckles)).try_normalize(1e-9)?;
            // The fingers' middle over the base's pad, or both meet half way.
            let start = match &self.base {
                Base::Thumb(_) => (base + fingers + axis * (radius - radius_far - width)) * 0.5,
                Base::Palm(point, _) => *point,
            };
            let end = start + axis * width;
            let (mut misses, mut facing) = ([0.0f64; 2], 0.0f64);
            if let Base::Thumb(thumb) = &self.base {
                let goal = Goal { centre: start - axis * thumb.pad.radius, normal: axis };
                misses[0] = solve(thumb, &thumb.ease(), &mut angles[0], &goal, 3);
                facing = thumb.reach(&angles[0]).normal.angle(&axis);
            }
            let mut mean = Vec3::zeros();
            for (i, finger) in self.fingers.iter().enumerate() {
                let place = end + across * self.offset(i);
                let goal = Goal { centre: place + axis * finger.pad.radius, normal: -axis };
                misses[1] =
                    misses[1].max(solve(finger, &finger.ease(), &mut angles[i + 1], &goal, 3));
                let reached = finger.reach(&angles[i + 1]);
                mean += (goal.centre - reached.centre) / count;
                facing = facing.max(reached.normal.angle(&-axis));
            }
            misses[0] = misses[0].max(mean.norm());
            let span = Span { width, base: start, fingers: end, axis, across, angles: *angles };
            found = Some((misses, facing, span));
        }
        let (misses, facing, span) = found?;
        let fits = misses[0] < MISS_MAX[0] && misses[1] < MISS_MAX[1] && facing < FACING_MAX;
        fits.then_some(span)
    }
}

/// A knuckle at rest, in the palm's frame \[m\].
fn knuckle(hand: &HandModel, digit: Digit) -> Option<Vec3> {
    let first = hand.bones.iter().position(|bone| bone.digit == digit)?;
    Some(hand.joints.get(first.checked_sub(1)?)?.pose_PJ.position)
}

/// Part of the way from the wrist to the knuckles at which the palm opposes bent fingers.
const PALM_ALONG: f64 = 0.75;

fn palm(hand: &HandModel) -> Option<Base> {
    let fingers = &Digit::FINGERS[1..];
    let knuckles: Vec<Vec3> = fingers.iter().filter_map(|digit| knuckle(hand, *digit)).collect();
    let middle = knuckles.iter().sum::<Vec3>() / knuckles.len().max(1) as f64;
    let bone = hand.bones.first()?;
    let on_axis = bone.ends_B[0] + (middle - bone.ends_B[0]) * PALM_ALONG;
    let normal = -Vec3::y();
    let skin = TaxelSkin::new(&hand.flesh, Vec::new());
    let way = skin.way(&bone.pose_MB.point(&on_axis), &bone.pose_MB.vector(&normal));
    (!knuckles.is_empty())
        .then(|| Base::Palm(on_axis + normal * way.unwrap_or(bone.radius), normal))
}
