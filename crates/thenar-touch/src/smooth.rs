//! Forces without steps where one frame takes over from another.
//!
//! A new frame knows better what the last one could only carry on: it corrects the force of the
//! very next tick, and at 60 frames a second such corrections are felt as ticking. What it
//! corrects, of the force as it went on in the last tick, is kept as an offset and let go
//! exponentially, so that a correction of J moves the force by no more than `J h/τ` in a tick of h.
//! A force that goes on evenly is not held up. Frames of every tick have nothing between them to be
//! smooth.

use thenar_core::math::Vec3;

/// Time constant in which a frame's correction is let in \[s\]: a seventh of it in the first
/// millisecond, of the paper's scenes' largest, 0.3 N where a car is touched, less than 0.05 N. The
/// correction, and nothing else, is later by so much.
pub const BLEND: f64 = 0.0065;

/// Offsets of all bones.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Smooth {
    /// Step of the frame that the last tick was on.
    step: Option<u64>,
    /// Part of an offset left after this tick, and whether its frame is a new one.
    decay: f64,
    fresh: bool,
    /// The last tick was on the same frame as the one before it: the force's rate is known.
    went_on: bool,
    offsets: Vec<[Vec3; 2]>,
    /// Wrenches that acted and that were felt in the last tick, and the rise of what acted over the
    /// one before.
    acted: Vec<[Vec3; 2]>,
    before: Vec<[Vec3; 2]>,
    rates: Vec<[Vec3; 2]>,
}

impl Smooth {
    pub fn new(bones: usize) -> Self {
        let none = vec![[Vec3::zeros(); 2]; bones];
        Self {
            step: None,
            decay: 1.0,
            fresh: false,
            went_on: false,
            offsets: none.clone(),
            acted: none.clone(),
            before: none.clone(),
            rates: none,
        }
    }

    /// Begins a tick of `h` \[s\] on the frame of this step.
    pub fn begin(&mut self, h: f64, step: u64) {
        self.went_on = !self.fresh;
        self.fresh = self.step.replace(step).is_some_and(|before| before != step);
        self.decay = (-h / BLEND).exp();
    }

    /// Returns what is felt of bone `i` under this wrench: all of it when the bone sets out anew.
    pub fn take(&mut self, i: usize, wrench: [Vec3; 2], anew: bool) -> [Vec3; 2] {
        let (offset, before, rate) =
            (&mut self.offsets[i], &mut self.before[i], &mut self.rates[i]);
        for k in 0..2 {
            let corrects = self.fresh && self.went_on;
            let left = match (anew, corrects) {
                (true, _) => Vec3::zeros(),
                (_, true) => before[k] + rate[k] - wrench[k],
                _ => offset[k],
            };
            offset[k] = if left == Vec3::zeros() { left } else { left * self.decay };
            if !self.fresh {
                rate[k] = wrench[k] - self.acted[i][k];
            }
            before[k] = wrench[k] + offset[k];
            self.acted[i][k] = wrench[k];
        }
        *before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A force that rises by 2 N/s, and that every frame of 16 ms corrects by 0.25 N: no tick
    /// changes it by more than its rise and the part of the correction that the time constant lets
    /// in; between frames it closes in on what acts.
    #[test]
    fn corrections_of_frames_come_in_little_by_little() {
        let mut smooth = Smooth::new(1);
        let (mut before, mut largest) = (None, 0.0_f64);
        for ms in 0..320_u32 {
            let step = u64::from(ms / 16);
            let correction = if step.is_multiple_of(2) { 0.25 } else { 0.0 };
            let acts = Vec3::y() * (2e-3 * f64::from(ms) + correction);
            smooth.begin(1e-3, step);
            let [force, _] = smooth.take(0, [acts, Vec3::zeros()], false);
            if let Some(before) = before {
                let change: Vec3 = force - before;
                largest = largest.max(change.norm());
            }
            if ms % 16 == 15 {
                let left = 0.25 * (-16.0 * 1e-3 / BLEND).exp();
                assert!((force - acts).norm() < left + 0.03, "{ms} ms: {force} of {acts}");
            }
            before = Some(force);
        }
        let lets_in = 0.25 * (1.0 - (-1e-3 / BLEND).exp());
        assert!(largest < lets_in + 0.01 && largest < 0.05, "{largest} N");
        // A hand that sets out anew is felt as it is.
        smooth.begin(1e-3, 99);
        assert_eq!(smooth.take(0, [Vec3::x(); 2], true), [Vec3::x(); 2]);
    }
}
