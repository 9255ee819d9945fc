//! Bodies of the session's frames.

use super::state::{MemorylessState, MemorylessStateRef};
use crate::format::PresetWord;
use crate::session::{GripsRef, IfNone, Memory, MemoryRef, ReflexesRef, Session, Source};
use serde::{Deserialize, Serialize};
use thenar_core::kernels::HeldPlace;
use thenar_core::world::State;

/// A scene frame, in postcard's encoding: a session begins. Behind it stands the number of the hand
/// that the scene means where it does not say, a byte; [`SceneStart::read`] takes both.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SceneStart {
    /// Source of the session.
    pub source: Source,
    /// The files that the scene names.
    pub assets: Vec<Asset>,
    /// Hash of the state it begins with.
    pub hash: u64,
    /// Simulated time at its beginning \[s\].
    pub time: f64,
    /// Time step \[s\].
    pub time_step: f64,
}

impl SceneStart {
    /// Appends it, and behind it the hand that the scene means where it does not say.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        append(out, self);
        out.push(match self.source.usual_hand {
            PresetWord::Paper => 0,
            PresetWord::Touch => 1,
        });
    }

    /// Reads it. What comes after the last part that is known is left alone.
    pub fn read(body: &[u8]) -> Option<Self> {
        let (mut start, rest): (Self, _) = postcard::take_from_bytes(body).ok()?;
        // Programs that knew one hand wrote no more.
        start.source.usual_hand = match rest.first() {
            None | Some(0) => PresetWord::Paper,
            Some(1) => PresetWord::Touch,
            Some(_) => return None,
        };
        Some(start)
    }

    /// True if a session that has just been made begins as it says.
    pub(super) fn is_of(&self, session: &Session) -> bool {
        let world = session.world();
        let times = [world.time(), world.time_step()];
        world.state_hash() == self.hash && times == [self.time, self.time_step]
    }
}

/// A file that a scene names.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Asset {
    /// Name in the scene.
    pub name: String,
    /// Size of the file \[bytes\].
    pub bytes: u64,
    /// CRC-32 of the file.
    pub crc32: u32,
    /// All of it; `None` for one that is too large to be put into a recording.
    pub content: Option<Vec<u8>>,
}

/// A step frame: 21 bytes, little-endian, in the order of the fields.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StepMark {
    /// Steps made since the scene frame, this one included.
    pub number: u64,
    /// Hash of the state after it.
    pub hash: u64,
    /// Duration of the step by the clock on the wall \[ns\].
    pub cost_ns: u32,
    /// True if the step was taken back, so that no simulated time passed: bit 0 of the last byte.
    pub taken_back: bool,
}

impl StepMark {
    /// Appends it.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.number.to_le_bytes());
        out.extend_from_slice(&self.hash.to_le_bytes());
        out.extend_from_slice(&self.cost_ns.to_le_bytes());
        out.push(u8::from(self.taken_back));
    }

    /// Reads it.
    pub fn read(body: &[u8]) -> Option<Self> {
        let (number, rest) = body.split_first_chunk::<8>()?;
        let (hash, rest) = rest.split_first_chunk::<8>()?;
        let (cost_ns, rest) = rest.split_first_chunk::<4>()?;
        Some(Self {
            number: u64::from_le_bytes(*number),
            hash: u64::from_le_bytes(*hash),
            cost_ns: u32::from_le_bytes(*cost_ns),
            taken_back: rest.first()? & 1 != 0,
        })
    }
}

/// A keyframe, in postcard's encoding.
#[derive(Clone, Debug)]
pub struct Keyframe {
    /// Steps made since the scene frame.
    pub number: u64,
    /// The world's state after them.
    pub state: State,
    /// Rest of what the next step depends on; `None` in recordings of programs that did not keep
    /// it.
    pub kept: Option<KeyframeRest>,
}

/// Rest of a keyframe: all but the world's state.
#[derive(Clone, Debug, Deserialize)]
pub struct KeyframeRest {
    /// Hash of the state that its scene began with.
    pub start: u64,
    /// Memory of the session.
    pub memory: Memory,
}

