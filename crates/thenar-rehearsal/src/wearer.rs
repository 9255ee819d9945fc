//! A hand whose fingers give way: each a mass on a spring and a damper, which its command holds.

use thenar_core::model::{Digit, HandModel};
use thenar_core::world::Target;
use thenar_core::{Mat3, Vec3};
use thenar_link::DIGITS;
use thenar_scene::motion::HandMotion;
use thenar_scene::session::Session;
use thenar_touch::Pad;
use thenar_track::live::{LiveError, LiveHand, LivePose};

/// Mass \[kg\], damping \[N s/m\] and stiffness \[N/m\] at a fingertip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FingerImpedance {
    /// Mass \[kg\].
    pub mass: f64,
    /// Damping \[N s/m\].
    pub damping: f64,
    /// Stiffness \[N/m\].
    pub stiffness: f64,
}

/// Fingertip of the wearer, by how far it is beyond its command, closing \[m\], and how fast
/// \[m/s\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Finger {
    /// Place \[m\].
    pub place: f64,
    /// Speed \[m/s\].
    pub speed: f64,
}

/// Flow of `m ẍ + b ẋ + k x = f` over a time h in which f is constant, exact however stiff: the
/// exponential of its matrix in `(x, ẋ h, f h²/m)`.
#[derive(Clone, Copy, Debug)]
pub struct Flow {
    over: Mat3,
    h: f64,
    mass: f64,
}

impl Flow {
    /// The flow of such a finger over `h` \[s\].
    pub fn new(human: &FingerImpedance, h: f64) -> Self {
        let [damping, stiffness] =
            [human.damping * h, human.stiffness * h * h].map(|x| x / human.mass);
        #[rustfmt::skip]
        let rates = Mat3::new(
            0.0, 1.0, 0.0,
            -stiffness, -damping, 1.0,
            0.0, 0.0, 0.0,
        );
        Self { over: rates.exp(), h, mass: human.mass }
    }
}

impl Finger {
    /// Moves for the flow's time under a constant force \[N\].
    pub fn advance(&mut self, flow: &Flow, force: f64) {
        let Flow { over, h, mass } = flow;
        let after = over * Vec3::new(self.place, self.speed * h, force * h * h / mass);
        (self.place, self.speed) = (after.x, after.y / h);
    }
}

/// A hand of five such fingers.
pub(super) struct RehearsedHand {
    human: FingerImpedance,
    flow: Flow,
    live: LiveHand,
    motion: Option<HandMotion>,
    targets: Vec<Option<Target>>,
    /// Pose that the script commands.
    commanded: LivePose,
    /// Further distance that the fingers are to close \[m\].
    press: f64,
    /// Part of `press` that the last command added \[m\].
    closed: f64,
    /// From the root of each finger to its pad \[m\].
    levers: [f64; DIGITS],
    pub fingers: [Finger; DIGITS],
    /// Energy given to each since its command stood still \[J\].
    pub given: [f64; DIGITS],
    /// Energy given to each and to what closes it, less what its damper took up, since the script
    /// ended \[J\].
    pub beyond: [f64; DIGITS],
}

impl RehearsedHand {
    /// A hand of such fingers, which move in steps of `h` \[s\].
    pub fn new(session: &Session, human: &FingerImpedance, h: f64) -> Result<Self, LiveError> {
        let mut live = session.live_hand(0)?;
        let model = &session.hands()[0].model;
        let targets = session.input().targets[bones(session)].to_vec();
        let commanded = live.pose_of(&targets);
        let (motion, levers) = (session.hands()[0].motion.clone(), levers(model));
        Ok(Self {
            human: *human,
            flow: Flow::new(human, h),
            live,
            motion,
            targets,
            commanded,
            press: 0.0,
            closed: 0.0,
            levers,
            fingers: [Finger::default(); DIGITS],
            given: [0.0; DIGITS],
            beyond: [0.0; DIGITS],
        })
    }

    /// Goes on with the script to this time of the scene \[s\], fingers closed by so much more
    /// \[m\].
    pub fn command(&mut self, time: f64, press: f64) {
        self.closed = press - std::mem::replace(&mut self.press, press);
        if let Some(motion) = &mut self.motion {
            motion.sample(time, &mut self.targets);
            self.commanded = self.live.pose_of(&self.targets);
        }
    }

    /// Returns how much farther the fingers are to close than the script has them \[m\].
    pub fn press(&self) -> f64 {
        self.press
    }

    /// Moves for a step under the forces on its pads, which open, and one that closes; how far each
    /// finger went \[m\].
    pub fn advance(&mut self, forces: &[f64; DIGITS], push: f64) -> [f64; DIGITS] {
        let mut moved = [0.0; DIGITS];
        for (k, finger) in self.fingers.iter_mut().enumerate() {
            let before = finger.place;
            finger.advance(&self.flow, push - forces[k]);
            moved[k] = finger.place - before;
            // Its damping takes up what it does at the speed at which the finger moves, with its
            // command and beyond.
            let way = moved[k] + self.closed;
            let heat = self.human.damping * way * way / self.flow.h;
            self.beyond[k] += -forces[k] * way - heat;
        }
        moved
    }

    /// Returns the hand's pose, each number off by `noise` \[m\] at the pads.
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

/// From the root of each finger to its pad \[m\]; a hand's breadth for a finger that the hand
/// lacks.
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
            let human = FingerImpedance { mass, damping, stiffness };
            let mut finger = Finger::default();
            let decay: f64 = damping / (2.0 * mass);
            let rate = (stiffness / mass - decay * decay).sqrt();
            let flow = Flow::new(&human, 1e-3);
            for ms in 1..=500 {
                finger.advance(&flow, 0.7);
                let t = 1e-3 * f64::from(ms);
                let swing = (rate * t).cos() + decay / rate * (rate * t).sin();
                let want = 0.7 / stiffness * (1.0 - (-decay * t).exp() * swing);
                assert!((finger.place - want).abs() < 1e-9, "{human:?} {ms} ms");
            }
        }
    }
    /// A gram in the thickest honey, B/M of a million a second: `v = f/b (1 - e^(-b t/m))`, without
    /// a spring and on one that takes minutes.
    #[test]
    fn fingers_in_honey_creep() {
        for stiffness in [0.0, 1e-3] {
            let human = FingerImpedance { mass: 1e-3, damping: 1000.0, stiffness };
            let flow = Flow::new(&human, 1e-3);
            let mut finger = Finger::default();
            (0..1000).for_each(|_| finger.advance(&flow, 2.0));
            assert!((finger.place - 2e-3).abs() < 1e-8, "{finger:?}");
            assert!((finger.speed - 2e-3).abs() < 1e-8, "{finger:?}");
        }
        // Light and on the stiffest spring: at rest at f/k.
        let human = FingerImpedance { mass: 1e-3, damping: 300.0, stiffness: 1e5 };
        let flow = Flow::new(&human, 1e-3);
        let mut finger = Finger::default();
        (0..1000).for_each(|_| finger.advance(&flow, 2.0));
        assert!((finger.place - 2e-5).abs() < 1e-12 && finger.speed.abs() < 1e-9, "{finger:?}");
    }
}
