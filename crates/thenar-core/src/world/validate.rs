//! Invariants of a world after every step and every change from outside, whatever came in.
//!
//! Box2D calls as much world validation. [`World::validate`] may be asked at any time; each step
//! asks by itself where debug assertions are on, so that every test of every crate does. What only
//! a step can know (that led bodies went where they were led, that held nodes stayed, and by which
//! cone of friction contact was solved) is asked there alone.
//!
//! Steps that fail are no exception: what is not finite is taken back before anyone can look, and
//! an answer of contact that did not converge still lies in the cones of friction.

use crate::math::{Pose, Quat, ROTATION_OFF, Vec3, is_turn};
use crate::model::{BodyId, Cone};
use crate::solver::ContactRow;
use crate::world::check::is_time_step;
use crate::world::limits;
use crate::world::model::Model;
use crate::world::parts::StepPart;
use crate::world::state::{State, is_sound_position, is_sound_velocity};
use crate::world::{ContactPoint, Input, StepReport, World};
use std::f64::consts::FRAC_1_SQRT_2;

/// Lengths of normals are off by so much at most. They are of length one to some roundings (2e-16
/// each) where they arise, and then turned from a part's frame to its shape's, its body's and the
/// world's: by a rotation of length 1 + δ a vector gets 1 + 2 δ as long, with δ up to
/// [`ROTATION_OFF`].
const NORMAL_OFF: f64 = 7.0 * ROTATION_OFF;

/// Part of a force by which it may leave its cone, to which solvers keep to 1e-12 (`contact_law`):
/// the normal is off by as much, and so is each tangent, which is made of it.
const CONE_OFF: f64 = 4.0 * NORMAL_OFF;

/// Impulses in the frame in which they were found keep to their bounds to this part: that of the
/// contact law, and as much again for roundings.
const BOUND_OFF: f64 = 2e-12;

/// Weights of a contact's two sides may differ by so much in sum: those of a surface's vertices may
/// be off by 1e-6 in a description, on either side, and there are up to 24 roundings.
const PAIR_OFF: f64 = 2.1e-6;

/// One thing that does not hold of a world.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Invalid {
    /// A number is not what it must be.
    #[error("{thing} {index}: {what} must be {expected}, got {got}")]
    Value {
        /// Kind of body, joint or contact.
        thing: &'static str,
        /// Number of the thing, from 0.
        index: usize,
        /// Quantity that is wrong.
        what: &'static str,
        /// Values that are allowed.
        expected: &'static str,
        /// Value that was found.
        got: f64,
    },
    /// A list has not the length that the model asks for.
    #[error("{list}: {got} entries, expected {expected}")]
    Count {
        /// Name of the list.
        list: &'static str,
        /// Length that is needed.
        expected: usize,
        /// Length that it has.
        got: usize,
    },
    /// A list that is searched is not in order.
    #[error("{list}: not in order")]
    Order {
        /// Name of the list.
        list: &'static str,
    },
}

/// Verdict of one check.
type Check = Result<(), Invalid>;

/// The number of a thing, of which quantities are checked.
#[derive(Clone, Copy)]
struct Subject(&'static str, usize);

impl Subject {
    fn number(
        self,
        what: &'static str,
        expected: &'static str,
        got: f64,
        ok: impl Fn(f64) -> bool,
    ) -> Check {
        if ok(got) {
            return Ok(());
        }
        Err(Invalid::Value { thing: self.0, index: self.1, what, expected, got })
    }

    fn finite(self, what: &'static str, numbers: &[f64]) -> Check {
        match numbers.iter().find(|x| !x.is_finite()) {
            None => Ok(()),
            Some(got) => self.number(what, "finite", *got, |_| false),
        }
    }

    fn not_negative(self, what: &'static str, got: f64) -> Check {
        self.number(what, "finite and not negative", got, |x| x >= 0.0 && x.is_finite())
    }

    fn index(self, what: &'static str, expected: &'static str, got: u32, count: usize) -> Check {
        self.number(what, expected, f64::from(got), |_| (got as usize) < count)
    }
}

fn count(list: &'static str, expected: usize, got: usize) -> Check {
    if got == expected { Ok(()) } else { Err(Invalid::Count { list, expected, got }) }
}

/// The component that is not finite, or the largest.
fn largest(v: &Vec3) -> f64 {
    v.iter().copied().find(|x| !x.is_finite()).unwrap_or_else(|| v.amax())
}

/// Looks whether each vector of a list is finite.
fn finite<'a>(
    thing: &'static str,
    what: &'static str,
    vectors: impl IntoIterator<Item = &'a Vec3>,
) -> Check {
    let mut all = vectors.into_iter().enumerate();
    all.try_for_each(|(i, v)| Subject(thing, i).finite(what, v.as_slice()))
}

