//! The whole scene as one description.

use crate::math::{Pose, Vec3};
use crate::model::{
    Binding, BodyParts, CouplingKind, ElementPatches, Flesh, FrictionTable, HandModel, JointDesc,
    Motion, PoseOffsets, RigidDesc, Skin, Skinning, patches,
};
use std::ops::Range;

/// A deformable body placed in the world, perhaps bound to bones.
#[derive(Clone, Debug)]
pub struct SoftDesc {
    /// Name, unique in the scene.
    pub name: String,
    /// Rest shape; `pose_WM` places it.
    pub flesh: Flesh,
    /// Start pose of the model frame in the world.
    pub pose_WM: Pose,
    /// Start velocity of all nodes, world \[m/s\].
    pub velocity_W: Vec3,
    /// Binding to rigid bodies, if the body has bones inside.
    pub coupling: Option<Coupling>,
}

/// Springs and skinning that bind flesh to bones (Eq. 6-9). Bone indices are those of
/// `WorldDesc::rigids`.
#[derive(Clone, Debug)]
pub struct Coupling {
    /// One binding per node.
    pub bindings: Vec<Binding>,
    /// Spring of each node.
    pub springs: Springs,
    /// Damper of each node, as a time: damping = `damping_time` × stiffness \[s\].
    pub damping_time: f64,
    /// Rule by which two bones place a node's target.
    pub skinning: Skinning,
}

impl Coupling {
    /// Usual damping time of the springs \[s\]: far shorter than motions of a hand, which keep
    /// their speed.
    pub const DAMPING_TIME: f64 = 1e-3;
}

/// Stiffness of the springs of a coupling, as it was given: one number for all, or a list.
#[derive(Clone, Debug, PartialEq)]
pub enum Springs {
    /// In proportion to what each node holds.
    PerVolume {
        /// Stiffness per volume \[N/m⁴\].
        stiffness: f64,
        /// Volume that each node holds \[m³\]; zero for a node without a spring.
        volumes: Vec<f64>,
    },
    /// Stiffness of each node's spring \[N/m\]; zero for a node without one.
    PerNode(Vec<f64>),
}

impl Springs {
    /// Stiffness of all springs, node by node \[N/m\].
    pub fn stiffness(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        let (list, factor) = match self {
            Self::PerVolume { stiffness, volumes } => (volumes, *stiffness),
            Self::PerNode(list) => (list, 1.0),
        };
        list.iter().map(move |x| x * factor)
    }
}

/// The 6-DoF viscoelastic spring that lets a bone follow a tracked pose (Sec. 5).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Drive {
    /// Spring on the tracked point \[N/m\].
    pub stiffness: f64,
    /// Damper on it \[N s/m\].
    pub damping: f64,
    /// Spring on the orientation \[N m/rad\].
    pub angular_stiffness: f64,
    /// Damper on it \[N m s/rad\].
    pub angular_damping: f64,
}

impl Drive {
    /// Usual drive of a palm, which follows its tracker closely.
    pub const fn palm() -> Self {
        Self { stiffness: 1000.0, damping: 10.0, angular_stiffness: 10.0, angular_damping: 0.1 }
    }

    /// Usual drive of every other bone of a hand.
    pub const fn bone() -> Self {
        Self { stiffness: 200.0, damping: 1.0, angular_stiffness: 0.3, angular_damping: 0.003 }
    }
}

/// Cone that bounds friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cone {
    /// The exact circular Coulomb cone.
    Circular,
    /// The paper's linearised cone: each tangent bounded by itself (a four-sided pyramid,
    /// inscribed).
    Linearised,
}

/// Behaviour of the flesh that step 1 of the two-step scheme assumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FleshInStep1 {
    /// Flesh does not move, as in the paper (Eq. 10). Diverges when the coupling is stiff.
    Frozen,
    /// Flesh yields by its own inertia. Stable at couplings far stiffer than with frozen flesh.
    Lumped,
}

