//! Figures with joints that follow others.

use super::container::{self, Kind};
use super::{Model, bytes_of, check as checks};
use crate::RigError;
use crate::figure::Mimic;
use crate::figure::mimic::tangled;
use std::path::Path;
use thenar_core::model::HandModel;

/// The bytes of a figure's file, which keeps what follows what. Without any such joint that is the
/// file of a hand.
///
/// # Errors
/// When the figure makes no sense, as on reading.
pub fn figure_bytes(figure: &HandModel, mimics: &[Mimic]) -> Result<Vec<u8>, RigError> {
    check(figure, mimics)?;
    match mimics {
        [] => container::encode(Kind::Hand, figure),
        _ => container::encode(Kind::Figure, &(figure, mimics)),
    }
}

/// Reads a figure, and which of its joints follow others.
///
/// # Errors
/// When the file cannot be read, holds no figure, or as [`Model::from_bytes`].
pub fn read_figure(path: &Path) -> Result<(HandModel, Vec<Mimic>), RigError> {
    let bytes = bytes_of(path)?;
    let read = || match container::open(&bytes)? {
        (_, Kind::Figure, body) => decode(body),
        _ => match Model::from_bytes(&bytes)? {
            Model::Hand(figure) => Ok((figure, Vec::new())),
            _ => Err(RigError::invalid("the file holds no figure")),
        },
    };
    read().map_err(|e| e.in_file(path.display()))
}

pub(super) fn decode(body: &[u8]) -> Result<(HandModel, Vec<Mimic>), RigError> {
    let (figure, mimics): (HandModel, Vec<Mimic>) = container::decode(body)?;
    check(&figure, &mimics)?;
    Ok((figure, mimics))
}

fn check(figure: &HandModel, mimics: &[Mimic]) -> Result<(), RigError> {
    checks::hand(figure)?;
    for mimic in mimics {
        let sound = mimic.fits(figure) && mimic.law.iter().all(|c| c.is_finite());
        if !sound {
            let (joint, leader) = (mimic.joint, mimic.leader);
            return Err(RigError::invalid(format!(
                "joint {joint} cannot follow joint {leader}: no such axes, or no such law"
            )));
        }
    }
    match tangled(mimics) {
        None => Ok(()),
        Some(mimic) => {
            let joint = mimic.joint;
            Err(RigError::invalid(format!("joint {joint} follows itself, or follows two joints")))
        }
    }
}
