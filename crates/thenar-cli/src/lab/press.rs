//! A flat plate that presses on the pad of a finger: where it stands when it touches, and the
//! changes of a scene that move it. Shared by validation and by fits.

use thenar_core::Vec3;
use thenar_core::model::Digit;
use thenar_scene::session::Session;

/// Length of the hand for which the plate's size is given \[m\].
const LENGTH: f64 = 0.19;
/// Across the finger, thickness, along it \[m\]: no other finger meets it.
const SIZE: [f64; 3] = [0.024, 0.01, 0.04];

/// A plate at the pad of a finger at rest.
#[derive(Clone, Debug)]
pub struct Plate {
    /// Position of the body when it touches, world \[m\].
    pub touch: Vec3,
    /// The way that it presses, of length one, world.
    pub way: Vec3,
    /// Changes of the scene that give the body `name` its size, rotation and start.
    pub changes: Vec<String>,
}

impl Plate {
    /// A plate for the box `name` that meets the pad of a finger of the scene's first hand at an
    /// angle \[degrees\] between it and the hand's plane; of the thumb, which lies across, between
    /// it and its last bone. None without such a finger and its skin.
    pub fn at(session: &Session, name: &str, digit: Digit, angle_deg: f64) -> Option<Self> {
        let hand = session.hands().first()?;
        let last = hand.model.bones.iter().rposition(|bone| bone.digit == digit)?;
        let bone = if digit == Digit::Thumb { last } else { 0 };
        let pose_WB = session.world().rigid_pose(hand.handle.bones.start + bone as u32);
        let (sin, cos) = angle_deg.to_radians().sin_cos();
        // Bones have -z along them to the tip and +y out of the back.
        let way = pose_WB.vector(&Vec3::new(0.0, cos, sin));
        let vertices = session.world().collision_vertices(hand.flesh()?);
        let pad = vertices.iter().zip(&hand.model.collision_digits).filter(|(_, d)| **d == digit);
        let first = pad.map(|(x, _)| x).min_by(|a, b| way.dot(a).total_cmp(&way.dot(b)))?;
        let size = SIZE.map(|edge| edge * hand.model.length / LENGTH);
        let touch = first - way * (0.5 * size[1]);
        let about = thenar_core::Quat::from_axis_angle(&Vec3::x_axis(), angle_deg.to_radians());
        let q = (pose_WB.rotation * about).coords;
        let changes = vec![
            format!("rigid.{name}.shape.size={size:?}"),
            format!("rigid.{name}.rotation={{quaternion=[{}, {}, {}, {}]}}", q.x, q.y, q.z, q.w),
        ];
        Some(Self { touch, way, changes })
    }

    /// The changes that move it: `[time [s], depth [m]]`, straight between.
    pub fn moves(&self, name: &str, depths: &[[f64; 2]]) -> Vec<String> {
        moves(name, &self.touch, &self.way, depths)
    }
}

/// Changes that move a scripted body along `way` from where it touches: `[time [s], depth [m]]`,
/// straight between, and let the scene last as long.
pub fn moves(name: &str, touch: &Vec3, way: &Vec3, depths: &[[f64; 2]]) -> Vec<String> {
    let place = |depth: f64| {
        let p = touch + way * depth;
        format!("[{:e}, {:e}, {:e}]", p.x, p.y, p.z)
    };
    let keys: Vec<String> =
        depths.iter().map(|[t, d]| format!("{{time={t:e},position={}}}", place(*d))).collect();
    let (first, last) = (depths.first().map_or(0.0, |k| k[1]), depths.last().map_or(0.0, |k| k[0]));
    vec![
        format!("rigid.{name}.position={}", place(first)),
        format!("rigid.{name}.interpolation=linear"),
        format!("rigid.{name}.keyframes=[{}]", keys.join(",")),
        format!("duration={last:e}"),
    ]
}
