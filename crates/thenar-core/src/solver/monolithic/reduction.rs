//! Joints in minimal coordinates: `v_s = Z u + z`, with one column of Z per freedom.
//!
//! A link's joint gives, with a the outward body, b the inward one, and σ = 1 (-1 when the joint
//! is declared the other way round),
//!
//! ```text
//!   D ω_a = D ω_b + c_r              ω_a = ω_b + N q̇ + ω_c,   D N = 0,  D ω_c = c_r
//!   σ (v_a - v_b) + F_a ω_a + F_b ω_b = c_p
//! ```
//!
//! with c = -C/Δt, so that position errors of the start are removed within the step exactly as the
//! joint rows of Eq. 9 ask. Joint rows then hold to round-off whatever the accuracy of u; positions
//! follow in the same coordinates (`world::kinematic_advance`). Joints that close loops are left
//! out of this and dealt with in `loops`.

use crate::math::{Mat3, Vec3, Vec6, tangents};
use crate::solver::monolithic::loops::{Columns, CutJoint, Loops};
use crate::solver::tree::{Link, Spanning, spanning};
use crate::solver::{BlockMatrix, JointBlock};
use fearless_simd::{Simd, f64x8, prelude::*};
use std::ops::Range;

/// Below this a joint's axis rows are dependent (a universal joint in gimbal lock).
const DEGENERATE: f64 = 1e-9;

/// A jointed body, its freedoms, and what the joint fixes.
#[derive(Clone, Debug)]
struct Member {
    link: Link,
    /// The body on the inner side of the joint, moving or not.
    base: Option<usize>,
    /// Own freedoms among u.
    own: Range<usize>,
    /// Directions of the own rotations.
    axes: [Vec3; 3],
    /// Angular velocity ω_c with which the joint removes its error \[rad/s\].
    turn: Vec3,
}

/// The freedoms of all rigid bodies.
#[derive(Clone, Debug)]
pub struct Reduction {
    /// Roots first.
    members: Vec<Member>,
    /// Z of the tree.
    tree: Columns,
    /// Z with the loops closed, when there are any.
    loops: Option<Loops>,
    /// Columns of Z, the loops closed when there are any, each with two zeros after it.
    lanes: Vec<[f64; 8]>,
    /// z of each body.
    offsets: Vec<Vec6>,
    /// Freedoms that are solved together: bodies that share a tree or flesh.
    groups: Vec<Range<usize>>,
    /// Group of each body that moves.
    group_of_body: Vec<Option<u32>>,
    /// First body of each group.
    first_of_group: Vec<u32>,
}

