//! Samples that no motion explains: a tracker's glitch, or a start that was not foreseen. The next sample tells which.

use thenar::Pose;

/// How far a sample may be from what was expected, and what the fastest start adds: place \[m, m/s²\], turns of the
/// wrist, angles of joints \[rad, rad/s²\]. Noise of trackers reaches 1 cm and 5 degrees; hands start with some 100
/// m/s², wrists and fingers turn with some 500 rad/s².
const EXPECTED: [[f64; 2]; 3] = [[0.02, 100.0], [0.12, 500.0], [0.15, 500.0]];
/// Fastest true motion from the sample in doubt to the next \[m/s\], \[rad/s\].
const FASTEST: [f64; 3] = [4.0, 25.0, 26.0];

/// A sample that waits for the next.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Doubt {
    waiting: Option<Pose>,
    angles: Vec<[f64; 2]>,
}

impl Doubt {
    /// Nothing waits.
    pub fn new(joints: usize) -> Self {
        Self { waiting: None, angles: vec![[0.0; 2]; joints] }
    }

    /// True if a sample waits.
    pub fn waits(&self) -> bool {
        self.waiting.is_some()
    }

    /// Nothing waits any more.
    pub fn forget(&mut self) {
        self.waiting = None;
    }

    /// True if this sample must wait: it is `surprises` from what is expected `gap` \[s\] after the last one taken, and
    /// none before it, `step` \[s\] earlier, bears it out.
    pub fn look(
        &mut self,
        wrist: &Pose,
        angles: &[[f64; 2]],
        surprises: [f64; 3],
        gap: f64,
        step: Option<f64>,
    ) -> bool {
        let most = EXPECTED.map(|[base, start]| base + 0.5 * start * gap * gap);
        let expected = surprises.iter().zip(&most).all(|(surprise, most)| surprise <= most);
        if expected || self.is_borne_out(wrist, angles, step.unwrap_or(gap)) {
            self.waiting = None;
            return false;
        }
        self.waiting = Some(*wrist);
        self.angles.copy_from_slice(angles);
        true
    }

    /// True if the sample in doubt and this one are of one motion.
    fn is_borne_out(&self, wrist: &Pose, angles: &[[f64; 2]], step: f64) -> bool {
        let Some(before) = &self.waiting else { return false };
        let change = (self.angles.as_flattened().iter().zip(angles.as_flattened()))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        let ways = [
            (wrist.position - before.position).norm(),
            wrist.rotation.angle_to(&before.rotation),
            change,
        ];
        let noise = EXPECTED.map(|[base, _]| base);
        (0..3).all(|k| ways[k] <= noise[k] + FASTEST[k] * step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar::{Quat, Vec3};

    const GAP: f64 = 1.0 / 90.0;

    fn at(x: f64) -> Pose {
        Pose::new(Vec3::x() * x, Quat::identity())
    }

    /// 5 cm off and back: that sample waits, and is forgotten. 5 cm off and staying there, or 3 m/s from rest: the
    /// first waits, the second is taken. Noise and a start of 90 m/s² never wait.
    #[test]
    fn one_sample_is_a_glitch_and_two_are_a_motion() {
        let none = [[0.0; 2]; 15];
        let mut doubt = Doubt::new(15);
        let mut look = |x: f64, expected: f64, gap: f64| {
            doubt.look(&at(x), &none, [(x - expected).abs(), 0.0, 0.0], gap, Some(GAP))
        };
        assert!(look(0.05, 0.0, GAP) && !look(0.0, 0.0, 2.0 * GAP));
        assert!(look(0.05, 0.0, GAP) && !look(0.05, 0.0, 2.0 * GAP));
        assert!(look(3.0 * GAP, 0.0, GAP) && !look(6.0 * GAP, 0.0, 2.0 * GAP));
        assert!(!look(0.01, 0.0, GAP) && !look(45.0 * GAP * GAP, 0.0, GAP));
        // Glitches of two samples that disagree.
        assert!(look(0.2, 0.0, GAP) && look(-0.2, 0.0, 2.0 * GAP) && !look(0.0, 0.0, 3.0 * GAP));
    }

    #[test]
    fn turns_and_joints_are_doubted_alike() {
        let mut doubt = Doubt::new(15);
        let mut bent = [[0.0; 2]; 15];
        bent[4][0] = 0.6;
        assert!(doubt.look(&at(0.0), &bent, [0.0, 0.0, 0.6], GAP, Some(GAP)));
        assert!(!doubt.look(&at(0.0), &bent, [0.0, 0.0, 0.6], 2.0 * GAP, Some(GAP)));
        let turned = Pose::new(Vec3::zeros(), Quat::from_scaled_axis(Vec3::z() * 0.5));
        assert!(doubt.look(&turned, &bent, [0.0, 0.5, 0.0], GAP, Some(GAP)));
        assert!(!doubt.look(&at(0.0), &bent, [0.0; 3], 2.0 * GAP, Some(GAP)));
    }
}
