//! Hands that were built before in this process: a scene that is opened again, mirrored or swept
//! builds each of its hands once.
//!
//! A hand is known by all that it is made from, the bytes of its mesh and its options. Those used
//! last are kept here, and in a folder where the program has one (`hand_store`).

use super::hand_store::store;
use super::recent::Recent;
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

static BUILT: Recent<Source, HandModel> = Recent::new(CAPACITY);

/// [`build_hand`], or what that gave for the same bytes and options before.
///
/// # Errors
/// As there.
pub fn hand_of(bytes: &[u8], options: &HandOptions) -> Result<HandModel, RigError> {
    let nameless = HandOptions { name: String::new(), ..options.clone() };
    let source = Source { bytes: bytes.to_vec(), options: format!("{nameless:?}") };
    let make = |source: &Source| stored_or_built(source, &nameless);
    let hand = BUILT.get_or_make(source, make, |_| 1)?;
    Ok(HandModel { name: options.name.clone(), ..hand })
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

/// Offsets that were measured before on the flesh of a hand, written out.
static OFFSETS: Recent<String, Vec<PoseOffsets>> = Recent::new(OFFSETS_KEPT);

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
    OFFSETS.get_or_make(source, |_| sculpted_offsets(hand, skinning), |_| 1)
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
            assert!(BUILT.get(&source).is_some());
        }
        let fresh = build_hand(bytes, &options(60, "a")).unwrap();
        assert_eq!(hand_of(bytes, &options(60, "a")).unwrap().flesh.nodes, fresh.flesh.nodes);
    }
}
