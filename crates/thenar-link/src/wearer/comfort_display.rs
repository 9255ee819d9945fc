//! A display as its wearer wants it.

use super::{Comfort, Wearer};
use crate::{ForceDisplay, HandOutput, MessageSource, PresenceCheck, Rendering};
use thenar_core::Vec3;
use thenar_touch::LoopProfile;
use thenar_touch::safety::Limits;

/// A display that shows no more than is comfortable. Guards before it are narrowed to the strongest
/// finger; what leaves is softened and each finger cut to its own, after the guards and before the
/// device's door.
///
/// A part of every force is as passive as the whole, and a force that ends growing more so: the
/// guards' account stays on the safe side of what the wearer is given.
pub struct ComfortDisplay {
    display: Box<dyn ForceDisplay>,
    comfort: Comfort,
}

/// Puts what this wearer finds comfortable before a display that was opened at `address`; what is,
/// if anything is known.
pub fn limited_to_comfort(
    display: Box<dyn ForceDisplay>,
    address: &str,
    wearer: &Wearer,
) -> (Box<dyn ForceDisplay>, Option<Comfort>) {
    // The device itself, where the address is of one that holds others.
    let names = display.presence_check()().into_iter().map(|presence| presence.name);
    let names: Vec<String> = names.chain(std::iter::once(address.to_string())).collect();
    let of = |name: &String| wearer.with(name.split(':').next().unwrap_or(name));
    match names.iter().find_map(of) {
        Some(comfort) => (Box::new(ComfortDisplay { display, comfort: *comfort }), Some(*comfort)),
        None => (display, None),
    }
}

impl ComfortDisplay {
    /// A display with what is comfortable.
    pub fn new(display: Box<dyn ForceDisplay>, comfort: Comfort) -> Self {
        Self { display, comfort }
    }

    /// Part of the device's range that is left for its strongest finger, or for the whole hand.
    fn part(&self) -> f64 {
        let force = self.comfort.force.into_iter();
        let most = match self.display.rendering() {
            Rendering::Wrench => force.fold(f64::INFINITY, f64::min),
            Rendering::Tendons | Rendering::Stops | Rendering::Vibration => {
                force.fold(0.0, f64::max)
            }
        };
        let own = self.display.limits().force_max();
        if own > 0.0 { (most / own).min(1.0) } else { 0.0 }
    }
}

impl ForceDisplay for ComfortDisplay {
    fn rendering(&self) -> Rendering {
        self.display.rendering()
    }

    fn limits(&self) -> Limits {
        self.comfort.within(&self.display.limits(), self.part())
    }

    fn torque_limits(&self) -> Option<Limits> {
        let part = self.part();
        self.display.torque_limits().map(|own| self.comfort.within(&own, part))
    }

    fn loop_profile(&self) -> LoopProfile {
        self.display.loop_profile()
    }

    fn show(&mut self, output: &HandOutput) {
        let Comfort { force, stiffness, .. } = self.comfort;
        let mut less = *output;
        let fingers = self.display.rendering() != Rendering::Wrench;
        for (digit, most) in less.digits.iter_mut().zip(force) {
            // The door refuses what is no number.
            let pad = stiffness * digit.pad_force;
            digit.pad_force = pad.clamp(-most, most);
            // Nothing is left of a finger that is to feel nothing, a stop and a vibration included.
            if fingers && digit.pad_force == 0.0 {
                *digit = thenar_touch::DigitOutput::default();
            } else {
                digit.force_W = at_most(digit.force_W * stiffness, most);
            }
        }
        let part = self.part();
        let torque = self.display.torque_limits().map_or(0.0, |own| part * own.force_max());
        let force = part * self.display.limits().force_max();
        less.force_W = at_most(less.force_W * stiffness, force);
        less.torque_W = at_most(less.torque_W * stiffness, torque);
        self.display.show(&less);
    }

    fn heard_ns(&mut self) -> Option<u64> {
        self.display.heard_ns()
    }

    fn messages(&mut self) -> Vec<String> {
        self.display.messages()
    }

    fn message_source(&self) -> MessageSource {
        self.display.message_source()
    }

    fn presence_check(&self) -> PresenceCheck {
        self.display.presence_check()
    }
}

