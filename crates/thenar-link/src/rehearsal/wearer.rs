//! A hand whose fingers give way: each a mass on a spring and a damper, which its command holds.

use crate::DIGITS;
use thenar::haptic::Pad;
use thenar::model::{Digit, HandModel};
use thenar::world::Target;
use thenar_scene::live::{LiveError, LiveHand, LivePose};
use thenar_scene::motion::HandMotion;
use thenar_scene::session::Session;

/// Mass \[kg\], damping \[N s/m\] and stiffness \[N/m\] at a fingertip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Human {
    /// Mass \[kg\].
    pub mass: f64,
    /// Damping \[N s/m\].
    pub damping: f64,
    /// Stiffness \[N/m\].
    pub stiffness: f64,
}

/// Fingertip of the wearer, by how far it is beyond its command, closing \[m\], and how fast \[m/s\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Finger {
    /// Place \[m\].
    pub place: f64,
    /// Speed \[m/s\].
    pub speed: f64,
}

impl Finger {
    /// Moves for `h` \[s\] under a constant force \[N\]: `m ẍ + b ẋ + k x = f`, by Runge and Kutta's rule in steps of a
    /// twentieth of a millisecond, beside which the fastest of these fingers are slow.
    pub fn advance(&mut self, human: &Human, force: f64, h: f64) {
        const STEP: f64 = 5e-5;
        let steps = (h / STEP).ceil().max(1.0);
        let dt = h / steps;
        let pull = |x: f64, v: f64| (force - human.damping * v - human.stiffness * x) / human.mass;
        for _ in 0..steps as u32 {
            let (x, v) = (self.place, self.speed);
            let k1 = (v, pull(x, v));
            let k2 = (v + 0.5 * dt * k1.1, pull(x + 0.5 * dt * k1.0, v + 0.5 * dt * k1.1));
            let k3 = (v + 0.5 * dt * k2.1, pull(x + 0.5 * dt * k2.0, v + 0.5 * dt * k2.1));
            let k4 = (v + dt * k3.1, pull(x + dt * k3.0, v + dt * k3.1));
            self.place += dt / 6.0 * (k1.0 + 2.0 * (k2.0 + k3.0) + k4.0);
            self.speed += dt / 6.0 * (k1.1 + 2.0 * (k2.1 + k3.1) + k4.1);
        }
    }
}

/// A hand of five such fingers.
pub(super) struct Hand {
    human: Human,
    live: LiveHand,
    motion: Option<HandMotion>,
    targets: Vec<Option<Target>>,
    /// Where the script has it.
    commanded: LivePose,
    /// How much farther its fingers are to close \[m\].
    press: f64,
    /// From the root of each finger to its pad \[m\].
    levers: [f64; DIGITS],
    pub fingers: [Finger; DIGITS],
    /// Energy given to each since its command stood still \[J\].
    pub given: [f64; DIGITS],
}

impl Hand {
    pub fn new(session: &Session, human: Human) -> Result<Self, LiveError> {
        let mut live = session.live_hand(0)?;
        let model = &session.hands()[0].model;
        let targets = session.input().targets[bones(session)].to_vec();
        let commanded = live.pose_of(&targets);
        let (motion, levers) = (session.hands()[0].motion.clone(), levers(model));
        let (fingers, given) = ([Finger::default(); DIGITS], [0.0; DIGITS]);
        Ok(Self { human, live, motion, targets, commanded, press: 0.0, levers, fingers, given })
    }

    /// Goes on with the script to this time of the scene \[s\], fingers closed by so much more \[m\].
    pub fn command(&mut self, time: f64, press: f64) {
        self.press = press;
        if let Some(motion) = &mut self.motion {
            motion.sample(time, &mut self.targets);
            self.commanded = self.live.pose_of(&self.targets);
        }
    }

    /// Moves for `h` \[s\] under the forces on its pads, which open, and one that closes; how far each finger went
    /// \[m\].
    pub fn advance(&mut self, h: f64, forces: &[f64; DIGITS], push: f64) -> [f64; DIGITS] {
        let mut moved = [0.0; DIGITS];
        for ((finger, force), moved) in self.fingers.iter_mut().zip(forces).zip(&mut moved) {
            let before = finger.place;
            finger.advance(&self.human, push - force, h);
            *moved = finger.place - before;
        }
        moved
    }

    /// Where the hand is, each number off by `noise` \[m\] at the pads.
    pub fn pose(&self, noise: &mut impl FnMut() -> f64) -> LivePose {
        let mut pose = self.commanded.clone();
        if let LivePose::Angles { wrist, angles } = &mut pose {
            wrist.position.iter_mut().for_each(|x| *x += noise());
            for (k, finger) in self.fingers.iter().enumerate() {
                angles[4 * k] += (self.press + finger.place + noise()) / self.levers[k];
            }
        }
        pose
    }
}

fn bones(session: &Session) -> std::ops::Range<usize> {
    let bones = &session.hands()[0].handle.bones;
    bones.start as usize..bones.end as usize
}

/// From the root of each finger to its pad \[m\]; a hand's breadth for a finger that the hand lacks.
fn levers(model: &HandModel) -> [f64; DIGITS] {
    let pads = Pad::of_hand(model);
    std::array::from_fn(|k| {
        let digit = Digit::FINGERS[k];
        let root = model.bones.iter().find(|bone| bone.digit == digit);
        let pad = pads.iter().find(|pad| pad.digit == digit);
        let (Some(root), Some(pad)) = (root, pad) else { return 0.08 };
        let at = model.bones[pad.bone].pose_MB.point(&pad.point_B);
        (at - root.pose_MB.point(&root.ends_B[0])).norm().max(0.01)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `x = f/k (1 - e^(-ζωt)(cos ω_d t + ζω/ω_d sin ω_d t))`, and at rest f/k.
    #[test]
    fn fingers_move_as_they_should() {
        for (mass, damping, stiffness) in [(0.02, 1.0, 500.0), (0.05, 1.0, 50.0), (2.0, 1.0, 50.0)]
        {
            let human = Human { mass, damping, stiffness };
            let mut finger = Finger::default();
            let decay: f64 = damping / (2.0 * mass);
            let rate = (stiffness / mass - decay * decay).sqrt();
            for ms in 1..=500 {
                finger.advance(&human, 0.7, 1e-3);
                let t = 1e-3 * f64::from(ms);
                let swing = (rate * t).cos() + decay / rate * (rate * t).sin();
                let want = 0.7 / stiffness * (1.0 - (-decay * t).exp() * swing);
                assert!((finger.place - want).abs() < 1e-9, "{human:?} {ms} ms");
            }
        }
    }
}
