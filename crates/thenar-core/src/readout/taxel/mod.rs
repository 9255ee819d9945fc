//! Contact as a skin of taxels feels it: pressing and shear forces at chosen places of a deformable
//! surface.
//!
//! Every contact of a part (a finger, the palm) is given to the taxels of that part, in shares that
//! sum to one: whatever the layout, the forces of its taxels sum to the force on the part, to
//! round-off. Who shares a contact is decided on the surface at rest, so that taxels stay where
//! they are on the skin.

mod frame;
mod place;
mod share;

pub use place::{TaxelPlace, TaxelSkin};

use crate::World;
use crate::contact::Site;
use crate::math::Vec3;
use crate::readout::part::part_touched;
use crate::world::ContactPoint;
use frame::Frames;
use share::{SHARED, share};

/// Reading of a taxel. Its frame moves with the skin: outward normal n, first shear axis t along
/// the surface, second shear axis n × t.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TaxelContact {
    /// Share of the contact forces, world \[N\].
    pub force_W: Vec3,
    /// Part of the force that presses, against n \[N\]; negative where neighbours' curvature makes
    /// it pull.
    pub normal: f64,
    /// Parts of the force along the two shear axes \[N\].
    pub shear: [f64; 2],
    /// Share of the area in contact \[m²\].
    pub area: f64,
    /// Share of the normal forces on skin, over that area \[Pa\]; zero without area.
    pub pressure: f64,
    /// Tangential velocity against what it touches along the two shear axes, mean by load \[m/s\].
    pub slip: [f64; 2],
    /// Place, world \[m\].
    pub position_W: Vec3,
    /// Outward normal n and the two shear axes, world.
    pub axes_W: [Vec3; 3],
}

/// Reason why places cannot be those of taxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TaxelError {
    /// No deformable body has this index.
    #[error("there is no deformable body {soft}: the world has {count}")]
    NoBody {
        /// Index given.
        soft: u32,
        /// Number of deformable bodies.
        count: usize,
    },
    /// A place is on no triangle, or a number of it is not finite.
    #[error("taxel {taxel} is not on the surface of the body")]
    OffSurface {
        /// Number of the taxel, from 0.
        taxel: usize,
    },
}

/// Sums of a taxel while contacts are gone through.
#[derive(Clone, Copy, Debug, Default)]
struct Sum {
    force_W: Vec3,
    area: f64,
    /// Normal forces on skin \[N\].
    pressed: f64,
    /// Normal forces \[N\], and slip times these.
    load: f64,
    slip_W: Vec3,
}

/// The taxels of one deformable body, read after a step.
#[derive(Clone, Debug)]
pub struct TaxelReadout {
    soft: u32,
    /// Collision vertices at rest, in the model frame.
    rest: Vec<Vec3>,
    frames: Frames,
    /// Taxels of each part, with their places at rest.
    parts: Vec<Vec<(u32, Vec3)>>,
    reach: f64,
    sums: Vec<Sum>,
    taxels: Vec<TaxelContact>,
    missed_W: Vec3,
}

impl TaxelReadout {
    /// Taxels at these places of deformable body `soft`. Contacts farther than `reach` from the
    /// nearest taxel, on the surface at rest, are felt by none \[m\]; infinite for no such bound.
    ///
    /// # Errors
    /// There is no such body, or a place is not on its surface.
    pub fn new(
        world: &World,
        soft: u32,
        places: &[TaxelPlace],
        reach: f64,
    ) -> Result<Self, TaxelError> {
        let softs = &world.desc().softs;
        let body = softs.get(soft as usize);
        let flesh = &body.ok_or(TaxelError::NoBody { soft, count: softs.len() })?.flesh;
        let surface = &flesh.collision;
        let mut rest = vec![Vec3::zeros(); surface.vertices.len()];
        surface.positions(&flesh.tets, &flesh.nodes, &mut rest);
        if let Some(taxel) = places.iter().position(|place| !place.is_on(&surface.triangles)) {
            return Err(TaxelError::OffSurface { taxel });
        }
        let mut parts: Vec<Vec<(u32, Vec3)>> = Vec::new();
        for (k, place) in (0..).zip(places) {
            let part = world.model().part_of(soft, place.nearest_vertex()) as usize;
            parts.resize_with(parts.len().max(part + 1), Vec::new);
            parts[part].push((k, place.on(&rest)));
        }
        Ok(Self {
            soft,
            rest,
            frames: Frames::new(places, &surface.triangles),
            parts,
            reach,
            sums: vec![Sum::default(); places.len()],
            taxels: vec![TaxelContact::default(); places.len()],
            missed_W: Vec3::zeros(),
        })
    }

