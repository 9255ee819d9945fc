//! Poses of this runtime's hands.

/// Joints of a hand, the palm first.
pub const JOINTS: usize = 26;
/// Steps after which the motion begins anew.
pub const STEPS: u64 = 50;
/// Height of the local space's origin above the stage's floor \[m\].
pub const LOCAL_HEIGHT: f32 = 1.5;

/// A joint: position \[m\] in the stage, +y up; rotation x y z w; radius \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Position \[m\].
    pub position: [f32; 3],
    /// x y z w
    pub rotation: [f32; 4],
    /// Radius \[m\].
    pub radius: f32,
}

/// Joint `k` of the left (0) or right (1) hand when it was asked for `asked` times before: all move
/// along x by a millimetre each time, and jump back after [`STEPS`].
pub fn joint(hand: usize, k: usize, asked: u64) -> Joint {
    let i = k as f32;
    let (sin, cos) = (0.05 * i).sin_cos();
    let mirror = if hand == 0 { -1.0 } else { 1.0 };
    let moved = 1e-3 * (asked % STEPS) as f32;
    Joint {
        position: [mirror * (0.2 + 4e-3 * i) + moved, 1.1 + 3e-3 * i, -0.3 - 2e-4 * i * i],
        rotation: [sin, 0.0, mirror * 0.6 * cos, 0.8 * cos],
        radius: 5e-3 + 5e-4 * i,
    }
}