/// A vector of the same direction, no longer than `most`. What is no number stays none, for the
/// door to refuse.
fn at_most(v: Vec3, most: f64) -> Vec3 {
    v.cap_magnitude(most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};
    use thenar_core::model::Side;
    use thenar_touch::DIGITS;
    use thenar_touch::safety::Guard;

    struct Fake(Rendering, Arc<Mutex<Vec<HandOutput>>>);

    impl ForceDisplay for Fake {
        fn rendering(&self) -> Rendering {
            self.0
        }

        fn limits(&self) -> Limits {
            Limits::cybergrasp()
        }

        fn torque_limits(&self) -> Option<Limits> {
            Some(Limits::torque(0.2))
        }

        fn loop_profile(&self) -> LoopProfile {
            unreachable!("nothing is coupled")
        }

        fn show(&mut self, output: &HandOutput) {
            self.1.lock().unwrap().push(*output);
        }

        fn heard_ns(&mut self) -> Option<u64> {
            None
        }

        fn messages(&mut self) -> Vec<String> {
            Vec::new()
        }
    }

    const COMFORT: Comfort =
        Comfort { force: [2.0, 3.0, 9.0, 0.0, 1.0], ramp: 0.0, stiffness: 0.5 };

    fn fake(rendering: Rendering) -> (ComfortDisplay, Arc<Mutex<Vec<HandOutput>>>) {
        let shown = Arc::new(Mutex::new(Vec::new()));
        (ComfortDisplay::new(Box::new(Fake(rendering, shown.clone())), COMFORT), shown)
    }

    /// Whatever the guards let through, each finger gets a part of it and no more than it wants;
    /// nothing else becomes more.
    #[test]
    fn each_finger_is_cut_to_its_own() {
        for rendering in [Rendering::Tendons, Rendering::Stops, Rendering::Vibration] {
            let (mut display, shown) = fake(rendering);
            // The middle finger would bear more than the device gives.
            assert_eq!(display.limits().force_max(), Limits::cybergrasp().force_max());
            let mut output = HandOutput::released(Side::Right, 7);
            for digit in &mut output.digits {
                digit.pad_force = 5.0;
                digit.force_W = Vec3::y() * 5.0;
                (digit.area, digit.curl_at_contact) = (1e-4, Some(0.4));
            }
            display.show(&output);
            let told = shown.lock().unwrap()[0];
            assert_eq!(told.digits.map(|d| d.pad_force), [2.0, 2.5, 2.5, 0.0, 1.0]);
            assert_eq!(told.digits.map(|d| d.force_W.y), [2.0, 2.5, 2.5, 0.0, 1.0]);
            assert_eq!(told.digits[3], thenar_touch::DigitOutput::default(), "no stop either");
            assert!(told.digits[0].curl_at_contact == Some(0.4) && told.time_ns == 7);
        }
    }

    /// An arm's force and torque keep to the least of the fingers.
    #[test]
    fn an_arm_keeps_to_the_weakest() {
        let comfort = Comfort { force: [3.0; DIGITS], ramp: 0.0, stiffness: 1.0 };
        let shown = Arc::new(Mutex::new(Vec::new()));
        let mut display =
            ComfortDisplay::new(Box::new(Fake(Rendering::Wrench, shown.clone())), comfort);
        assert_eq!(display.limits().force_max(), 3.0);
        // Half of what the device allows is half of its torque.
        assert!((display.torque_limits().unwrap().force_max() - 0.05).abs() < 1e-12);
        let mut output = HandOutput::released(Side::Right, 0);
        output.force_W = Vec3::new(3.0, 4.0, 0.0);
        output.torque_W = Vec3::z() * 0.08;
        display.show(&output);
        let told = shown.lock().unwrap()[0];
        assert!((told.force_W - Vec3::new(1.8, 2.4, 0.0)).norm() < 1e-12);
        assert!((told.torque_W.z - 0.05).abs() < 1e-12);
    }

    /// The device behind an address that holds others is what counts.
    #[test]
    fn the_device_itself_is_looked_up() {
        let file = std::env::temp_dir().join(format!("thenar-worn-{}.toml", std::process::id()));
        super::super::keep(&file, "null", &COMFORT).unwrap();
        let wearer = Wearer::read(&file).unwrap();
        std::fs::remove_file(&file).unwrap();
        for address in ["null:right", "either:null:left||null:right", "fault:1:null:right"] {
            let display = crate::open(address).unwrap().display.unwrap();
            let own = display.limits();
            let (display, comfort) = limited_to_comfort(display, address, &wearer);
            assert_eq!(comfort, Some(COMFORT), "{address}");
            assert!(display.limits().force_max() <= own.force_max());
        }
        let display = crate::open("null:right").unwrap().display.unwrap();
        assert_eq!(limited_to_comfort(display, "null:right", &Wearer::default()).1, None);
    }

    /// A guard with these limits, driven by whatever, never lets more through than the strongest
    /// finger wants.
    #[test]
    fn the_guards_are_narrowed() {
        let comfort = Comfort { force: [1.5; DIGITS], ramp: 0.5, stiffness: 1.0 };
        let display =
            ComfortDisplay::new(Box::new(Fake(Rendering::Tendons, Arc::default())), comfort);
        let limits = display.limits();
        let mut guard = Guard::<1>::new(limits, 0).unwrap();
        guard.arm();
        let mut most = 0.0_f64;
        for k in 1..5000_u64 {
            let now = k * 1_000_000;
            let force = [if k < 100 { 0.0 } else { 50.0 }];
            let signal = thenar_touch::safety::Signal {
                force,
                velocity: [0.0],
                simulation_ns: now,
                tracking_ns: now,
                device_ns: now,
                enabled: true,
            };
            most = most.max(guard.tick(now, &signal)[0]);
        }
        assert!((most - 1.5).abs() < 1e-9, "{most} N");
    }
}