/// Solver that steps the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SolverKind {
    /// Eq. 9 with its joint rows and contacts, to a velocity tolerance: joints in minimal
    /// coordinates, flesh relative to its skinned motion.
    Monolithic,
    /// The paper's: joints first, then flesh, then contact by constraint anticipation (Sec. 4).
    TwoStep,
    /// Eq. 9 with its joint rows and contacts in one dense solve, which allocates and costs the
    /// cube of the unknowns: the solver that tests measure the others against. Only builds with the
    /// feature `reference` have it.
    #[cfg(any(test, feature = "reference"))]
    DenseReference,
}

impl SolverKind {
    /// The solver's name in reports.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Monolithic => "monolithic",
            Self::TwoStep => "two-step",
            #[cfg(any(test, feature = "reference"))]
            Self::DenseReference => "dense reference",
        }
    }
}

/// Mechanism that keeps a joint within its range.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum JointLimits {
    /// A bound that is not passed, whatever the load: an inequality in one system with contact. The
    /// two-step scheme has no such rows and uses springs.
    Rows,
    /// Stiff springs past the bound, as in the paper (Sec. 3.1): `JointDesc::limit_stiffness`.
    Springs,
}

/// Parameters of the solvers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverSettings {
    /// Solver that steps the world.
    pub kind: SolverKind,
    /// The monolithic solver's velocity error, estimated \[m/s\].
    pub velocity_tolerance: f64,
    /// Flesh in step 1.
    pub step1_flesh: FleshInStep1,
    /// Close the joints once more at the end of each step, where step 2 and contact have moved
    /// bones off them; the paper leaves that to the next step.
    pub close_joints: bool,
    /// Conjugate gradients stop when the residual has fallen to this part of the right-hand side.
    pub cg_tolerance: f64,
    /// Most iterations of the conjugate gradients.
    pub cg_iterations_max: u32,
    /// Constraint anticipation stops at this relative residual.
    pub contact_tolerance: f64,
    /// Most outer sweeps of constraint anticipation.
    pub contact_sweeps_max: u32,
    /// Most multiply-adds of a step that the monolithic solver spends on the law of contact; it
    /// then makes the last sweeps and reports what is left. No bound when `None`. A bound keeps a
    /// step's cost from growing where contact is hard: see
    /// [`StepReport::contact_cut_short`](crate::world::StepReport::contact_cut_short).
    pub contact_work_max: Option<u64>,
    /// Projected Gauss-Seidel passes over the contacts within one outer sweep.
    pub contact_inner_passes: u32,
    /// Friction cone.
    pub cone: Cone,
    /// Joint limits.
    pub limits: JointLimits,
    /// Points nearer than this become constraints, before they touch \[m\]; motion adds to it. For
    /// motion that a step does not foresee, as other contacts make it: a millimetre is 6 cm/s at 60
    /// steps a second. A wider one costs constraints that bear nothing.
    pub contact_margin: f64,
    /// A step that contact does not carry through (an overlap grows in it by half the margin or
    /// half the thickness of a thin rigid body, or it is off by a hundred tolerances) is made in
    /// halves, and these again, at most this many times: see `World::step`. By default the shortest
    /// part of a step at 60 Hz is half a millisecond: jammed hands obey the law of contact in steps
    /// of 1 ms, and miss it by up to a metre per second in parts of 2 ms.
    pub step_halvings_max: u32,
}

impl Default for SolverSettings {
    fn default() -> Self {
        Self {
            kind: SolverKind::Monolithic,
            velocity_tolerance: 1e-5,
            step1_flesh: FleshInStep1::Lumped,
            close_joints: true,
            cg_tolerance: 1e-5,
            cg_iterations_max: 500,
            contact_tolerance: 1e-4,
            contact_sweeps_max: 200,
            contact_work_max: None,
            contact_inner_passes: 2,
            cone: Cone::Circular,
            limits: JointLimits::Rows,
            contact_margin: 1e-3,
            step_halvings_max: 5,
        }
    }
}