    /// Takes in the contacts of the world's last step. Allocates nothing.
    ///
    /// # Panics
    /// When the world has other bodies than the one this was made for.
    pub fn read(&mut self, world: &World) {
        self.sums.fill(Sum::default());
        self.missed_W = Vec3::zeros();
        for (contact, point) in world.contact_sites() {
            for (side, site) in [&contact.a, &contact.b].into_iter().enumerate() {
                if let Some((part, place)) = self.place_touched(world, point, side, site) {
                    self.give(point, side, part, &place);
                }
            }
        }
        let vertices = world.collision_vertices(self.soft);
        for (k, (taxel, sum)) in self.taxels.iter_mut().zip(&self.sums).enumerate() {
            let (position_W, axes_W) = self.frames.of(k, vertices);
            *taxel = sum.felt(position_W, axes_W);
        }
    }

    /// Readings of the taxels, in the order of the places.
    pub fn taxels(&self) -> &[TaxelContact] {
        &self.taxels
    }

    /// Force on parts that have taxels which none of them feels, as it is out of reach, world
    /// \[N\]. With it the taxels' forces sum to that on the parts.
    pub fn missed_W(&self) -> Vec3 {
        self.missed_W
    }

    /// True when some taxel is on this part of the body: all contact of the part is then read.
    pub fn covers(&self, part: u32) -> bool {
        self.parts.get(part as usize).is_some_and(|taxels| !taxels.is_empty())
    }

    /// The part that a contact touches on this side, and where that is at rest; `None` where it is
    /// of no taxel.
    fn place_touched(
        &self,
        world: &World,
        point: &ContactPoint,
        side: usize,
        site: &Site,
    ) -> Option<(usize, Vec3)> {
        let (soft, part) = part_touched(world, point, side)?;
        if soft != self.soft || !self.covers(part) {
            return None;
        }
        let place = match site {
            Site::Soft(on) => on.interpolate(&self.rest),
            // A bone that touches through crushed flesh: the skin there is nearest.
            Site::Rigid { .. } => self.rest[self.nearest_vertex(world, part, &point.position_W)?],
        };
        Some((part as usize, place))
    }

    /// The vertex of a part that is nearest to a place now.
    fn nearest_vertex(&self, world: &World, part: u32, place_W: &Vec3) -> Option<usize> {
        let vertices = (0..).zip(world.collision_vertices(self.soft));
        let own = vertices.filter(|(v, _)| world.model().part_of(self.soft, *v) == part);
        let distances = own.map(|(v, x)| (v as usize, (x - place_W).norm_squared()));
        distances.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(v, _)| v)
    }

    /// Shares a contact out among the taxels of its part.
    fn give(&mut self, point: &ContactPoint, side: usize, part: usize, place: &Vec3) {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let force_W = point.force_W * sign;
        let mut shares = [(0, 0.0); SHARED];
        let Some(count) = share(place, &self.parts[part], self.reach, &mut shares) else {
            self.missed_W += force_W;
            return;
        };
        let normal = point.force_W.dot(&point.normal_W).max(0.0);
        for (taxel, weight) in &shares[..count] {
            let sum = &mut self.sums[*taxel as usize];
            sum.force_W += force_W * *weight;
            sum.area += point.area * weight;
            sum.pressed += if point.touches_skin() { normal * weight } else { 0.0 };
            sum.load += normal * weight;
            sum.slip_W += point.slip_W * (sign * normal * weight);
        }
    }
}

impl Sum {
    /// In a taxel's frame.
    fn felt(&self, position_W: Vec3, axes_W: [Vec3; 3]) -> TaxelContact {
        let [n, t, s] = axes_W;
        let slip_W = if self.load > 0.0 { self.slip_W / self.load } else { Vec3::zeros() };
        TaxelContact {
            force_W: self.force_W,
            normal: -self.force_W.dot(&n),
            shear: [self.force_W.dot(&t), self.force_W.dot(&s)],
            area: self.area,
            pressure: if self.area > 0.0 { self.pressed / self.area } else { 0.0 },
            slip: [slip_W.dot(&t), slip_W.dot(&s)],
            position_W,
            axes_W,
        }
    }
}
