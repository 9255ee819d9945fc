//! The theory beside the experiment: one tick of a device against a wall is linear, and its
//! eigenvalues say when it oscillates. Written down independently of the code that is ticked.

use crate::Proxy;
use crate::virtual_user::{Device, Wall};
use nalgebra::DMatrix;

/// One tick of the linear loop as a matrix. State: position, velocity, position before, proxy
/// position and velocity, forces under way.
fn loop_matrix(device: &Device, proxy: &Proxy) -> DMatrix<f64> {
    let (m, b, h) = (device.mass, device.damping, device.period);
    let (kd, cd) = (proxy.device.stiffness, proxy.device.damping);
    let (kb, cb) = (proxy.bone.stiffness, proxy.bone.damping);
    let n = 5 + device.delay_ticks;
    let row = |entries: &[(usize, f64)]| {
        let mut row = nalgebra::RowDVector::zeros(n);
        entries.iter().for_each(|(i, x)| row[*i] += x);
        row
    };
    // Proxy by backward Euler, at the hand's present place and difference velocity.
    let s = proxy.mass + h * (cd + cb) + h * h * (kd + kb);
    let hand_speed = row(&[(0, 1.0 / h), (2, -1.0 / h)]);
    let spring = row(&[(0, kd), (3, -kd - kb)]);
    let v1 = (row(&[(4, proxy.mass)]) + (spring + &hand_speed * cd) * h) / s;
    let x1 = row(&[(3, 1.0)]) + &v1 * h;
    let force = (&x1 - row(&[(0, 1.0)])) * kd + (&v1 - &hand_speed) * cd;
    // Device under a held force.
    let decay = (-b * h / m).exp();
    let (to_x, to_v) = (h / b - m / (b * b) * (1.0 - decay), (1.0 - decay) / b);
    let applied = if device.delay_ticks == 0 { force.clone() } else { row(&[(n - 1, 1.0)]) };
    let mut a = DMatrix::zeros(n, n);
    a.set_row(0, &(row(&[(0, 1.0), (1, m / b * (1.0 - decay))]) + &applied * to_x));
    a.set_row(1, &(row(&[(1, decay)]) + &applied * to_v));
    a.set_row(2, &row(&[(0, 1.0)]));
    a.set_row(3, &x1);
    a.set_row(4, &v1);
    for i in 0..device.delay_ticks {
        a.set_row(5 + i, &if i == 0 { force.clone() } else { row(&[(4 + i, 1.0)]) });
    }
    // A proxy that stands still keeps its place and speed for ever, which says nothing.
    if proxy.mass > 1e9 { a.remove_rows(3, 2).remove_columns(3, 2) } else { a }
}

/// The value of a parameter at which the largest eigenvalue of the loop leaves the unit circle,
/// between `low` (within) and `high` (beyond).
pub fn predicted_onset(low: f64, high: f64, wall: impl Fn(f64) -> Wall) -> f64 {
    let (mut low, mut high) = (low, high);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        let Wall { device, proxy } = wall(middle);
        let eigenvalues = loop_matrix(&device, &proxy).complex_eigenvalues();
        if eigenvalues.iter().all(|z| z.norm() < 1.0) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}