/// Body that a pair setting refers to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BodyId {
    /// Index into `WorldDesc::rigids`.
    Rigid(u32),
    /// Index into `WorldDesc::softs`.
    Soft(u32),
}

/// An override for one pair of bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairRule {
    /// The pair, in any order.
    pub bodies: [BodyId; 2],
    /// Coulomb friction coefficient; `None` removes contact between the two.
    pub friction: Option<f64>,
}

/// Everything a world is built from.
#[derive(Clone, Debug)]
pub struct WorldDesc {
    /// Gravity, world \[m/s²\].
    pub gravity: Vec3,
    /// Time step \[s\].
    pub time_step: f64,
    /// Settings of the solver.
    pub solver: SolverSettings,
    /// Rigid bodies: bones and objects.
    pub rigids: Vec<RigidDesc>,
    /// Joints between rigid bodies. Bodies joined directly do not touch each other.
    pub joints: Vec<JointDesc>,
    /// Deformable bodies.
    pub softs: Vec<SoftDesc>,
    /// Drives, one entry per rigid body.
    pub drives: Vec<Option<Drive>>,
    /// Contact overrides. A pair of one deformable body with itself sets its own friction there.
    pub pairs: Vec<PairRule>,
    /// Pairs whose friction depends on load.
    pub friction_tables: Vec<FrictionTable>,
    /// Deformable bodies of which several parts count, each once.
    pub parts: Vec<BodyParts>,
    /// Deformable bodies whose tetrahedra are evaluated by patches, each once; the others' are
    /// evaluated one by one.
    pub patches: Vec<ElementPatches>,
    /// Skins of deformable bodies, each of which has one at most.
    pub skins: Vec<Skin>,
    /// Offsets of skinning targets by the pose of joints; each node has those of one joint at most.
    pub pose_offsets: Vec<PoseOffsets>,
    /// Indices into `softs`: those whose surface also touches itself. Hands are among them.
    pub self_contact: Vec<u32>,
}

impl Default for WorldDesc {
    fn default() -> Self {
        Self {
            gravity: Vec3::new(0.0, -9.81, 0.0),
            time_step: 1e-3,
            solver: SolverSettings::default(),
            rigids: Vec::new(),
            joints: Vec::new(),
            softs: Vec::new(),
            drives: Vec::new(),
            pairs: Vec::new(),
            friction_tables: Vec::new(),
            parts: Vec::new(),
            patches: Vec::new(),
            skins: Vec::new(),
            pose_offsets: Vec::new(),
            self_contact: Vec::new(),
        }
    }
}

/// Settings for putting a hand into a world.
#[derive(Clone, Debug)]
pub struct HandPlacement {
    /// Prefix of its body names.
    pub name: String,
    /// Pose of the model frame in the world.
    pub pose_WM: Pose,
    /// The flesh that the springs to the bones hold.
    pub coupling: CouplingKind,
    /// Coupling stiffness per volume of flesh, or of bone \[N/m⁴\].
    pub coupling_stiffness: f64,
    /// Coupling damping time \[s\].
    pub coupling_damping_time: f64,
    /// Rule by which two bones place the target of a node.
    pub skinning: Skinning,
    /// Drive of the root bone; `None` leaves it to physics.
    pub root_drive: Option<Drive>,
    /// Drive of every other bone.
    pub bone_drive: Option<Drive>,
    /// Bones touch other bodies with their solids (`HandModel::solids`), where flesh is crushed.
    pub solid_bones: bool,
    /// Nails are grown to the last bones (`HandModel::nail_nodes`).
    pub nails: bool,
}

/// Indices of a hand's parts in the world.
#[derive(Clone, Debug)]
pub struct HandHandle {
    /// Bones of the hand among the rigid bodies.
    pub bones: Range<u32>,
    /// Joints of the hand among the world's joints.
    pub joints: Range<u32>,
    /// Flesh of the hand among the deformable bodies.
    pub soft: u32,
}

