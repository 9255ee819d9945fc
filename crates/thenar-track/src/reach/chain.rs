//! One digit as a chain of joints from the palm to a pad, and where the pad is.

use thenar_core::kinematics::Tree;
use thenar_core::model::{Digit, HandModel, JointDesc, JointKind};
use thenar_core::readout::TaxelSkin;
use thenar_core::{Pose, Vec3};

/// Most freedoms of a chain: a thumb with a metacarpal of its own has five, a finger with one six.
pub const FREEDOMS_MAX: usize = 6;
/// Most bones of a chain, the palm included.
const BONES_MAX: usize = 6;
/// Angles of a chain, in the order of its freedoms \[rad\].
pub type Angles = [f64; FREEDOMS_MAX];

/// Place of a pad along the last bone, from its joint (0) to its end (1): a little nearer to the
/// end, where people put fingertips down.
pub const ALONG: f64 = 0.55;

/// Place of a pad on a digit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PadPlace {
    /// The palm's side of the last bone.
    Tip,
    /// The thumb's side of the last bone but one.
    Side,
}

/// One angle of a chain.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Freedom {
    /// Joint of the hand.
    pub joint: usize,
    /// Number of the angle among the joint's axes.
    pub axis: usize,
    /// Range \[rad\].
    pub range: [f64; 2],
    /// Angle at ease \[rad\]: what pads leave open is brought near to it.
    pub ease: f64,
    /// Joint of the chain.
    link: usize,
}

impl Freedom {
    /// True where a turn by `way` from `angle` goes on beyond an end of the range \[rad\].
    pub fn ends(&self, angle: f64, way: f64) -> bool {
        let [low, high] = self.range;
        (angle >= high && way > 0.0) || (angle <= low && way < 0.0)
    }
}

/// A patch of skin that grips: round about a point on the axis of its bone, so that what it touches
/// is as far from there however the finger is turned.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Pad {
    /// Bone of the hand that it is on.
    pub bone: usize,
    /// Centre, on the bone's axis, in that bone's frame \[m\].
    pub centre_B: Vec3,
    /// From the centre to the skin at rest \[m\].
    pub radius: f64,
    /// From the centre to the middle of the pad.
    pub normal_B: Vec3,
}

/// A digit's joints from the palm outwards.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Chain {
    /// Digit that is led.
    pub digit: Digit,
    /// Pad on its last bone, or on the one before.
    pub pad: Pad,
    /// Bones of the hand in it, the palm first.
    pub bones: Vec<usize>,
    /// Angles of its joints.
    pub freedoms: Vec<Freedom>,
    tree: Tree,
}

/// Place of a chain's pad, in the palm's frame, and its change with each freedom.
#[derive(Clone, Copy, Debug)]
pub struct PadKinematics {
    /// The pad's centre \[m\].
    pub centre: Vec3,
    /// Out of the skin.
    pub normal: Vec3,
    /// Change of the centre with each angle \[m/rad\].
    pub moves: [Vec3; FREEDOMS_MAX],
    /// Axis about which each angle turns it.
    pub turns: [Vec3; FREEDOMS_MAX],
}

impl Chain {
    /// The chain of a digit with its pad; `None` where the hand has no such digit, no skin there,
    /// or joints that make no chain of hinges.
    pub fn new(hand: &HandModel, digit: Digit, place: PadPlace) -> Option<Self> {
        let last = hand.bones.iter().rposition(|bone| bone.digit == digit)?;
        let tip = match place {
            PadPlace::Tip => last,
            PadPlace::Side => hand.bones[last].parent? as usize,
        };
        // A bone beyond the pad goes with it: left where it was, it would hold the finger back.
        let mut bones = vec![last];
        while *bones.last()? != 0 {
            bones.push(hand.bones[*bones.last()?].parent? as usize);
        }
        bones.reverse();
        if !(2..=BONES_MAX).contains(&bones.len()) {
            return None;
        }
        let joints: Vec<JointDesc> = (1..bones.len())
            .map(|link| JointDesc {
                parent: Some(link as u32 - 1),
                child: link as u32,
                ..hand.joints[bones[link] - 1].clone()
            })
            .collect();
        let tree = Tree::new(bones.len(), &joints).ok()?;
        let freedoms = freedoms(&bones, &joints);
        let fits = (1..=FREEDOMS_MAX).contains(&freedoms.len());
        let pad = pad(hand, tip, place)?;
        fits.then_some(Self { digit, pad, bones, freedoms, tree })
    }

