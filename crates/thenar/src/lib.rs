//! A soft human hand that touches things: flesh on a jointed skeleton, in frictional contact with
//! rigid and soft objects.
//!
//! Describe a [`Scene`] of hands and objects, [build](Scene::build) it into a [`Simulation`], give
//! each hand the pose that it should follow, [step](Simulation::step), and read the forces.
//!
//! ```
//! use thenar::{Hand, HandPose, Pose, Rigid, Scene};
//!
//! let mut scene = Scene::new();                               // gravity down, steps of 5 ms
//! let ball = scene.add(Rigid::sphere(0.03).at([0.0, 0.03, 0.0]).mass(0.05));
//! scene.add(Rigid::plane());
//! let hand = scene.add(Hand::right().paper().at([0.0, 0.2, 0.0]));
//! let mut sim = scene.build()?;
//!
//! let wrist = Pose::translation(0.0, 0.2, 0.0);               // 20 cm above the plane
//! for _ in 0..10 {
//!     sim.hand_mut(hand).follow(&HandPose::flat(wrist))?;
//!     sim.step();
//! }
//! assert!(sim.loads(hand).iter().all(|load| load.normal == 0.0));
//! assert!(sim.rigid(ball).velocity().linear.norm() < 1e-3);   // the ball rests on the plane
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Scenes in files
//!
//! A scene in code is a scene file in the making: [`Scene::to_toml`] prints it,
//! [`Scene::from_file`] and [`Scene::named`] open one, and both give the same simulation, bit for
//! bit. Keys that have no method here are set by name, [`Rigid::set`] and its likes;
//! `docs/scene.md` lists them.
//!
//! # Units and frames
//!
//! SI units (m, kg, s, N, Pa, rad). Frames are right-handed, and +y is up in the usual scene. A
//! [`Pose`] `pose_AB` takes points of frame B to frame A. A hand's wrist has -z towards the fingers
//! and +y out of the back of the hand.
//!
//! # Beyond this crate
//!
//! Programs that extend Thenar use the crates below it: `thenar-core` (the simulator),
//! `thenar-scene` (scene files, sessions, recordings), `thenar-rig` (meshes to models),
//! `thenar-track` (tracked hands), `thenar-touch` (the haptic loop), `thenar-link` (devices).
//! [`Simulation::session`] leads there.

mod body;
mod contact;
mod drive;
mod entry;
mod grip;
mod hand;
mod hand_ref;
mod handle;
mod motion;
mod rigid;
mod rigid_ref;
mod scene;
mod simulation;
mod soft;
mod soft_ref;

pub use body::Body;
pub use contact::Contact;
pub use drive::{Coupling, Drive};
pub use grip::Grip;
pub use hand::Hand;
pub use hand_ref::{FingerLoad, HandMut, HandRef};
pub use handle::{HandId, RigidId, SoftId};
pub use motion::{Twist, Wrench};
pub use rigid::Rigid;
pub use rigid_ref::{RigidMut, RigidRef};
pub use scene::{Part, Scene};
pub use simulation::Simulation;
pub use soft::Soft;
pub use soft_ref::{SoftMut, SoftRef};

pub use nalgebra;
pub use thenar_core::model::{Digit, Side};
pub use thenar_core::world::StepReport;
pub use thenar_core::{Pose, Quat, Vec3};
pub use thenar_scene::SceneError;
pub use thenar_scene::grip::GripKind;
pub use thenar_scene::recording::SnapshotError;
pub use thenar_scene::session::GripError;
pub use thenar_scene::tuning::SettingError;
pub use thenar_track::live::{LiveError as PoseError, LivePose as HandPose, Mover};

/// The samples in the README, run as tests of documentation.
#[cfg(doctest)]
#[doc = include_str!("../../../README.md")]
struct Readme;

/// The samples of its page, likewise.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/rust.md")]
struct Page;