impl WorldDesc {
    /// Adds a rigid body and returns its index.
    pub fn add_rigid(&mut self, rigid: RigidDesc) -> u32 {
        self.rigids.push(rigid);
        self.drives.push(None);
        (self.rigids.len() - 1) as u32
    }

    /// The deformable body that a rigid body is a bone of, and the part of it that it is in.
    pub fn flesh_of_bone(&self, rigid: u32) -> Option<(u32, u8)> {
        self.parts.iter().find_map(|parts| {
            let bone = parts.bones.iter().find(|(bone, _)| *bone == rigid)?;
            Some((parts.soft, bone.1))
        })
    }

    /// Adds a deformable body and returns its index.
    pub fn add_soft(&mut self, soft: SoftDesc) -> u32 {
        self.softs.push(soft);
        (self.softs.len() - 1) as u32
    }

    /// Has the tetrahedra of deformable body `soft` evaluated by
    /// [`patches`](crate::model::patches), as flesh that hangs on bone should be.
    ///
    /// # Panics
    /// When there is no deformable body `soft`.
    pub fn group_into_patches(&mut self, soft: u32) {
        let flesh = &self.softs[soft as usize].flesh;
        let of_tet = patches(&flesh.nodes, &flesh.tets, &flesh.materials, &flesh.relaxation);
        self.patches.push(ElementPatches { soft, of_tet });
    }

    /// Adds a hand at rest in `placement.pose_WM`; each digit is a part of it (`Digit::part`). Its
    /// fingers and palm touch each other.
    pub fn add_hand(&mut self, hand: &HandModel, placement: &HandPlacement) -> HandHandle {
        let bone0 = self.rigids.len() as u32;
        for (i, bone) in hand.bones.iter().enumerate() {
            let solid = hand.solids.get(i).filter(|_| placement.solid_bones);
            self.add_rigid(RigidDesc {
                name: format!("{}/{}", placement.name, bone.name),
                motion: Motion::Dynamic,
                mass: bone.mass,
                inertia: bone.inertia,
                pose_WB: placement.pose_WM * bone.pose_MB,
                velocity_W: Vec3::zeros(),
                angular_velocity_W: Vec3::zeros(),
                shape: solid.map(|solid| solid.shape.clone()),
                pose_BS: solid.map_or(Pose::identity(), |solid| solid.pose_BS),
                friction: hand.flesh.friction,
            });
            self.drives[bone0 as usize + i] =
                if i == 0 { placement.root_drive } else { placement.bone_drive };
        }

        let joint0 = self.joints.len() as u32;
        self.joints.extend(hand.joints.iter().map(|joint| JointDesc {
            name: format!("{}/{}", placement.name, joint.name),
            parent: joint.parent.map(|p| p + bone0),
            child: joint.child + bone0,
            ..joint.clone()
        }));

        let (bindings, volumes) = hand.held(placement.coupling, placement.nails);
        let bindings = bindings
            .iter()
            .map(|b| Binding { bones: b.bones.map(|j| j + bone0), weights: b.weights })
            .collect();
        let soft = self.add_soft(SoftDesc {
            name: placement.name.clone(),
            flesh: hand.flesh.clone(),
            pose_WM: placement.pose_WM,
            velocity_W: Vec3::zeros(),
            coupling: Some(Coupling {
                bindings,
                springs: Springs::PerVolume { stiffness: placement.coupling_stiffness, volumes },
                damping_time: placement.coupling_damping_time,
                skinning: placement.skinning,
            }),
        });
        self.parts.push(BodyParts {
            soft,
            vertices: hand.collision_digits.iter().map(|digit| digit.part()).collect(),
            bones: (bone0..).zip(hand.bones.iter().map(|bone| bone.digit.part())).collect(),
        });
        self.self_contact.push(soft);
        HandHandle {
            bones: bone0..self.rigids.len() as u32,
            joints: joint0..self.joints.len() as u32,
            soft,
        }
    }
}
