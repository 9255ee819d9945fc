//! Places of a soft surface that follow a round part, from step to step.
//!
//! The place where a flat triangle is nearest to a ball of radius R moves by `R θ` when the
//! triangle tilts by θ. A contact pushes at the place of the step's start. Where the load F that it
//! bears there turns the triangle by more than the place went, `R F` above its stiffness against
//! tilting, the place leaps to and fro for ever, farther each time. A place therefore goes a part
//! of the way: less where it turns back, the whole way where it goes on. (One learning rate per
//! unknown, by the sign of its changes [Jacobs 1988, Riedmiller and Braun 1993].)

use crate::capacity_vec::CapacityVec;
use crate::contact::Shape;
use crate::contact::area::TOUCHING;
use crate::contact::blunt::has_edges;
use crate::math::Vec3;

/// The part of the way that a new place goes at first, and the least: what 20 turns back leave of
/// it.
const START: f64 = 0.5;
const LEAST: f64 = 1e-6;
/// The part grows and shrinks by these where the place turns back, and where it goes on (Riedmiller
/// and Braun's).
const TURNED_BACK: f64 = 0.5;
const WENT_ON: f64 = 1.2;
/// A place lags behind the nearest one by no more than makes it so much farther from the part, in
/// lengths of the edge: a tenth of what gaps are good for.
const BEHIND: f64 = 1e-3;
/// Rounds in which a lag is made short enough.
const ROUNDS: usize = 4;

/// A part with a radius of this many edges is flat there: the nearest place goes as far for each
/// radian that the triangle tilts.
const FLAT: f64 = 0.5;

/// Around a place the part bulges by at most this where it is held \[m\]: a twentieth of what
/// counts as touching.
const BULGE: f64 = 0.05 * TOUCHING;

/// Returns the distance from a following place at which its triangle, of longest edge `edge`, is
/// held \[m\], in up to three directions; `None` where the place alone holds it. At one
/// point friction does not resist a spin about the normal: a ball that two triangles pinch swings
/// to and fro about the line between them. At three it resists with `μ F` times this distance, and
/// a roll with at most F times it, 1 % of the radius of a ball of 40 mm. Where several triangles
/// bear the part, they hold it so. One bears it alone where the touching area, a disc of radius √(2
/// R [`TOUCHING`]), lies within the circle inscribed in it. In a circle 2.5 times as large, of
/// radius edge/√12 in an equilateral triangle, it does at a third of all places. What has edges is
/// held at several places along its side, and points past an edge would meet its end.
pub(crate) fn spread(edge: f64, shape: &Shape) -> Option<f64> {
    let radius = shape.least_radius();
    let is_alone = !has_edges(shape) && edge * edge > 150.0 * radius * TOUCHING;
    is_alone.then(|| (2.0 * radius * BULGE).sqrt())
}

/// Places at which a triangle is held by a round part; its corners are contacts of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Hold {
    /// No place: the part bulges by less than [`TOUCHING`] between the corners.
    Corners,
    /// Places nearest to the part.
    Nearest,
    /// Places that follow the nearest.
    Following,
}

impl Hold {
    /// For a triangle whose longest edge is `edge` at rest \[m\]: lengths at rest alone decide.
    pub fn of(edge: f64, shape: &Shape) -> Self {
        let [least, greatest] = radii(shape);
        let is_narrow = matches!(shape, Shape::Cylinder { radius, .. } if *radius < edge);
        if is_narrow || greatest < FLAT * edge {
            Self::Nearest
        } else if edge * edge <= 8.0 * least * TOUCHING {
            Self::Corners
        } else {
            Self::Following
        }
    }
}

/// The least and the greatest radius of curvature \[m\]. Along its axis a capsule is held at both
/// ends of what lies over a triangle, so that its flatness there does not count.
fn radii(shape: &Shape) -> [f64; 2] {
    let least = shape.least_radius();
    match shape {
        Shape::Ellipsoid { half } => [least, half.max() * half.max() / half.min()],
        _ => [least; 2],
    }
}

/// Surface, triangle, rigid body, and the number of a place.
pub type PlaceKey = [u32; 4];

/// A place of a triangle that is held.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct HeldPlace {
    /// Surface, triangle, rigid body, and the number of the place.
    pub key: PlaceKey,
    /// Position, in weights of the triangle's corners.
    pub weights: [f64; 3],
    /// Displacement, in the same weights.
    pub way: [f64; 3],
    /// The part of its way to the nearest place that it goes.
    pub part: f64,
}

/// The places that are held in one step.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Places {
    /// Sorted by key once the search is over.
    pub held: CapacityVec<HeldPlace>,
}

impl Places {
    pub fn recall(&self, key: &PlaceKey) -> Option<&HeldPlace> {
        let at = self.held.binary_search_by_key(key, |held| held.key).ok()?;
        Some(&self.held[at])
    }
}