impl World {
    /// Looks whether everything holds that must hold of a world between steps: the state has the
    /// lengths of its model and finite numbers within 1e9, rotations are rotations, held nodes rest
    /// along their axes, and what memory is searched is in order; contacts of the last step point
    /// somewhere, push, keep within Coulomb's cone (the linearised one lies within it), have an
    /// area and put on one body what they take from the other; limits push away from their bounds.
    /// One pass, which allocates nothing.
    ///
    /// # Errors
    /// The first thing that does not hold.
    pub fn validate(&self) -> Result<(), Invalid> {
        let world = Subject("world", 0);
        world.number("time step", "from 1e-12 to 10 s", self.time_step, is_time_step)?;
        self.state.validate(&self.model)?;
        self.contacts_are_valid()?;
        self.limits_are_valid()
    }

    /// Asks as [`World::validate`] does, and whether contact was solved with the cone of the
    /// settings.
    ///
    /// # Errors
    /// The first thing that does not hold.
    pub(super) fn validate_step(&self) -> Result<(), Invalid> {
        self.validate()?;
        if self.desc.solver.cone == Cone::Circular {
            return Ok(());
        }
        let rows = self.readout.rows.rows.iter().zip(&self.readout.contacts);
        rows.enumerate().try_for_each(|(i, (row, _))| {
            let bound = row.friction * row.lambda.x * FRAC_1_SQRT_2 * (1.0 + BOUND_OFF);
            let largest = row.lambda.y.abs().max(row.lambda.z.abs());
            let expected = "within the square inscribed in Coulomb's disc";
            Subject("contact", i).number("friction [N s]", expected, largest, |t| t <= bound)
        })
    }

    /// Looks whether a part of a step has put led bodies where they were led, and left held nodes
    /// where they were held.
    ///
    /// # Errors
    /// The first thing that is elsewhere.
    pub(super) fn validate_led(&self, part: StepPart, input: &Input, done: &StepReport) -> Check {
        let Self { model, state, scratch, .. } = self;
        let before = &scratch.before;
        for (b, _) in model.rigids.iter().enumerate().filter(|(_, body)| !body.moves) {
            let of = Subject("led body", b);
            let v = [state.v[2 * b], state.v[2 * b + 1]];
            if !done.taken_back {
                let off =
                    (0..2).map(|k| (v[k] - input.prescribed[b][k]).norm()).fold(0.0, f64::max);
                of.number("velocity", "as prescribed", off, |off| off == 0.0)?;
            }
            let led = led(&before.poses_WB[b], v, part.h);
            let (now, way) = (&state.poses_WB[b], v[0].norm() * part.h);
            let rounding = 4.0 * f64::EPSILON * (led.position.norm() + way);
            let off = (now.position - led.position).norm();
            of.number("way from where it was led [m]", "none", off, |off| off <= rounding)?;
            let off = (now.rotation.coords - led.rotation.coords).norm();
            let expected = "none";
            of.number("turn from where it was led", expected, off, |off| {
                off <= 2.0 * ROTATION_OFF
            })?;
        }
        model.held.iter().try_for_each(|(node, axes)| {
            let n = *node as usize;
            let off = (state.x[n] - before.x[n]).abs();
            let off = (0..3).filter(|k| axes[*k]).map(|k| off[k]).fold(0.0, f64::max);
            Subject("held node", n).number("way along held axes [m]", "none", off, |off| off == 0.0)
        })
    }

