//! The monolithic solver: Eq. 9 with its joint rows, to a velocity tolerance, contact in the same
//! system.
//!
//! Joints are in minimal coordinates, `v_s = Z u + z` (`reduction`), flesh is relative to its
//! skinned motion, `v_f = J v_s + w` (`relative`). The system
//!
//! ```text
//!   [ Zᵀ(A_s + Jᵀ B J)Z   (B J Z)ᵀ ] [ u ]
//!   [ B J Z                B + G   ] [ w ]
//! ```
//!
//! is symmetric positive definite, and the stiff coupling springs G act on w alone. Without contact
//! it is solved by conjugate gradients (`pcg`) with the block diagonal (`jacobi`), which keep to
//! the joint limits that bear load (`held`); with contact that does not rest the flesh is factored
//! (`factor`, `direct`), which gives the compliance of the whole system at the contacts that press
//! (`joining`, `delassus`) and preconditions the solve for what their impulses do.
//!
//! Nothing is allocated once built. Joints form trees; those left over because they close loops
//! take directions out of u (`loops`).

mod aligned;
mod coarse;
mod compliance;
mod condense;
mod decay;
mod delassus;
mod dense;
mod direct;
mod factor;
mod free_motion;
mod half_solves;
mod held;
mod jacobi;
mod joining;
mod loops;
mod minimum_degree;
mod ordering;
mod pcg;
mod push_out;
mod reduced;
mod reduction;
mod relative;
mod respond;
mod small_cholesky;
mod substitution;
mod symbolic;
pub(crate) mod vectors;
mod wide_cholesky;

pub use free_motion::LastContact;
pub use held::Bound;
pub use reduced::ReducedCompliance;
pub use reduction::Reduction;
pub use relative::{CarriedNode, Coordinates, System};

use crate::capacity_vec::CapacityVec;
use crate::math::Vec3;
use crate::solver::{BlockMatrix, Islands, JointBlock};
use coarse::Coarse;
use delassus::Delassus;
use direct::Direct;
use factor::Factor;
use held::HeldBounds;
use jacobi::BlockJacobi;
use pcg::StoppingCriteria;
use symbolic::Symbolic;

/// Inputs from which the solver is built.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// True for each body that moves by itself.
    pub moves: &'a [bool],
    /// Parent and child of each joint.
    pub ends: &'a [(Option<u32>, u32)],
    /// Rows of each joint.
    pub rows: &'a [usize],
    /// Carried nodes, with their springs, weights and levers still unset.
    pub carried: &'a [CarriedNode],
    /// True when springs bind every node to bones.
    pub all_is_bound: bool,
    /// Deformable body of each node.
    pub soft_of_node: &'a [u32],
    /// Rest position of each node, world \[m\].
    pub positions: &'a [Vec3],
    /// Pattern of Eq. 9's matrix.
    pub pattern: &'a BlockMatrix,
    /// Most contacts that the world may find.
    pub contacts_max: usize,
    /// Most bounds that limit how joints turn.
    pub bounds_max: usize,
}

/// Most contacts that may press in one step; W takes 36 bytes times their square.
pub const PRESSING_MAX: usize = 512;
/// Preconditioner that the next solves use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Preconditioner {
    Nothing,
    Jacobi,
    Direct,
}

/// The solver's memory.
#[derive(Clone, Debug)]
pub struct Monolithic {
    bodies: Reduction,
    /// Carried nodes; the world fills in springs and levers before each step.
    pub carried: Vec<CarriedNode>,
    springs: Vec<f64>,
    split: Vec<u32>,
    coarse: Coarse,
    jacobi: BlockJacobi,
    direct: Direct,
    ready: Preconditioner,
    /// The contacts of this step kept their impulses, and nothing knows their compliance.
    kept: bool,
    /// The largest part of an error's energy that an iteration with the factor of this step has
    /// left.
    left: Option<f64>,
    /// True when springs bind all flesh to bones, so that few iterations of the block diagonal are
    /// enough.
    all_is_bound: bool,
    /// Number of iterations of the block diagonal that cost what the factor does.
    iterations_worth_a_factor: u32,
    x: Coordinates,
    held: HeldBounds,
    delassus: Delassus,
    /// One column of the response that touch reads.
    pulled: CapacityVec<f64>,
    work: pcg::Workspace,
}

