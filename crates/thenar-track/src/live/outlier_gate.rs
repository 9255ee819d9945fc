//! Samples that no motion explains: a tracker's glitch, or a start that was not foreseen. The next
//! sample tells which.

use thenar_core::Pose;

/// Largest deviation of a sample from what was expected, the part that the fastest start adds, and
/// the most of that: place \[m, m/s², m\], turns of the wrist, angles of joints \[rad, rad/s²,
/// rad\]. Noise of trackers reaches 1 cm and 5 degrees. A reach that is 3 m/s fast on its way of
/// 0.3 m starts with 49 m/s² (the least jerk of Flash and Hogan 1985: 1.875 D/T and 5.77 D/T²);
/// twice that is allowed for, and 500 rad/s² of wrists and fingers. Where samples are so far apart
/// that this would reach 3.5 cm at a fingertip, 17 cm from the wrist and 10 cm from its knuckle,
/// starts wait as glitches do: 5 cm never pass.
const EXPECTED: [[f64; 3]; 3] = [[0.02, 100.0, 0.015], [0.12, 500.0, 0.08], [0.15, 500.0, 0.2]];
/// Fastest true motion from the sample in doubt to the next \[m/s\], \[rad/s\].
const FASTEST: [f64; 3] = [4.0, 25.0, 26.0];

/// A sample that waits for the next.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct OutlierGate {
    waiting: Option<PendingWrist>,
    angles: Vec<[f64; 2]>,
}

/// A wrist in doubt, and how long after the last one taken it was \[s\].
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct PendingWrist {
    /// Pose at which it was seen.
    pub wrist: Pose,
    /// Time since the last sample that was taken \[s\].
    pub gap: f64,
}

/// Verdict on a sample.
#[derive(Clone, Copy, Debug)]
pub enum GateDecision {
    /// The sample is taken; what waited is forgotten.
    Taken,
    /// The sample is taken after the one that waited, which it bears out.
    BornOut(PendingWrist),
    /// The sample waits for the next.
    Waits,
}

impl OutlierGate {
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

    /// Angles of the joints of the sample that waits or waited last \[rad\].
    pub fn angles(&self) -> &[[f64; 2]] {
        &self.angles
    }

    /// Judges this sample: it is `surprises` from what is expected `gap` \[s\] after the last one
    /// taken, and may bear out the one before it, `step` \[s\] earlier.
    pub fn look(
        &mut self,
        wrist: &Pose,
        angles: &[[f64; 2]],
        surprises: [f64; 3],
        gap: f64,
        step: Option<f64>,
    ) -> GateDecision {
        let most = EXPECTED.map(|[base, start, most]| base + (0.5 * start * gap * gap).min(most));
        if surprises.iter().zip(&most).all(|(surprise, most)| surprise <= most) {
            self.waiting = None;
            return GateDecision::Taken;
        }
        if self.is_borne_out(wrist, angles, step.unwrap_or(gap))
            && let Some(waiting) = self.waiting.take()
        {
            return GateDecision::BornOut(waiting);
        }
        self.waiting = Some(PendingWrist { wrist: *wrist, gap });
        self.angles.copy_from_slice(angles);
        GateDecision::Waits
    }

    /// True if the sample in doubt and this one are of one motion.
    fn is_borne_out(&self, wrist: &Pose, angles: &[[f64; 2]], step: f64) -> bool {
        let Some(PendingWrist { wrist: before, .. }) = &self.waiting else { return false };
        let change = (self.angles.as_flattened().iter().zip(angles.as_flattened()))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        let ways = [
            (wrist.position - before.position).norm(),
            wrist.rotation.angle_to(&before.rotation),
            change,
        ];
        let noise = EXPECTED.map(|[base, ..]| base);
        (0..3).all(|k| ways[k] <= noise[k] + FASTEST[k] * step)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::{Quat, Vec3};

    const GAP: f64 = 1.0 / 90.0;

    fn at(x: f64) -> Pose {
        Pose::new(Vec3::x() * x, Quat::identity())
    }

    /// 5 cm off and back: that sample waits, and is forgotten. 5 cm off and staying there, or 3 m/s
    /// from rest: the first waits, the second is taken. Noise and a start of 90 m/s² never wait.
    #[test]
    fn one_sample_is_a_glitch_and_two_are_a_motion() {
        let none = [[0.0; 2]; 15];
        let mut outlier_gate = OutlierGate::new(15);
        let mut look = |x: f64, expected: f64, gap: f64| {
            let surprises = [(x - expected).abs(), 0.0, 0.0];
            matches!(
                outlier_gate.look(&at(x), &none, surprises, gap, Some(GAP)),
                GateDecision::Waits
            )
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
        let mut outlier_gate = OutlierGate::new(15);
        let mut bent = [[0.0; 2]; 15];
        bent[4][0] = 0.6;
        let mut look = |wrist: &Pose, surprises: [f64; 3], gap: f64| {
            outlier_gate.look(wrist, &bent, surprises, gap, Some(GAP))
        };
        assert!(matches!(look(&at(0.0), [0.0, 0.0, 0.6], GAP), GateDecision::Waits));
        let after = look(&at(0.0), [0.0, 0.0, 0.6], 2.0 * GAP);
        assert!(matches!(after, GateDecision::BornOut(waiting) if waiting.gap == GAP));
        let turned = Pose::new(Vec3::zeros(), Quat::from_scaled_axis(Vec3::z() * 0.5));
        assert!(matches!(look(&turned, [0.0, 0.5, 0.0], GAP), GateDecision::Waits));
        assert!(matches!(look(&at(0.0), [0.0; 3], 2.0 * GAP), GateDecision::Taken));
    }

    /// Five centimetres of a fingertip are in doubt however long ago the last sample was: by the
    /// wrist, by its turn 17 cm away, by a knuckle 10 cm away.
    #[test]
    fn five_centimetres_never_pass() {
        let none = [[0.0; 2]; 15];
        for gap in [1e-3, GAP, 1.0 / 60.0, 1.0 / 30.0, 0.067, 0.1] {
            for k in 0..3 {
                let mut surprises = [0.0; 3];
                surprises[k] = [0.05, 0.05 / 0.17, 0.5][k];
                let verdict = OutlierGate::new(15).look(&at(0.0), &none, surprises, gap, Some(gap));
                assert!(matches!(verdict, GateDecision::Waits), "{k} after {gap} s");
            }
        }
    }
}
