//! Contact results in the forms that users of a simulation ask for: per surface vertex, per finger
//! (any part of a deformable body), per pair of bodies, per taxel ([`TaxelReadout`]). The points
//! themselves are [`World::contacts`].
//!
//! A [`ContactReadout`] belongs to whoever reads; it is made once, and reading allocates nothing.
//! All forms hold the same forces: those of the points, summed. Nothing is smoothed; taxels share
//! points.
//!
//! ```
//! # use thenar_core::{model::WorldDesc, readout::ContactReadout, World};
//! # let mut world = World::new(WorldDesc::default()).unwrap();
//! # let input = world.input();
//! let mut readout = ContactReadout::new(&world);
//! world.step(&input, &mut ());
//! readout.read(&world);
//! for soft in 0..world.desc().softs.len() as u32 {
//!     let load: f64 = readout.vertices(soft).iter().map(|v| v.pressure * v.area).sum(); // N
//!     let thumb_and_others = readout.parts(soft); // [palm, thumb, index, ...] of a hand
//! #   let _ = (load, thumb_and_others);
//! }
//! ```

mod part;
mod patch;
mod taxel;
mod vertex;

pub use part::{PartContact, part_touched, sum_parts};
pub use patch::{PatchContact, PatchSum};
pub use taxel::{TaxelContact, TaxelError, TaxelPlace, TaxelReadout, TaxelSkin};
pub use vertex::VertexContact;

use crate::World;
use crate::contact::Site;
use crate::coupling::KernelValue;
use crate::model::BodyId;
use std::ops::Range;
use vertex::Surfaces;

/// State of friction at a contact.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SlipState {
    /// Nothing presses.
    #[default]
    Open,
    /// Friction holds.
    Stick,
    /// The contact slides, or friction gives all it can; of several points, those count that bear
    /// most of the load.
    Slip,
}

impl SlipState {
    /// From the normal force \[N\] and the part of it that sliding points bear \[N\].
    fn of(normal: f64, slipping: f64) -> Self {
        match normal > 0.0 {
            true if slipping > 0.5 * normal => Self::Slip,
            true => Self::Stick,
            false => Self::Open,
        }
    }

    /// 0, 1, 2: open, stick, slip.
    pub fn number(self) -> u8 {
        self as u8
    }
}

/// Contact of one world, read after a step.
#[derive(Clone, Debug)]
pub struct ContactReadout {
    surfaces: Surfaces,
    /// Parts of all deformable bodies, one body after another.
    parts: Vec<PartContact>,
    /// Parts being summed up, likewise.
    sums: Vec<PatchSum>,
    part_ranges: Vec<Range<usize>>,
    /// Part that each rigid body is inside of.
    part_of_bone: Vec<Option<u32>>,
    /// Last bone of each part.
    tips: Vec<Option<u32>>,
    /// Shares of offsets by pose.
    shares: Vec<KernelValue>,
}

impl ContactReadout {
    /// Room for this world.
    pub fn new(world: &World) -> Self {
        let desc = world.desc();
        let mut readout = Self {
            surfaces: Surfaces::new(world),
            parts: Vec::new(),
            sums: Vec::new(),
            part_ranges: Vec::new(),
            part_of_bone: vec![None; desc.rigids.len()],
            tips: Vec::new(),
            shares: Vec::with_capacity(world.model().coupling.offsets.sample_count()),
        };
        for soft in 0..desc.softs.len() as u32 {
            let first = readout.tips.len();
            let parts = desc.parts.iter().find(|parts| parts.soft == soft);
            let of_bones = parts.iter().flat_map(|p| p.bones.iter().map(|(_, part)| *part));
            let of_vertices = parts.iter().flat_map(|p| p.vertices.iter().copied());
            let count = 1 + of_bones.chain(of_vertices).max().unwrap_or(0) as usize;
            readout.tips.resize(first + count, None);
            for (bone, part) in parts.iter().flat_map(|p| &p.bones) {
                let part = first + *part as usize;
                readout.part_of_bone[*bone as usize] = Some(part as u32);
                readout.tips[part] = Some(*bone);
            }
            readout.part_ranges.push(first..first + count);
        }
        readout.parts = vec![PartContact::default(); readout.tips.len()];
        readout.sums = vec![PatchSum::default(); readout.tips.len()];
        readout
    }

    /// Takes in the contacts of the world's last step. Allocates nothing.
    ///
    /// # Panics
    /// When the world has other bodies than the one this was made for.
    pub fn read(&mut self, world: &World) {
        self.surfaces.read(world);
        part::read(self, world);
    }

    /// Each vertex of a deformable body's collision surface, in the order of
    /// `World::collision_vertices`.
    pub fn vertices(&self, soft: u32) -> &[VertexContact] {
        self.surfaces.vertices(soft)
    }

    /// Each part of a deformable body; of a hand palm, thumb, index, middle, ring, little finger. A
    /// body without parts is one.
    pub fn parts(&self, soft: u32) -> &[PartContact] {
        &self.parts[self.part_ranges[soft as usize].clone()]
    }

    /// Contact of the first body with the second; forces are those on the first. The bones of a
    /// hand count as its flesh. Of a body with itself each point counts once, with the force on its
    /// side A.
    pub fn pair(&mut self, world: &World, [of, with]: [BodyId; 2]) -> PatchContact {
        self.select(world, of, Some(with))
    }

    /// Contact of a body with all others; forces are those on it.
    pub fn body(&mut self, world: &World, of: BodyId) -> PatchContact {
        self.select(world, of, None)
    }

    fn select(&mut self, world: &World, of: BodyId, with: Option<BodyId>) -> PatchContact {
        let mut sum = PatchSum::default();
        self.surfaces.begin_peak();
        for (contact, point) in world.contact_sites() {
            let mut counted = false;
            for side in 0..2 {
                let other = point.bodies[1 - side];
                let is_in = |found, asked| world.model().is_in(found, asked);
                if !is_in(point.bodies[side], of) || with.is_some_and(|with| !is_in(other, with)) {
                    continue;
                }
                // A pair of a body with itself has both sides of a point, and is one contact all
                // the same; on a body that is asked for alone both sides act.
                if with.is_none() || !counted {
                    sum.add(point, side);
                }
                counted = true;
                // Pressure is that on a deformable surface, be it the other's.
                let sites = [&contact.a, &contact.b];
                let own = matches!(sites[side], Site::Soft(_));
                let soft = if own { side } else { 1 - side };
                self.surfaces.add_peak(sites[soft], point, soft);
            }
        }
        sum.finish(self.surfaces.peak(world))
    }
}