/// Inputs of a step: matrix, right-hand side, known components.
#[derive(Clone, Copy, Debug)]
pub struct StepSystem<'a> {
    /// Eq. 9's matrix without the coupling springs.
    pub A: &'a BlockMatrix,
    /// Right-hand side of Eq. 9, likewise without the coupling springs.
    pub b: &'a [Vec3],
    /// Components given from outside, per block row.
    pub known: &'a [[bool; 3]],
}

/// Accuracy of a solve, and its limits.
#[derive(Clone, Copy, Debug)]
pub struct Accuracy {
    /// Take the best that is found where the accuracy cannot be had, rather than fail.
    pub best_effort: bool,
    /// Largest velocity error \[m/s\].
    pub velocity: f64,
    /// Most iterations.
    pub iterations_max: u32,
    /// Most Gauss-Seidel sweeps over the contacts.
    pub sweeps_max: u32,
}

impl Accuracy {
    fn stop(&self, iterations_min: u32, iterations_max: u32) -> StoppingCriteria {
        let tolerance = self.velocity;
        StoppingCriteria {
            tolerance,
            iterations_min,
            iterations_max,
            scale: 0.0,
            left: None,
            gives_up: false,
        }
    }
}

impl Monolithic {
    /// Plans everything.
    pub fn new(plan: &Plan<'_>) -> Self {
        let softs = plan.soft_of_node.iter().max().map_or(0, |s| *s as usize + 1);
        let mut together: Vec<Vec<u32>> = vec![Vec::new(); softs];
        for c in plan.carried {
            let soft = plan.soft_of_node[c.node as usize] as usize;
            together[soft].extend(&c.bones[..c.bone_count as usize]);
        }
        let bodies = Reduction::new(plan.moves, plan.ends, plan.rows, &together);
        let group_of_soft: Vec<Option<u32>> = together
            .iter()
            .map(|bones| bones.iter().find_map(|&b| bodies.group_of_body(b as usize)))
            .map(|g| g.map(|g| g as u32))
            .collect();
        let group_of_node: Vec<Option<u32>> =
            plan.soft_of_node.iter().map(|&s| group_of_soft[s as usize]).collect();
        let (count, nodes) = (plan.moves.len(), plan.positions.len());
        let pattern = plan.pattern;
        let split = (0..pattern.rows())
            .map(|i| {
                let row = pattern.row(i);
                let before =
                    pattern.columns[row.clone()].partition_point(|&j| (j as usize) < 2 * count);
                (row.start + before) as u32
            })
            .collect();
        let coarse = Coarse::new(&bodies, group_of_node, plan.carried, pattern);
        let factor = Factor::new(Symbolic::new(
            pattern,
            2 * count,
            plan.positions,
            !plan.carried.is_empty(),
        ));
        // Flops of the factor's numbers, of which an iteration does some twenty per block.
        let flops = factor.symbolic.flops() / 2.0;
        let iteration = 25.0 * pattern.blocks.len() as f64;
        let direct = Direct::new(factor, &coarse, bodies.groups());
        Self {
            iterations_worth_a_factor: (flops / iteration).clamp(16.0, 400.0) as u32,
            all_is_bound: plan.all_is_bound,
            jacobi: BlockJacobi::new(&coarse, nodes),
            ready: Preconditioner::Nothing,
            kept: false,
            left: None,
            x: Coordinates::new(bodies.freedoms(), nodes),
            held: HeldBounds::new(plan.bounds_max, bodies.freedoms()),
            work: pcg::Workspace::new(bodies.freedoms(), count, nodes),
            carried: plan.carried.to_vec(),
            springs: vec![0.0; nodes],
            delassus: Delassus::new(
                plan.contacts_max.min(PRESSING_MAX),
                plan.contacts_max,
                count,
                &direct,
                bodies.freedoms(),
            ),
            pulled: CapacityVec::with_capacity(
                3 * plan.contacts_max.min(PRESSING_MAX) + factor::LANES,
            ),
            direct,
            coarse,
            split,
            bodies,
        }
    }

    /// Starts a step that may spend this many multiply-adds on the law of contact; no bound when
    /// `None`.
    pub fn begin_step(&mut self, contact_work_max: Option<u64>) {
        self.delassus.allow(contact_work_max);
    }

    /// True when the step has spent the multiply-adds that [`Monolithic::begin_step`] allowed it.
    pub fn was_cut_short(&self) -> bool {
        self.delassus.is_spent()
    }

