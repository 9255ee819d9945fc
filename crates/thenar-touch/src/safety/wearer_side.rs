//! The account of energy at the wearer's side: which force acted when the motion was made that is
//! seen now.
//!
//! What is measured of the wearer is old by the delay t_d of tracker and chain. Force now times
//! velocity now is then the power of neither instant: a spring that hums behind a delay seems to be
//! even while it gives out `π K X² sin ω t_d` a cycle. So each velocity meets the force that was
//! sent t_d ago. What the account cannot see yet is what the forces of the last t_d did: no more
//! than their impulse times the fastest motion of late ([`WearerSide::hidden`]).

/// Intervals that are remembered: a quarter of a second of ticks at 1 kHz, and at any rate twice
/// the delay.
const INTERVALS: usize = 256;
/// Parts of the delay: ticks that are shorter share an interval, which is known to 1 % of the delay
/// then.
const PARTS: f64 = INTERVALS as f64 / 2.0;

/// Forces of the last intervals, the newest last.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct WearerSide<const N: usize> {
    delay: f64,
    /// The last of them, [`INTERVALS`].
    #[serde(deserialize_with = "whole")]
    ring: Vec<Interval<N>>,
    next: usize,
}

/// A tick, or some short ones together, and what they did.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Interval<const N: usize> {
    /// Force held, on average \[N\].
    #[serde(with = "crate::safety::arrays")]
    force: [f64; N],
    /// Length \[s\].
    dt: f64,
    /// Largest speed seen meanwhile \[m/s\].
    speed: f64,
}

impl<const N: usize> Interval<N> {
    const NONE: Self = Self { force: [0.0; N], dt: 0.0, speed: 0.0 };

    /// Both together.
    fn and(&self, next: &Self) -> Self {
        let dt = self.dt + next.dt;
        let share = if dt > 0.0 { next.dt / dt } else { 1.0 };
        let force =
            std::array::from_fn(|k| self.force[k] + share * (next.force[k] - self.force[k]));
        Self { force, dt, speed: self.speed.max(next.speed) }
    }
}

/// A ring of its full length.
fn whole<'de, D: serde::Deserializer<'de>, const N: usize>(
    deserializer: D,
) -> Result<Vec<Interval<N>>, D::Error> {
    let ring: Vec<Interval<N>> = serde::Deserialize::deserialize(deserializer)?;
    let wrong = || serde::de::Error::invalid_length(ring.len(), &"256 intervals");
    if ring.len() == INTERVALS { Ok(ring) } else { Err(wrong()) }
}

impl<const N: usize> WearerSide<N> {
    pub fn new() -> Self {
        Self { delay: 0.0, ring: vec![Interval::NONE; INTERVALS], next: 0 }
    }

    /// The wearer's motion is seen so late \[s\]; what is no number is as late as can be.
    pub fn see_late(&mut self, delay: f64) {
        self.delay = if delay.is_nan() { f64::INFINITY } else { delay.max(0.0) };
    }

    /// Nothing of before counts any more.
    pub fn forget(&mut self) {
        self.ring.fill(Interval::NONE);
    }

    /// True if what is seen of the wearer is older than a tick or two.
    pub fn is_late(&self) -> bool {
        self.delay > 2e-3
    }

    /// Takes in the interval just past, in which `force` was held for `dt` and this speed was seen;
    /// the force that was held when that motion was made.
    pub fn take(&mut self, force: [f64; N], dt: f64, speed: f64) -> [f64; N] {
        let tick = Interval { force, dt, speed };
        let newest = &mut self.ring[(self.next + INTERVALS - 1) % INTERVALS];
        // A delay without end is as long as what is remembered tick by tick.
        if self.delay.is_finite() && newest.dt + dt <= self.delay / PARTS {
            *newest = newest.and(&tick);
        } else {
            self.ring[self.next] = tick;
            self.next = (self.next + 1) % INTERVALS;
        }
        let mut passed = 0.0;
        for Interval { force, dt, .. } in self.newest_first() {
            passed += dt;
            // The middle of this interval is that long ago.
            if passed - 0.5 * dt >= self.delay {
                return *force;
            }
        }
        self.ring[self.next].force
    }

