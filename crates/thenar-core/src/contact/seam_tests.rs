//! Surfaces that touched before are not led out as one along a seam of shallow cuts.

use super::approach::LastSide;
use super::sides::Sight;
use super::tests::{Scene, cube, moved};
use super::{Detector, SeenSides};
use crate::math::{Quat, Vec3};

/// Edge of the cubes \[m\].
const SIZE: f64 = 0.04;

/// Cubes of `cells` cells that lie in one place but for a turn and then `off`. Put there, they
/// leave by the length of a cube; where the vertices outside of `touched` cubes did before, they
/// are a seam, and nothing goes farther than they are inside. The deepest gap \[m\].
fn deepest(cells: u32, (turn, off): (Quat, Vec3), touched: &[usize]) -> f64 {
    let mut scene = Scene::new();
    let places = [(Quat::identity(), Vec3::zeros()), (turn, off)];
    for (turn, by) in places {
        scene.soft(cube(SIZE, cells));
        let points = &mut scene.surfaces.last_mut().unwrap().0;
        points.iter_mut().for_each(|p| *p = turn * *p);
        moved(points, by);
    }
    let (mut detector, mut sides) = (Detector::new(&scene.desc), SeenSides::default());
    if !touched.is_empty() {
        let count = scene.surfaces[0].0.len();
        let (before, mut now) = (SeenSides::default(), SeenSides::with_capacity(2 * count));
        let mut sight = Sight { before: &before, now: Some(&mut now) };
        for &soft in touched {
            let points = &scene.surfaces[soft].0;
            let (turn, by) = places[1 - soft];
            let is_out = |p: &Vec3| (turn.inverse() * (p - by)).amax() > 0.5 * SIZE;
            for (v, p) in points.iter().enumerate().filter(|(_, p)| is_out(p)) {
                // The other cube lay before each face.
                let normal = -p.normalize();
                sight.note(soft * count + v, 1 - soft as u32, LastSide { normal, place: *p });
            }
        }
        now.sort();
        sides = now;
    }
    let mut out = Vec::new();
    scene.find_next(&mut detector, &mut sides, 1e-3, &mut out);
    out.iter().map(|c| c.gap).fold(0.0, f64::min)
}

#[test]
fn what_touched_before_is_not_led_through_the_other_along_a_seam() {
    for cells in [3, 5, 8] {
        for off in [[7e-4, 6e-4, 5e-4], [9e-4, -6e-4, 8e-4], [1.5e-3, 1.2e-3, 1e-3]] {
            let off = Vec3::from(off);
            let at = (Quat::identity(), off);
            let put = deepest(cells, at, &[]);
            assert!(put < -0.9 * SIZE, "{cells} cells, {off}: put there, {put} m");
            let seam = deepest(cells, at, &[0, 1]);
            assert!(seam > -3.0 * off.amax(), "{cells} cells, {off}: a seam, {seam} m");
        }
    }
}

/// Cubes that stand in each other turned, one higher by `up`: edges go through, and no vertex is
/// inside.
#[test]
fn edges_whose_ends_touched_before_are_not_led_through_the_other() {
    for (degrees, up) in [(45.0_f64, 5e-4), (45.0, 2e-3), (40.0, 1e-3), (52.0, 1e-3)] {
        let turn = Quat::from_axis_angle(&Vec3::y_axis(), degrees.to_radians());
        let at = (turn, Vec3::y() * up);
        let put = deepest(1, at, &[]);
        assert!(put < -0.5 * SIZE, "{degrees} degrees, {up} m: put there, {put} m");
        let seam = deepest(1, at, &[0, 1]);
        assert!(seam > -2.0 * up, "{degrees} degrees, {up} m: a seam, {seam} m");
        for one in [0, 1] {
            let partly = deepest(1, at, &[one]);
            assert!(partly < -0.5 * SIZE, "{degrees} degrees, {up} m: {one} touched, {partly} m");
        }
    }
}
