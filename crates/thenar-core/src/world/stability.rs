//! Settings at which a step is known not to be stable.

use crate::coupling::{BoundNode, add_part};
use crate::math::{Mat3, Mat6, skew};
use crate::model::{FleshInStep1, JointDesc, SolverKind};
use crate::world::World;

/// Joint corrections larger than this times what is needed grow from step to step: an error e
/// becomes `(1 - γ) e`.
const OVER_CORRECTION_MAX: f64 = 2.0;
/// Bound like [`OVER_CORRECTION_MAX`], when joints are closed once more at the end of a step: the
/// soft finger of `tests/all/skeleton/coupled_finger.rs` was stable up to 117 and diverged from 207
/// on.
const OVER_CORRECTION_CLOSED_MAX: f64 = 50.0;

impl World {
    /// By how much step 1 with frozen flesh (Eq. 10) over-corrects the joints of rigid body `i`, at
    /// the present time step. The bone is moved as if it felt all of its coupling springs,
    /// `s = Δt² k + Δt c`, while in step 2 it feels them in series with the flesh's mass m. In one
    /// direction that is
    ///
    /// ```text
    ///   γ = (m_s + Σ s) / (m_s + Σ s m / (m + s))
    /// ```
    ///
    /// over the nodes bound to the bone; of the six motions of the bone the largest γ is given.
    /// 1 where nothing is bound or the body's velocity is prescribed.
    ///
    /// # Panics
    /// When there is no rigid body `i`.
    pub fn joint_over_correction(&self, i: u32) -> f64 {
        let (model, h) = (&self.model, self.time_step);
        let body = &model.rigids[i as usize];
        if !body.moves {
            return 1.0;
        }
        let mut frozen = Mat6::zeros();
        add_part(&mut frozen, 0, 0, &Mat3::from_diagonal_element(body.mass));
        add_part(&mut frozen, 1, 1, &body.inertia);
        let mut yielding = frozen;
        for (k, bound) in model.coupling.bound.iter().enumerate() {
            let node = bound.node as usize;
            let s = h * h * model.coupling.stiffness[k] + h * model.coupling.damping[k];
            let m = model.flesh.mass[node] * (1.0 + h * model.flesh.mass_damping[node]);
            let series = if model.is_held[node] { s } else { s * m / (m + s) };
            for j in (0..bound.bone_count()).filter(|&j| bound.bones[j] == i) {
                let moved = own_block(bound, j);
                frozen += moved * s;
                yielding += moved * series;
            }
        }
        // The largest γ with `frozen x = γ yielding x`.
        let Some(inverse) = yielding.cholesky().and_then(|c| c.l().try_inverse()) else {
            return f64::INFINITY;
        };
        (inverse * frozen * inverse.transpose()).symmetric_eigenvalues().max()
    }

    /// Returns what in the present settings is known to diverge or not to be followed, one sentence
    /// each; empty when nothing is. Allocates: for use outside the stepped loop.
    pub fn stability_warnings(&self) -> Vec<String> {
        let settings = &self.desc.solver;
        if settings.kind != SolverKind::TwoStep || settings.step1_flesh != FleshInStep1::Frozen {
            return Vec::new();
        }
        let limit = match settings.close_joints {
            true => OVER_CORRECTION_CLOSED_MAX,
            false => OVER_CORRECTION_MAX,
        };
        let jointed = |b: u32| {
            let of_bone = |j: &JointDesc| j.child == b || j.parent == Some(b);
            self.model.joints.iter().any(|j| j.kind.rows() > 0 && of_bone(j))
        };
        let unstable: Vec<(u32, f64)> = (0..self.model.rigids.len() as u32)
            .filter(|&b| jointed(b))
            .map(|b| (b, self.joint_over_correction(b)))
            .filter(|&(_, factor)| factor > limit)
            .collect();
        let Some((worst, factor)) = unstable.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            return Vec::new();
        };
        vec![format!(
            "frozen flesh in step 1 over-corrects the joints of {} bodies, {} most, by a factor of \
             {factor:.1}; above {limit} the motion may diverge: choose lumped flesh, a softer \
             coupling, or a time step below {:.2e} s",
            unstable.len(),
            self.desc.rigids[*worst as usize].name,
            self.time_step,
        )]
    }
}

/// `(∂f/∂q_j)ᵀ ∂f/∂q_j` of a node's target, in the frame of its bone j; where rotations are
/// blended, at rest.
fn own_block(bound: &BoundNode, j: usize) -> Mat6 {
    let weight = bound.weights[j];
    let turn = skew(&(bound.offsets[j] * weight));
    let mut block = Mat6::zeros();
    add_part(&mut block, 0, 0, &Mat3::from_diagonal_element(weight * weight));
    add_part(&mut block, 0, 1, &(turn * -weight));
    add_part(&mut block, 1, 0, &(turn * weight));
    add_part(&mut block, 1, 1, &turn.tr_mul(&turn));
    block
}
