//! The last check, where outputs leave for the device: whatever mapped to it, and however it got
//! here.
//!
//! Guards stand before each hand and each display, and a device may be reached past them: two hands
//! that feel through one glove, a program of one's own. Per device and channel (each finger's
//! force, the force and the torque on one point) what leaves here is finite, within what the
//! device's profile allows of its rating, and moves no faster than its slew from one message to the
//! next, except to zero, which is shown at once; a stop comes as fast in parts of the finger's way.
//! A display that holds one hand shows one.

use super::handles::slot;
use crate::{DigitOutput, HandOutput};
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_touch::safety::Limits;

/// A hand that has asked for nothing for so long leaves a device of one hand to the other \[ns\]:
/// longer than a grasp lets go of a thing to take it anew, and as long as a wearer notices.
const LEAVES_AFTER_NS: u64 = 1_000_000_000;

/// Stands before one device.
#[derive(Clone, Debug)]
pub struct Door {
    limits: Limits,
    torque_limits: Option<Limits>,
    /// The device holds one hand, and nobody said which.
    one_hand: bool,
    bound: Option<Side>,
    /// Time when the bound hand last asked for anything \[ns\].
    bore_ns: u64,
    /// Left, right.
    hands: [LastOutput; 2],
}

/// Outputs that passed for one hand.
#[derive(Clone, Copy, Debug)]
struct LastOutput {
    wanted: HandOutput,
    sent: HandOutput,
    at_ns: u64,
}

impl LastOutput {
    /// The hand holds nothing.
    fn release(&mut self, now_ns: u64) {
        let none = HandOutput::released(self.wanted.side, now_ns);
        *self = Self { wanted: none, sent: none, at_ns: now_ns };
    }
}

impl Door {
    /// Nothing has passed. Without limits nothing does.
    pub fn new(limits: Limits, torque_limits: Option<Limits>, one_hand: bool) -> Self {
        let none = |side| LastOutput {
            wanted: HandOutput::released(side, 0),
            sent: HandOutput::released(side, 0),
            at_ns: 0,
        };
        let hands = [Side::Left, Side::Right].map(none);
        Self { limits, torque_limits, one_hand, bound: None, bore_ns: 0, hands }
    }

    /// The device was set free: it holds nothing.
    pub fn open(&mut self, now_ns: u64) {
        self.bound = None;
        self.hands.iter_mut().for_each(|passed| passed.release(now_ns));
    }

    /// Output that leaves at `now_ns` for a hand that is to be shown `new`, or else keeps its last
    /// goal; `None` when the device shows that goal already, or is bound to the other hand.
    pub fn pass(
        &mut self,
        side: Side,
        new: Option<&HandOutput>,
        now_ns: u64,
    ) -> Option<HandOutput> {
        if let Some(new) = new.filter(|_| self.takes(side)) {
            self.hands[slot(side)].wanted = *new;
        } else if new.is_some() {
            return None;
        }
        let passed = &mut self.hands[slot(side)];
        let dt = now_ns.saturating_sub(passed.at_ns) as f64 * 1e-9;
        let next =
            toward(&passed.sent, &passed.wanted, &self.limits, self.torque_limits.as_ref(), dt);
        let changed = next != passed.sent;
        (passed.sent, passed.at_ns) = (next, now_ns);
        (new.is_some() || changed).then_some(next)
    }

    /// True if the device shows this hand.
    fn takes(&self, side: Side) -> bool {
        !self.one_hand || self.bound.is_none_or(|bound| bound == side)
    }

    /// Binds the device to the hand of an output with force, if it is of one hand and free; true
    /// when another hand's force is refused. It is free again when its hand has asked for nothing
    /// for a second.
    pub fn bind(&mut self, output: &HandOutput, now_ns: u64) -> bool {
        let bears = bears(output);
        if self.one_hand && bears {
            let rested = now_ns.saturating_sub(self.bore_ns) > LEAVES_AFTER_NS;
            if self.bound.is_none() || rested && !self.takes(output.side) {
                if let Some(side) = self.bound {
                    self.hands[slot(side)].release(now_ns);
                }
                self.bound = Some(output.side);
            }
            if self.takes(output.side) {
                self.bore_ns = now_ns;
            }
        }
        !self.takes(output.side) && bears
    }

