//! The bytes behind every array, by quantity, in the machine's order.

use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use thenar_core::model::BodyId;
use thenar_core::readout::{ContactReadout, PartContact};
use thenar_core::world::ContactPoint;
use thenar_core::{Vec3, World};
use thenar_scene::flat::flat_pose;
use thenar_scene::session::{HandLoad, Session};

/// A quantity, of a deformable body, a rigid body, a hand or the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Nodes of a deformable body, `(N, 3)` \[m\].
    Nodes,
    /// Velocities of these nodes, `(N, 3)` \[m/s\].
    NodeVelocities,
    /// Vertices of its surface, `(V, 3)` \[m\].
    Vertices,
    /// Contact forces on these, `(V, 3)` \[N\].
    VertexForces,
    /// Contact pressures there, `(V,)` \[Pa\].
    VertexPressures,
    /// Pose of a rigid body, `(7,)`.
    Pose,
    /// Linear and angular velocity of a rigid body, `(6,)`.
    Velocity,
    /// Poses of a hand's bones, `(B, 7)`.
    BonePoses,
    /// Velocities of a hand's bones, `(B, 6)`.
    BoneVelocities,
    /// The hand's wrist, `(7,)`.
    Wrist,
    /// The hand's twenty angles, `(20,)` \[rad\]; NaN for those that it lacks.
    Angles,
    /// Loads on palm and fingers, six records.
    Loads,
    /// Contact points, one record each.
    Contacts,
}

impl Quantity {
    /// The quantity of a name.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn named(name: &str) -> PyResult<Self> {
        Ok(match name {
            "nodes" => Self::Nodes,
            "node_velocities" => Self::NodeVelocities,
            "vertices" => Self::Vertices,
            "vertex_forces" => Self::VertexForces,
            "vertex_pressures" => Self::VertexPressures,
            "pose" => Self::Pose,
            "velocity" => Self::Velocity,
            "bone_poses" => Self::BonePoses,
            "bone_velocities" => Self::BoneVelocities,
            "wrist" => Self::Wrist,
            "angles" => Self::Angles,
            "loads" => Self::Loads,
            "contacts" => Self::Contacts,
            _ => return Err(PyValueError::new_err(format!("there is no quantity `{name}`"))),
        })
    }

    /// True when [`ContactReadout::read`] computes it.
    pub fn is_of_contact(self) -> bool {
        matches!(self, Self::VertexForces | Self::VertexPressures | Self::Loads)
    }

    /// Number of things that the quantity may be asked of.
    fn count(self, session: &Session) -> usize {
        let desc = session.world().desc();
        match self {
            Self::Nodes
            | Self::NodeVelocities
            | Self::Vertices
            | Self::VertexForces
            | Self::VertexPressures => desc.softs.len(),
            Self::Pose | Self::Velocity => desc.rigids.len(),
            Self::BonePoses | Self::BoneVelocities | Self::Wrist | Self::Angles | Self::Loads => {
                session.hands().len()
            }
            Self::Contacts => 1,
        }
    }

    /// The bytes for the body or hand of this index.
    ///
    /// # Errors
    /// There is no such thing.
    pub fn read<'py>(
        self,
        py: Python<'py>,
        session: &Session,
        readout: &ContactReadout,
        index: usize,
    ) -> PyResult<Bound<'py, PyBytes>> {
        if index >= self.count(session) {
            return Err(PyIndexError::new_err(format!("there is nothing with index {index}")));
        }
        let (world, i) = (session.world(), index as u32);
        let vectors = |vectors: &[Vec3]| PyBytes::new(py, bytemuck::cast_slice(vectors));
        let numbers = |numbers: &[f64]| PyBytes::new(py, bytemuck::cast_slice(numbers));
        Ok(match self {
            Self::Nodes => vectors(world.nodes(i)),
            Self::NodeVelocities => vectors(world.node_velocities(i)),
            Self::Vertices => vectors(world.collision_vertices(i)),
            Self::VertexForces => {
                let forces: Vec<Vec3> = readout.vertices(i).iter().map(|v| v.force_W).collect();
                vectors(&forces)
            }
            Self::VertexPressures => {
                let pressures: Vec<f64> = readout.vertices(i).iter().map(|v| v.pressure).collect();
                numbers(&pressures)
            }
            Self::Pose => numbers(&flat_pose(&world.rigid_pose(i))),
            Self::Velocity => vectors(&world.rigid_velocity(i)),
            Self::BonePoses => {
                let poses: Vec<[f64; 7]> =
                    bones(session, index).map(|b| flat_pose(&world.rigid_pose(b))).collect();
                numbers(poses.as_flattened())
            }
            Self::BoneVelocities => {
                let velocities: Vec<[Vec3; 2]> =
                    bones(session, index).map(|b| world.rigid_velocity(b)).collect();
                vectors(velocities.as_flattened())
            }
            Self::Wrist => numbers(&flat_pose(&session.hand_wrist(index))),
            Self::Angles => numbers(&session.hand_angles(index)),
            Self::Loads => numbers(&loads(session, readout, index)),
            Self::Contacts => PyBytes::new(py, &contacts(world)),
        })
    }
}

