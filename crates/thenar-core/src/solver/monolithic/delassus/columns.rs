//! The compliance at the handles, `E` (see `handles`): `G = Eᵀ K⁻¹ E`.
//!
//! With K eliminated flesh first, `K_ww = L Lᵀ`, half solves are enough:
//!
//! ```text
//!   Y_E = L⁻¹ E_w,   H = L_S⁻¹ (E_u - Yᵀ Y_E),   G = Y_Eᵀ Y_E + Hᵀ H
//! ```
//!
//! where `Y = L⁻¹ C` and `S = L_S L_Sᵀ` are those of `direct`. Columns come in batches of `LANES`.
//! All this is in the factor's precision.

use super::handles::Handle;
use super::nodes_of;
use crate::math::Vec3;
use crate::solver::ContactRows;
use crate::solver::monolithic::aligned::Aligned;
use crate::solver::monolithic::coarse::Coarse;
use crate::solver::monolithic::compliance::Compliance;
use crate::solver::monolithic::direct::Direct;
use crate::solver::monolithic::factor::{LANES, Lanes, Scalar};
use crate::solver::monolithic::half_solves::{HalfSolves, add_common_product, add_product};
use crate::solver::monolithic::{System, small_cholesky};
use fearless_simd::dispatch;
use std::ops::Range;

/// Half solves of the handles, and their products.
#[derive(Clone, Debug)]
pub struct Columns {
    /// Number of them that G holds already.
    built: usize,
    /// Half solves Y_E of the handles.
    half: HalfSolves,
    /// All supernodes.
    flesh: Vec<u32>,
    /// H: per batch, one register per freedom.
    pull: Aligned<Scalar>,
    freedoms: usize,
    /// Per batch: the groups of bodies that it pulls on.
    pulls_on: Vec<bool>,
    groups: usize,
    /// Compliance G.
    pub G: Compliance,
}

impl Columns {
    /// Room for `batches` batches.
    pub fn new(batches: usize, system: &Direct, freedoms: usize) -> Self {
        let symbolic = &system.factor.symbolic;
        let groups = system.flesh_of_group.len();
        Self {
            built: 0,
            half: HalfSolves::new(symbolic, batches),
            flesh: (0..symbolic.supernodes.len() as u32).collect(),
            pull: Aligned::new(batches * freedoms * LANES),
            freedoms,
            pulls_on: vec![false; batches * groups],
            groups,
            G: Compliance::new(batches),
        }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.built = 0;
    }

    /// Fills the parts of G that new handles bring.
    pub fn extend(
        &mut self,
        system: &System<'_>,
        coarse: &Coarse,
        direct: &Direct,
        contacts: &ContactRows,
        handles: &[Handle],
    ) {
        if handles.len() == self.built {
            return;
        }
        // The batch that was not full is done again.
        let rest = handles.chunks(LANES).enumerate().skip(self.built / LANES);
        for (batch, handles) in rest {
            self.load(batch, handles, system, coarse, direct, contacts);
            self.half.half_solve(&direct.factor, batch);
            self.solve_bodies(batch, system, coarse, direct);
            (0..=batch).for_each(|other| self.multiply(other, batch, system, direct));
        }
        self.built = handles.len();
    }

    /// `to = Hᵀ g`, one number per column; g holds the half-solved freedoms `dofs`, all others are
    /// zero.
    pub fn pulled_by(&self, g: &[f64], dofs: &Range<usize>, to: &mut [f64]) {
        for (batch, to) in to[..self.built].chunks_mut(LANES).enumerate() {
            to.fill(0.0);
            for (lanes, g) in self.pull_of(batch)[dofs.clone()].iter().zip(g) {
                to.iter_mut().zip(lanes).for_each(|(to, pull)| *to += f64::from(*pull) * g);
            }
        }
    }

    fn pull_of(&self, batch: usize) -> &[Lanes] {
        &self.pull.as_chunks().0[batch * self.freedoms..(batch + 1) * self.freedoms]
    }

