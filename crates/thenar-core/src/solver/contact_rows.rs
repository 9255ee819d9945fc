//! The contact constraints of one step: `J v ≥ -g/Δt` with friction, and the products with J
//! that the solvers need. J is never formed; a row is a contact frame and the points it holds.
//! A joint limit is a row too, which holds how two bodies turn against each other.

use crate::capacity_vec::CapacityVec;
use crate::math::{Mat3, Mat6, Vec3, Vec6, tangents};
use crate::solver::BlockDiagonal;
use crate::solver::push_out::PushRow;
use std::ops::Range;

/// A turn enters as the speed of a point so far from its axis, so that one tolerance \[m/s\] serves
/// all rows \[m\].
pub const TURN_LEVER: f64 = 0.05;

/// One contact: three rows (normal and two tangents).
#[derive(Clone, Debug)]
pub struct ContactRow {
    /// Rows: normal (from B to A), first and second tangent, world. Of a turn: its axis times
    /// [`TURN_LEVER`], and nothing.
    pub frame: Mat3,
    /// Holds how its rigid bodies turn, not how their points move.
    pub turns: bool,
    /// The nodes this contact holds, in `ContactRows::{nodes, weights}`.
    pub nodes: Range<u32>,
    /// Rigid bodies held: index, lever from the centre of mass to the contact \[m\], and sign.
    pub rigids: [Option<(u32, Vec3, f64)>; 2],
    /// Friction coefficient.
    pub friction: f64,
    /// Wanted `J Δv`: at least this along the normal, exactly this along a sticking tangent
    /// \[m/s\].
    pub target: Vec3,
    /// Impulse in the contact frame \[N s\].
    pub lambda: Vec3,
    /// The part of its normal component that is in the velocities without contact already \[N s\].
    pub included: f64,
    /// While overlaps are undone, what the row asks for then.
    pub push: Option<PushRow>,
    /// Own response `J D⁻¹ Jᵀ` \[1/kg\].
    pub response: Mat3,
}

/// All contacts of a step, in arrays that are kept between steps.
#[derive(Clone, Debug, Default)]
pub struct ContactRows {
    /// Rows of the contacts.
    pub rows: CapacityVec<ContactRow>,
    /// Node of each held point.
    pub nodes: CapacityVec<u32>,
    /// Barycentric weight of each, negative on side B.
    pub weights: CapacityVec<f64>,
    /// Number of rigid bodies, which come before the nodes among the unknowns.
    pub rigids: usize,
}

impl ContactRows {
    /// Room for this many bodies and contacts.
    pub fn with_capacity(rigids: usize, contacts: usize) -> Self {
        Self {
            rows: CapacityVec::with_capacity(contacts),
            nodes: CapacityVec::with_capacity(16 * contacts),
            weights: CapacityVec::with_capacity(16 * contacts),
            rigids,
        }
    }

    /// Forgets all contacts.
    pub fn clear(&mut self) {
        self.rows.clear();
        self.nodes.clear();
        self.weights.clear();
    }

    /// Begins a contact with this normal; points are added by `hold_node` and `hold_rigid`.
    pub fn begin(&mut self, normal: &Vec3, friction: f64, lambda_W: &Vec3) -> usize {
        let (t1, t2) = tangents(normal);
        let frame = Mat3::from_rows(&[normal.transpose(), t1.transpose(), t2.transpose()]);
        let start = self.nodes.len() as u32;
        self.rows.push(ContactRow {
            lambda: frame * lambda_W,
            frame,
            turns: false,
            nodes: start..start,
            rigids: [None; 2],
            friction,
            target: Vec3::zeros(),
            included: 0.0,
            push: None,
            response: Mat3::zeros(),
        });
        self.rows.len() - 1
    }

    /// Begins a row on how fast bodies turn about an axis, with no friction; the bodies are added
    /// by `hold_rigid`, their levers do not matter. `impulse` starts it \[N m s\].
    pub fn begin_turn(&mut self, axis_W: &Vec3, impulse: f64) -> usize {
        let i = self.begin(axis_W, 0.0, &Vec3::zeros());
        let row = &mut self.rows[i];
        row.turns = true;
        row.frame = Mat3::zeros();
        row.frame.set_row(0, &(axis_W * TURN_LEVER).transpose());
        row.lambda.x = impulse / TURN_LEVER;
        i
    }

    /// The last contact holds `node` with this signed weight.
    pub fn hold_node(&mut self, node: u32, weight: f64) {
        let Some(row) = self.rows.last_mut() else { return };
        let range = row.nodes.start as usize..row.nodes.end as usize;
        if let Some(k) = self.nodes[range.clone()].iter().position(|&n| n == node) {
            self.weights[range.start + k] += weight;
            return;
        }
        self.nodes.push(node);
        self.weights.push(weight);
        row.nodes.end += 1;
    }

