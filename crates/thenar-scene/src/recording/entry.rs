//! Inputs of a session, as a recording keeps them.

use super::state::{MemorylessState, MemorylessStateRef};
use crate::flat::{FlatTarget, Flattened, flat_pose, pose, target};
use crate::grip::Order;
use crate::live::LivePose;
use crate::session::Entry;
use crate::text::plain;
use crate::tuning::SettingValue;
use serde::{Deserialize, Serialize};
use std::fmt;
use thenar_core::kernels::HeldPlace;
use thenar_core::world::{State, Target};

/// An input frame, in postcard's encoding: after `number` steps this entered.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Input {
    /// Steps made since the scene frame.
    pub number: u64,
    /// Content of the input.
    pub what: InputKind,
}

/// Content of an input. Variants are numbered from 0 in the file; new ones come last.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub enum InputKind {
    Joints { hand: u32, time: f64, joints: Vec<[f64; 7]>, radii: Vec<f64> },
    Angles { hand: u32, time: f64, wrist: [f64; 7], angles: Vec<f64> },
    Lost { hand: u32 },
    Script { hand: u32 },
    Restart,
    SetNumber { key: String, value: f64 },
    SetChoice { key: String, value: String },
    Lead { hand: u32, targets: Vec<FlatTarget> },
    LetGo { hand: u32 },
    Resume { state: Box<MemorylessState> },
    ResumeRemembering { state: Box<MemorylessState>, faded: Vec<[f64; 6]> },
    Grip { hand: u32, order: Order },
    Release { hand: u32 },
    GripAdapting { hand: u32, order: Order },
    ResumeHolding { state: Box<MemorylessState>, faded: Vec<[f64; 6]>, places: Vec<HeldPlace> },
}

/// A borrowed input, to be written: nothing is copied to the heap.
#[derive(Debug, Serialize)]
pub struct InputRef<'a> {
    pub number: u64,
    pub what: InputKindRef<'a>,
}

