//! Contact between two bodies.

use crate::math::Vec3;
use thenar::model::BodyId;
use thenar::world::ContactPoint;

/// Force on the first body, size of its normal and tangential part, area in contact, centre of
/// pressure, penetration, and number of points that carry force.
pub fn between(contacts: &[ContactPoint], [a, b]: [BodyId; 2], out: &mut Vec<f64>) {
    let (mut normal, mut shear, mut centre) = (Vec3::zeros(), Vec3::zeros(), Vec3::zeros());
    let (mut pressing, mut area, mut depth, mut points) = (0.0, 0.0, 0.0_f64, 0.0);
    for contact in contacts {
        let sign = match contact.bodies {
            pair if pair == [a, b] => 1.0,
            pair if pair == [b, a] => -1.0,
            _ => continue,
        };
        depth = depth.max(-contact.gap);
        let size = contact.force_W.dot(&contact.normal_W);
        if size <= 0.0 {
            continue;
        }
        normal += contact.normal_W * (size * sign);
        shear += (contact.force_W - contact.normal_W * size) * sign;
        centre += contact.position_W * size;
        pressing += size;
        area += contact.area;
        points += 1.0;
    }
    let force = normal + shear;
    let centre = if pressing > 0.0 { centre / pressing } else { Vec3::zeros() };
    out.extend(force.iter().copied().chain([normal.norm(), shear.norm(), area]));
    out.extend(centre.iter().copied().chain([depth, points]));
}