    /// Sets to zero the blocks of A between two bodies and between two nodes.
    pub fn clear(&self, A: &mut BlockMatrix) {
        debug_assert_eq!(A.rows(), self.split.len(), "block rows of A, rows planned for");
        let row0 = 2 * self.bodies.bodies();
        for (i, &split) in self.split.iter().enumerate() {
            let row = A.row(i);
            let here = if i < row0 { row.start..split as usize } else { split as usize..row.end };
            bytemuck::fill_zeroes(&mut A.blocks[here]);
        }
    }

    /// The bounds of this step's joints, empty, for the world to fill.
    pub fn bounds_mut(&mut self) -> &mut Vec<Bound> {
        self.held.bounds.clear();
        &mut self.held.bounds
    }

    /// These; after a solve their impulses are those in the velocities found.
    pub fn bounds(&self) -> &[Bound] {
        &self.held.bounds
    }

    /// The motion over 1 s after which all joints are closed, by the freedoms that the tree of
    /// joints leaves; `still` has the velocities, zero, of bodies that do not move by themselves.
    /// `None` where a joint's rows are dependent.
    pub fn closing_motion(
        &mut self,
        A: &BlockMatrix,
        joints: &[JointBlock],
        still: &[Vec3],
    ) -> Option<&Reduction> {
        debug_assert_eq!(still.len(), 2 * self.bodies.bodies(), "velocities, rows of bodies");
        debug_assert_eq!(A.rows(), self.split.len(), "block rows of A, rows planned for");
        let closed = self.bodies.refresh(A, joints, still, 1.0);
        closed.then_some(&self.bodies)
    }

    /// Shortens the velocities of each island so that they take no more energy than forces and
    /// motion put in. With `v = T x + v̄` the solution without contact minimises `½ xᵀ K x - xᵀ g`;
    /// of all velocities `s x`, `0 ≤ s ≤ 1`, that with the least is taken. Then `xᵀ K x ≤ xᵀ g`,
    /// which is the balance of energy of a backward Euler step: contacts and errors can take energy
    /// out, not bring it in.
    pub fn limit_energy(&mut self, step: &StepSystem<'_>, islands: &mut Islands, v: &mut [Vec3]) {
        debug_assert_eq!(v.len(), step.A.rows(), "velocities, block rows");
        let Self { bodies, carried, springs, split, coarse, jacobi, x, work, .. } = self;
        let system = system(step, bodies, carried, springs, split);
        system.coordinates(v, x, &mut work.v);
        let pcg::Workspace { r, q, v: moved, f, .. } = work;
        system.residual(step.b, x, r, moved, f);
        // Bodies that nothing touches are solved by themselves, whatever others came to.
        for (group, freedoms) in bodies.groups().iter().enumerate() {
            if islands.are_free(2 * bodies.first_of_group(group)) {
                jacobi.correct(
                    coarse,
                    group,
                    &mut r.u[freedoms.clone()],
                    &mut x.u[freedoms.clone()],
                );
            }
        }
        system.residual(step.b, x, r, moved, f);
        system.product(x, q, moved, f);
        let row0 = 2 * bodies.bodies();
        for (group, freedoms) in bodies.groups().iter().enumerate() {
            let row = 2 * bodies.first_of_group(group);
            for k in freedoms.clone() {
                islands.add(row, x.u[k] * q.u[k], x.u[k] * r.u[k]);
            }
        }
        for (node, w) in x.w.iter().enumerate() {
            islands.add(row0 + node, w.dot(&q.w[node]), w.dot(&r.w[node]));
        }
        islands.weigh();
        for (group, freedoms) in bodies.groups().iter().enumerate() {
            let s = islands.share(2 * bodies.first_of_group(group));
            x.u[freedoms.clone()].iter_mut().for_each(|u| *u *= s);
        }
        for (node, w) in x.w.iter_mut().enumerate() {
            *w *= islands.share(row0 + node);
        }
        system.velocities(x, v);
    }
}

fn system<'a>(
    step: &StepSystem<'a>,
    bodies: &'a Reduction,
    carried: &'a [CarriedNode],
    springs: &'a [f64],
    split: &'a [u32],
) -> System<'a> {
    debug_assert_eq!(step.A.rows(), split.len(), "block rows of A, rows planned for");
    debug_assert_eq!(step.b.len(), split.len(), "right-hand sides, rows planned for");
    debug_assert_eq!(step.known.len(), split.len(), "rows known or not, rows planned for");
    System { A: step.A, split, bodies, carried, known: step.known, springs }
}