impl Reduction {
    /// Plans the freedoms. `moves[b]` tells whether body b has unknowns; `ends` holds parent and
    /// child of each joint, `rows` its rows; each list of `together` names bodies that share flesh.
    pub fn new(
        moves: &[bool],
        ends: &[(Option<u32>, u32)],
        rows: &[usize],
        together: &[Vec<u32>],
    ) -> Self {
        // Joints without rows tie nothing.
        let real: Vec<usize> = (0..ends.len()).filter(|&j| rows[j] > 0).collect();
        let real_ends: Vec<_> = real.iter().map(|&j| ends[j]).collect();
        let Spanning { mut links, cuts } = spanning(moves, &real_ends);
        links.iter_mut().for_each(|link| link.joint = link.joint.map(|j| real[j]));
        let cuts: Vec<CutJoint> =
            cuts.iter().map(|&j| CutJoint { joint: real[j], ends: real_ends[j] }).collect();

        // Bodies of one tree, or of trees that share flesh, make a group.
        let mut leader: Vec<usize> = (0..moves.len()).collect();
        let find = |leader: &[usize], mut b: usize| {
            while leader[b] != b {
                b = leader[b];
            }
            b
        };
        let tied = links.iter().filter_map(|l| l.parent.map(|p| (l.bone, p)));
        let shared = together.iter().flat_map(|bodies| {
            let moving = bodies.iter().map(|&b| b as usize).filter(|&b| moves[b]);
            let first = moving.clone().next();
            moving.filter_map(move |b| first.map(|f| (b, f)))
        });
        let cut = cuts.iter().filter_map(|cut| {
            let (a, b) = (cut.ends.0? as usize, cut.ends.1 as usize);
            (moves[a] && moves[b]).then_some((a, b))
        });
        for (a, b) in tied.chain(shared).chain(cut) {
            let (a, b) = (find(&leader, a), find(&leader, b));
            leader[a.max(b)] = a.min(b);
        }

        // Freedoms are numbered group by group, roots first in each.
        let mut reduction = Self {
            members: Vec::new(),
            tree: Columns::default(),
            loops: None,
            lanes: Vec::new(),
            offsets: vec![Vec6::zeros(); moves.len()],
            groups: Vec::new(),
            group_of_body: vec![None; moves.len()],
            first_of_group: Vec::new(),
        };
        let mut paths: Vec<Vec<u32>> = vec![Vec::new(); moves.len()];
        let mut next = 0;
        for head in (0..moves.len()).filter(|&b| moves[b] && leader[b] == b) {
            let start = next;
            for link in links.iter().filter(|l| find(&leader, l.bone) == head) {
                let free = link.joint.map_or(6, |j| 6 - rows[j]);
                let mut path = link.parent.map_or(Vec::new(), |p| paths[p].clone());
                path.extend((next..next + free).map(|d| d as u32));
                paths[link.bone] = path;
                reduction.group_of_body[link.bone] = Some(reduction.groups.len() as u32);
                reduction.members.push(Member {
                    link: *link,
                    base: link.joint.and_then(|j| {
                        if link.reversed {
                            Some(ends[j].1 as usize)
                        } else {
                            ends[j].0.map(|p| p as usize)
                        }
                    }),
                    own: next..next + free,
                    axes: [Vec3::zeros(); 3],
                    turn: Vec3::zeros(),
                });
                next += free;
            }
            reduction.groups.push(start..next);
        }
        let of_group =
            |g: usize| reduction.group_of_body.iter().position(|group| *group == Some(g as u32));
        let first = (0..reduction.groups.len()).map(|g| of_group(g).unwrap_or(0) as u32);
        reduction.first_of_group = first.collect();
        reduction.tree = Columns::new(&paths);
        if !cuts.is_empty() {
            reduction.loops = Some(reduction.plan_loops(&cuts));
        }
        reduction.lanes = vec![[0.0; 8]; reduction.shown().dofs.len()];
        reduction
    }

    fn plan_loops(&self, cuts: &[CutJoint]) -> Loops {
        let group_of = |cut: &CutJoint| {
            let ends = [cut.ends.0, Some(cut.ends.1)];
            ends.into_iter().flatten().find_map(|b| self.group_of_body[b as usize])
        };
        let groups = self.groups.iter().enumerate().map(|(g, dofs)| {
            let here = Some(g as u32);
            let bodies = (0..self.bodies()).filter(|&b| self.group_of_body[b] == here);
            let cuts = cuts.iter().filter(|cut| group_of(cut) == here);
            (dofs.clone(), bodies.collect(), cuts.copied().collect())
        });
        Loops::new(&self.tree, groups.collect())
    }

    /// Z as seen from outside.
    #[inline]
    fn shown(&self) -> &Columns {
        self.loops.as_ref().map_or(&self.tree, |loops| &loops.columns)
    }

    /// Number of bodies, moving or not.
    pub fn bodies(&self) -> usize {
        self.offsets.len()
    }

    /// Number of freedoms.
    pub fn freedoms(&self) -> usize {
        self.groups.last().map_or(0, |g| g.end)
    }

    /// Freedoms of each group.
    pub fn groups(&self) -> &[Range<usize>] {
        &self.groups
    }

    /// Group of a body; `None` when it does not move by itself.
    pub fn group_of_body(&self, body: usize) -> Option<usize> {
        self.group_of_body[body].map(|g| g as usize)
    }

    /// The first body of a group.
    pub fn first_of_group(&self, group: usize) -> usize {
        self.first_of_group[group] as usize
    }

    /// Freedoms that move a body, with the body's motion per unit of each.
    #[inline]
    pub fn columns(&self, body: usize) -> impl Iterator<Item = (usize, &Vec6)> {
        self.shown().of(body)
    }