    /// Bound of what the delay hides \[J\].
    pub fn hidden(&self) -> f64 {
        let (mut impulse, mut passed) = (0.0, 0.0);
        let mut fastest = 0.0_f64;
        for Interval { force, dt, speed } in self.newest_first() {
            fastest = fastest.max(*speed);
            if passed < self.delay {
                impulse += force.iter().map(|f| f * f).sum::<f64>().sqrt() * dt;
            }
            passed += dt;
        }
        impulse * fastest
    }

    fn newest_first(&self) -> impl Iterator<Item = &Interval<N>> {
        (1..=INTERVALS).map(|back| &self.ring[(self.next + INTERVALS - back) % INTERVALS])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::safety::Passivity;
    use std::f64::consts::{PI, TAU};

    /// A delay that is no number is as late as can be: each motion meets the oldest force that is
    /// remembered, and all of them may be hidden. After a new start no force of before counts.
    #[test]
    fn no_number_is_as_late_as_can_be() {
        let mut side = WearerSide::<1>::new();
        side.see_late(f64::NAN);
        assert!(side.is_late());
        let held: Vec<f64> =
            (1..=2 * INTERVALS).map(|k| side.take([k as f64], 1e-3, 0.5)[0]).collect();
        let oldest = held.last().unwrap();
        assert!((*oldest - INTERVALS as f64).abs() <= 1.0, "{oldest}");
        // The impulse of the last quarter of a second at half a metre a second.
        let impulse: f64 = (INTERVALS + 1..=2 * INTERVALS).map(|k| 1e-3 * k as f64).sum();
        assert!((side.hidden() / (0.5 * impulse) - 1.0).abs() < 1e-9, "{} J", side.hidden());
        side.forget();
        assert_eq!((side.take([0.0], 1e-3, 0.5), side.hidden()), ([0.0], 0.0));
    }

    /// A spring of 160 N/m that hums at 9 Hz by 5 mm behind a delay: it gives out
    /// `π K X² sin ω t_d` a cycle. The account at the wearer's side says so, that of the present
    /// says nearly nothing; what is hidden is within its bound.
    #[test]
    fn a_hum_behind_a_delay_is_accounted_as_it_is() {
        // A tick of 20 kHz is as good as one of 1 kHz, and so is a delay that is longer than 256
        // ticks.
        for (h, delay) in [(1e-3, 0.03), (1.0 / 8000.0, 0.05), (5e-5, 0.03), (1e-3, 0.36)] {
            hums(h, delay);
        }
    }

    fn hums(h: f64, delay: f64) {
        let (k, x, rate) = (160.0, 5e-3, TAU * 9.0);
        let cycles = 9.0;
        let mut side = WearerSide::<1>::new();
        side.see_late(delay);
        let (mut account, mut naive) = (Passivity::default(), Passivity::default());
        let (mut given, mut force) = (0.0, 0.0);
        let place = |t: f64| x * (rate * t).sin();
        for tick in 1..=(cycles / 9.0 / h) as u64 {
            let t = h * tick as f64;
            given += force * (place(t) - place(t - h));
            let seen = (place(t - delay) - place(t - delay - h)) / h;
            let then = side.take([force], h, seen.abs());
            account.observe(&then, &[seen], h, 1e9);
            naive.observe(&[force], &[seen], h, 1e9);
            // To the wearer's motion as it was when it was seen.
            force = -k * place(t - delay);
            let hidden = (given + account.balance()).abs();
            assert!(hidden <= side.hidden() + 2e-3, "{t} s: {hidden} of {} J", side.hidden());
        }
        let theory = cycles * PI * k * x * x * (rate * delay).sin();
        assert!((given / theory - 1.0).abs() < 0.05, "{given} of {theory} J");
        // Of this second it has seen what is older than the delay.
        let seen = theory * (1.0 - delay);
        assert!((-account.balance() / seen - 1.0).abs() < 0.15, "{} J", account.balance());
        assert!(naive.balance().abs() < 0.2 * theory, "{} J", naive.balance());
    }
}
