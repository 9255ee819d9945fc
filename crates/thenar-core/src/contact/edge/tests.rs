use super::*;
use crate::random::Random;

/// Upper edge of a wall along x at height 0, and lower edge of one along z at this height above it.
fn crossing(height: f64) -> (Edge, Edge) {
    let below = Edge { ends: [-Vec3::x(), Vec3::x()], normals: [Vec3::y(), Vec3::z()] };
    let above = Edge {
        ends: [-Vec3::z(), Vec3::z()].map(|p| p + Vec3::y() * height),
        normals: [-Vec3::y(), Vec3::x()],
    };
    (above, below)
}

/// An edge turned about a point.
fn turned(edge: &Edge, about: Vec3, turn: Vec3) -> Edge {
    let turn = crate::math::Quat::from_scaled_axis(turn);
    Edge {
        ends: edge.ends.map(|p| about + turn * (p - about)),
        normals: edge.normals.map(|n| turn * n),
    }
}

#[test]
fn edges_cross_where_their_lines_are_nearest() {
    for height in [0.3, 1e-4, -1e-3] {
        let (above, below) = crossing(height);
        let met = above.cross(&below, 0.0).unwrap();
        assert!((met.gap() - height).abs() < 1e-15 && (met.n - Vec3::y()).norm() < 1e-15);
        let other = below.cross(&above, 0.0).unwrap();
        assert!((other.gap() - height).abs() < 1e-15 && (other.n + Vec3::y()).norm() < 1e-15);
    }
    let (mut above, below) = crossing(0.1);
    above.ends = above.ends.map(|p| p + Vec3::x() * 1.01);
    assert!(above.cross(&below, 0.0).is_none(), "beyond the end");
}

/// Between two edges that lie level but for a small tilt the gap is that to the face beside the
/// edge, to a thousandth; at larger tilts the face alone is nearest, and the edges are none.
#[test]
fn what_leans_a_little_from_the_cone_of_normals_still_crosses() {
    let (above, below) = crossing(1e-3);
    for axis in [Vec3::x(), Vec3::z()] {
        for (angle, counts) in [(0.04, true), (-0.04, true), (0.06, false), (-0.06, false)] {
            let leaning = turned(&above, Vec3::y() * 1e-3, axis * angle);
            // The other way the normal leans towards the side of the edge, where it is one of its
            // own.
            let towards_side = if axis == Vec3::x() { angle > 0.0 } else { angle < 0.0 };
            let met = leaning.cross(&below, 0.0);
            assert_eq!(met.is_some(), counts || towards_side, "{axis} {angle}");
            assert!(
                leaning.cross(&below, 0.01).is_some(),
                "as level within the step: {axis} {angle}"
            );
            if let Some(met) = met {
                let least = 1e-3 * f64::cos(angle);
                let gap = met.gap();
                assert!(gap >= least - 1e-15 && gap <= 1e-3 + 1e-15, "{axis} {angle}: {gap}");
            }
        }
    }
}

/// An edge whose ends go straight on meets another where a fine walk along its way finds that it
/// passes.
#[test]
fn an_edge_arrives_where_a_walk_finds_it() {
    const WALK: usize = 4000;
    let mut random = Random::new(41);
    let (mut met, mut missed) = (0, 0);
    for case in 0..2000 {
        let (above, below) = crossing(random.range(0.05, 0.5));
        let above = turned(&above, above.ends[0], random.vector(0.3));
        let fall = Vec3::y() * -random.range(0.0, 0.8);
        let ways = [fall + random.vector(0.3), fall + random.vector(0.3)];
        let height = |s: f64| {
            let ends = [0, 1].map(|k| above.ends[k] + s * ways[k]);
            let there = Edge { ends, ..above };
            there.cross(&below, 0.0).map(|c| c.gap())
        };
        let passes = |k: usize| {
            let [before, after] = [k, k + 1].map(|k| height(FOLLOWED * k as f64 / WALK as f64));
            matches!((before, after), (Some(before), Some(after)) if before > 0.0 && after <= 0.0)
        };
        let walked = (0..WALK).find(|&k| passes(k)).map(|k| FOLLOWED * k as f64 / WALK as f64);
        let found = above.arrival(&ways, &below);
        match (walked, found) {
            (Some(when), Some(c)) => {
                met += 1;
                assert!((c.when - when).abs() <= FOLLOWED / WALK as f64 + 1e-9, "case {case}");
                // On its way along the normal it uses up its gap just then.
                let s = (c.p - above.ends[0]).norm() / above.along().norm();
                let way = ways[0] + s * (ways[1] - ways[0]);
                let left = c.gap() + c.when * way.dot(&c.n);
                assert!(left.abs() < 1e-9, "case {case}: {left}");
            }
            // A walk may step over what lasts less than a stride.
            (None, found) => missed += u32::from(found.is_none()),
            (Some(when), None) => panic!("case {case}: passes at {when}"),
        }
    }
    assert!(met > 300 && missed > 300, "{met} met, {missed} did not");
}

#[test]
fn the_smaller_root_comes_first() {
    let mut random = Random::new(43);
    for _ in 0..1000 {
        let (a, b, scale) =
            (random.range(-2.0, 2.0), random.range(-2.0, 2.0), random.range(-3.0, 3.0));
        let [low, high] = [a.min(b), a.max(b)];
        let found = roots([scale * a * b, -scale * (a + b), scale]).map(Option::unwrap);
        assert!((found[0] - low).abs() < 1e-6 && (found[1] - high).abs() < 1e-6, "{found:?}");
    }
    assert_eq!(roots([1.0, 0.0, 1.0]), [None; 2]);
    assert_eq!(roots([-1.0, 2.0, 0.0]).into_iter().flatten().collect::<Vec<_>>(), [0.5]);
    assert_eq!(roots([0.0; 3]), [None; 2]);
}