    /// Returns the velocity that z gives a body, linear and angular.
    pub fn offset(&self, body: usize) -> [Vec3; 2] {
        unstack(&self.offsets[body])
    }

    /// Freedoms that move a body.
    pub fn path(&self, body: usize) -> &[u32] {
        let shown = self.shown();
        &shown.dofs[shown.range(body)]
    }

    /// Adds to `y = Zᵀ A Z u` what makes it definite along what loops hold.
    pub fn add_held(&self, u: &[f64], y: &mut [f64]) {
        if let Some(loops) = &self.loops {
            loops.add_held(u, y);
        }
    }

    /// Adds the same to a group's block of `Zᵀ A Z`.
    pub fn stiffen(&self, group: usize, block: &mut [f64]) {
        if let Some(loops) = &self.loops {
            loops.stiffen(&self.groups[group], block);
        }
    }

    /// Fills Z and z for the joints as they are; A is Eq. 9's matrix. `v` gives the velocities of
    /// the bodies that do not move by themselves. False when a joint's rows are dependent.
    pub fn refresh(&mut self, A: &BlockMatrix, joints: &[JointBlock], v: &[Vec3], h: f64) -> bool {
        for (b, offset) in self.offsets.iter_mut().enumerate() {
            let known = self.group_of_body[b].is_none();
            *offset = if known { stack(&v[2 * b], &v[2 * b + 1]) } else { Vec6::zeros() };
        }
        for member in &mut self.members {
            let a = member.link.bone;
            let at = self.tree.range(a);
            let Some(j) = member.link.joint else {
                for (k, column) in self.tree.values[at].iter_mut().enumerate() {
                    *column = Vec6::ith(k, 1.0);
                }
                continue;
            };
            let block = &joints[j];
            let (J_a, J_b, sign) = if member.link.reversed {
                (&block.J_parent, &block.J_child, -1.0)
            } else {
                (&block.J_child, &block.J_parent, 1.0)
            };
            let c = block.C / -h;
            let Some((axes, turn)) = rotations(block.rows, J_a, &c) else { return false };
            (member.axes, member.turn) = (axes, turn);

            let F_a: Mat3 = J_a.fixed_view::<3, 3>(0, 3).into();
            let F_b: Mat3 = J_b.fixed_view::<3, 3>(0, 3).into();
            let base = member.base.map_or(Vec6::zeros(), |b| self.offsets[b]);
            let [lin_b, ang_b] = unstack(&base);
            let ang = ang_b + turn;
            let gap = Vec3::new(c[0], c[1], c[2]);
            let lin = lin_b + (gap - F_a * ang - F_b * ang_b) * sign;
            self.offsets[a] = stack(&lin, &ang);

            // Columns of the base, carried over; then the own ones.
            let inherited = at.len() - member.own.len();
            for k in 0..inherited {
                let from = self.tree.first[member.link.parent.unwrap_or(a)] + k;
                let [lin_b, ang] = unstack(&self.tree.values[from]);
                self.tree.values[at.start + k] =
                    stack(&(lin_b - (F_a * ang + F_b * ang) * sign), &ang);
            }
            for (k, axis) in axes[..member.own.len()].iter().enumerate() {
                self.tree.values[at.start + inherited + k] = stack(&(F_a * axis * -sign), axis);
            }
        }
        if let Some(loops) = &mut self.loops {
            loops.refresh(&self.tree, A, joints, h, &mut self.offsets);
        }
        let shown = self.loops.as_ref().map_or(&self.tree, |loops| &loops.columns);
        for (lanes, column) in self.lanes.iter_mut().zip(&shown.values) {
            lanes[..6].copy_from_slice(column.as_slice());
        }
        true
    }

    /// `v_s = Z u`; zero for bodies that do not move by themselves.
    #[inline(always)]
    pub fn spread<S: Simd>(&self, simd: S, u: &[f64], v: &mut [Vec3]) {
        let shown = self.shown();
        for b in 0..self.offsets.len() {
            let mut motion = simd.splat_f64x8(0.0);
            for k in shown.range(b) {
                let column = f64x8::load_array_ref(simd, &self.lanes[k]);
                motion = column.mul_add(u[shown.dofs[k] as usize], motion);
            }
            let m = motion.to_array();
            v[2 * b] = Vec3::new(m[0], m[1], m[2]);
            v[2 * b + 1] = Vec3::new(m[3], m[4], m[5]);
        }
    }

