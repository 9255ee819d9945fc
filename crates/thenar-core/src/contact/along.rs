//! A straight edge along a convex shape.

use crate::contact::Shape;
use crate::math::Vec3;

/// Edges that stand at less than this to a face lie on it \[rad\]: the distance along the normal
/// errs by half its square.
const LYING: f64 = 0.1;

/// Point of a segment nearest to a convex shape, and the part of the segment over the same face.
pub(super) struct Along {
    pub lowest: Vec3,
    pub value: f64,
    pub gradient: Vec3,
    pub ends: [Vec3; 2],
}

impl Along {
    /// By bisection of the slope, which rises along the segment since the distance is convex, then
    /// by bisection for where the distance leaves its tangent plane by more than `flat`.
    pub fn of(shape: &Shape, [p, q]: [Vec3; 2], flat: f64) -> Self {
        let way = q - p;
        let at = |t: f64| p + t * way;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let t = 0.5 * (low + high);
            if shape.distance(&at(t)).gradient.dot(&way) > 0.0 { high = t } else { low = t }
        }
        let t = 0.5 * (low + high);
        let lowest = at(t);
        // The middle of what is as low as this, so that the face is that under the segment.
        let d = shape.distance(&lowest);
        let leaves = |s: f64| {
            let x = at(s);
            shape.distance(&x).value - d.value - d.gradient.dot(&(x - lowest)) > flat
        };
        let end = |to: f64| {
            if !leaves(to) {
                return at(to);
            }
            let (mut on, mut off) = (t, to);
            for _ in 0..40 {
                let s = 0.5 * (on + off);
                *(if leaves(s) { &mut off } else { &mut on }) = s;
            }
            at(on)
        };
        // A segment that stands off the face touches at its lowest point only.
        let lies = d.gradient.dot(&way).abs() < LYING * way.norm();
        let ends = if lies { [end(0.0), end(1.0)] } else { [lowest; 2] };
        Self { lowest, value: d.value, gradient: d.gradient, ends }
    }
}

/// Times that an edge is drawn out of a shape along the way found before. The bisector of its
/// faces, the first way, leads aside by as much as it leans from the way out (31 µm on rims of 12
/// mm); along that way only the bend of the shape's own edge within it remains, and the last time
/// takes that out.
const DRAWN: usize = 3;

impl Along {
    /// Looks again from `way` outside the shape, where an edge that crosses one of the shape's own
    /// has the direction between the two. `out` leads from the edge into the shape.
    pub fn draw_apart(&mut self, shape: &Shape, ends: [Vec3; 2], mut out: Vec3, way: f64) {
        for _ in 0..DRAWN {
            let beside = Self::of(shape, ends.map(|p| p - way * out), 0.0);
            if beside.value <= 0.0 {
                return;
            }
            self.gradient = beside.gradient;
            self.value = beside.value + way * out.dot(&beside.gradient);
            self.lowest = beside.lowest + way * out;
            self.ends = [self.lowest; 2];
            out = -beside.gradient;
        }
    }
}
