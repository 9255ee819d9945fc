//! Handles, the columns that the rows of contacts are made of.
//!
//! Contacts on one coarse tetrahedron pull on the same four nodes, so their rows are combinations
//! of few columns, `J_c = B Eᵀ`, and with them `W = B (Eᵀ K⁻¹ E) Bᵀ`. A column of E is a *handle*:
//! an axis of a node or of a body's motion. Where contacts lie so far apart that these would be
//! more than the contacts' own axes, each axis is a handle itself. A turn has one axis only.

use super::nodes_of;
use crate::capacity_vec::CapacityVec;
use crate::solver::monolithic::factor::Scalar;
use crate::solver::{ContactRow, ContactRows};

/// Most terms of one contact: 16 nodes of three axes, and two bodies of six.
const TERMS_MAX: usize = 60;
/// No column.
const NONE: u32 = u32::MAX;
/// A column still to be numbered.
const PENDING: u32 = u32::MAX - 1;

/// One column of E.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// A node along a world axis.
    Node(u32, u8),
    /// A body along a world axis (0 to 2) or about it (3 to 5), at its centre of mass.
    Body(u32, u8),
    /// A contact along an axis of its frame.
    Row(u32, u8),
}

/// Share of one handle in the three rows of a contact.
#[derive(Clone, Copy, Debug)]
pub struct Term {
    /// The handle's column.
    pub column: u32,
    /// Weight of the handle in each row.
    pub weights: [Scalar; 3],
}

/// The handles, and B.
#[derive(Clone, Debug)]
pub struct Handles {
    list: CapacityVec<Handle>,
    terms: CapacityVec<Term>,
    /// Index of the first term of each member; one more at the end.
    start: CapacityVec<usize>,
    /// First column of each node and each body.
    of_node: Vec<u32>,
    of_body: Vec<u32>,
    new_nodes: CapacityVec<u32>,
    new_bodies: CapacityVec<u32>,
}

impl Handles {
    /// Room for `members` contacts on this many nodes and bodies.
    pub fn new(members: usize, nodes: usize, bodies: usize) -> Self {
        let mut start = CapacityVec::with_capacity(members + 1);
        start.push(0);
        Self {
            list: CapacityVec::with_capacity(3 * members),
            terms: CapacityVec::with_capacity(TERMS_MAX * members),
            start,
            of_node: vec![NONE; nodes],
            of_body: vec![NONE; bodies],
            new_nodes: CapacityVec::with_capacity(nodes),
            new_bodies: CapacityVec::with_capacity(bodies),
        }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        for handle in self.list.drain(..) {
            match handle {
                Handle::Node(node, _) => self.of_node[node as usize] = NONE,
                Handle::Body(body, _) => self.of_body[body as usize] = NONE,
                Handle::Row(..) => {}
            }
        }
        self.terms.clear();
        self.start.truncate(1);
    }

    /// All columns, in their order; no more than three per member.
    pub fn list(&self) -> &[Handle] {
        &self.list
    }

    /// Returns the terms that make up the rows of member m.
    pub fn terms(&self, m: usize) -> &[Term] {
        &self.terms[self.start[m]..self.start[m + 1]]
    }

    /// The first of member m's three columns when its axes are handles themselves.
    pub fn own_column(&self, m: usize) -> Option<usize> {
        match self.terms(m) {
            [first, _, _] => {
                let column = first.column as usize;
                matches!(self.list[column], Handle::Row(..)).then_some(column)
            }
            _ => None,
        }
    }

    /// Takes in contacts that become members. `place` orders the nodes so that neighbours share a
    /// batch; `moves` tells which bodies are pulled by contacts at all.
    pub fn extend(
        &mut self,
        joining: &[u32],
        contacts: &ContactRows,
        place: &[u32],
        moves: impl Fn(usize) -> bool,
    ) {
        self.share(joining, contacts, place, &moves);
        for &i in joining {
            let row = &contacts.rows[i as usize];
            if row.turns || !self.is_covered(contacts, row, &moves) {
                let axes = if row.turns { 1 } else { 3 };
                for axis in 0..axes {
                    let mut weights = [0.0; 3];
                    weights[axis] = 1.0;
                    self.terms.push(Term { column: self.list.len() as u32, weights });
                    self.list.push(Handle::Row(i, axis as u8));
                }
            } else {
                self.combine(contacts, row, &moves);
            }
            self.start.push(self.terms.len());
        }
    }

    /// Gives columns to the nodes and bodies that the joining contacts pull on, if these are fewer
    /// than the contacts' own.
    fn share(
        &mut self,
        joining: &[u32],
        contacts: &ContactRows,
        place: &[u32],
        moves: &impl Fn(usize) -> bool,
    ) {
        let Self { list, of_node, of_body, new_nodes, new_bodies, .. } = self;
        new_nodes.clear();
        new_bodies.clear();
        let mut own = 0;
        for &i in joining {
            let row = &contacts.rows[i as usize];
            if row.turns {
                continue;
            }
            own += 3;
            for (node, _) in nodes_of(contacts, row) {
                if of_node[node] == NONE {
                    of_node[node] = PENDING;
                    new_nodes.push(node as u32);
                }
            }
            for (body, ..) in row.rigids.iter().flatten().filter(|r| moves(r.0 as usize)) {
                if of_body[*body as usize] == NONE {
                    of_body[*body as usize] = PENDING;
                    new_bodies.push(*body);
                }
            }
        }
        if 3 * new_nodes.len() + 6 * new_bodies.len() >= own {
            new_nodes.iter().for_each(|&node| of_node[node as usize] = NONE);
            new_bodies.iter().for_each(|&body| of_body[body as usize] = NONE);
            return;
        }
        new_nodes.sort_unstable_by_key(|&node| place[node as usize]);
        for &node in &*new_nodes {
            of_node[node as usize] = list.len() as u32;
            list.extend((0..3).map(|axis| Handle::Node(node, axis)));
        }
        for &body in &*new_bodies {
            of_body[body as usize] = list.len() as u32;
            list.extend((0..6).map(|axis| Handle::Body(body, axis)));
        }
    }

    fn is_covered(
        &self,
        contacts: &ContactRows,
        row: &ContactRow,
        moves: &impl Fn(usize) -> bool,
    ) -> bool {
        let mut bodies = row.rigids.iter().flatten().filter(|r| moves(r.0 as usize));
        nodes_of(contacts, row).all(|(node, _)| self.of_node[node] != NONE)
            && bodies.all(|r| self.of_body[r.0 as usize] != NONE)
    }

    fn combine(
        &mut self,
        contacts: &ContactRows,
        row: &ContactRow,
        moves: &impl Fn(usize) -> bool,
    ) {
        for (node, weight) in nodes_of(contacts, row) {
            for axis in 0..3 {
                self.terms.push(Term {
                    column: self.of_node[node] + axis as u32,
                    weights: std::array::from_fn(|a| (row.frame[(a, axis)] * weight) as Scalar),
                });
            }
        }
        for (body, lever, sign) in row.rigids.iter().flatten() {
            if !moves(*body as usize) {
                continue;
            }
            let wrenches: [_; 3] =
                std::array::from_fn(|a| row.wrench(&(row.frame.row(a).transpose() * *sign), lever));
            for axis in 0..6 {
                self.terms.push(Term {
                    column: self.of_body[*body as usize] + axis as u32,
                    weights: std::array::from_fn(|a| wrenches[a][axis / 3][axis % 3] as Scalar),
                });
            }
        }
    }
}