fn bones(session: &Session, hand: usize) -> std::ops::Range<u32> {
    session.hands()[hand].handle.bones.clone()
}

/// Numbers of a record of loads.
const LOAD: usize = 16;

/// For palm, thumb, index, middle, ring and little finger: normal \[N\], shear \[N\], area \[m²\],
/// pressure \[Pa\]; force on it \[N\], its centre \[m\], force \[N\] and torque \[N m\] on its
/// bones.
fn loads(session: &Session, readout: &ContactReadout, hand: usize) -> Vec<f64> {
    let parts = session.hands()[hand].flesh().map_or(&[][..], |soft| readout.parts(soft));
    let none = PartContact::default();
    let mut numbers = Vec::with_capacity(6 * LOAD);
    for (k, load) in session.hand_loads(hand).iter().enumerate() {
        let part = parts.get(k).unwrap_or(&none);
        numbers.extend(HandLoad::figures(load));
        let forces = [part.contact.force_W, part.contact.centre_W];
        let on_bones = [part.bone_force_W, part.bone_torque_W];
        forces.iter().chain(&on_bones).for_each(|v| numbers.extend(v.iter()));
    }
    numbers
}

/// Bytes of a contact's record.
const CONTACT: usize = 8 * 18;

/// Contact points, a record for each: bodies and vertices as `i32`, then numbers, then whether it
/// slips.
fn contacts(world: &World) -> Vec<u8> {
    let rigids = world.desc().rigids.len();
    let body = |body: BodyId| match body {
        BodyId::Rigid(i) => i as usize,
        BodyId::Soft(i) => rigids + i as usize,
    };
    let mut bytes = Vec::with_capacity(CONTACT * world.contacts().len());
    for point in world.contacts() {
        let bodies = point.bodies.map(|b| body(b) as i32);
        let vertices = point.vertices.map(|v| v.map_or(-1, |v| v as i32));
        bytes.extend(bodies.iter().chain(&vertices).flat_map(|i| i.to_ne_bytes()));
        let ContactPoint { position_W, normal_W, force_W, slip_W, gap, area, friction, .. } = point;
        let vectors = [position_W, normal_W, force_W, slip_W];
        bytes.extend(vectors.iter().flat_map(|v| v.iter()).flat_map(|x| x.to_ne_bytes()));
        bytes.extend([gap, area, friction].iter().flat_map(|x| x.to_ne_bytes()));
        // A byte that numpy takes for a bool, and room up to the next number.
        bytes.extend([u8::from(point.slips), 0, 0, 0, 0, 0, 0, 0]);
    }
    bytes
}
