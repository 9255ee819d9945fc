//! The finger pads: where a hand's forces are shown, and how they move.

use crate::{PAD_NORMAL_B, Touch, pad_force};
use thenar_core::math::{Pose, Vec3};
use thenar_core::model::{Digit, HandModel};

/// One finger pad and how it moved since it was last read.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Pad {
    /// The finger.
    pub digit: Digit,
    /// Distal bone of the digit.
    pub bone: usize,
    /// The pad in the bone's frame \[m\].
    pub point_B: Vec3,
    /// The bone that the device stands on: the palm for a glove, which feels nothing of the hand's
    /// motion as a whole; `None` for one that stands on the table.
    pub ground: Option<usize>,
    /// Last place of the pad, in the ground's frame.
    last_G: Option<Vec3>,
}

/// Force and motion of one pad, for the guard of its actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PadReading {
    /// Force of the device coupling on the wearer, world \[N\].
    pub force_W: Vec3,
    /// Part of the force along the inward pad normal \[N\]: positive when something presses on the
    /// pad.
    pub pad_force: f64,
    /// Mean velocity of the tracked pad against its ground since the last reading, along the same
    /// normal \[m/s\]:
    /// positive when the finger opens. Force times velocity is power given to the wearer. Zero in
    /// the tick of a jump, which is the tracker's motion and not the wearer's.
    pub opening_velocity: f64,
}

impl Pad {
    /// The pad of this bone, on the table.
    pub fn new(digit: Digit, bone: usize, point_B: Vec3) -> Self {
        Self { digit, bone, point_B, ground: None, last_G: None }
    }

    /// The pads of a hand for a glove, thumb first: on the last bone of each finger, where the bone
    /// ends, against the palm.
    pub fn of_hand(hand: &HandModel) -> Vec<Self> {
        (Digit::FINGERS.into_iter())
            .filter_map(|digit| {
                let bone = hand.bones.iter().rposition(|bone| bone.digit == digit)?;
                let pad = Self::new(digit, bone, hand.bones[bone].ends_B[1]);
                Some(Self { ground: Some(0), ..pad })
            })
            .collect()
    }