    /// Angles among those of all joints of the hand.
    pub fn read(&self, angles: &[[f64; 2]]) -> Angles {
        let mut own = [0.0; FREEDOMS_MAX];
        for (own, freedom) in own.iter_mut().zip(&self.freedoms) {
            *own = angles[freedom.joint][freedom.axis];
        }
        own
    }

    /// Angles at ease.
    pub fn ease(&self) -> Angles {
        let mut ease = [0.0; FREEDOMS_MAX];
        for (ease, freedom) in ease.iter_mut().zip(&self.freedoms) {
            *ease = freedom.ease;
        }
        ease
    }

    /// The nearest angles within the ranges.
    pub fn within(&self, mut angles: Angles) -> Angles {
        for (angle, Freedom { range: [low, high], .. }) in angles.iter_mut().zip(&self.freedoms) {
            *angle = angle.clamp(*low, *high);
        }
        angles
    }

    /// Returns the place of the pad at these angles.
    pub fn reach(&self, angles: &Angles) -> PadKinematics {
        let (poses, angles) = self.forward(&Pose::identity(), angles);
        let tip = self.pad_link();
        let centre = poses[tip].point(&self.pad.centre_B);
        let mut reached = PadKinematics {
            centre,
            normal: poses[tip].vector(&self.pad.normal_B),
            moves: [Vec3::zeros(); FREEDOMS_MAX],
            turns: [Vec3::zeros(); FREEDOMS_MAX],
        };
        let arm = centre - poses[tip].position;
        let (mut rates, mut velocities) = ([[0.0; 2]; BONES_MAX], [[Vec3::zeros(); 2]; BONES_MAX]);
        let n = self.bones.len();
        for (k, freedom) in self.freedoms.iter().enumerate() {
            rates[freedom.link][freedom.axis] = 1.0;
            let (rates, velocities) = (&mut rates[..n - 1], &mut velocities[..n]);
            let still = [Vec3::zeros(); 2];
            self.tree.velocities(&poses[..n], still, &angles[..n - 1], rates, velocities);
            rates[freedom.link][freedom.axis] = 0.0;
            let [velocity, spin] = velocities[tip];
            (reached.moves[k], reached.turns[k]) = (velocity + spin.cross(&arm), spin);
        }
        reached
    }

    /// Hands out pose and velocities (linear, angular) of each of its bones but the palm, whose own
    /// are given, at these angles and rates; the first argument is the bone's number in the hand.
    pub fn bones_at(
        &self,
        palm: (&Pose, [Vec3; 2]),
        angles: &Angles,
        rates: &Angles,
        mut to: impl FnMut(usize, Pose, [Vec3; 2]),
    ) {
        let n = self.bones.len();
        let (poses, pairs) = self.forward(palm.0, angles);
        let rates = self.pairs(rates);
        let mut velocities = [[Vec3::zeros(); 2]; BONES_MAX];
        self.tree.velocities(
            &poses[..n],
            palm.1,
            &pairs[..n - 1],
            &rates[..n - 1],
            &mut velocities[..n],
        );
        for link in 1..n {
            to(self.bones[link], poses[link], velocities[link]);
        }
    }

    /// Link of the bone that has the pad.
    fn pad_link(&self) -> usize {
        let last = self.bones.len() - 1;
        self.bones.iter().position(|bone| *bone == self.pad.bone).unwrap_or(last)
    }

    fn forward(&self, palm: &Pose, angles: &Angles) -> ([Pose; BONES_MAX], [[f64; 2]; BONES_MAX]) {
        let n = self.bones.len();
        let pairs = self.pairs(angles);
        let mut poses = [Pose::identity(); BONES_MAX];
        self.tree.forward(palm, &pairs[..n - 1], &mut poses[..n]);
        (poses, pairs)
    }