    fn contacts_are_valid(&self) -> Check {
        let Self { model, readout, .. } = self;
        let contacts = &readout.contacts;
        count("sites of contacts", contacts.len(), readout.sites.len())?;
        count("rows of contacts and limits", contacts.len() + readout.limits.len(), {
            readout.rows.rows.len()
        })?;
        contacts.iter().enumerate().try_for_each(|(i, contact)| {
            contact_is_valid(Subject("contact", i), contact)?;
            sides_exist(Subject("contact", i), contact, model)
        })?;
        let rows = readout.rows.rows.iter().zip(contacts).enumerate();
        rows.into_iter().try_for_each(|(i, (row, _))| {
            let expected = "opposite to that on A, in sum of weights";
            let sum = self.sum_of_weights(row);
            Subject("contact", i).number("force on B", expected, sum, |sum| sum.abs() <= PAIR_OFF)
        })
    }

    /// Weights of what a row holds, negative on side B: the part of its force that no body feels
    /// the opposite of.
    fn sum_of_weights(&self, row: &ContactRow) -> f64 {
        let nodes = row.nodes.start as usize..row.nodes.end as usize;
        let of_nodes: f64 = self.readout.rows.weights[nodes].iter().sum();
        of_nodes + row.rigids.iter().flatten().map(|(_, _, sign)| sign).sum::<f64>()
    }

    fn limits_are_valid(&self) -> Check {
        let Self { model, readout, .. } = self;
        let (most, got) = (limits::rows_max(model), readout.limits.len());
        if got > most {
            return Err(Invalid::Count { list: "limits", expected: most, got });
        }
        let rows = &readout.rows.rows[readout.contacts.len()..];
        readout.limits.iter().zip(rows).enumerate().try_for_each(|(i, (limit, row))| {
            let of = Subject("limit", i);
            of.index("joint", "one of the world's", limit.joint, model.joints.len())?;
            of.not_negative("impulse away from its bound [N s]", row.lambda.x)
        })
    }
}

/// Pose to which these velocities lead a body.
fn led(from: &Pose, [velocity_W, spin_W]: [Vec3; 2], h: f64) -> Pose {
    let turn = Quat::from_scaled_axis(spin_W * h);
    let rotation = Quat::new_normalize((turn * from.rotation).into_inner());
    Pose::new(from.position + velocity_W * h, rotation)
}

fn contact_is_valid(of: Subject, contact: &ContactPoint) -> Check {
    of.finite("position [m]", contact.position_W.as_slice())?;
    let length = contact.normal_W.norm();
    of.number("length of the normal", "1", length, |x| (x - 1.0).abs() <= NORMAL_OFF)?;
    of.finite("gap [m]", &[contact.gap])?;
    of.finite("slip [m/s]", contact.slip_W.as_slice())?;
    of.finite("force [N]", contact.force_W.as_slice())?;
    of.not_negative("area [m²]", contact.area)?;
    of.not_negative("friction coefficient", contact.friction)?;
    let along = contact.force_W.dot(&contact.normal_W);
    let slack = CONE_OFF * contact.force_W.norm();
    of.number("normal force [N]", "not negative", along, |force| force >= -slack)?;
    let across = (contact.force_W - contact.normal_W * along).norm();
    let most = contact.friction * along.max(0.0) + slack;
    of.number("tangential force [N]", "within the cone of friction", across, |force| force <= most)
}

/// Bodies and vertices of a contact are some of the model's.
fn sides_exist(of: Subject, contact: &ContactPoint, model: &Model) -> Check {
    for (body, vertex) in contact.bodies.iter().zip(contact.vertices) {
        match (*body, vertex) {
            (BodyId::Rigid(b), None) => {
                of.index("rigid body", "one of the world's", b, model.rigids.len())?;
            }
            (BodyId::Soft(s), Some(vertex)) => {
                of.index("deformable body", "one of the world's", s, model.soft_vertices.len())?;
                let vertices = model.soft_vertices[s as usize].len();
                of.index("vertex", "one of its body's surface", vertex, vertices)?;
            }
            (BodyId::Rigid(_), Some(vertex)) => {
                of.number("vertex", "none on a rigid body", f64::from(vertex), |_| false)?;
            }
            (BodyId::Soft(s), None) => {
                of.number("body without a vertex", "rigid", f64::from(s), |_| false)?;
            }
        }
    }
    match contact.bodies {
        [BodyId::Rigid(a), BodyId::Rigid(b)] if a == b => {
            of.number("other body", "another one", f64::from(b), |_| false)
        }
        _ => Ok(()),
    }
}

