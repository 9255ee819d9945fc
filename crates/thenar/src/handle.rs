//! Handles: what [`Scene::add`](crate::Scene::add) returns and a simulation is asked with.

/// A hand of a scene, by its place among the scene's hands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct HandId(pub(crate) usize);

/// A rigid body of a scene, by its place among the scene's rigid bodies. Bones belong to their
/// hands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct RigidId(pub(crate) usize);

/// A soft body of a scene, by its place among the scene's soft bodies. Flesh belongs to its hand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SoftId(pub(crate) usize);
