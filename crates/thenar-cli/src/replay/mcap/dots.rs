//! Surfaces and forces as clouds of points, for viewers that draw no meshes from MCAP.

use super::message::{placed, time};
use super::picture::{ARROW, BONE, FORCE, FORCE_MIN, GROUND, WORLD, colour_of, colour_of_soft};
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{PackedElementField, PointCloud};
use std::f64::consts::{PI, TAU};
use thenar_core::shape::Shape;
use thenar_core::{Pose, Vec3};
use thenar_scene::session::Session;

/// About the distance between neighbouring points \[m\].
const SPACING: f64 = 2.5e-3;
/// No surface has more points: large ones have them farther apart.
const DOTS_MAX: f64 = 20_000.0;
/// Points of an arrow.
const ARROW_DOTS: u32 = 12;

/// Points that keep their place on triangles while these move.
#[derive(Clone, Debug, Default)]
pub struct Dots {
    /// Three vertices each, and their weights, which sum up to 1.
    points: Vec<([u32; 3], [f64; 3])>,
}

impl Dots {
    /// Spread evenly over the area.
    pub fn spread(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Self {
        let corners = |t: &[u32; 3]| t.map(|v| vertices[v as usize]);
        let area = |t: &[u32; 3]| {
            let [a, b, c] = corners(t);
            0.5 * (b - a).cross(&(c - a)).norm()
        };
        let whole: f64 = triangles.iter().map(area).sum();
        let per_area = (1.0 / (SPACING * SPACING)).min(DOTS_MAX / whole);
        let mut points = Vec::new();
        let (mut owed, mut count) = (0.0, 0.0);
        for triangle in triangles {
            owed += area(triangle) * per_area;
            while owed >= 1.0 {
                owed -= 1.0;
                count += 1.0;
                // Roberts' sequence, which covers a square evenly, folded to a triangle.
                let (u, v) = ((0.754_877_67 * count) % 1.0, (0.569_840_29 * count) % 1.0);
                let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
                points.push((*triangle, [1.0 - u - v, u, v]));
            }
        }
        Self { points }
    }

    /// Places of the points now.
    pub fn at<'a>(&'a self, vertices: &'a [Vec3]) -> impl Iterator<Item = Vec3> + 'a {
        self.points.iter().map(|(corners, weights)| {
            corners.iter().zip(weights).map(|(v, w)| vertices[*v as usize] * *w).sum()
        })
    }
}

/// Points on a capsule along y; a sphere where it has no length. Zones of equal height have equal
/// area, on the round ends as on the cylinder (Archimedes), so that one spiral is even everywhere.
fn capsule(radius: f64, half_length: f64) -> impl Iterator<Item = Vec3> {
    let height = 2.0 * (radius + half_length);
    let count = (TAU * radius * height / (SPACING * SPACING)).clamp(12.0, DOTS_MAX) as u32;
    (0..count).map(move |k| {
        let y = height * ((f64::from(k) + 0.5) / f64::from(count) - 0.5);
        let above = (y.abs() - half_length).max(0.0);
        let across = (radius * radius - above * above).max(0.0).sqrt();
        // The golden angle.
        let angle = PI * (3.0 - 5.0_f64.sqrt()) * f64::from(k);
        Vec3::new(across * angle.cos(), y, across * angle.sin())
    })
}

/// Points on a mesh at rest.
fn mesh(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Vec<Vec3> {
    Dots::spread(vertices, triangles).at(vertices).collect()
}

/// Points on a box.
fn cuboid(half: &Vec3) -> Vec<Vec3> {
    let sign = |corner: u32, axis: u32| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
    let corner = |k| Vec3::new(sign(k, 0), sign(k, 1), sign(k, 2)).component_mul(half);
    let corners: Vec<Vec3> = (0..8).map(corner).collect();
    let faces =
        [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
    let triangles: Vec<[u32; 3]> =
        faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    mesh(&corners, &triangles)
}

/// Points on a shape, in the body's frame.
fn shape(shape: &Shape, pose: &Pose) -> Vec<Vec3> {
    let points: Vec<Vec3> = match shape {
        Shape::Sphere { radius } => capsule(*radius, 0.0).collect(),
        Shape::Capsule { radius, half_length } => capsule(*radius, *half_length).collect(),
        Shape::Cuboid { half } => cuboid(half),
        Shape::HalfSpace => cuboid(&Vec3::new(GROUND, 0.0, GROUND)),
        Shape::Mesh(shape) => mesh(&shape.points, &shape.triangles),
        other => thenar_picture::of_shape(other, 48, 1)
            .map(|solid| mesh(&solid.positions, &solid.triangles))
            .unwrap_or_default(),
    };
    points.iter().map(|p| pose.point(p)).collect()
}

/// A point with its colour and numbers that viewers may colour by.
type Dot<const N: usize> = (Vec3, [f64; 3], [f64; N]);

/// A cloud. Coordinates are f32: 6 nm at 0.1 m.
fn cloud<const N: usize>(
    ns: u64,
    frame: &str,
    names: [&str; N],
    dots: impl IntoIterator<Item = Dot<N>>,
) -> PointCloud {
    let field = |(k, name): (usize, &str)| PackedElementField {
        name: name.into(),
        offset: 4 * k as u32,
        r#type: NumericType::Float32 as i32,
    };
    let numbers = ["x", "y", "z"].into_iter().chain(names);
    let mut fields: Vec<PackedElementField> = numbers.enumerate().map(field).collect();
    let place = 4 * fields.len() as u32;
    for (k, name) in ["red", "green", "blue", "alpha"].into_iter().enumerate() {
        let r#type = NumericType::Uint8 as i32;
        fields.push(PackedElementField { name: name.into(), offset: place + k as u32, r#type });
    }
    let mut data: Vec<u8> = Vec::new();
    for (place, colour, values) in dots {
        place.iter().chain(&values).for_each(|x| data.extend((*x as f32).to_le_bytes()));
        // From 0 to 1 in to 0 to 255.
        data.extend(colour.map(|part| (255.0 * part).round() as u8));
        data.push(255);
    }
    PointCloud {
        timestamp: Some(time(ns)),
        frame_id: frame.into(),
        pose: Some(placed(&Pose::identity())),
        point_stride: place + 4,
        fields,
        data: data.into(),
    }
}

/// No points, in place of a body that has gone.
pub fn none(ns: u64) -> PointCloud {
    cloud::<0>(ns, WORLD, [], [])
}

/// Rigid bodies and bones: name, and a cloud in the body's own frame.
pub fn objects(session: &Session, ns: u64) -> Vec<(String, PointCloud)> {
    let desc = session.world().desc();
    let mut all: Vec<Vec<Dot<0>>> = Vec::new();
    for (b, rigid) in desc.rigids.iter().enumerate() {
        let colour = colour_of(session, b);
        let look = session.looks().get(b).and_then(|look| look.mesh.as_ref());
        let points = match (look, &rigid.shape) {
            (Some((seen, _)), _) => mesh(&seen.positions, &seen.triangles),
            // Bones follow below.
            (None, _) if desc.flesh_of_bone(b as u32).is_some() => Vec::new(),
            (None, Some(kind)) => shape(kind, &rigid.pose_BS),
            (None, None) => Vec::new(),
        };
        all.push(points.into_iter().map(|p| (p, colour, [])).collect());
    }
    for hand in session.hands() {
        for (bone, b) in hand.model.bones.iter().zip(hand.handle.bones.clone()) {
            let [from, to] = bone.ends_B;
            let axis = to - from;
            let turn = thenar_core::Quat::rotation_between(&Vec3::y(), &axis);
            let pose =
                Pose::new((from + to) / 2.0, turn.unwrap_or_else(thenar_core::Quat::identity));
            let points = capsule(bone.radius, 0.5 * axis.norm());
            all[b as usize].extend(points.map(|p| (pose.point(&p), BONE, [])));
        }
    }
    let named = desc.rigids.iter().zip(all).filter(|(_, dots)| !dots.is_empty());
    named.map(|(rigid, dots)| (rigid.name.clone(), cloud(ns, &rigid.name, [], dots))).collect()
}

/// Points on each deformable body.
pub fn flesh_dots(session: &Session) -> Vec<Dots> {
    let world = session.world();
    let softs = world.desc().softs.iter().enumerate();
    softs
        .map(|(s, soft)| {
            let vertices = world.collision_vertices(s as u32);
            Dots::spread(vertices, &soft.flesh.collision.triangles)
        })
        .collect()
}

/// Deformable bodies, as they are now: name and cloud.
pub fn flesh(session: &Session, dots: &[Dots], ns: u64) -> Vec<(String, PointCloud)> {
    let world = session.world();
    let softs = world.desc().softs.iter().zip(dots).enumerate();
    softs
        .map(|(s, (soft, dots))| {
            let colour = colour_of_soft(session, s);
            let points = dots.at(world.collision_vertices(s as u32));
            let points = points.map(|p| (p, colour, []));
            (soft.name.clone(), cloud(ns, WORLD, [], points))
        })
        .collect()
}

/// Points at which bodies touch, with what is there: force on the first body \[N\], its normal
/// part, gap \[m\], normal towards that body, area \[m²\] and mean pressure \[Pa\], both 0 between
/// rigid bodies, which touch at points.
pub fn contacts(session: &Session, ns: u64) -> PointCloud {
    let names = [
        "force",
        "normal_force",
        "force_x",
        "force_y",
        "force_z",
        "gap",
        "normal_x",
        "normal_y",
        "normal_z",
        "area",
        "pressure",
    ];
    let dots = session.world().contacts().iter().map(|contact| {
        let (f, n, area) = (contact.force_W, contact.normal_W, contact.area);
        let normal = f.dot(&n);
        let pressure = if area > 0.0 { normal / area } else { 0.0 };
        let values = [f.norm(), normal, f.x, f.y, f.z, contact.gap, n.x, n.y, n.z, area, pressure];
        (contact.position_W, FORCE, values)
    });
    cloud(ns, WORLD, names, dots)
}

/// Forces as dotted lines, as long as arrows would be.
pub fn forces(session: &Session, ns: u64) -> PointCloud {
    let pressed = session.world().contacts().iter().filter(|c| c.force_W.norm() >= FORCE_MIN);
    let dots = pressed.flat_map(|contact| {
        let (from, force) = (contact.position_W, contact.force_W);
        (0..ARROW_DOTS).map(move |k| {
            let along = ARROW * f64::from(k) / f64::from(ARROW_DOTS - 1);
            (from + force * along, FORCE, [force.norm()])
        })
    });
    cloud(ns, WORLD, ["force"], dots)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_lie_on_the_surface_and_are_as_dense_everywhere() {
        let (r, h) = (0.02, 0.03);
        let points: Vec<Vec3> = capsule(r, h).collect();
        let off = |p: &Vec3| {
            let axis = Vec3::new(0.0, p.y.clamp(-h, h), 0.0);
            ((p - axis).norm() - r).abs()
        };
        assert!(points.iter().all(|p| off(p) < 1e-12));
        // A round end has the area 2 pi r², the whole 4 pi r (r + h).
        let share = points.iter().filter(|p| p.y > h).count() as f64 / points.len() as f64;
        assert!((share - 0.5 * r / (r + h)).abs() < 0.01, "{share}");
    }

    #[test]
    fn points_on_a_box_are_shared_out_by_area() {
        let half = Vec3::new(0.05, 0.02, 0.01);
        let points = cuboid(&half);
        let on = |axis: usize| {
            points.iter().filter(|p| (p[axis].abs() - half[axis]).abs() < 1e-12).count() as f64
        };
        let area = |axis: usize| half.product() / half[axis];
        let all = area(0) + area(1) + area(2);
        assert!((0..3).map(on).sum::<f64>() >= points.len() as f64, "none lies inside");
        for axis in 0..3 {
            let (share, theory) = (on(axis) / points.len() as f64, area(axis) / all);
            assert!((share - theory).abs() < 0.02, "{axis}: {share} {theory}");
        }
        let theory = 8.0 * all / (SPACING * SPACING);
        assert!((points.len() as f64 - theory).abs() < 2.0, "{} {theory}", points.len());
    }

    #[test]
    fn points_move_with_their_triangle() {
        let rest = [Vec3::zeros(), Vec3::x() * 0.01, Vec3::y() * 0.01];
        let dots = Dots::spread(&rest, &[[0, 1, 2]]);
        let map = |p: &Vec3| Vec3::new(2.0 * p.x + p.y, 0.5 * p.y, 1.0 - p.x);
        let moved = rest.map(|p| map(&p));
        assert!(dots.at(&rest).count() >= 8);
        for (p, q) in dots.at(&rest).zip(dots.at(&moved)) {
            assert!((map(&p) - q).norm() < 1e-15);
        }
    }
}