impl HeldPlace {
    /// A place that was not there before.
    pub(crate) fn new(key: PlaceKey, weights: [f64; 3]) -> Self {
        Self { key, weights, way: [0.0; 3], part: START }
    }

    /// True when the held place lies where `nearest` does, inside or on that edge. A state that was
    /// read back may hold anything.
    fn is_like(&self, nearest: &[f64; 3]) -> bool {
        let sum: f64 = self.weights.iter().sum();
        let within = |w: &f64| (0.0..=1.0).contains(w);
        let on_edge = |(w, n): (&f64, &f64)| *n != 0.0 || *w == 0.0;
        (sum - 1.0).abs() < 1e-9
            && self.weights.iter().all(within)
            && self.weights.iter().zip(nearest).all(on_edge)
    }

    /// Weights, way and part.
    pub(crate) fn numbers(&self) -> impl Iterator<Item = f64> {
        self.weights.into_iter().chain(self.way).chain([self.part])
    }

    pub(crate) fn is_finite(&self) -> bool {
        self.numbers().all(f64::is_finite)
    }

    /// Goes on to the place `nearest` of triangle `x`, or a part of the way. `farther` tells how
    /// much farther from the part than this a place is, and `edge` is the length of the triangle's
    /// edges \[m\].
    pub(crate) fn follow(
        &self,
        nearest: [f64; 3],
        x: &[Vec3; 3],
        edge: f64,
        farther: impl Fn(&[f64; 3]) -> f64,
    ) -> Self {
        if !self.is_like(&nearest) {
            return Self::new(self.key, nearest);
        }
        let at = |w: &[f64; 3]| -> Vec3 { (0..3).map(|k| x[k] * w[k]).sum() };
        let way: [f64; 3] = std::array::from_fn(|k| nearest[k] - self.weights[k]);
        let turned_back = at(&way).dot(&at(&self.way)) < 0.0;
        let part = self.part * if turned_back { TURNED_BACK } else { WENT_ON };
        let part = part.clamp(LEAST, 1.0);
        let behind =
            |part: f64| std::array::from_fn(|k| part * nearest[k] + (1.0 - part) * self.weights[k]);
        let (mut weights, mut lag) = (behind(part), 1.0 - part);
        let most = BEHIND * edge;
        for round in 0..ROUNDS {
            let excess = farther(&weights);
            if excess <= most {
                break;
            }
            // Near its least a distance grows with the square of the way; anywhere at least as fast
            // as the way, if the part is convex.
            let less = most / excess;
            lag *= if round + 1 < ROUNDS { less.sqrt() } else { less };
            weights = behind(1.0 - lag);
        }
        let way = std::array::from_fn(|k| weights[k] - self.weights[k]);
        Self { key: self.key, weights, way, part }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle with edges of 10 mm.
    const X: [Vec3; 3] =
        [Vec3::new(0.0, 0.0, 0.0), Vec3::new(0.01, 0.0, 0.0), Vec3::new(0.005, 0.0, 0.008_660_254)];
    const EDGE: f64 = 0.01;

    fn weights(u: f64, v: f64) -> [f64; 3] {
        [1.0 - u - v, u, v]
    }

    fn at(w: &[f64; 3]) -> Vec3 {
        (0..3).map(|k| X[k] * w[k]).sum()
    }

    /// Returns the excess distance of a place from a ball that touches at `nearest` from below.
    fn of_ball<'a>(radius: f64, nearest: &'a [f64; 3]) -> impl Fn(&[f64; 3]) -> f64 + 'a {
        move |w| (at(w) - at(nearest)).norm().hypot(radius) - radius
    }

    /// Held at p a triangle tilts so that its nearest place is `q - gain (p - q)`. With the whole
    /// way p - q grows by the gain in each step; by parts it goes down until it is round-off,
    /// whatever the gain.
    #[test]
    fn a_place_that_leaps_to_and_fro_comes_to_rest() {
        let rest = [0.3, 0.4];
        for gain in [0.5, 1.0, 3.0, 30.0] {
            let mut held = HeldPlace::new([0; 4], weights(rest[0] + 1e-3, rest[1] - 2e-3));
            let mut off = f64::INFINITY;
            for _ in 0..400 {
                let [_, u, v] = held.weights;
                let [u, v] = [(u, rest[0]), (v, rest[1])].map(|(p, q)| q - gain * (p - q));
                let nearest = weights(u.clamp(1e-3, 0.49), v.clamp(1e-3, 0.49));
                // As flat as it gets: only the part of the way holds the place back.
                held = held.follow(nearest, &X, EDGE, |_| 0.0);
                off = (at(&held.weights) - at(&weights(rest[0], rest[1]))).norm();
            }
            assert!(off < 1e-9, "{gain}: {off} m");
        }
    }

    /// A place that goes on by 20 µm in each step is where it is nearest.
    #[test]
    fn a_place_that_goes_on_is_followed_all_the_way() {
        let step = 20e-6 / EDGE;
        let mut held = HeldPlace::new([0; 4], weights(0.1, 0.2));
        for k in 1..=100 {
            let nearest = weights(0.1 + step * f64::from(k), 0.2);
            held = held.follow(nearest, &X, EDGE, of_ball(0.01, &nearest));
            let behind = (at(&held.weights) - at(&nearest)).norm();
            assert!(k < 5 || behind < 1e-12, "step {k}: {behind} m");
        }
    }

    /// However far a place leaps and however small its part, it is never farther from the ball than
    /// the nearest by more than a thousandth of the edge: 10 µm.
    #[test]
    fn a_place_does_not_stay_behind_what_comes_near() {
        for radius in [1e-3, 0.01, 1.0] {
            let mut held = HeldPlace::new([0; 4], weights(0.1, 0.1));
            held.part = 1e-6;
            for (u, v) in [(0.8, 0.1), (0.1, 0.8), (0.3, 0.3), (0.0, 0.0)] {
                let nearest = weights(u, v);
                let farther = of_ball(radius, &nearest);
                held = held.follow(nearest, &X, EDGE, &farther);
                let behind = farther(&held.weights);
                assert!(behind < 1.001e-5, "{radius}: {behind} m");
                assert!((held.weights.iter().sum::<f64>() - 1.0).abs() < 1e-15);
                assert!(held.weights.iter().all(|w| (0.0..=1.0).contains(w)));
            }
        }
    }

    #[test]
    fn what_is_large_beside_a_triangle_is_followed() {
        let ball = |radius: f64| Shape::Sphere { radius };
        assert_eq!(Hold::of(0.016, &ball(0.005)), Hold::Nearest);
        assert_eq!(Hold::of(0.016, &ball(0.03)), Hold::Following);
        // An edge of √(8 R · 20 µm), 1.26 mm for 10 mm, bulges by 20 µm.
        assert_eq!(Hold::of(1.27e-3, &ball(0.01)), Hold::Following);
        assert_eq!(Hold::of(1.26e-3, &ball(0.01)), Hold::Corners);
        // A tin narrower than the triangle, and a column.
        let cylinder = |radius: f64| Shape::Cylinder { radius, half_length: 0.06 };
        assert_eq!(Hold::of(0.016, &cylinder(0.012)), Hold::Nearest);
        assert_eq!(Hold::of(0.016, &cylinder(0.06)), Hold::Following);
        // A pebble rocks about its flat side, of 50 mm, though its tip has 3.2.
        let pebble = Shape::Ellipsoid { half: Vec3::new(0.02, 0.008, 0.014) };
        assert_eq!(Hold::of(0.016, &pebble), Hold::Following);
    }

    #[test]
    fn what_lies_within_one_triangle_is_spread() {
        let ball = Shape::Sphere { radius: 0.02 };
        // The part that touches is 0.89 mm in radius: 2.5 times as wide is the circle in a triangle
        // of 7.7 mm.
        assert_eq!(spread(7.7e-3, &ball), None);
        assert_eq!(spread(0.02, &Shape::Cylinder { radius: 0.03, half_length: 0.02 }), None);
        let found = spread(7.8e-3, &ball).unwrap();
        assert!((found - 0.2e-3).abs() < 1e-9, "{found}");
    }

    #[test]
    fn a_place_outside_of_its_triangle_is_forgotten() {
        let nearest = weights(0.2, 0.3);
        for wrong in [[2.0, -1.0, 0.0], [f64::NAN; 3], [0.0; 3], [1.0; 3]] {
            let held = HeldPlace { weights: wrong, ..HeldPlace::new([7; 4], nearest) };
            assert_eq!(held.follow(nearest, &X, EDGE, |_| 0.0), HeldPlace::new([7; 4], nearest));
        }
        // One inside is none on an edge.
        let (inside, on_edge) = (HeldPlace::new([7; 4], nearest), [0.5, 0.5, 0.0]);
        assert_eq!(inside.follow(on_edge, &X, EDGE, |_| 0.0), HeldPlace::new([7; 4], on_edge));
    }

    #[test]
    fn a_place_on_what_is_flat_stays_where_it_was() {
        let held = HeldPlace { part: 1e-6, ..HeldPlace::new([0; 4], weights(0.1, 0.1)) };
        let nearest = weights(0.2, 0.3);
        let near = held.follow(nearest, &X, EDGE, of_ball(1.0, &nearest));
        assert!((at(&near.weights) - at(&held.weights)).norm() < 1e-8, "{near:?}");
    }

    /// Between two places of an edge the third weight is exactly zero.
    #[test]
    fn a_place_on_an_edge_stays_on_it() {
        let mut held = HeldPlace::new([0; 4], [0.9, 0.1, 0.0]);
        for t in [0.3, 0.2, 0.7, 0.1, 0.11, 0.99] {
            let nearest = [1.0 - t, t, 0.0];
            held = held.follow(nearest, &X, EDGE, of_ball(0.01, &nearest));
            assert_eq!(held.weights[2].to_bits(), 0.0_f64.to_bits());
        }
    }
}