    /// The last contact holds a point of rigid body `body` at `lever` from its centre of mass.
    pub fn hold_rigid(&mut self, body: u32, lever: Vec3, sign: f64) {
        let Some(row) = self.rows.last_mut() else { return };
        let free = usize::from(row.rigids[0].is_some());
        row.rigids[free] = Some((body, lever, sign));
    }

    /// `J v` of one contact, in world axes: the velocity of A relative to B \[m/s\].
    #[inline]
    pub fn relative_velocity(&self, row: &ContactRow, v: &[Vec3]) -> Vec3 {
        let mut w = Vec3::zeros();
        for k in row.nodes.start as usize..row.nodes.end as usize {
            w += v[2 * self.rigids + self.nodes[k] as usize] * self.weights[k];
        }
        for (body, lever, sign) in row.rigids.iter().flatten() {
            let b = *body as usize;
            w += row.motion(&v[2 * b], &v[2 * b + 1], lever) * *sign;
        }
        w
    }

    /// `f += Jᵀ λ` for a world impulse at one contact: plus on A, minus on B. (The paper's Eq. 12
    /// prints the opposite sign, with which bodies would attract.)
    #[inline]
    pub fn scatter(&self, row: &ContactRow, impulse_W: &Vec3, f: &mut [Vec3]) {
        for k in row.nodes.start as usize..row.nodes.end as usize {
            f[2 * self.rigids + self.nodes[k] as usize] += impulse_W * self.weights[k];
        }
        for (body, lever, sign) in row.rigids.iter().flatten() {
            let b = *body as usize;
            let [force, moment] = row.wrench(impulse_W, lever);
            f[2 * b] += force * *sign;
            f[2 * b + 1] += moment * *sign;
        }
    }

    /// `u += D⁻¹ Jᵀ λ` for a world impulse at one contact.
    #[inline]
    pub fn scatter_response(
        &self,
        row: &ContactRow,
        impulse_W: &Vec3,
        d: &BlockDiagonal,
        u: &mut [Vec3],
    ) {
        for k in row.nodes.start as usize..row.nodes.end as usize {
            let n = self.nodes[k] as usize;
            u[2 * self.rigids + n] += d.node[n] * (impulse_W * self.weights[k]);
        }
        for (body, lever, sign) in row.rigids.iter().flatten() {
            let b = *body as usize;
            let (lin, ang) = rigid_response(&d.rigid[b], &row.wrench(&(impulse_W * *sign), lever));
            u[2 * b] += lin;
            u[2 * b + 1] += ang;
        }
    }

    /// Fills each contact's own response from `D⁻¹`.
    pub fn refresh_responses(&mut self, d: &BlockDiagonal) {
        for i in 0..self.rows.len() {
            let row = &self.rows[i];
            let mut W = Mat3::zeros();
            for k in row.nodes.start as usize..row.nodes.end as usize {
                W += d.node[self.nodes[k] as usize] * (self.weights[k] * self.weights[k]);
            }
            for (body, lever, _) in row.rigids.iter().flatten() {
                let inverse = &d.rigid[*body as usize];
                for axis in 0..3 {
                    let unit: Vec3 = Mat3::identity().column(axis).into();
                    let (lin, ang) = rigid_response(inverse, &row.wrench(&unit, lever));
                    W.set_column(axis, &(W.column(axis) + row.motion(&lin, &ang, lever)));
                }
            }
            let W = row.frame * W * row.frame.transpose();
            self.rows[i].response = W;
        }
    }
}

impl ContactRow {
    /// Returns the row's velocity for a body that moves with these velocities and is held at
    /// `lever`.
    #[inline]
    pub fn motion(&self, lin: &Vec3, ang: &Vec3, lever: &Vec3) -> Vec3 {
        if self.turns { *ang } else { lin + ang.cross(lever) }
    }

    /// Force and moment that an impulse of the row puts on a body held at `lever`.
    #[inline]
    pub fn wrench(&self, impulse: &Vec3, lever: &Vec3) -> [Vec3; 2] {
        if self.turns { [Vec3::zeros(), *impulse] } else { [*impulse, lever.cross(impulse)] }
    }
}

#[inline]
fn rigid_response(inverse: &Mat6, [force, moment]: &[Vec3; 2]) -> (Vec3, Vec3) {
    let y = inverse * Vec6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z);
    (Vec3::new(y[0], y[1], y[2]), Vec3::new(y[3], y[4], y[5]))
}
