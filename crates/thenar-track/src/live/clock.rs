//! Time at which a pose was taken, by the simulation's clock.
//!
//! Poses arrive unevenly, their own times are even. The least delay seen lately joins the two
//! clocks; what a pose is late beyond it is its age on arrival. A clock that jumps, stands still
//! or runs at another rate (slow motion) costs accuracy, nothing else.

/// Largest lateness that is believed \[s\]; beyond it one of the clocks has jumped.
const LATENESS_MAX: f64 = 0.1;
/// Part of a pose's lateness by which the least delay rises, so that it follows a change.
const LEAK: f64 = 0.02;
/// Shortest and longest time between poses of one motion \[s\].
const GAP: [f64; 2] = [5e-4, 0.1];

/// Joins the two clocks.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Clock {
    /// Least delay between pose and arrival, and the last pose's own time and arrival.
    last: Option<(f64, f64, f64)>,
}

/// Timing of a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Timing {
    /// Time since the pose before \[s\], if that can be told.
    pub gap: Option<f64>,
    /// The pose before is too old to be of the same motion.
    pub fresh: bool,
    /// Age on arrival \[s\].
    pub late: f64,
}

impl Clock {
    /// Takes in a pose of time `sent` (the client's clock) that arrives at `arrived` (ours).
    pub fn take(&mut self, sent: f64, arrived: f64) -> Timing {
        let delay = arrived - sent;
        let Some((least, sent_before, arrived_before)) = self.last else {
            self.last = Some((delay, sent, arrived));
            return Timing { gap: None, fresh: true, late: 0.0 };
        };
        let late = delay - least;
        let believed = (0.0..=LATENESS_MAX).contains(&late);
        let late = if believed { late } else { 0.0 };
        let least = if believed { least + LEAK * late } else { delay };
        self.last = Some((least, sent, arrived));

        let usable = |gap: f64| (GAP[0]..=GAP[1]).contains(&gap);
        let gaps = [sent - sent_before, arrived - arrived_before];
        Timing { gap: gaps.into_iter().find(|gap| usable(*gap)), fresh: gaps[0] > GAP[1], late }
    }

    /// Forgets all poses.
    pub fn forget(&mut self) {
        self.last = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_late_pose_is_as_old_as_it_is_late() {
        let mut clock = Clock::default();
        for k in 0..50 {
            // The clients clock is 1000 s ahead; poses take 3 ms, every fifth takes 9 ms.
            let sent = 1000.0 + f64::from(k) * 0.011;
            let extra = if k % 5 == 4 { 6e-3 } else { 0.0 };
            let timing = clock.take(sent, sent - 1000.0 + 3e-3 + extra);
            // The leak lifts the least delay by 2 % of 6 ms at each late pose, until the next.
            assert!((timing.late - extra).abs() < 2e-4, "{k} {timing:?}");
            if k > 0 {
                assert!((timing.gap.unwrap() - 0.011).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_broken_clock_is_replaced_by_ours() {
        let mut clock = Clock::default();
        clock.take(5.0, 1.0);
        let still = clock.take(5.0, 1.02);
        assert!((still.gap.unwrap() - 0.02).abs() < 1e-12 && !still.fresh);
        let back = clock.take(-7.0, 1.03);
        assert!((back.gap.unwrap() - 0.01).abs() < 1e-12);
        assert_eq!(back.late, 0.0);
        let ahead = clock.take(1e9, 1.04);
        assert!(ahead.fresh && ahead.late == 0.0);
    }
}
