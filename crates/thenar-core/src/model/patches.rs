//! Patches of tetrahedra: those around one long edge of a body-centred lattice deform as one.

use crate::math::Vec3;
use crate::model::{Material, Relaxation};
use std::collections::VecDeque;

/// The patch of each tetrahedron of one deformable body (`WorldDesc::patches`). The tetrahedra of a
/// patch share one evaluation of their law, at their mean deformation gradient.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ElementPatches {
    /// Index into `WorldDesc::softs`.
    pub soft: u32,
    /// One number per tetrahedron; the numbers run from 0 without gaps.
    pub of_tet: Vec<u32>,
}

/// Tetrahedra that a patch has at most. Four fill the octahedron of a body-centred lattice, eight
/// that of a lattice whose ring of four edges is halved.
pub const PATCH_TETS_MAX: usize = 8;
/// Edges shorter than the longest by less than this part are long too: half of what the short edges
/// of a body-centred lattice, √3/2 of the long ones, are shorter.
const SAME_LENGTH: f64 = 0.067;
/// Tetrahedra of an octahedron of the body-centred lattice.
const OCTAHEDRON: usize = 4;
pub(super) const NONE: u32 = u32::MAX;
/// The edges of a tetrahedron, by its corners.
const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The patch of each tetrahedron: those around one edge that is the longest, or as long as it, of
/// each. In a body-centred lattice the four tetrahedra around an edge between two centres form an
/// octahedron (of the two families of long edges, the one that the first tetrahedron chooses). A
/// tetrahedron that is left alone joins the neighbouring patch with which it shares most faces. A
/// patch has one law and one relaxation (`relaxation` has one per tetrahedron, or none at all).
///
/// Deterministic: depends on the order of the tetrahedra and on their shapes alone.
///
/// # Panics
/// When a tetrahedron has a node that does not exist.
pub fn patches(
    nodes: &[Vec3],
    tets: &[[u32; 4]],
    materials: &[Material],
    relaxation: &[Relaxation],
) -> Vec<u32> {
    let mut grouping = Grouping::new(nodes, tets, materials, relaxation);
    let all = 0..tets.len() as u32;
    let inside = all.clone().filter(|&t| grouping.is_inside(t)).collect::<Vec<_>>();
    inside.into_iter().chain(all).for_each(|first| grouping.spread_from(first));
    grouping.join_single();
    grouping.numbered()
}

/// The part of a node in the patches around it.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Role {
    Unknown,
    /// An end of their axes.
    Axis,
    /// A corner of the rings around them.
    Ring,
}

struct Grouping<'a> {
    tets: &'a [[u32; 4]],
    materials: &'a [Material],
    relaxation: &'a [Relaxation],
    /// Long edges (lower node first) with each tetrahedron that has one, sorted.
    long: Vec<([u32; 2], u32)>,
    /// Long edges of each tetrahedron.
    axes: Vec<Vec<[u32; 2]>>,
    /// The tetrahedron behind each face, `NONE` at the boundary.
    behind: Vec<[u32; 4]>,
    roles: Vec<Role>,
    patch: Vec<u32>,
    sizes: Vec<usize>,
}

impl<'a> Grouping<'a> {
    fn new(
        nodes: &[Vec3],
        tets: &'a [[u32; 4]],
        materials: &'a [Material],
        relaxation: &'a [Relaxation],
    ) -> Self {
        let axes: Vec<Vec<[u32; 2]>> = tets.iter().map(|tet| long_edges(nodes, tet)).collect();
        let mut long: Vec<([u32; 2], u32)> = (axes.iter().zip(0..))
            .flat_map(|(axes, t)| axes.iter().map(move |&axis| (axis, t)))
            .collect();
        long.sort_unstable();
        Self {
            tets,
            materials,
            relaxation,
            long,
            axes,
            behind: behind_faces(tets),
            roles: vec![Role::Unknown; nodes.len()],
            patch: vec![NONE; tets.len()],
            sizes: Vec::new(),
        }
    }

    /// True when around one of the tetrahedron's long edges there are as many tetrahedra as around
    /// that of a lattice.
    fn is_inside(&self, t: u32) -> bool {
        self.axes[t as usize].iter().any(|&axis| self.free_around(axis).count() >= 4)
    }

    /// Groups all that hangs together with one tetrahedron, neighbours first, so that the roles of
    /// nodes spread from patch to patch.
    fn spread_from(&mut self, first: u32) {
        let mut queue = VecDeque::from([first]);
        while let Some(t) = queue.pop_front() {
            if self.patch[t as usize] != NONE {
                continue;
            }
            let axis = self.axis_of(t);
            let members = self.members(t, axis);
            let number = self.sizes.len() as u32;
            self.sizes.push(members.len());
            members.iter().for_each(|&m| self.patch[m as usize] = number);
            // Fewer at the body's surface say little of the lattice.
            for &m in members.iter().filter(|_| members.len() >= 3) {
                for node in self.tets[m as usize] {
                    let role = &mut self.roles[node as usize];
                    if *role == Role::Unknown {
                        *role = if axis.contains(&node) { Role::Axis } else { Role::Ring };
                    }
                }
            }
            let beside = members.iter().flat_map(|&m| self.behind[m as usize]);
            queue.extend(beside.filter(|&n| n != NONE && self.patch[n as usize] == NONE));
        }
    }

