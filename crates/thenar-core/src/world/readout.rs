//! The last step's result as others read it until the next one: contacts with their rows, and
//! surfaces.
//!
//! A step works on its contacts in [`Scratch`]. Their lists are in one place at a time:
//! [`Readout::lend`] gives the memory to the step, empty, and [`Readout::take`] takes the filled
//! lists back. So nothing is copied or allocated, and no step can read contacts of the one before.

use crate::capacity_vec::CapacityVec;
use crate::contact::Contact;
use crate::math::Vec3;
use crate::solver::ContactRows;
use crate::world::limits::{self, LimitRow};
use crate::world::state::Scratch;
use crate::world::{ContactPoint, Model};
use std::mem::swap;

/// Lists of the last step that `World::contacts`, readouts, validation and touch read.
#[derive(Clone, Debug)]
pub struct Readout {
    /// Contacts as reported.
    pub contacts: CapacityVec<ContactPoint>,
    /// Places where each of them holds its bodies.
    pub sites: CapacityVec<Contact>,
    /// Bounds of joints that had rows.
    pub limits: CapacityVec<LimitRow>,
    /// Rows of contacts, then of limits, with their impulses.
    pub rows: ContactRows,
    /// Pseudo-velocity that undid overlaps \[m/s\].
    push: Vec<Vec3>,
    /// True when there was one.
    pushes: bool,
    /// Length of the step, or of its last part, that contacts and limits are of \[s\].
    pub part_length: f64,
    /// Collision vertices of all deformable bodies where they are now, world \[m\].
    pub vertices: Vec<Vec3>,
}

impl Readout {
    /// Room for as many contacts.
    pub fn new(model: &Model, contacts_max: usize) -> Self {
        let limits_max = limits::rows_max(model);
        Self {
            contacts: CapacityVec::with_capacity(contacts_max),
            sites: CapacityVec::with_capacity(contacts_max),
            limits: CapacityVec::with_capacity(limits_max),
            rows: ContactRows::with_capacity(model.rigids.len(), contacts_max + limits_max),
            push: vec![Vec3::zeros(); model.rows()],
            pushes: false,
            part_length: 0.0,
            vertices: vec![Vec3::zeros(); model.vertices.len()],
        }
    }

    /// Gives the memory of its lists to a step, without what is in them.
    pub fn lend(&mut self, scratch: &mut Scratch) {
        self.forget_contacts();
        self.exchange(scratch);
    }

    /// Takes what a step found, with the memory.
    pub fn take(&mut self, scratch: &mut Scratch) {
        self.exchange(scratch);
        self.pushes = std::mem::take(&mut scratch.pushes);
    }

    fn exchange(&mut self, scratch: &mut Scratch) {
        swap(&mut self.contacts, &mut scratch.contacts);
        swap(&mut self.sites, &mut scratch.found);
        swap(&mut self.limits, &mut scratch.limits);
        swap(&mut self.rows, &mut scratch.rows);
        swap(&mut self.push, &mut scratch.push);
    }

    /// The last step's contacts and limits are not those of the state.
    pub fn forget_contacts(&mut self) {
        self.contacts.clear();
        self.sites.clear();
        self.limits.clear();
        self.rows.clear();
    }

    /// Pseudo-velocity that undid overlaps \[m/s\], where there was one.
    pub fn push(&self) -> Option<&[Vec3]> {
        self.pushes.then_some(&self.push)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::condensed::{BoneFrame, RigidState};
    use crate::contact::Shape;
    use crate::math::{Mat3, Pose};
    use crate::model::{Drive, Motion, RigidDesc, WorldDesc};
    use crate::world::{Input, Target, World};

    /// A driven cube that is pressed to a floor.
    fn pressed() -> (World, Input) {
        let floor = RigidDesc {
            name: "floor".into(),
            motion: Motion::Prescribed,
            mass: 0.1,
            inertia: Mat3::from_diagonal_element(1e-5),
            pose_WB: Pose::identity(),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
            shape: Some(Shape::HalfSpace),
            pose_BS: Pose::identity(),
            friction: 0.5,
        };
        let cube = RigidDesc {
            name: "cube".into(),
            motion: Motion::Dynamic,
            pose_WB: Pose::translation(0.0, 0.01, 0.0),
            shape: Some(Shape::Cuboid { half: Vec3::repeat(0.01) }),
            ..floor.clone()
        };
        let mut desc = WorldDesc { time_step: 1e-3, ..WorldDesc::default() };
        desc.add_rigid(floor);
        let cube = desc.add_rigid(cube) as usize;
        desc.drives[cube] = Some(Drive {
            stiffness: 400.0,
            damping: 4.0,
            angular_stiffness: 0.4,
            angular_damping: 4e-3,
        });
        let world = World::new(desc).unwrap();
        let mut input = world.input();
        input.targets[cube] = Some(Target {
            pose_WB: Pose::translation(1e-4, 0.008, 0.0),
            velocity_W: Vec3::zeros(),
            angular_velocity_W: Vec3::zeros(),
        });
        (world, input)
    }

    /// All that is read after a step, with the hash of its state.
    fn read(world: &mut World, input: &Input) -> String {
        let mut frame = BoneFrame::new(&[RigidState::of(world, 1)], 8);
        assert!(world.condense(1..2, input, &mut frame));
        format!("{frame:?} {:?} {}", world.contacts(), world.state_hash())
    }

    #[test]
    fn nothing_that_is_read_lies_in_scratch() {
        let (mut world, input) = pressed();
        let mut other = world.clone();
        for _ in 0..5 {
            for world in [&mut world, &mut other] {
                world.step(&input, &mut ());
                assert!(world.contacts().len() >= 3, "{}", world.contacts().len());
            }
            // One world goes on in memory that has seen no step.
            other.scratch =
                Scratch::new(&other.model, &other.state, [0, other.detector.sides_max()]);
            assert_eq!(other.validate(), Ok(()));
            assert_eq!(read(&mut other, &input), read(&mut world, &input));
        }
    }

    #[test]
    fn the_next_step_finds_the_lists_empty_and_as_large() {
        let (mut world, input) = pressed();
        let room = world.readout.contacts.capacity();
        for _ in 0..3 {
            world.step(&input, &mut ());
            let Scratch { found, contacts, limits, rows, .. } = &world.scratch;
            assert!(found.is_empty() && contacts.is_empty() && limits.is_empty());
            assert!(rows.rows.is_empty() && !world.readout.rows.rows.is_empty());
            assert_eq!(world.readout.contacts.capacity(), room);
        }
    }
}