/// Variants as those of [`InputKind`].
#[derive(Debug, Serialize)]
pub enum InputKindRef<'a> {
    Joints { hand: u32, time: f64, joints: &'a [[f64; 7]], radii: &'a [f64] },
    Angles { hand: u32, time: f64, wrist: [f64; 7], angles: &'a [f64] },
    Lost { hand: u32 },
    Script { hand: u32 },
    Restart,
    SetNumber { key: &'a str, value: f64 },
    SetChoice { key: &'a str, value: &'a str },
    Lead { hand: u32, targets: Flattened<'a, Target> },
    LetGo { hand: u32 },
    Resume { state: MemorylessStateRef<'a> },
    ResumeRemembering { state: MemorylessStateRef<'a>, faded: &'a [[f64; 6]] },
    Grip { hand: u32, order: &'a Order },
    Release { hand: u32 },
    GripAdapting { hand: u32, order: &'a Order },
    ResumeHolding { state: MemorylessStateRef<'a>, faded: &'a [[f64; 6]], places: &'a [HeldPlace] },
}

/// Hands an entry on in the form in which it is written.
pub fn with_ref(number: u64, entry: Entry<'_>, then: impl FnOnce(&InputRef<'_>)) {
    let give = |what| then(&InputRef { number, what });
    match entry {
        Entry::Pose { hand, time, pose: LivePose::Joints { joints, radii } } => {
            let joints: [[f64; 7]; 25] = std::array::from_fn(|k| flat_pose(&joints[k]));
            give(InputKindRef::Joints { hand: hand as u32, time, joints: &joints, radii });
        }
        Entry::Pose { hand, time, pose: LivePose::Angles { wrist, angles } } => {
            let wrist = flat_pose(wrist);
            give(InputKindRef::Angles { hand: hand as u32, time, wrist, angles });
        }
        Entry::Lost { hand } => give(InputKindRef::Lost { hand: hand as u32 }),
        Entry::Script { hand } => give(InputKindRef::Script { hand: hand as u32 }),
        Entry::Lead { hand, targets } => {
            give(InputKindRef::Lead { hand: hand as u32, targets: Flattened(targets) });
        }
        Entry::LetGo { hand } => give(InputKindRef::LetGo { hand: hand as u32 }),
        Entry::Resume { state } if !state.sides.places().is_empty() => {
            let (faded, places) = (&state.faded[..], state.sides.places());
            give(InputKindRef::ResumeHolding { state: state.into(), faded, places });
        }
        Entry::Resume { state } if state.faded.is_empty() => {
            give(InputKindRef::Resume { state: state.into() });
        }
        Entry::Resume { state } => {
            give(InputKindRef::ResumeRemembering { state: state.into(), faded: &state.faded });
        }
        Entry::Grip { hand, order } if order.adapts => {
            give(InputKindRef::GripAdapting { hand: hand as u32, order });
        }
        Entry::Grip { hand, order } => give(InputKindRef::Grip { hand: hand as u32, order }),
        Entry::Release { hand } => give(InputKindRef::Release { hand: hand as u32 }),
        Entry::Restart => give(InputKindRef::Restart),
        Entry::Set { key, value: SettingValue::Number(value) } => {
            give(InputKindRef::SetNumber { key, value: *value });
        }
        Entry::Set { key, value: SettingValue::Choice(value) } => {
            give(InputKindRef::SetChoice { key, value });
        }
    }
}

impl InputKind {
    /// True for what comes many times a second.
    pub fn is_often(&self) -> bool {
        matches!(
            self,
            Self::Joints { .. }
                | Self::Angles { .. }
                | Self::Lead { .. }
                | Self::Resume { .. }
                | Self::ResumeRemembering { .. }
                | Self::ResumeHolding { .. }
        )
    }

    /// Hands it on as the session takes it. `None` when it has the wrong number of joints or
    /// angles.
    pub fn with_entry<R>(&self, then: impl FnOnce(Entry<'_>) -> R) -> Option<R> {
        Some(match self {
            Self::Joints { hand, time, joints, radii } => {
                let joints: [[f64; 7]; 25] = joints[..].try_into().ok()?;
                let radii = radii[..].try_into().ok()?;
                let pose = LivePose::Joints { joints: joints.each_ref().map(pose), radii };
                then(Entry::Pose { hand: *hand as usize, time: *time, pose: &pose })
            }
            Self::Angles { hand, time, wrist, angles } => {
                let angles = angles[..].try_into().ok()?;
                let pose = LivePose::Angles { wrist: pose(wrist), angles };
                then(Entry::Pose { hand: *hand as usize, time: *time, pose: &pose })
            }
            Self::Lost { hand } => then(Entry::Lost { hand: *hand as usize }),
            Self::Script { hand } => then(Entry::Script { hand: *hand as usize }),
            Self::Lead { hand, targets } => {
                let targets: Vec<Target> = targets.iter().map(target).collect();
                then(Entry::Lead { hand: *hand as usize, targets: &targets })
            }
            Self::LetGo { hand } => then(Entry::LetGo { hand: *hand as usize }),
            Self::Resume { state } => then(Entry::Resume { state: &state.0 }),
            Self::ResumeRemembering { state, faded } => {
                let state = State { faded: faded.clone(), ..state.0.clone() };
                then(Entry::Resume { state: &state })
            }
            Self::ResumeHolding { state, faded, places } => {
                let sides = state.0.sides.clone().with_places(places.clone());
                let state = State { faded: faded.clone(), sides, ..state.0.clone() };
                then(Entry::Resume { state: &state })
            }
            Self::Grip { hand, order } => then(Entry::Grip { hand: *hand as usize, order }),
            Self::GripAdapting { hand, order } => {
                then(Entry::Grip { hand: *hand as usize, order: &order.adapting(true) })
            }
            Self::Release { hand } => then(Entry::Release { hand: *hand as usize }),
            Self::Restart => then(Entry::Restart),
            Self::SetNumber { key, value } => {
                then(Entry::Set { key, value: &SettingValue::Number(*value) })
            }
            Self::SetChoice { key, value } => {
                then(Entry::Set { key, value: &SettingValue::Choice(value.clone()) })
            }
        })
    }
}

impl fmt::Display for InputKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Joints { hand, .. } => write!(f, "joints of hand {hand}"),
            Self::Angles { hand, .. } => write!(f, "angles of hand {hand}"),
            Self::Lost { hand } => write!(f, "hand {hand} is not tracked"),
            Self::Script { hand } => write!(f, "hand {hand} follows its script"),
            Self::Lead { hand, .. } => write!(f, "targets of hand {hand}"),
            Self::LetGo { hand } => write!(f, "hand {hand} is led no more"),
            Self::Resume { .. } | Self::ResumeRemembering { .. } | Self::ResumeHolding { .. } => {
                write!(f, "the state of another simulation")
            }
            Self::Grip { hand, order } | Self::GripAdapting { hand, order } => {
                write!(f, "{} of hand {hand}", order.kind.name())
            }
            Self::Release { hand } => write!(f, "hand {hand} opens"),
            Self::Restart => write!(f, "restart"),
            Self::SetNumber { key, value } => write!(f, "{key} = {}", plain(*value)),
            Self::SetChoice { key, value } => write!(f, "{key} = {value}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::{Pose, Quat, Vec3};

    /// An entry goes through the file's form and back with all its bits.
    #[track_caller]
    fn check(entry: Entry<'_>) {
        let mut bytes = Vec::new();
        with_ref(1 << 40, entry, |input| super::super::content::append(&mut bytes, input));
        let input: Input = postcard::from_bytes(&bytes).unwrap();
        assert_eq!(input.number, 1 << 40);
        // Debug's numbers tell every bit but those of NaN, which nothing takes.
        let back = input.what.with_entry(|back| format!("{back:?}"));
        assert_eq!(back, Some(format!("{entry:?}")));
    }

    #[test]
    fn entries_come_back_as_they_were() {
        // Not quite a unit quaternion, as a tracker sends it.
        let odd = Quat::new_unchecked(nalgebra::Quaternion::new(0.7, -0.1, 0.4, 0.601));
        let frame = |k: usize| Pose::new(Vec3::new(k as f64, -0.0, 1.0 / 3.0), odd);
        let joints = std::array::from_fn(frame);
        let radii = std::array::from_fn(|k| 1e-3 * k as f64);
        let pose = LivePose::Joints { joints, radii };
        check(Entry::Pose { hand: 1, time: 12.5, pose: &pose });
        let angles = std::array::from_fn(|k| -0.1 * k as f64);
        let pose = LivePose::Angles { wrist: frame(3), angles };
        check(Entry::Pose { hand: 0, time: -1e-300, pose: &pose });
        check(Entry::Lost { hand: 3 });
        check(Entry::Script { hand: 0 });
        check(Entry::Restart);
        let ball = thenar_core::model::BodyId::Rigid(3);
        let order =
            Order::new(Some(ball), crate::grip::GripKind::Tripod, 1.0 / 3.0, 0.1, Some(2.5));
        check(Entry::Grip { hand: 1, order: &order });
        check(Entry::Grip { hand: 1, order: &order.adapting(true) });
        check(Entry::Release { hand: 1 });
        let target = |k: usize| Target {
            pose_WB: frame(k),
            velocity_W: Vec3::new(k as f64, 0.1, -0.2),
            angular_velocity_W: Vec3::new(-0.0, 3.0, 1e-9 * k as f64),
        };
        let targets: [Target; 16] = std::array::from_fn(target);
        check(Entry::Lead { hand: 1, targets: &targets });
        check(Entry::LetGo { hand: 1 });
        let mut world = thenar_core::World::new(thenar_core::model::WorldDesc::default()).unwrap();
        world.set_time(0.1);
        check(Entry::Resume { state: world.state() });
        let faded = vec![[0.1, -0.0, 1e300, 1.0 / 3.0, -7.0, 5e-324]; 3];
        check(Entry::Resume { state: &State { faded: faded.clone(), ..world.state().clone() } });
        let place = HeldPlace {
            key: [0, 17, 3, 2],
            weights: [0.25, 0.75, -0.0],
            way: [1.0 / 3.0, 5e-324, -1e-9],
            part: 0.5,
        };
        for faded in [Vec::new(), faded] {
            let sides = world.state().sides.clone().with_places(vec![place; 2]);
            check(Entry::Resume { state: &State { faded, sides, ..world.state().clone() } });
        }
        check(Entry::Set { key: "friction", value: &SettingValue::Number(0.25) });
        check(Entry::Set { key: "solver", value: &SettingValue::Choice("two-step".into()) });
    }

    #[test]
    fn a_pose_with_too_few_joints_is_none() {
        let what =
            InputKind::Joints { hand: 0, time: 0.0, joints: vec![[0.0; 7]; 24], radii: vec![] };
        assert_eq!(what.with_entry(|_| ()), None);
    }
}
