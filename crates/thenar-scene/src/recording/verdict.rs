//! Verdict on a replay: whether it gave what was recorded, and if not, why.

use std::fmt;
use thenar_core::Vec3;
use thenar_core::world::State;
use thenar_record::{Build, Damage, Gap, Header};

/// The first step that gave something else.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference {
    /// Number of the scene in the recording, from 1.
    pub scene: u32,
    /// Step since that scene began; 0 is its start.
    pub step: u64,
    /// Time in the recording \[s\].
    pub time: f64,
}

/// Distance of a replay from a keyframe before it was put right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReplayDrift {
    /// Largest distance of a rigid body \[m\].
    pub rigid: f64,
    /// Largest distance of a node \[m\].
    pub node: f64,
}

impl ReplayDrift {
    pub(super) fn between(a: &State, b: &State) -> Self {
        let farthest = |pairs: &mut dyn Iterator<Item = (Vec3, Vec3)>| {
            pairs.map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
        };
        let places = |s: &State| s.poses_WB.iter().map(|p| p.position).collect::<Vec<_>>();
        Self {
            rigid: farthest(&mut places(a).into_iter().zip(places(b))),
            node: farthest(&mut a.x.iter().copied().zip(b.x.iter().copied())),
        }
    }

    pub(super) fn max(self, other: Self) -> Self {
        Self { rigid: self.rigid.max(other.rigid), node: self.node.max(other.node) }
    }
}

/// A piece of a recording that is damaged, and what that costs the replay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loss {
    /// Place and kind of the damage.
    pub damage: Damage,
    /// Time in the recording of the session's last frame before it \[s\].
    pub from: f64,
    /// Time at which the session is known again \[s\]; `None` when it is not before the end.
    pub until: Option<f64>,
}

impl fmt::Display for Loss {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { damage, from, until } = self;
        match until {
            // Nothing of the session was in it, or what was could be made again.
            Some(until) if until <= from => write!(f, "no step is lost at {from:.3} s")?,
            Some(until) => write!(f, "from {from:.3} s to {until:.3} s is lost")?,
            None => write!(f, "all from {from:.3} s on is lost")?,
        }
        write!(f, ": {damage}")
    }
}

/// Findings of a replay up to now.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Verdict {
    /// Scenes begun.
    pub scenes: u32,
    /// Steps made.
    pub steps: u64,
    /// Number of steps with the same bits.
    pub same: u64,
    /// Number of steps without a mark to compare with.
    pub unmarked: u64,
    /// Number of steps taken back: their numbers were not finite.
    pub taken_back: u64,
    /// Steps passed over on the way to a later beginning.
    pub passed: u64,
    /// Time of the session's newest frame \[s\].
    pub seconds: f64,
    /// The first difference.
    pub first: Option<Difference>,
    /// Keyframes that put the replay right, and how far it was off at most.
    pub put_right: (u64, ReplayDrift),
    /// Inputs that the session refused.
    pub refused: Vec<String>,
    /// Records of channels that were not announced, or with another number of values than
    /// announced.
    pub strays: u64,
    /// Times \[s\] and gaps of dropped frames.
    pub gaps: Vec<(f64, Gap)>,
    /// Places where the file makes no sense.
    pub losses: Vec<Loss>,
    /// Steps that were not made, as what led to them is lost.
    pub lost: u64,
    /// True if the recording was ended properly.
    pub ended: bool,
}

impl Verdict {
    /// True when every step that could be compared gave the same bits.
    pub fn is_same(&self) -> bool {
        self.first.is_none() && self.refused.is_empty()
    }

    /// Why bits may differ between the recording's program and this one: a line for each cause.
    pub fn causes(&self, recorded: &Header, here: &Header) -> Vec<String> {
        let mut causes = Vec::new();
        if recorded.program != here.program {
            causes
                .push(format!("it was recorded by {}, this is {}", recorded.program, here.program));
        } else if recorded.build != here.build && recorded.build != Build::default() {
            causes.push(format!(
                "it was recorded by another build of {} (program file CRC-32 {:08x}, here {:08x})",
                here.program, recorded.build.crc32, here.build.crc32
            ));
        }
        if recorded.system != here.system {
            causes.push(format!("it was recorded on {}, this is {}", recorded.system, here.system));
        }
        if recorded.vectors != here.vectors {
            causes.push(format!(
                "it was recorded with {} vector instructions, here steps use {}",
                recorded.vectors, here.vectors
            ));
        }
        if self.first.is_some_and(|first| first.step == 0) {
            causes.push("the scene as built here starts in another state".into());
        }
        if self.gaps.iter().any(|(_, gap)| gap.source == 0 && gap.heavy > 0) {
            causes.push("inputs are missing: the disk was too slow".into());
        }
        let differs = self.first.map_or(f64::NEG_INFINITY, |first| first.time);
        if self.losses.iter().any(|loss| loss.from <= differs) {
            causes.push("inputs or settings may be in the part of the file that is damaged".into());
        }
        causes
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { steps, same, unmarked, seconds, .. } = self;
        match &self.first {
            None => write!(f, "the same bits in all {same} steps, {seconds:.3} s")?,
            Some(d) => write!(
                f,
                "differs from step {} of scene {} on, at {:.3} s; {same} of {} steps have the same \
                 bits",
                d.step,
                d.scene,
                d.time,
                steps - unmarked,
            )?,
        }
        if *unmarked > 0 {
            write!(f, "; {unmarked} steps were not marked and could not be compared")?;
        }
        if let (times @ 1.., ReplayDrift { rigid, node }) = self.put_right {
            write!(
                f,
                "; put right {times} times by keyframes, when bodies were off by {rigid:.1e} m and \
                 nodes by {node:.1e} m at most"
            )?;
        }
        Ok(())
    }
}
