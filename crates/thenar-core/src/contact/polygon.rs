//! Convex polygons that are clipped side by side: the part of one face over another.

use crate::math::Vec3;

/// A corner of the clipped face. `edge` names the line to the next corner: below the polygon's
/// number of edges an edge of the face itself, from there on a side that clipped it.
#[derive(Clone, Copy, Default)]
pub(super) struct Corner {
    pub p: Vec3,
    pub id: u32,
    pub edge: u32,
}

/// A polygon of at most `CORNERS` corners, whose face has at most `EDGES` edges: each side adds at
/// most one corner.
pub(super) struct Polygon<const CORNERS: usize, const EDGES: u32> {
    corners: [Corner; CORNERS],
    count: usize,
    /// Corners nearer than this are one: a segment is cut on its way there and back \[m\]. Without
    /// it all count.
    same: Option<f64>,
}

impl<const CORNERS: usize, const EDGES: u32> Polygon<CORNERS, EDGES> {
    /// A polygon without corners.
    pub fn empty(same: Option<f64>) -> Self {
        Self { corners: [Corner::default(); CORNERS], count: 0, same }
    }

    pub fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    pub fn corners_mut(&mut self) -> &mut [Corner] {
        &mut self.corners[..self.count]
    }

    pub fn push(&mut self, corner: Corner) {
        let is_known = |same: f64| self.corners().iter().any(|c| (c.p - corner.p).norm() <= same);
        if self.count < CORNERS && !self.same.is_some_and(is_known) {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// Keeps the part with `n · p ≤ offset`; corners within `tolerance` of the side stay.
    pub fn clip(&self, n: &Vec3, offset: f64, side: u32, tolerance: f64) -> Self {
        let mut out = Self::empty(self.same);
        for i in 0..self.count {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % self.count]);
            let (d0, d1) = (n.dot(&from.p) - offset, n.dot(&to.p) - offset);
            let (in0, in1) = (d0 <= tolerance, d1 <= tolerance);
            if in0 {
                // When the boundary leaves here through a corner on the side, it follows it.
                let leaves_on_side = !in1 && d0 > -tolerance;
                out.push(if leaves_on_side { Corner { edge: EDGES + side, ..from } } else { from });
            }
            let on_side = if in0 { d0 > -tolerance } else { d1 > -tolerance };
            if in0 != in1 && !on_side {
                let p = from.p + (to.p - from.p) * (d0 / (d0 - d1));
                let edge = if in0 { EDGES + side } else { from.edge };
                out.push(Corner { p, id: 2 * EDGES * (1 + side) + from.edge, edge });
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 2 m cut along its diagonal keeps two corners and gains none, cut beside it gains
    /// two.
    #[test]
    fn a_cut_square_keeps_what_is_within() {
        let mut square = Polygon::<12, 4>::empty(None);
        for (k, (x, z)) in [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].iter().enumerate() {
            square.push(Corner { p: Vec3::new(*x, 0.0, *z), id: k as u32, edge: k as u32 });
        }
        let names = |polygon: &Polygon<12, 4>| -> Vec<_> {
            polygon.corners().iter().map(|c| (c.id, c.edge)).collect()
        };
        let diagonal = Vec3::new(1.0, 0.0, 1.0).normalize();
        // Corners 1 and 3 lie on the side: from 3 on the boundary follows it.
        assert_eq!(names(&square.clip(&diagonal, 0.0, 2, 1e-9)), [(1, 1), (2, 2), (3, 6)]);
        // Side 1 cuts edge 0 and edge 2 at x = 0.5: corners 8 + 8 + 0 and 8 + 8 + 2.
        let cut = square.clip(&Vec3::x(), 0.5, 1, 1e-9);
        assert_eq!(names(&cut), [(16, 0), (1, 1), (2, 2), (18, 5)]);
        assert!(cut.corners().iter().all(|c| c.p.x <= 0.5 && c.p.z.abs() == 1.0));
    }

    /// A segment there and back has two corners where near ones are one, else four.
    #[test]
    fn a_segment_has_two_ends() {
        let ends = [Vec3::zeros(), Vec3::x(), Vec3::x(), Vec3::zeros()];
        for (same, count) in [(Some(1e-9), 2), (None, 4)] {
            let mut segment = Polygon::<8, 64>::empty(same);
            ends.iter().for_each(|p| segment.push(Corner { p: *p, ..Corner::default() }));
            assert_eq!(segment.corners().len(), count);
        }
    }
}
