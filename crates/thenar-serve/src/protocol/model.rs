//! The model message: everything that stays while a scene runs.

use super::arrays::Arrays;
use super::{VERSION, kind};
use super::{hand, rigid, soft};
use serde::Serialize;
use thenar_scene::format::MotionWord;
use thenar_scene::session::Session;

/// Rigid bodies, and deformable bodies, that indices of contacts can tell apart.
const BODIES_MAX: usize = 32767;
/// Longest message \[bytes\].
const BYTES_MAX: usize = 256 << 20;

/// Why a scene cannot be sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ModelError {
    /// More bodies than numbers for them.
    #[error(
        "the scene has {rigids} rigid and {softs} soft bodies; a page can be sent 32767 of each"
    )]
    Bodies {
        /// Rigid bodies.
        rigids: usize,
        /// Soft bodies.
        softs: usize,
    },
    /// Too much to send.
    #[error("the scene's meshes take {bytes} bytes; a page can be sent {BYTES_MAX}")]
    Bytes {
        /// Size of the message.
        bytes: usize,
    },
}

#[derive(Serialize)]
struct Json<'a> {
    scene: &'a str,
    title: &'a str,
    description: &'a str,
    time_step: f64,
    duration: f64,
    camera: Option<Camera>,
    rigids: Vec<rigid::Rigid>,
    softs: Vec<soft::Soft>,
    hands: Vec<hand::HandEntry>,
    overlaps: Vec<Overlap<'a>>,
}

/// Two bodies that start inside each other.
#[derive(Serialize)]
struct Overlap<'a> {
    bodies: &'a [String; 2],
    depth: f64,
    place: [f64; 3],
}

#[derive(Serialize)]
struct Camera {
    position: [f64; 3],
    target: [f64; 3],
    fov_deg: f64,
}

/// The model message of a session. `scene` is the name that clients ask for it by.
///
/// # Errors
/// The scene is too large to be sent.
pub fn model(session: &Session, scene: &str, epoch: u32) -> Result<Vec<u8>, ModelError> {
    let desc = session.world().desc();
    let (rigids, softs) = (desc.rigids.len(), desc.softs.len());
    if rigids.max(softs) > BODIES_MAX {
        return Err(ModelError::Bodies { rigids, softs });
    }
    let mut arrays = Arrays::default();
    let json = describe(session, scene, &mut arrays);
    // Only finite numbers and texts are in it, which always have a JSON form.
    let mut json = serde_json::to_vec(&json).unwrap_or_default();
    json.resize(json.len().next_multiple_of(4), b' ');
    let bytes = 16 + json.len() + arrays.bytes().len();
    if bytes > BYTES_MAX {
        return Err(ModelError::Bytes { bytes });
    }
    let mut out = Vec::with_capacity(bytes);
    out.extend_from_slice(&[kind::MODEL, VERSION, 0, 0]);
    out.extend_from_slice(&epoch.to_le_bytes());
    out.extend_from_slice(&(json.len() as u32).to_le_bytes());
    out.extend_from_slice(&[0; 4]);
    out.extend_from_slice(&json);
    out.extend_from_slice(arrays.bytes());
    Ok(out)
}

fn describe<'a>(session: &'a Session, scene: &'a str, arrays: &mut Arrays) -> Json<'a> {
    let (world, file) = (session.world(), session.scene());
    let desc = world.desc();
    let bone = |i: usize| session.hands().iter().any(|h| h.handle.bones.contains(&(i as u32)));
    let rigids = (0..desc.rigids.len())
        .map(|i| {
            let moves = file.rigid.get(i).is_some_and(|r| r.motion == MotionWord::Scripted);
            rigid::rigid(&desc.rigids[i], session.looks().get(i), bone(i), moves, arrays)
        })
        .collect();
    let softs = (0..desc.softs.len()).map(|i| soft::soft(session, i as u32, arrays)).collect();
    let mut target_start = 0;
    let hands = session
        .hands()
        .iter()
        .map(|built| {
            let hand = hand::hand(built, target_start, arrays);
            target_start += built.handle.bones.len();
            hand
        })
        .collect();
    let triple = |v: &thenar_core::Vec3| [v.x, v.y, v.z];
    Json {
        scene,
        title: file.title.as_deref().unwrap_or(scene),
        description: file.description.as_deref().unwrap_or_default(),
        time_step: world.time_step(),
        duration: file.duration,
        camera: session.camera().map(|c| Camera {
            position: triple(&c.position),
            target: triple(&c.target),
            fov_deg: c.fov_deg,
        }),
        rigids,
        softs,
        hands,
        overlaps: session
            .start_overlaps()
            .iter()
            .map(|o| Overlap { bodies: &o.bodies, depth: o.depth, place: triple(&o.place_W) })
            .collect(),
    }
}

/// Gives a model message another epoch.
pub fn set_epoch(message: &mut [u8], epoch: u32) {
    if let Some(bytes) = message.get_mut(4..8) {
        bytes.copy_from_slice(&epoch.to_le_bytes());
    }
}
