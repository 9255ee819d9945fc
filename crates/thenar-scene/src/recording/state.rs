//! A world's state as recordings keep it: what they kept from the first version on in one piece,
//! what tissue remembers and where skin is held beside it.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use thenar_core::kernels::SeenSides;
use thenar_core::world::State;
use thenar_core::{Pose, Vec3};

/// All of a state but what tissue remembers, while it is written.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct MemorylessStateRef<'a> {
    time: f64,
    poses_WB: &'a [Pose],
    x: &'a [Vec3],
    v: &'a [Vec3],
    contact_change: &'a [Vec3],
    impulses: &'a [(u64, Vec3)],
    sides: &'a SeenSides,
    limit_impulses: &'a [[f64; 2]],
    patch_loads: &'a [([u32; 3], f64)],
}

/// A state as it is read, with tissue that remembers nothing.
#[derive(Clone, Debug)]
pub struct MemorylessState(pub State);

/// The parts of it.
#[derive(Deserialize)]
struct Parts {
    time: f64,
    poses_WB: Vec<Pose>,
    x: Vec<Vec3>,
    v: Vec<Vec3>,
    contact_change: Vec<Vec3>,
    impulses: Vec<(u64, Vec3)>,
    sides: SeenSides,
    limit_impulses: Vec<[f64; 2]>,
    patch_loads: Vec<([u32; 3], f64)>,
}

impl<'a> From<&'a State> for MemorylessStateRef<'a> {
    fn from(state: &'a State) -> Self {
        Self {
            time: state.time,
            poses_WB: &state.poses_WB,
            x: &state.x,
            v: &state.v,
            contact_change: &state.contact_change,
            impulses: &state.impulses,
            sides: &state.sides,
            limit_impulses: &state.limit_impulses,
            patch_loads: &state.patch_loads,
        }
    }
}

impl<'de> Deserialize<'de> for MemorylessState {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let parts = Parts::deserialize(from)?;
        Ok(Self(State {
            time: parts.time,
            poses_WB: parts.poses_WB,
            x: parts.x,
            v: parts.v,
            contact_change: parts.contact_change,
            impulses: parts.impulses.into(),
            sides: parts.sides,
            limit_impulses: parts.limit_impulses,
            patch_loads: parts.patch_loads.into(),
            faded: Vec::new(),
        }))
    }
}

impl Serialize for MemorylessState {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        MemorylessStateRef::from(&self.0).serialize(to)
    }
}