    /// `E_w` and `E_u` of one batch.
    fn load(
        &mut self,
        batch: usize,
        handles: &[Handle],
        system: &System<'_>,
        coarse: &Coarse,
        direct: &Direct,
        contacts: &ContactRows,
    ) {
        self.half.clear(&direct.factor.symbolic, batch);
        let freedoms = batch * self.freedoms..(batch + 1) * self.freedoms;
        let pull = &mut self.pull.as_chunks_mut::<LANES>().0[freedoms];
        pull.fill([0.0; LANES]);
        let pulls_on = &mut self.pulls_on[batch * self.groups..(batch + 1) * self.groups];
        pulls_on.fill(false);
        let half = &mut self.half;
        let mut column = Column { system, coarse, direct, batch, lane: 0, half, pull, pulls_on };
        let unit = |axis: u8| Vec3::ith(axis as usize, 1.0);
        for (lane, handle) in handles.iter().enumerate() {
            column.lane = lane;
            match *handle {
                Handle::Node(node, axis) => column.add_node(node as usize, &unit(axis)),
                Handle::Body(body, axis) if axis < 3 => {
                    column.add_body(body as usize, &[unit(axis), Vec3::zeros()]);
                }
                Handle::Body(body, axis) => {
                    column.add_body(body as usize, &[Vec3::zeros(), unit(axis - 3)]);
                }
                Handle::Row(contact, axis) => {
                    let row = &contacts.rows[contact as usize];
                    let direction: Vec3 = row.frame.row(axis as usize).transpose();
                    for (node, weight) in nodes_of(contacts, row) {
                        column.add_node(node, &(direction * weight));
                    }
                    for (body, lever, sign) in row.rigids.iter().flatten() {
                        column.add_body(*body as usize, &row.wrench(&(direction * *sign), lever));
                    }
                }
            }
        }
    }

    /// H of one batch.
    fn solve_bodies(
        &mut self,
        batch: usize,
        system: &System<'_>,
        coarse: &Coarse,
        direct: &Direct,
    ) {
        for (g, dofs) in system.bodies.groups().iter().enumerate() {
            if !self.pulls_on[batch * self.groups + g] {
                continue;
            }
            let flesh = &direct.flesh_of_group[g];
            let first = batch * self.freedoms;
            let pull = &mut self.pull.as_chunks_mut::<LANES>().0;
            let pull = &mut pull[first + dofs.start..first + dofs.end];
            for (k, pull) in pull.chunks_mut(LANES).enumerate().filter(|_| !flesh.is_empty()) {
                let mut product = [[0.0; LANES]; LANES];
                let (carried, own) = ((&direct.half, k), (&self.half, batch));
                add_common_product(&direct.factor, carried, own, flesh, &mut product);
                let pairs = pull.as_flattened_mut().iter_mut().zip(product.as_flattened());
                pairs.for_each(|(pull, product)| *pull -= product);
            }
            small_cholesky::forward_many(&direct.schur[coarse.block(g)], dofs.len(), pull);
        }
    }

    /// G in the columns of one batch and the rows of another, and by symmetry the other way round.
    fn multiply(&mut self, a: usize, b: usize, system: &System<'_>, direct: &Direct) {
        let mut product = [[0.0; LANES]; LANES];
        let (x, y) = ((&self.half, a), (&self.half, b));
        add_common_product(&direct.factor, x, y, &self.flesh, &mut product);
        let pulls_on = |batch: usize, g: usize| self.pulls_on[batch * self.groups + g];
        for (g, dofs) in system.bodies.groups().iter().enumerate() {
            if pulls_on(a, g) && pulls_on(b, g) {
                let (x, y) = (&self.pull_of(a)[dofs.clone()], &self.pull_of(b)[dofs.clone()]);
                dispatch!(direct.factor.level, simd => add_product(simd, x, y, &mut product));
            }
        }
        self.G.set(a, b, &product);
    }
}

/// One column of E while it is filled.
struct Column<'a> {
    system: &'a System<'a>,
    coarse: &'a Coarse,
    direct: &'a Direct,
    batch: usize,
    lane: usize,
    half: &'a mut HalfSolves,
    pull: &'a mut [Lanes],
    pulls_on: &'a mut [bool],
}

impl Column<'_> {
    /// A force on a node.
    fn add_node(&mut self, node: usize, force: &Vec3) {
        let f = self.system.unknown(2 * self.system.bodies.bodies() + node, force);
        let rhs = self.half.node_mut(&self.direct.factor.symbolic, self.batch, node);
        (0..3).for_each(|r| rhs[r][self.lane] += f[r] as Scalar);
        let Some((group, _)) = self.coarse.cross_of(node) else { return };
        self.pulls_on[group] = true;
        let start = self.system.bodies.groups()[group].start;
        for (dof, motion) in self.coarse.skin_of(node) {
            self.pull[start + dof][self.lane] += motion.dot(&f) as Scalar;
        }
    }

    /// Force and moment on a body.
    fn add_body(&mut self, body: usize, [f, moment]: &[Vec3; 2]) {
        let Some(group) = self.system.bodies.group_of_body(body) else { return };
        self.pulls_on[group] = true;
        for (dof, c) in self.system.bodies.columns(body) {
            let (lin, ang) = (Vec3::new(c[0], c[1], c[2]), Vec3::new(c[3], c[4], c[5]));
            self.pull[dof][self.lane] += (lin.dot(f) + ang.dot(moment)) as Scalar;
        }
    }
}