    /// Writes its angles among those of all joints of the hand.
    pub fn write(&self, own: &Angles, angles: &mut [[f64; 2]]) {
        for (own, freedom) in own.iter().zip(&self.freedoms) {
            angles[freedom.joint][freedom.axis] = *own;
        }
    }

    fn pairs(&self, angles: &Angles) -> [[f64; 2]; BONES_MAX] {
        let mut pairs = [[0.0; 2]; BONES_MAX];
        for (freedom, angle) in self.freedoms.iter().zip(angles) {
            pairs[freedom.link][freedom.axis] = *angle;
        }
        pairs
    }
}

/// Part of a range of flexion, from its straight end, at which a joint is at ease.
const EASE: f64 = 0.35;

fn freedoms(bones: &[usize], joints: &[JointDesc]) -> Vec<Freedom> {
    let mut freedoms = Vec::new();
    for (link, desc) in joints.iter().enumerate() {
        let axes = match desc.kind {
            JointKind::Hinge => 1,
            JointKind::Universal => 2,
            _ => 0,
        };
        for axis in 0..axes {
            let whole = [-std::f64::consts::PI, std::f64::consts::PI];
            let [low, high] = desc.axes[axis].limit.map_or(whole, |limit| [limit.min, limit.max]);
            let straight = 0.0f64.clamp(low, high);
            let far = if high.abs() > low.abs() { high } else { low };
            // A joint that spreads is at ease where it rests.
            let spreads = desc.kind == JointKind::Universal && axis == 0;
            let ease = if spreads {
                desc.axes[axis].rest_angle
            } else {
                straight + EASE * (far - straight)
            };
            let joint = bones[link + 1] - 1;
            let ease = ease.clamp(low, high);
            freedoms.push(Freedom { joint, axis, range: [low, high], ease, link });
        }
    }
    freedoms
}

/// The palm's side of any bone, as a pad; `None` where it has no length.
pub fn palmar_pad(hand: &HandModel, bone: usize) -> Option<Pad> {
    pad(hand, bone, PadPlace::Tip)
}

/// The pad on a bone: where a line from the bone's axis leaves the skin at rest.
fn pad(hand: &HandModel, bone: usize, place: PadPlace) -> Option<Pad> {
    let of = &hand.bones[bone];
    let [from, to] = of.ends_B;
    let along = (to - from).try_normalize(1e-9)?;
    let palmar = (along * along.y - Vec3::y()).try_normalize(1e-9)?;
    let normal_B = match place {
        PadPlace::Tip => palmar,
        PadPlace::Side => towards_thumb(hand, bone, &along)?,
    };
    let on_axis = from + (to - from) * ALONG;
    let parts = hand.collision_digits.iter().map(|digit| digit.part()).collect();
    let skin = TaxelSkin::new(&hand.flesh, parts);
    // A skeleton without flesh grips with its bones.
    let way =
        skin.way(&of.pose_MB.point(&on_axis), &of.pose_MB.vector(&normal_B)).unwrap_or(of.radius);
    Some(Pad { bone, centre_B: on_axis, radius: way, normal_B })
}

/// Across a bone, to the side on which the hand has its thumb.
fn towards_thumb(hand: &HandModel, bone: usize, along: &Vec3) -> Option<Vec3> {
    let knuckle = |digit: Digit| {
        let joint = hand.joints.iter().find(|joint| {
            joint.parent == Some(0)
                && hand.bones.get(joint.child as usize).is_some_and(|bone| bone.digit == digit)
        })?;
        Some(hand.bones[0].pose_MB.point(&joint.pose_PJ.position))
    };
    let across_M = knuckle(Digit::Index)? - knuckle(Digit::Little)?;
    let across = hand.bones[bone].pose_MB.inverse_vector(&across_M);
    (across - along * along.dot(&across)).try_normalize(1e-9)
}