    /// Nobody shows this hand any more: the device is free for another.
    pub fn leave(&mut self, side: Side) {
        self.bound = self.bound.filter(|bound| *bound != side);
    }
}

/// True if an output asks for anything.
fn bears(output: &HandOutput) -> bool {
    let none = HandOutput::released(output.side, output.time_ns);
    (output.digits, output.force_W, output.torque_W) != (none.digits, none.force_W, none.torque_W)
}

/// From what was sent towards what is wanted, as far as `dt` \[s\] allows.
fn toward(
    sent: &HandOutput,
    wanted: &HandOutput,
    limits: &Limits,
    torque: Option<&Limits>,
    dt: f64,
) -> HandOutput {
    let mut next = *wanted;
    let change = limits.change_max(dt);
    for (next, sent) in next.digits.iter_mut().zip(&sent.digits) {
        *next = digit(next, sent, limits, change);
    }
    next.force_W = vector(&sent.force_W, &wanted.force_W, limits.force_max(), change);
    next.torque_W = torque.map_or(Vec3::zeros(), |limits| {
        vector(&sent.torque_W, &wanted.torque_W, limits.force_max(), limits.change_max(dt))
    });
    next
}

/// Bounds a finger: its pad force, and its force in space, which is no larger; a stop is within the
/// finger's way.
fn digit(wanted: &DigitOutput, sent: &DigitOutput, limits: &Limits, change: f64) -> DigitOutput {
    let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
    let most = limits.force_max();
    let least = if limits.unilateral { 0.0 } else { -most };
    let goal = finite(wanted.pad_force).clamp(least, most);
    let force = if goal == 0.0 { 0.0 } else { within(goal, sent.pad_force, change) };
    DigitOutput {
        force_W: vector(&sent.force_W, &wanted.force_W, force.abs(), change),
        pad_force: force,
        area: finite(wanted.area).max(0.0),
        pressure_mean: finite(wanted.pressure_mean).max(0.0),
        pressure_max: finite(wanted.pressure_max).max(0.0),
        slip_speed: finite(wanted.slip_speed).max(0.0),
        curl_at_contact: stop(wanted, sent, change / limits.rated),
    }
}

/// Stop of a finger, from open (0) to a fist (1): it comes nearer by no more than `change`, in
/// parts of that way, and makes room at once. With a force that is no number there is no stop
/// either.
fn stop(wanted: &DigitOutput, sent: &DigitOutput, change: f64) -> Option<f64> {
    let goal = wanted.curl_at_contact.filter(|c| c.is_finite() && wanted.pad_force.is_finite())?;
    let before = sent.curl_at_contact.unwrap_or(1.0);
    Some(goal.clamp(0.0, 1.0).max(before - change))
}

/// `goal`, no farther than `change` from what was sent.
fn within(goal: f64, sent: f64, change: f64) -> f64 {
    goal.clamp(sent - change, sent + change)
}