impl State {
    /// Looks whether the state is one of this model's, and a step can go on from it.
    ///
    /// # Errors
    /// The first thing that does not hold.
    pub(super) fn validate(&self, model: &Model) -> Result<(), Invalid> {
        self.has_lengths(model)?;
        self.is_somewhere()?;
        self.remembers_numbers()?;
        let row0 = 2 * model.rigids.len();
        model.held.iter().try_for_each(|(node, axes)| {
            let v = &self.v[row0 + *node as usize];
            let speed = (0..3).filter(|k| axes[*k]).map(|k| v[k].abs()).fold(0.0, f64::max);
            let of = Subject("held node", *node as usize);
            of.number("speed along held axes [m/s]", "0", speed, |speed| speed == 0.0)
        })?;
        if !self.impulses.is_sorted_by_key(|(key, _)| *key) {
            return Err(Invalid::Order { list: "impulses of contacts" });
        }
        if !self.patch_loads.is_sorted_by_key(|(key, _)| *key) {
            return Err(Invalid::Order { list: "loads of patches" });
        }
        Ok(())
    }

    fn has_lengths(&self, model: &Model) -> Check {
        count("poses of rigid bodies", model.rigids.len(), self.poses_WB.len())?;
        count("positions of nodes", model.flesh.mass.len(), self.x.len())?;
        count("velocities", model.rows(), self.v.len())?;
        count("velocities by contact", model.rows(), self.contact_change.len())?;
        count("impulses of joint limits", model.joints.len(), self.limit_impulses.len())?;
        count("faded stresses", model.flesh.memory.len(), self.faded.len())
    }

    /// Looks at places and velocities.
    fn is_somewhere(&self) -> Check {
        Subject("world", 0).finite("time [s]", &[self.time])?;
        for (b, pose) in self.poses_WB.iter().enumerate() {
            let (of, x) = (Subject("rigid body", b), &pose.position);
            of.number("position [m]", WITHIN, largest(x), |_| is_sound_position(x))?;
            let length = pose.rotation.coords.norm();
            of.number("length of the rotation", "1", length, |_| is_turn(&pose.rotation))?;
        }
        for (n, x) in self.x.iter().enumerate() {
            let sound = |_| is_sound_position(x);
            Subject("node", n).number("position [m]", WITHIN, largest(x), sound)?;
        }
        for (row, v) in self.v.iter().enumerate() {
            let sound = |_| is_sound_velocity(v);
            Subject("block row", row).number("velocity [m/s, rad/s]", WITHIN, largest(v), sound)?;
        }
        Ok(())
    }

    /// Looks at memories of contact, limits and tissue.
    fn remembers_numbers(&self) -> Check {
        finite("block row", "velocity by contact [m/s]", &self.contact_change)?;
        finite("remembered contact", "impulse [N s]", self.impulses.iter().map(|(_, p)| p))?;
        for (j, impulses) in self.limit_impulses.iter().enumerate() {
            Subject("joint", j).finite("impulse of limits [N m s]", impulses)?;
        }
        for (i, (_, load)) in self.patch_loads.iter().enumerate() {
            Subject("patch", i).not_negative("load [N]", *load)?;
        }
        for (i, faded) in self.faded.iter().enumerate() {
            Subject("element with memory", i).finite("faded stress", faded)?;
        }
        let sides = self.sides.as_slice();
        finite("side", "normal", sides.iter().map(|side| &side.normal))?;
        finite("side", "place [m]", sides.iter().map(|side| &side.place))?;
        let bad = self.sides.places().iter().position(|place| !place.is_finite());
        bad.map_or(Ok(()), |i| Subject("held place", i).finite("weights", &[f64::NAN]))
    }
}

/// The room that a state may fill (`State::is_sound`).
const WITHIN: &str = "finite and within 1e9";

#[cfg(test)]
mod tests;