impl Keyframe {
    /// Reads it. What comes after the last part that is known is left alone.
    pub fn read(body: &[u8]) -> Option<Self> {
        let ((number, MemorylessState(mut state)), rest) = postcard::take_from_bytes(body).ok()?;
        if rest.is_empty() {
            return Some(Self { number, state, kept: None });
        }
        let (mut kept, rest): (KeyframeRest, &[u8]) = postcard::take_from_bytes(rest).ok()?;
        if !rest.is_empty() {
            let faded: (Vec<[f64; 6]>, &[u8]) = postcard::take_from_bytes(rest).ok()?;
            state.faded = faded.0;
            if !faded.1.is_empty() {
                let rest;
                (kept.memory.grips, rest) = postcard::take_from_bytes(faded.1).ok()?;
                if !rest.is_empty() {
                    let (reflexes, rest): (Vec<_>, &[u8]) = postcard::take_from_bytes(rest).ok()?;
                    kept.memory.set_reflexes(&reflexes);
                    if kept.memory.grips.iter().all(Option::is_none) {
                        kept.memory.grips.clear();
                    }
                    if !rest.is_empty() {
                        let places: Vec<HeldPlace> = postcard::take_from_bytes(rest).ok()?.0;
                        state.sides = state.sides.with_places(places);
                    }
                }
            }
        }
        Some(Self { number, state, kept: Some(kept) })
    }

    /// A session that has just begun.
    pub(super) fn of(session: &Session, start: u64) -> Option<Self> {
        let mut bytes = Vec::new();
        append(&mut bytes, &KeyframeRef::of(session, 0, start));
        Self::read(&bytes)
    }

    /// True when a session remembers the same as this, to the bit.
    pub(super) fn remembers_as(&self, session: &Session) -> bool {
        let (mut one, mut other) = (Vec::new(), Vec::new());
        append(
            &mut one,
            &(
                session.memory(),
                session.grips_memory(IfNone::Nothing),
                session.reflexes(IfNone::Nothing),
            ),
        );
        self.kept.as_ref().is_none_or(|kept| {
            append(&mut other, &kept.memory);
            if !kept.memory.grips.is_empty() {
                append(&mut other, &(&kept.memory.grips, kept.memory.reflexes()));
            }
            one == other
        })
    }
}

/// A borrowed keyframe, to be written.
#[derive(Debug, Serialize)]
pub(super) struct KeyframeRef<'a> {
    number: u64,
    state: MemorylessStateRef<'a>,
    start: u64,
    memory: MemoryRef<'a>,
    /// The memory of tissue came last to the form.
    faded: &'a [[f64; 6]],
    /// After it what hands grip.
    grips: GripsRef<'a>,
    /// After that how their grips answer to load.
    reflexes: ReflexesRef<'a>,
    /// Last where skin is held by round parts; of none nothing is written.
    #[serde(skip_serializing_if = "<[HeldPlace]>::is_empty")]
    places: &'a [HeldPlace],
}

impl<'a> KeyframeRef<'a> {
    /// That of a session `number` steps after one that began with a state of hash `start`.
    pub fn of(session: &'a Session, number: u64, start: u64) -> Self {
        let state = session.world().state();
        let memory = session.memory();
        let (faded, places) = (&state.faded[..], state.sides.places());
        let if_none = if places.is_empty() { IfNone::Nothing } else { IfNone::Each };
        let (grips, reflexes) = (session.grips_memory(if_none), session.reflexes(if_none));
        Self { number, state: state.into(), start, memory, faded, grips, reflexes, places }
    }
}

/// Appends a value in postcard's encoding.
pub(super) fn append(out: &mut Vec<u8>, value: &impl Serialize) {
    let length = out.len();
    // What is in memory always has such a form; were it not so, an empty body is refused on
    // reading.
    match postcard::to_extend(value, std::mem::take(out)) {
        Ok(written) => *out = written,
        Err(_) => out.resize(length, 0),
    }
}