/// A force in space.
fn vector(sent: &Vec3, wanted: &Vec3, most: f64, change: f64) -> Vec3 {
    if !wanted.iter().all(|x| x.is_finite()) || *wanted == Vec3::zeros() || most == 0.0 {
        return Vec3::zeros();
    }
    let largest = wanted.amax();
    // By its largest component first: the length of a finite vector may be infinite.
    let unit = wanted / largest;
    let goal = unit * (largest.min(most / unit.norm()));
    let way = goal - sent;
    let next = if way.norm() <= change { goal } else { sent + way * (change / way.norm()) };
    // On the way round from another direction, or from a larger force.
    next.cap_magnitude(most)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn pressing(side: Side, force: f64, now_ns: u64) -> HandOutput {
        let mut output = HandOutput::released(side, now_ns);
        output.digits[1].pad_force = force;
        output.digits[1].force_W = Vec3::y() * force;
        output.force_W = Vec3::x() * force;
        output.torque_W = Vec3::z() * force;
        output
    }

    /// CyberGrasp: half of 12 N, 0.6 N a millisecond. Whatever comes, and however often it changes
    /// its mind.
    #[test]
    fn what_leaves_is_finite_within_the_clamp_and_the_slew() {
        let limits = Limits::cybergrasp();
        let torque = Limits::torque(0.2);
        let mut door = Door::new(limits, Some(torque), false);
        let mut before = HandOutput::released(Side::Right, 0);
        let all = [3.0, 9e9, f64::NAN, -4.0, 2.0, f64::INFINITY, 5.9, f64::NEG_INFINITY, 1e308];
        for ms in 0..900u64 {
            let wanted = pressing(Side::Right, all[(ms / 7) as usize % all.len()], ms * MS);
            let new = Some(&wanted).filter(|_| ms % 7 == 0);
            let Some(sent) = door.pass(Side::Right, new, ms * MS) else { continue };
            let force = sent.digits[1].pad_force;
            assert!((0.0..=6.0).contains(&force), "{ms}: {force} N");
            assert!(sent.force_W.norm() <= 6.0 + 1e-9 && sent.torque_W.norm() <= 0.1 + 1e-9);
            let change = force - before.digits[1].pad_force;
            assert!(force == 0.0 || change.abs() <= 0.6 + 1e-9, "{ms}: by {change} N");
            let change = (sent.force_W - before.force_W).norm();
            assert!(sent.force_W.norm() == 0.0 || change <= 0.6 + 1e-9, "{ms}: by {change} N");
            assert!((sent.digits[1].force_W.norm() - force).abs() < 1e-9);
            before = sent;
        }
        // It gets there in the end.
        let wanted = pressing(Side::Right, 3.0, 0);
        door.pass(Side::Right, Some(&wanted), 900 * MS);
        (901..920).for_each(|ms| _ = door.pass(Side::Right, None, ms * MS));
        assert_eq!(door.hands[1].sent.digits[1].pad_force, 3.0);
        assert_eq!(door.pass(Side::Right, None, 921 * MS), None, "nothing new");
        let none = HandOutput::released(Side::Right, 0);
        assert_eq!(door.pass(Side::Right, Some(&none), 922 * MS), Some(none), "zero at once");
    }

    /// A program of one's own asks for a pad force of 1 N, and in space for a million, turned about
    /// from message to message; and for a stop behind the hand: within the pad's force, its slew
    /// and the finger's way.
    #[test]
    fn what_goes_with_a_pads_force_is_bounded_as_it_is() {
        let mut door = Door::new(Limits::cybergrasp(), None, false);
        let mut before = Vec3::zeros();
        for ms in 1..200u64 {
            let mut wanted = HandOutput::released(Side::Right, ms * MS);
            let sign = if ms % 3 == 0 { -1e6 } else { 1e6 };
            wanted.digits[2].pad_force = 1.0;
            wanted.digits[2].force_W = Vec3::new(sign, 1.0, 0.0);
            wanted.digits[2].curl_at_contact = Some([-7.0, 40.0, f64::NAN][ms as usize % 3]);
            let sent = door.pass(Side::Right, Some(&wanted), ms * MS).unwrap().digits[2];
            assert!(sent.force_W.norm() <= sent.pad_force + 1e-12, "{ms}: {:?}", sent.force_W);
            assert!((sent.force_W - before).norm() <= 0.6 + 1e-9, "{ms}: from {before}");
            assert!(sent.curl_at_contact.is_none_or(|curl| (0.0..=1.0).contains(&curl)));
            before = sent.force_W;
        }
    }

    /// A pad force that falls, turns to nothing, or is no force, while the force in space stays or
    /// turns: this is no larger at any time, and nothing at once with it.
    #[test]
    fn a_force_in_space_goes_with_its_pads() {
        for end in [2.0, 0.0, -3.0, f64::NAN] {
            let mut door = Door::new(Limits::cybergrasp(), None, false);
            for ms in 1..200u64 {
                let angle = 0.3 * ms as f64;
                let mut wanted = HandOutput::released(Side::Right, ms * MS);
                wanted.digits[1].pad_force = if ms < 100 { 10.0 } else { end };
                wanted.digits[1].force_W = Vec3::new(angle.cos(), angle.sin(), 0.0) * 10.0;
                let sent = door.pass(Side::Right, Some(&wanted), ms * MS).unwrap().digits[1];
                assert!(sent.force_W.norm() <= sent.pad_force.abs() + 1e-12, "{end}: {sent:?}");
                if ms >= 100 && end != 2.0 {
                    assert_eq!((sent.pad_force, sent.force_W), (0.0, Vec3::zeros()), "{end}");
                }
            }
        }
    }

    /// Two hands take turns at one glove: it shows the first that presses, for as long as that
    /// presses and a second more.
    #[test]
    fn a_device_of_one_hand_shows_one() {
        let mut door = Door::new(Limits::cybergrasp(), None, true);
        let mut refused = 0;
        for ms in 0..100u64 {
            for side in [Side::Right, Side::Left] {
                let wanted = pressing(side, 1.0, ms * MS);
                refused += u32::from(door.bind(&wanted, ms * MS));
                let sent = door.pass(side, Some(&wanted), ms * MS);
                assert!(sent.is_none_or(|sent| sent.side == Side::Right));
            }
        }
        assert_eq!(refused, 100);
        // The right hand is shown on, and presses nothing.
        for ms in 100..1200 {
            let none = HandOutput::released(Side::Right, ms * MS);
            assert!(!door.bind(&none, ms * MS));
            door.pass(Side::Right, Some(&none), ms * MS);
            let wanted = pressing(Side::Left, 1.0, ms * MS);
            assert_eq!(door.bind(&wanted, ms * MS), ms <= 1099, "{ms} ms");
            let sent = door.pass(Side::Left, Some(&wanted), ms * MS);
            assert_eq!(sent.is_none(), ms <= 1099, "{ms} ms");
        }
        door.leave(Side::Right);
        assert!(door.bind(&pressing(Side::Right, 1.0, 0), 1200 * MS), "held by the left hand");
        door.leave(Side::Left);
        assert!(!door.bind(&pressing(Side::Right, 1.0, 0), 1200 * MS));
        // A device of two hands shows both.
        let mut door = Door::new(Limits::cybergrasp(), None, false);
        for side in [Side::Right, Side::Left] {
            assert!(!door.bind(&pressing(side, 1.0, 0), 0));
            assert!(door.pass(side, Some(&pressing(side, 1.0, 0)), MS).is_some());
        }
    }

    /// A stop jumps before an open finger's way: it comes by a twentieth of the way a millisecond,
    /// 0.6 of 12 N, and goes at once; with a force that is no number there is none.
    #[test]
    fn a_stop_comes_no_faster_than_a_force() {
        let mut door = Door::new(Limits::cybergrasp(), None, false);
        let mut pass = |curl: Option<f64>, force: f64, ms: u64| {
            let mut wanted = HandOutput::released(Side::Left, ms * MS);
            (wanted.digits[3].curl_at_contact, wanted.digits[3].pad_force) = (curl, force);
            door.pass(Side::Left, Some(&wanted), ms * MS).unwrap().digits[3].curl_at_contact
        };
        for ms in 1..40 {
            let stop = pass(Some(0.2), 1.0, ms).unwrap();
            let theory = (1.0 - 0.05 * ms as f64).max(0.2);
            assert!((stop - theory).abs() < 1e-12, "{ms} ms: {stop}");
        }
        assert_eq!(pass(Some(0.7), 1.0, 40), Some(0.7), "room at once");
        assert_eq!(pass(Some(0.7), f64::NAN, 41), None);
        assert_eq!(pass(None, 1.0, 42), None);
    }
}