    /// Adds z.
    pub fn add_offsets(&self, v: &mut [Vec3]) {
        for (b, offset) in self.offsets.iter().enumerate() {
            let [lin, ang] = unstack(offset);
            v[2 * b] += lin;
            v[2 * b + 1] += ang;
        }
    }

    /// `r = Zᵀ f`.
    #[inline(always)]
    pub fn gather<S: Simd>(&self, simd: S, f: &[Vec3], r: &mut [f64]) {
        let shown = self.shown();
        r.fill(0.0);
        for b in 0..self.offsets.len() {
            let (l, a) = (&f[2 * b], &f[2 * b + 1]);
            let wrench = f64x8::load_array(simd, [l.x, l.y, l.z, a.x, a.y, a.z, 0.0, 0.0]);
            for k in shown.range(b) {
                let product = f64x8::load_array_ref(simd, &self.lanes[k]) * wrench;
                r[shown.dofs[k] as usize] += simd.reduce_sum_f64x8(product);
            }
        }
    }

    /// A body's columns of Z as [`Reduction::columns`] gives them, each with two zeros after it.
    pub fn lanes(&self, body: usize) -> &[[f64; 8]] {
        &self.lanes[self.shown().range(body)]
    }

    /// The coordinates nearest to given bone velocities.
    pub fn rates(&self, v: &[Vec3], u: &mut [f64]) {
        for member in &self.members {
            let a = member.link.bone;
            let u = &mut u[member.own.clone()];
            if member.link.joint.is_none() {
                u[..3].copy_from_slice(v[2 * a].as_slice());
                u[3..].copy_from_slice(v[2 * a + 1].as_slice());
                continue;
            }
            let base = member.base.map_or(Vec3::zeros(), |b| v[2 * b + 1]);
            let relative = v[2 * a + 1] - base - member.turn;
            for (u, axis) in u.iter_mut().zip(&member.axes) {
                *u = axis.dot(&relative);
            }
        }
        if let Some(loops) = &self.loops {
            loops.close(u);
        }
    }
}

/// The free axes of a joint (orthonormal) and the turn its axis rows ask for.
fn rotations(rows: usize, J_a: &crate::math::Mat6, c: &Vec6) -> Option<([Vec3; 3], Vec3)> {
    let d = |r: usize| Vec3::new(J_a[(r, 3)], J_a[(r, 4)], J_a[(r, 5)]);
    let none = Vec3::zeros();
    match rows {
        3 => Some(([Vec3::x(), Vec3::y(), Vec3::z()], none)),
        4 => {
            let (d, size2) = (d(3), d(3).norm_squared());
            if size2 < DEGENERATE {
                return None;
            }
            let (t1, t2) = tangents(&d.normalize());
            Some(([t1, t2, none], d * (c[3] / size2)))
        }
        5 => {
            let (d1, d2) = (d(3), d(4));
            let n = d1.cross(&d2);
            let size2 = n.norm_squared();
            if size2 < DEGENERATE {
                return None;
            }
            let turn = (d2.cross(&n) * c[3] + n.cross(&d1) * c[4]) / size2;
            Some(([n.normalize(), none, none], turn))
        }
        _ => {
            let D: Mat3 = J_a.fixed_view::<3, 3>(3, 3).into();
            Some(([none; 3], D.try_inverse()? * Vec3::new(c[3], c[4], c[5])))
        }
    }
}

/// Linear above angular.
pub fn stack(lin: &Vec3, ang: &Vec3) -> Vec6 {
    Vec6::new(lin.x, lin.y, lin.z, ang.x, ang.y, ang.z)
}

/// Linear and angular.
pub fn unstack(v: &Vec6) -> [Vec3; 2] {
    [Vec3::new(v[0], v[1], v[2]), Vec3::new(v[3], v[4], v[5])]
}
