//! What each part of a hand feels.

use thenar::Vec3;
use thenar::model::{BodyId, Digit};
use thenar::world::ContactPoint;

/// Load on one part.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Sum of normal forces \[N\].
    pub normal: f64,
    /// Size of the summed tangential force \[N\].
    pub shear: f64,
    /// Area in contact \[m²\].
    pub area: f64,
}

/// Loads on palm, thumb, index, middle, ring and little finger of the hand whose flesh is `soft`.
/// `digits` names the part of each vertex of its collision surface.
pub fn loads(contacts: &[ContactPoint], soft: u32, digits: &[Digit]) -> [Load; 6] {
    let mut sums = [(0.0, Vec3::zeros(), 0.0); 6];
    for contact in contacts {
        for side in 0..2 {
            if contact.bodies[side] != BodyId::Soft(soft) {
                continue;
            }
            let digit = contact.vertices[side].and_then(|v| digits.get(v as usize));
            let Some(sum) = digit.map(|digit| &mut sums[*digit as usize]) else { continue };
            let normal = contact.force_W.dot(&contact.normal_W);
            let sign = if side == 0 { 1.0 } else { -1.0 };
            sum.0 += normal;
            sum.1 += (contact.force_W - contact.normal_W * normal) * sign;
            sum.2 += if normal > 0.0 { contact.area } else { 0.0 };
        }
    }
    sums.map(|(normal, shear, area)| Load { normal, shear: shear.norm(), area })
}
