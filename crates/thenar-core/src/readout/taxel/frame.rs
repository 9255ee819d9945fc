//! Present places and directions of taxels.

use super::TaxelPlace;
use crate::math::Vec3;
use std::ops::Range;

/// Places of taxels with what their normals are made of.
#[derive(Clone, Debug)]
pub struct Frames {
    places: Vec<TaxelPlace>,
    /// Triangles around each corner of each place, one list after another in `around`.
    corners: Vec<[Range<u32>; 3]>,
    around: Vec<[u32; 3]>,
}

impl Frames {
    pub fn new(places: &[TaxelPlace], triangles: &[[u32; 3]]) -> Self {
        let mut around = Vec::new();
        let mut corner = |vertex: u32| {
            let start = around.len() as u32;
            around.extend(triangles.iter().filter(|t| t.contains(&vertex)));
            start..around.len() as u32
        };
        let corners = places.iter().map(|place| place.vertices.map(&mut corner)).collect();
        Self { places: places.to_vec(), corners, around }
    }

    /// Place, outward normal and shear axes of taxel `k`, with collision vertices there.
    pub fn of(&self, k: usize, vertices: &[Vec3]) -> (Vec3, [Vec3; 3]) {
        let place = &self.places[k];
        let n = unit(&self.normal(k, vertices)).unwrap_or_else(Vec3::y);
        let along = place.along_on(vertices);
        let across = |v: Vec3| unit(&(v - n * n.dot(&v)));
        // Flesh that is turned over so far that its direction is the normal: any other direction
        // does.
        let t = across(along).or_else(|| across(Vec3::x())).or_else(|| across(Vec3::z()));
        let t = t.unwrap_or_else(Vec3::x);
        (place.on(vertices), [n, t, n.cross(&t)])
    }

    /// Mean by weight of the corners' normals, each the mean by area of the triangles around it.
    fn normal(&self, k: usize, vertices: &[Vec3]) -> Vec3 {
        let of = |range: &Range<u32>| -> Vec3 {
            let around = &self.around[range.start as usize..range.end as usize];
            let areas = around.iter().map(|t| {
                let [a, b, c] = t.map(|v| vertices[v as usize]);
                (b - a).cross(&(c - a))
            });
            unit(&areas.sum()).unwrap_or_else(Vec3::zeros)
        };
        let place = &self.places[k];
        self.corners[k].iter().zip(place.weights).map(|(range, w)| of(range) * w).sum()
    }
}

fn unit(v: &Vec3) -> Option<Vec3> {
    v.try_normalize(1e-12 * v.amax()).filter(|n| n.iter().all(|x| x.is_finite()))
}
