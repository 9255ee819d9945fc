//! Memory of a session besides the state of its world: with both, another session from the same
//! source continues with the same bits.

use super::{Session, drive};
use crate::flat::{FlatTarget, Flattened, target};
use crate::grip::{GripMemory, Reflex};
use crate::live::{LiveMemory, LiveMemoryRef};
use crate::tuning::{SettingValue, spelled_now};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use thenar_core::world::{State, StepReport, Target};

/// Memory of a session, apart from it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Memory {
    /// Steps done since the start.
    steps: u64,
    /// Settings that were changed, by key.
    #[serde(deserialize_with = "read_set")]
    set: Vec<(String, Value)>,
    hands: Vec<HandMemory>,
    /// Memories of grips, one for each hand; empty where nobody said. A frame keeps them apart,
    /// behind what came to it before.
    #[serde(skip)]
    pub(crate) grips: Vec<Option<GripMemory>>,
}

/// Memory of one hand.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct HandMemory {
    /// `None` for a hand that poses cannot move.
    live: Option<LiveMemory>,
    /// Targets to which its bones are led.
    led: Option<Vec<FlatTarget>>,
    /// Targets of its bones in the last step.
    targets: Vec<Option<FlatTarget>>,
}

/// A setting's value, with its kind in the bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Value {
    Number(f64),
    Choice(String),
}

/// Reads changed settings, choices in their present spelling.
fn read_set<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<(String, Value)>, D::Error> {
    let mut set = Vec::<(String, Value)>::deserialize(from)?;
    for (key, value) in &mut set {
        if let Value::Choice(word) = value {
            *word = spelled_now(key, word).into();
        }
    }
    Ok(set)
}

/// A borrowed [`Memory`]: nothing is copied to the heap.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MemoryRef<'a> {
    steps: u64,
    set: SetRef<'a>,
    hands: HandMemoriesRef<'a>,
}

#[derive(Clone, Copy, Debug)]
struct SetRef<'a>(&'a Session);

#[derive(Clone, Copy, Debug)]
struct HandMemoriesRef<'a>(&'a Session);

#[derive(Serialize)]
enum ValueRef<'a> {
    Number(f64),
    Choice(&'a str),
}

#[derive(Serialize)]
struct HandMemoryRef<'a> {
    live: Option<LiveMemoryRef<'a>>,
    led: Option<Flattened<'a, Target>>,
    targets: Flattened<'a, Option<Target>>,
}

impl Serialize for SetRef<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_seq(self.0.tuning.changed().map(|(key, value)| {
            let value = match value {
                SettingValue::Number(value) => ValueRef::Number(*value),
                SettingValue::Choice(value) => ValueRef::Choice(value),
            };
            (key, value)
        }))
    }
}

impl Serialize for HandMemoriesRef<'_> {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let Session { live, led, input, built, .. } = self.0;
        to.collect_seq(built.hands.iter().zip(live).zip(led).map(|((hand, live), led)| {
            HandMemoryRef {
                live: live.as_ref().ok().map(|live| live.memory()),
                led: led.as_deref().map(Flattened),
                targets: Flattened(&input.targets[drive::bones(hand)]),
            }
        }))
    }
}

impl Session {
    /// Memory that the next step depends on besides the world's state, the source and what enters.
    pub(crate) fn memory(&self) -> MemoryRef<'_> {
        MemoryRef { steps: self.steps, set: SetRef(self), hands: HandMemoriesRef(self) }
    }

    /// Goes on from what another session of the same source was at an instant. False, and nothing
    /// changes, when it does not fit. Takes milliseconds where settings differ.
    pub(crate) fn recall(&mut self, state: &State, memory: &Memory) -> bool {
        let set = memory.set.iter().map(|(key, value)| (&key[..], value.setting()));
        if !self.takes(memory) || !self.world.fits(state) {
            return false;
        }
        if !self.tuning.is_changed_to(set.clone()) {
            let Ok((tuning, desc)) = self.tuning.changed_to(set) else { return false };
            let gravity = desc.gravity;
            if self.world.retune(desc).is_err() {
                return false;
            }
            (self.tuning, self.input.gravity) = (tuning, gravity);
        }
        self.world.restore(state);
        for (k, kept) in memory.hands.iter().enumerate() {
            if let (Ok(live), Some(kept)) = (&mut self.live[k], &kept.live) {
                // It was found to fit.
                let _ = live.recall(kept);
            }
            self.led[k] = kept.led.as_ref().map(|led| led.iter().map(target).collect());
            let bones = drive::bones(&self.built.hands[k]);
            for (to, kept) in self.input.targets[bones].iter_mut().zip(&kept.targets) {
                *to = kept.as_ref().map(target);
            }
        }
        drive::motors(&mut self.input, &self.built, &self.world, state.time);
        self.recall_grips(&memory.grips);
        (self.steps, self.report) = (memory.steps, StepReport::default());
        true
    }

    /// True when hands, bones and joints are as many.
    fn takes(&self, memory: &Memory) -> bool {
        let fits = |(k, kept): (usize, &HandMemory)| {
            let bones = drive::bones(&self.built.hands[k]).len();
            let live = match (&self.live[k], &kept.live) {
                (Ok(live), Some(kept)) => live.fits(kept),
                (Err(_), None) => true,
                _ => false,
            };
            live && kept.targets.len() == bones
                && kept.led.as_ref().is_none_or(|l| l.len() == bones)
        };
        memory.hands.len() == self.built.hands.len()
            && self.takes_grips(&memory.grips)
            && memory.hands.iter().enumerate().all(fits)
    }
}

impl Memory {
    /// Reflexes of grips, one for each hand.
    pub(crate) fn reflexes(&self) -> Vec<Option<Reflex>> {
        self.grips.iter().map(|grip| grip.as_ref().map(GripMemory::reflex)).collect()
    }

    /// Goes on with these.
    pub(crate) fn set_reflexes(&mut self, reflexes: &[Option<Reflex>]) {
        for (grip, reflex) in self.grips.iter_mut().zip(reflexes) {
            if let (Some(grip), Some(reflex)) = (grip, reflex) {
                grip.set_reflex(*reflex);
            }
        }
    }
}

impl Value {
    fn setting(&self) -> SettingValue {
        match self {
            Self::Number(value) => SettingValue::Number(*value),
            Self::Choice(value) => SettingValue::Choice(value.clone()),
        }
    }
}
