//! Contacts of vertices and edges that lead entangled regions out.

use super::{DeepScratch, NONE, Place, Region};
use crate::contact::collector::{Collector, feature_key};
use crate::contact::sides::Sight;
use crate::contact::soft_rigid::KEY_PIERCED;
use crate::contact::soft_soft::{SoftSide, SoftSoft, VertexScratch};
use crate::contact::soft_way::Exit;
use crate::contact::triangle::ROUNDED_UP;
use crate::contact::{Contact, Site, SurfacePoint};
use crate::math::Vec3;

impl SoftSoft<'_> {
    /// Contacts of all that leads deep regions out, and of vertices in others that touch nothing.
    pub(in crate::contact) fn lead_out(
        &self,
        deep: &mut DeepScratch,
        touching: &[VertexScratch; 2],
        sight: &mut Sight,
        out: &mut Collector,
    ) {
        for region in &deep.regions {
            for place in &deep.places[region.start..region.end] {
                let on_edge = place.vertex == NONE;
                if match region.deep {
                    true => on_edge && !place.alone,
                    false => on_edge || touching[place.side].touches(place.vertex),
                } {
                    continue;
                }
                if let Some((normal, exit)) = self.led_by(region, place) {
                    self.push_place(place, &normal, &exit, sight, out);
                }
            }
        }
        deep.clear();
    }

    /// The direction in which a place is led out, and where. What is not opposed in a region that
    /// is pressed in follows the rest, and no farther; what came in by itself goes back where it is
    /// opposed.
    fn led_by(&self, region: &Region, place: &Place) -> Option<(Vec3, Exit)> {
        if place.is_opposed() && (region.pressed.is_some() || region.way.is_none()) {
            let (triangle, weights) = place.nearest;
            let depth = place.out.norm();
            return Some((place.out / depth, Exit { depth, triangle, weights }));
        }
        let way = region.way?;
        let exit = self.exit(place, &way.along)?;
        let most = region.pressed.map_or(f64::INFINITY, |depth| depth * ROUNDED_UP);
        (exit.depth > 0.0 && exit.depth <= most).then(|| (way.of(place.side), exit))
    }

    fn push_place(
        &self,
        place: &Place,
        normal: &Vec3,
        exit: &Exit,
        sight: &mut Sight,
        out: &mut Collector,
    ) {
        let [own, other] = self.facing(place.side);
        let gap = -exit.depth;
        if place.vertex != NONE {
            let to = (exit.triangle, exit.weights);
            self.push([own, other], place.vertex, to, (*normal, gap), sight, out);
            return;
        }
        let point = |side: &SoftSide, t: u32, weights| SurfacePoint {
            soft: side.soft,
            vertices: side.surface.triangles[t as usize],
            weights,
        };
        out.push(Contact {
            key: feature_key([
                KEY_PIERCED | own.soft,
                other.soft,
                own.surface.first_vertex as u32 + place.triangle,
                place.through,
            ]),
            a: Site::Soft(point(own, place.triangle, place.weights)),
            b: Site::Soft(point(other, exit.triangle, exit.weights)),
            position_W: place.p,
            normal_W: *normal,
            gap,
            friction: self.friction,
        });
    }
}
