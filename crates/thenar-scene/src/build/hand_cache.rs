//! Hands that were built before in this process: a scene that is opened again, mirrored or swept
//! builds each of its hands once.
//!
//! A hand is known by all that it is made from, the bytes of its mesh and its options, so that no
//! entry can be stale. Those used last are kept here, and in a folder where the program has one
//! (`hand_store`).

use super::hand_store::store;
use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};
use thenar_core::model::{Flesh, HandModel, PoseOffsets, Skinning};
use thenar_rig::RigError;
use thenar_rig::hand::{HandOptions, build_hand, sculpted_offsets};

/// Hands kept: two of each of four scenes. One of 12 thousand tetrahedra has a file of some
/// megabytes.
const CAPACITY: usize = 8;

/// The source of a hand.
#[derive(Clone, PartialEq)]
pub(super) struct Source {
    pub bytes: Vec<u8>,
    /// All options but the name, written out.
    pub options: String,
}

static BUILT: Mutex<VecDeque<(Source, HandModel)>> = Mutex::new(VecDeque::new());

/// [`build_hand`], or what that gave for the same bytes and options before.
///
/// # Errors
/// As there.
pub fn hand_of(bytes: &[u8], options: &HandOptions) -> Result<HandModel, RigError> {
    let nameless = HandOptions { name: String::new(), ..options.clone() };
    let source = Source { bytes: bytes.to_vec(), options: format!("{nameless:?}") };
    // Nobody waits for the lock while a hand is built.
    let hand = match recall(&source) {
        Some(hand) => hand,
        None => {
            let hand = stored_or_built(&source, &nameless)?;
            let mut built = built();
            // Another thread may have built it, too.
            built.retain(|(key, _)| *key != source);
            built.truncate(CAPACITY - 1);
            built.push_front((source, hand.clone()));
            hand
        }
    };
    Ok(HandModel { name: options.name.clone(), ..hand })
}

fn built() -> MutexGuard<'static, VecDeque<(Source, HandModel)>> {
    BUILT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A hand of this process, which then is the one used last.
fn recall(source: &Source) -> Option<HandModel> {
    let mut built = built();
    let at = built.iter().position(|(key, _)| key == source)?;
    let entry = built.remove(at)?;
    let hand = entry.1.clone();
    built.push_front(entry);
    Some(hand)
}

/// The hand from the program's folder, or a new one, which goes there.
fn stored_or_built(source: &Source, options: &HandOptions) -> Result<HandModel, RigError> {
    let store = store();
    if let Some(hand) = store.as_ref().and_then(|store| store.read(source)) {
        return Ok(hand);
    }
    let hand = build_hand(&source.bytes, options)?;
    if let Some(store) = store {
        store.write(source, &hand);
    }
    Ok(hand)
}

/// Sets of offsets kept, the last ones asked for.
const OFFSETS_KEPT: usize = 4;

/// Offsets that were measured before on the flesh of a hand.
type MeasuredOffsets = (String, Vec<PoseOffsets>);

static OFFSETS: Mutex<VecDeque<MeasuredOffsets>> = Mutex::new(VecDeque::new());

/// [`sculpted_offsets`], or what that gave for the same hand before. A hand is known here by all
/// that is written of its skeleton, its flesh and what binds the two.
///
/// # Errors
/// As there.
pub fn offsets_of(hand: &HandModel, skinning: Skinning) -> Result<Vec<PoseOffsets>, RigError> {
    let HandModel { bones, joints, flesh, bindings, bone_nodes, .. } = hand;
    let Flesh { nodes, tets, materials, relaxation, .. } = flesh;
    let source = format!(
        "{:?}",
        (bones, joints, (nodes, tets, materials, relaxation), bindings, bone_nodes, skinning)
    );
    let lock = || OFFSETS.lock().unwrap_or_else(PoisonError::into_inner);
    let known = lock().iter().find(|(key, _)| *key == source).map(|(_, offsets)| offsets.clone());
    if let Some(offsets) = known {
        return Ok(offsets);
    }
    let offsets = sculpted_offsets(hand, skinning)?;
    let mut known = lock();
    known.truncate(OFFSETS_KEPT - 1);
    known.push_front((source, offsets.clone()));
    Ok(offsets)
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::model::Side;
    use thenar_rig::hand::asset;

    fn options(tets: usize, name: &str) -> HandOptions {
        HandOptions { tets, name: name.into(), render_triangles: 200, ..HandOptions::paper() }
    }

    #[test]
    fn a_hand_that_is_asked_for_again_is_the_same_under_its_own_name() {
        let bytes = asset(Side::Right);
        let first = hand_of(bytes, &options(60, "a")).unwrap();
        let again = hand_of(bytes, &options(60, "b")).unwrap();
        assert_eq!((first.name.as_str(), again.name.as_str()), ("a", "b"));
        assert_eq!(first.flesh.nodes, again.flesh.nodes);
        // What differs in anything is another hand, and errors are no hands.
        assert_ne!(hand_of(bytes, &options(90, "a")).unwrap().flesh.nodes, first.flesh.nodes);
        let left = hand_of(asset(Side::Left), &options(60, "a")).unwrap();
        assert_eq!(left.side, Some(Side::Left));
        assert!(hand_of(&bytes[..1000], &options(60, "a")).is_err());
        // What is used stays, however many others are asked for.
        let source = Source { bytes: bytes.to_vec(), options: format!("{:?}", options(60, "")) };
        for tets in (0..CAPACITY).map(|k| 100 + 10 * k) {
            hand_of(bytes, &options(tets, "a")).unwrap();
            assert!(recall(&source).is_some());
        }
        assert!(BUILT.lock().unwrap().len() <= CAPACITY);
        let fresh = build_hand(bytes, &options(60, "a")).unwrap();
        assert_eq!(hand_of(bytes, &options(60, "a")).unwrap().flesh.nodes, fresh.flesh.nodes);
    }
}
