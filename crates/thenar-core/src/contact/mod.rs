//! Contact detection: shapes, signed distances, broad and narrow phase.
//!
//! [`Detector::find`] turns the state at the start of a step into [`Contact`]s: a point on each
//! side, a unit normal and a gap. It does not decide forces.
//!
//! Guaranteed: no allocation once the output has its capacity; the same input gives the same
//! contacts in the same order; both sides of a contact use one common point, so that opposite
//! forces balance in torque too; a point that would cross a surface within the step gets its
//! contact before it crosses. Two soft surfaces meet at vertices on faces and at edges that cross,
//! which is all that flat faces can do; a surface may meet itself, but for its neighbouring parts.
//! Not guaranteed: that a soft surface and an edge of a rigid body cannot cut each other by a
//! hundredth of an edge, or between points of that edge where they meet at speed; that flesh which
//! is crushed until its surface turns inside out keeps its contacts.

mod aabb;
mod along;
mod apart;
mod approach;
mod area;
mod area_between;
mod area_faces;
mod area_least;
mod area_samples;
mod bit_table;
mod blunt;
mod bvh;
mod collector;
mod contact_point;
mod convex_pair;
mod crowd;
mod cuboid_pair;
mod deepening;
#[cfg(test)]
mod depth_tests;
mod detector;
mod distance;
mod edge;
mod ellipsoid;
#[cfg(test)]
mod fast_tests;
mod features;
mod grid;
mod manifold;
mod mesh_clear;
mod mesh_crossing;
mod mesh_deep;
mod mesh_distance;
mod mesh_index;
mod mesh_normals;
mod mesh_pair;
mod near;
mod nearest;
#[cfg(test)]
mod neighbour_tests;
#[cfg(test)]
mod pair_tests;
mod pairs;
mod places;
mod polygon;
mod ridge;
mod rigid_body;
mod rigid_pair;
#[cfg(test)]
mod rigid_tests;
mod round_side;
#[cfg(test)]
mod seam_tests;
mod separation;
mod shape;
mod sharp;
mod sharp_blocks;
mod sides;
mod smooth;
mod soft_deep;
mod soft_edge;
mod soft_feature;
mod soft_inside;
mod soft_offer;
mod soft_pairs;
mod soft_rigid;
mod soft_round;
mod soft_soft;
#[cfg(test)]
mod soft_truth_tests;
mod soft_way;
mod support;
mod surface;
mod sweep;
#[cfg(test)]
mod tests;
mod traced;
mod triangle;
#[cfg(test)]
mod truth_tests;
mod union_find;

pub(crate) use collector::KnownDepths;
pub use contact_point::{Contact, RigidPlace, SearchReport, Site, SurfacePoint, SurfaceState};
pub(crate) use deepening::Displacements;
pub use detector::Detector;
pub use distance::Distance;
pub use places::HeldPlace;
pub use rigid_pair::Reach;
pub use shape::{DistanceGrid, MeshShape, PlacedShape, Shape};
pub use sides::{SeenSide, SeenSides};
pub(crate) use triangle::{closest_on_triangle, cut_by_ray, stands_for};