    /// The long edge that fits the roles known so far best, then that with most free tetrahedra
    /// around.
    fn axis_of(&self, t: u32) -> [u32; 2] {
        let fit = |axis: &[u32; 2]| -> i32 {
            axis.iter()
                .map(|&node| match self.roles[node as usize] {
                    Role::Unknown => 0,
                    Role::Axis => 1,
                    Role::Ring => -1,
                })
                .sum()
        };
        let axes = self.axes[t as usize].iter().copied();
        let key = |axis: &[u32; 2]| (fit(axis), self.free_around(*axis).count());
        // Of equals the first, in the order of the tetrahedron's corners.
        axes.rev().max_by_key(key).unwrap_or([NONE; 2])
    }

    /// The free tetrahedra of one law and relaxation around an axis, or, of more than make an
    /// octahedron, a half that hangs together by faces.
    fn members(&self, t: u32, axis: [u32; 2]) -> Vec<u32> {
        let around: Vec<u32> = self.free_around(axis).filter(|&m| self.are_alike(m, t)).collect();
        if (1..=OCTAHEDRON).contains(&around.len()) {
            return around;
        }
        let (mut members, mut next) = (vec![t], 0);
        while next < members.len() {
            for beside in self.behind[members[next] as usize] {
                let is_new = around.contains(&beside) && !members.contains(&beside);
                let has_room = members.len() < PATCH_TETS_MAX && 2 * members.len() < around.len();
                if is_new && has_room {
                    members.push(beside);
                }
            }
            next += 1;
        }
        members
    }

    fn free_around(&self, axis: [u32; 2]) -> impl Iterator<Item = u32> + '_ {
        let from = self.long.partition_point(|(edge, _)| *edge < axis);
        let around = self.long[from..].iter().take_while(move |(edge, _)| *edge == axis);
        around.map(|(_, t)| *t).filter(|&t| self.patch[t as usize] == NONE)
    }

    fn are_alike(&self, s: u32, t: u32) -> bool {
        let (s, t) = (s as usize, t as usize);
        self.materials[s].law == self.materials[t].law
            && self.relaxation.get(s) == self.relaxation.get(t)
    }

    fn join_single(&mut self) {
        for t in 0..self.tets.len() {
            if self.sizes[self.patch[t] as usize] != 1 {
                continue;
            }
            let beside: Vec<u32> = (self.behind[t].iter())
                .filter(|&&n| n != NONE && self.are_alike(n, t as u32))
                .map(|&n| self.patch[n as usize])
                .filter(|&p| p != self.patch[t] && self.sizes[p as usize] < PATCH_TETS_MAX)
                .collect();
            let faces = |p: u32| beside.iter().filter(|&&q| q == p).count();
            let best = beside
                .iter()
                .copied()
                .min_by_key(|&p| (std::cmp::Reverse(faces(p)), self.sizes[p as usize], p));
            if let Some(best) = best {
                self.sizes[self.patch[t] as usize] = 0;
                self.sizes[best as usize] += 1;
                self.patch[t] = best;
            }
        }
    }

    /// Patch numbers in the order of their first tetrahedra.
    fn numbered(self) -> Vec<u32> {
        let mut number = vec![NONE; self.sizes.len()];
        let mut count = 0;
        (self.patch.iter())
            .map(|&p| {
                let number = &mut number[p as usize];
                if *number == NONE {
                    *number = count;
                    count += 1;
                }
                *number
            })
            .collect()
    }
}

fn long_edges(nodes: &[Vec3], tet: &[u32; 4]) -> Vec<[u32; 2]> {
    let ends = EDGES.map(|[a, b]| [tet[a].min(tet[b]), tet[a].max(tet[b])]);
    let lengths = ends.map(|[a, b]| (nodes[a as usize] - nodes[b as usize]).norm());
    let longest = lengths.iter().copied().fold(0.0, f64::max);
    let is_long = |k: &usize| lengths[*k] >= (1.0 - SAME_LENGTH) * longest;
    (0..6).filter(is_long).map(|k| ends[k]).collect()
}

pub(super) fn behind_faces(tets: &[[u32; 4]]) -> Vec<[u32; 4]> {
    let mut faces: Vec<([u32; 3], u32, usize)> = Vec::with_capacity(4 * tets.len());
    for (t, tet) in tets.iter().enumerate() {
        for k in 0..4 {
            let mut face = [tet[(k + 1) % 4], tet[(k + 2) % 4], tet[(k + 3) % 4]];
            face.sort_unstable();
            faces.push((face, t as u32, k));
        }
    }
    faces.sort_unstable();
    let mut behind = vec![[NONE; 4]; tets.len()];
    for pair in faces.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        let ((_, s, k), (_, t, l)) = (pair[0], pair[1]);
        behind[s as usize][k] = t;
        behind[t as usize][l] = s;
    }
    behind
}