    /// Reads the pad after a tick that took `h` \[s\].
    pub fn read(&mut self, hand: &(impl Touch + ?Sized), h: f64) -> PadReading {
        let pose_WB = hand.tracked()[self.bone].pose_WB;
        let pose_WG = self.ground.map_or(Pose::identity(), |ground| hand.tracked()[ground].pose_WB);
        let point_G = pose_WG.inverse_point(&pose_WB.point(&self.point_B));
        let jumped = hand.jumped(self.bone) || self.ground.is_some_and(|g| hand.jumped(g));
        let before = self.last_G.replace(point_G).filter(|_| !jumped).unwrap_or(point_G);
        let [force_W, _] = hand.device_wrenches()[self.bone];
        let normal_G = pose_WG.inverse_vector(&pose_WB.vector(&PAD_NORMAL_B));
        let opening = -(point_G - before).dot(&normal_G);
        PadReading {
            force_W,
            pad_force: pad_force(&force_W, &pose_WB),
            opening_velocity: if h > 0.0 { opening / h } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoneFrame, CouplingDesign, HandSettings, HapticHand, RigidState};
    use thenar_core::math::{Mat3, Quat};
    use thenar_core::model::{Bone, CouplingKind, EmbeddedSurface, Flesh};

    /// A palm and two fingers of two bones, in the order of a model.
    fn hand() -> HandModel {
        let bone = |name: &str, digit: Digit| Bone {
            name: name.into(),
            parent: None,
            pose_MB: Pose::identity(),
            mass: 0.004,
            inertia: Mat3::from_diagonal_element(1e-7),
            digit,
            ends_B: [Vec3::z() * 0.01, Vec3::z() * -0.012],
            radius: 0.004,
            tracked_joint: None,
            pose_BT: Pose::identity(),
        };
        HandModel {
            name: "two fingers".into(),
            side: None,
            bones: vec![
                bone("palm", Digit::Palm),
                bone("index-proximal", Digit::Index),
                bone("index-distal", Digit::Index),
                bone("thumb-proximal", Digit::Thumb),
                bone("thumb-distal", Digit::Thumb),
            ],
            joints: Vec::new(),
            flesh: Flesh {
                nodes: Vec::new(),
                tets: Vec::new(),
                materials: Vec::new(),
                relaxation: Vec::new(),
                mass_damping: 0.0,
                stiffness_damping: 0.0,
                fixed: Vec::new(),
                collision: EmbeddedSurface::default(),
                friction: 0.5,
            },
            bindings: Vec::new(),
            node_volumes: Vec::new(),
            render: EmbeddedSurface::default(),
            collision_digits: Vec::new(),
            length: 0.18,
            solids: Vec::new(),
            coupling: CouplingKind::Uniform,
            bone_nodes: Vec::new(),
            regions: Vec::new(),
            nail_nodes: Vec::new(),
            bending: Vec::new(),
        }
    }

    #[test]
    fn pads_are_at_the_ends_of_the_last_bones() {
        let pads = Pad::of_hand(&hand());
        let places: Vec<_> = pads.iter().map(|pad| (pad.digit, pad.bone)).collect();
        assert_eq!(places, [(Digit::Thumb, 4), (Digit::Index, 2)]);
        assert_eq!(pads[0].point_B, Vec3::z() * -0.012);
    }

    /// A finger flexing about its knuckle into something that holds it back: the pad closes at
    /// rate × length, and the force presses on it.
    #[test]
    fn a_closing_finger_that_is_held_back_takes_no_power() {
        let model = hand();
        let start = [RigidState::at_rest(Pose::identity()); 5];
        let design = CouplingDesign::default();
        let settings = HandSettings::default();
        let mut loops = HapticHand::new(settings, design.hand(&model), &start, 0).unwrap();
        let frame = BoneFrame::new(&start, 0);
        let mut pad = Pad::of_hand(&model)[1];
        let mut reading = None;
        for tick in 0..200u64 {
            // Flexion turns about -x and pushes the bone down, 20 mm/s at its centre.
            let t = tick as f64 * 1e-3;
            let turn = Quat::from_scaled_axis(Vec3::x() * -0.5 * t);
            let now = (tick + 1) * 1_000_000;
            loops.lead(0, RigidState::at_rest(Pose::identity()));
            let there = RigidState {
                pose_WB: Pose::new(Vec3::y() * -0.02 * t, turn),
                velocity_W: Vec3::y() * -0.02,
                angular_velocity_W: Vec3::x() * -0.5,
            };
            loops.lead(2, there);
            let report = loops.tick(now, &frame);
            reading = Some(pad.read(&loops, report.step));
        }
        let reading = reading.unwrap();
        let closing = 0.02 + 0.5 * 0.012;
        assert!((reading.opening_velocity + closing).abs() < 1e-3, "{reading:?}");
        // 4 mm through 400 N/m, and the couplings' damping.
        assert!((1.5..1.8).contains(&reading.pad_force), "{reading:?}");
        assert!(reading.pad_force * reading.opening_velocity < 0.0);
    }

    /// An arm that swings opens no finger of its glove; a device on the table sees it move.
    #[test]
    fn a_glove_does_not_see_the_hand_move_as_a_whole() {
        let model = hand();
        let start = [RigidState::at_rest(Pose::identity()); 5];
        let design = CouplingDesign::default();
        let settings = HandSettings::default();
        let mut loops = HapticHand::new(settings, design.hand(&model), &start, 0).unwrap();
        let frame = BoneFrame::new(&start, 0);
        let glove = Pad::of_hand(&model)[1];
        let mut pads = [glove, Pad { ground: None, ..glove }];
        let mut speeds = [0.0; 2];
        for tick in 0..200u64 {
            let (now, t) = ((tick + 1) * 1_000_000, tick as f64 * 1e-3);
            let pose = Pose::translation(0.0, t, 0.0);
            let there = RigidState { velocity_W: Vec3::y(), ..RigidState::at_rest(pose) };
            (0..5).for_each(|bone| loops.lead(bone, there));
            let report = loops.tick(now, &frame);
            speeds = [0, 1].map(|i| pads[i].read(&loops, report.step).opening_velocity);
        }
        assert!(speeds[0].abs() < 1e-9 && (speeds[1] - 1.0).abs() < 1e-3, "{speeds:?}");
    }
}
