//! The model file: one built body, read back in an instant.
//!
//! ```text
//!   byte  0  magic    8 bytes, "THENARMD"
//!         8  version  u32, 5
//!        12  kind     u32: 1 hand, 2 rigid, 3 soft, 4 figure with joints that follow others
//!        16  length   u64, bytes of the body
//!        24  checksum u64, FNV-1a of the body
//!        32  body     the model, in postcard's encoding
//! ```
//!
//! All numbers are little-endian. A file is refused as a whole unless magic, version, length and
//! checksum agree and the decoded model makes sense (indices in range, numbers finite, weights of
//! sum 1), so that what has been read can be simulated. Hands of version 1 have no solids of bones
//! and are read as such: their bones touch nothing. Flesh of versions 1 and 2 has no memory, and
//! their hands do not know which nodes stand for bone, so that their flesh can be held uniformly
//! alone. Hands before version 4 know neither the regions of their skin nor their nails, and those
//! before version 5 not what their flesh resists. All else is as in version 5.

mod check;
mod container;
mod figure;
mod old;

pub(crate) use check::hand as check_hand;
pub use figure::{figure_bytes, read_figure};

use crate::RigError;
use crate::export::write_whole;
use crate::object::{RigidModel, SoftModel};
use container::Kind;
use std::path::Path;
use thenar_core::model::HandModel;

/// A built body.
#[derive(Clone, Debug)]
pub enum Model {
    /// A hand, or another jointed soft body. Which joints of it follow others, [`read_figure`]
    /// says.
    Hand(HandModel),
    /// A rigid body.
    Rigid(RigidModel),
    /// A deformable body without bones.
    Soft(SoftModel),
}

/// A file larger than this is refused \[bytes\].
const FILE_BYTES_MAX: u64 = 1 << 30;

impl Model {
    /// The bytes of the model's file.
    ///
    /// # Errors
    /// When the model makes no sense, as on reading.
    pub fn to_bytes(&self) -> Result<Vec<u8>, RigError> {
        match self {
            Self::Hand(hand) => {
                check::hand(hand)?;
                container::encode(Kind::Hand, hand)
            }
            Self::Rigid(rigid) => {
                check::rigid(rigid)?;
                container::encode(Kind::Rigid, rigid)
            }
            Self::Soft(soft) => {
                check::soft(soft)?;
                container::encode(Kind::Soft, soft)
            }
        }
    }

    /// The model in the bytes of a file.
    ///
    /// # Errors
    /// When the bytes are not a whole, undamaged model file of version 1 to 5, or hold a model that
    /// makes no sense.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, RigError> {
        let (version, kind, body) = container::open(bytes)?;
        match kind {
            Kind::Hand => {
                let hand: HandModel = match version {
                    // The list of solids came last and anew: none.
                    1 => container::decode::<old::OldHand>(&[body, &[0]].concat())?.into(),
                    2 => container::decode::<old::OldHand>(body)?.into(),
                    // Regions and nails came last and anew: none.
                    3 => container::decode(&[body, &[0, 0, 0]].concat())?,
                    // What flesh resists came last and anew: nothing.
                    4 => container::decode(&[body, &[0]].concat())?,
                    _ => container::decode(body)?,
                };
                check::hand(&hand)?;
                Ok(Self::Hand(hand))
            }
            Kind::Figure => Ok(Self::Hand(figure::decode(body)?.0)),
            Kind::Rigid => {
                let rigid: RigidModel = container::decode(body)?;
                check::rigid(&rigid)?;
                Ok(Self::Rigid(rigid))
            }
            Kind::Soft => {
                let soft: SoftModel = match version {
                    1 | 2 => container::decode::<old::OldSoft>(body)?.into(),
                    _ => container::decode(body)?,
                };
                check::soft(&soft)?;
                Ok(Self::Soft(soft))
            }
        }
    }
}

/// Writes a model file, whole or not at all: a file that was there stays until the new one is
/// complete.
///
/// # Errors
/// When the model makes no sense or the file cannot be written.
pub fn write_model(path: &Path, model: &Model) -> Result<(), RigError> {
    let bytes = model.to_bytes().map_err(|e| e.in_file(path.display()))?;
    write_whole(path, &bytes)
}

/// Reads a model file.
///
/// # Errors
/// When it cannot be read, or as [`Model::from_bytes`].
pub fn read_model(path: &Path) -> Result<Model, RigError> {
    Model::from_bytes(&bytes_of(path)?).map_err(|e| e.in_file(path.display()))
}

fn bytes_of(path: &Path) -> Result<Vec<u8>, RigError> {
    thenar_input::read(path, FILE_BYTES_MAX)
        .map_err(|e| RigError::Read { file: path.display().to_string(), cause: e.into() })
}

#[cfg(test)]
mod tests;
