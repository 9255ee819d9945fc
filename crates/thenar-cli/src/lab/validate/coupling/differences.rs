//! Derivatives against central differences, at random states of scenes.
//!
//! Generalised coordinates are those of Eq. 9: three of place and three of turning (about world
//! axes) for each bone, then three for each node.

use super::{coupled, jointed};
use crate::lab::validate::case::{Basis, CaseError, Figure};
use crate::lab::validate::run::Solver;
use thenar_core::{Pose, Quat, Vec3, World};
use thenar_scene::session::Random;

/// Everything of D6.
pub fn all(solver: Solver) -> Result<Vec<Figure>, CaseError> {
    let mut figures = coupled::coupling(solver, "lbs")?;
    figures.extend(coupled::flesh(solver)?);
    figures.extend(jointed::skeleton(solver)?);
    Ok(figures.into_iter().map(|figure| figure.rests_on(Basis::Itself)).collect())
}

/// A matrix as rows.
pub type Matrix = Vec<Vec<f64>>;

/// Size of a displacement: metres and radians.
const STEP: f64 = 1e-6;

/// Moves coordinate `q` of the world by `step`.
fn displace(world: &mut World, soft: Option<u32>, q: usize, step: f64) {
    let bones = world.desc().rigids.len();
    let unit = |k: usize| Vec3::from_fn(|i, _| if i == k { step } else { 0.0 });
    if q < 6 * bones {
        let (bone, k) = ((q / 6) as u32, q % 6);
        let pose = world.rigid_pose(bone);
        let moved = if k < 3 {
            Pose::new(pose.position + unit(k), pose.rotation)
        } else {
            Pose::new(pose.position, Quat::from_scaled_axis(unit(k - 3)) * pose.rotation)
        };
        world.set_rigid_state(bone, moved, world.rigid_velocity(bone));
    } else if let Some(soft) = soft {
        let mut nodes = world.nodes(soft).to_vec();
        let at = q - 6 * bones;
        nodes[at / 3] += unit(at % 3);
        world.set_nodes(soft, &nodes);
    }
}

/// Coordinates of a world with the given deformable body.
pub fn coordinates(world: &World, soft: Option<u32>) -> usize {
    6 * world.desc().rigids.len() + soft.map_or(0, |s| 3 * world.nodes(s).len())
}

/// `∂f_i/∂q_j` by central differences; entry `[i][j]`.
pub fn differences(
    world: &World,
    soft: Option<u32>,
    mut f: impl FnMut(&World) -> Vec<f64>,
) -> Matrix {
    let count = coordinates(world, soft);
    let mut moved = world.clone();
    let mut columns = Vec::with_capacity(count);
    for q in 0..count {
        displace(&mut moved, soft, q, STEP);
        let ahead = f(&moved);
        displace(&mut moved, soft, q, -2.0 * STEP);
        let behind = f(&moved);
        displace(&mut moved, soft, q, STEP);
        let slopes = ahead.iter().zip(&behind).map(|(a, b)| (a - b) / (2.0 * STEP));
        columns.push(slopes.collect::<Vec<f64>>());
    }
    (0..columns[0].len()).map(|i| columns.iter().map(|c| c[i]).collect()).collect()
}

/// Kind of a coordinate or of a force on it: place and force of a bone, turn and torque of a bone,
/// or place and force of a node.
fn kind(coordinate: usize, bones: usize) -> usize {
    match coordinate {
        q if q >= 6 * bones => 2,
        q => usize::from(q % 6 >= 3),
    }
}

/// Largest difference of chosen entries, relative to the largest entry of the same kind: metres
/// and radians, newtons and newton metres are not compared with each other. Columns are
/// coordinates; rows are too when `rows` says so, and all of one kind otherwise.
pub fn mismatch(
    world: &World,
    rows: Rows,
    got: &Matrix,
    want: &Matrix,
    chosen: impl Fn(usize, usize) -> bool,
) -> f64 {
    let bones = world.desc().rigids.len();
    let (mut off, mut size) = ([[0.0_f64; 3]; 3], [[0.0_f64; 3]; 3]);
    for (i, (got, want)) in got.iter().zip(want).enumerate() {
        let row = if rows == Rows::Coordinates { kind(i, bones) } else { 0 };
        for (j, (g, w)) in got.iter().zip(want).enumerate().filter(|(j, _)| chosen(i, *j)) {
            let column = kind(j, bones);
            off[row][column] = off[row][column].max((g - w).abs());
            size[row][column] = size[row][column].max(w.abs()).max(g.abs());
        }
    }
    let ratios = off.iter().flatten().zip(size.iter().flatten());
    ratios.filter(|(off, _)| **off > 0.0).map(|(off, size)| off / size).fold(0.0, f64::max)
}

/// Meaning of the rows of a matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// Forces on the coordinates.
    Coordinates,
    /// One quantity, or several of one kind.
    OneKind,
}

/// Turns every bone by up to 90 degrees about a random axis and moves it by up to `size` along
/// each world axis.
pub fn scatter_bones(world: &mut World, size: f64, random: &mut Random) {
    let mut vector = |size: f64| random.vector(size);
    for bone in 0..world.desc().rigids.len() as u32 {
        let pose = world.rigid_pose(bone);
        let turn = vector(1.0).normalize() * (std::f64::consts::FRAC_PI_2 * vector(1.0).x);
        let rotation = Quat::from_scaled_axis(turn) * pose.rotation;
        let moved = Pose::new(pose.position + vector(size), rotation);
        world.set_rigid_state(bone, moved, [Vec3::zeros(); 2]);
    }
}
