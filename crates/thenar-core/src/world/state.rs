//! Changing data of a world: the state that a snapshot must hold, and the step's scratch memory.

use crate::capacity_vec::CapacityVec;
use crate::contact::{Contact, HeldPlace, SeenSides};
use crate::coupling::{BoneSystem, KernelValue};
use crate::flesh::Faded;
use crate::math::{Mat6, Pose, Vec3, Vec6, to_turn};
use crate::model::WorldDesc;
use crate::skeleton::AxisState;
use crate::solver::{
    Anticipation, Articulated, BlockDiagonal, BlockMatrix, CgWorkspace, ContactRows, Failure,
    Islands, JointBlock, PushTarget,
};
use crate::world::friction::{PatchKey, patches_max};
use crate::world::hash::Hasher;
use crate::world::kinematic_advance::UnjointedMotion;
use crate::world::limits::{self, LimitRow};
use crate::world::{ContactPoint, Model};

/// A state beyond these is taken for a failed step, not for motion \[m, m/s, rad/s\]: products of
/// numbers within them stay finite, so that a step can always go on from such a state.
const POSITION_MAX: f64 = 1e9;
const SPEED_MAX: f64 = 1e9;

/// The state at one instant.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State {
    /// Time \[s\].
    pub time: f64,
    /// Pose of each rigid body.
    pub poses_WB: Vec<Pose>,
    /// Position of each node, world \[m\].
    pub x: Vec<Vec3>,
    /// Velocities, as blocks: linear and angular of each rigid body, then nodes.
    pub v: Vec<Vec3>,
    /// Change of the velocities by contact in the last step: the next one's first guess.
    pub contact_change: Vec<Vec3>,
    /// Contact impulses of the last step by feature, sorted \[N s\], world, on A.
    pub impulses: CapacityVec<(u64, Vec3)>,
    /// From which side surface vertices came near other bodies in the last step.
    pub sides: SeenSides,
    /// Impulses of joint limits in the last step, per joint and axis, on the child \[N m s\].
    pub limit_impulses: Vec<[f64; 2]>,
    /// Normal forces of the last step in patches whose friction depends on them, sorted \[N\].
    pub patch_loads: CapacityVec<(PatchKey, f64)>,
    /// Stress that has faded in elements with memory: element after element, term after term.
    pub faded: Vec<Faded>,
}

impl State {
    /// The state a description starts in.
    pub fn new(desc: &WorldDesc, model: &Model) -> Self {
        let rigids = desc.rigids.len();
        let mut v = vec![Vec3::zeros(); model.rows()];
        for (b, rigid) in desc.rigids.iter().enumerate() {
            v[2 * b] = rigid.velocity_W;
            v[2 * b + 1] = rigid.angular_velocity_W;
        }
        let mut x = Vec::with_capacity(model.flesh.mass.len());
        for (soft, nodes) in desc.softs.iter().zip(&model.soft_nodes) {
            x.extend(soft.flesh.nodes.iter().map(|n| soft.pose_WM.point(n)));
            v[2 * rigids + nodes.start..2 * rigids + nodes.end].fill(soft.velocity_W);
        }
        let mut state = Self {
            time: 0.0,
            poses_WB: desc.rigids.iter().map(|r| r.pose_WB).collect(),
            x,
            contact_change: vec![Vec3::zeros(); v.len()],
            v,
            impulses: CapacityVec::default(),
            sides: SeenSides::default(),
            limit_impulses: vec![[0.0; 2]; model.joints.len()],
            patch_loads: CapacityVec::with_capacity(patches_max(model)),
            faded: vec![Faded::default(); model.flesh.memory.len()],
        };
        state.hold(model);
        state.normalize_rotations();
        state
    }

    /// Held nodes do not move along their held axes.
    fn hold(&mut self, model: &Model) {
        let row0 = 2 * model.rigids.len();
        for (node, axes) in &model.held {
            for axis in 0..3 {
                let v = &mut self.v[row0 + *node as usize][axis];
                if axes[axis] && *v != 0.0 {
                    *v = 0.0;
                }
            }
        }
    }

    /// Makes rotations of what is one but for its length.
    fn normalize_rotations(&mut self) {
        for pose in &mut self.poses_WB {
            pose.rotation = to_turn(&pose.rotation).unwrap_or(pose.rotation);
        }
    }

    /// Sorts lists that are searched, and stops held nodes along their axes: a state that was read
    /// back may say otherwise.
    pub(super) fn normalize(&mut self, model: &Model) {
        self.hold(model);
        self.normalize_rotations();
        // What is in order stays as it is, to the bit.
        if !self.impulses.is_sorted_by_key(|(key, _)| *key) {
            self.impulses.sort_by_key(|(key, _)| *key);
        }
        if !self.patch_loads.is_sorted_by_key(|(key, _)| *key) {
            self.patch_loads.sort_by_key(|(key, _)| *key);
        }
    }

    /// Scales what contact and limits remember of the last step to a step `ratio` times as long:
    /// the same forces give impulses in proportion. What is no number then is forgotten.
    pub fn scale_impulses(&mut self, ratio: f64) {
        let scaled = |x: f64| if (x * ratio).is_finite() { x * ratio } else { 0.0 };
        for (_, impulse) in &mut self.impulses {
            *impulse = impulse.map(scaled);
        }
        self.limit_impulses.as_flattened_mut().iter_mut().for_each(|x| *x = scaled(*x));
        self.contact_change.iter_mut().for_each(|change| *change = change.map(scaled));
    }

    /// Becomes a copy of another state of the same world.
    pub fn copy_from(&mut self, other: &Self) {
        self.copy_motion(other);
        self.sides.copy_from(&other.sides);
        self.faded.clone_from(&other.faded);
    }

    /// All but the sides and what tissue remembers, which change only when a part of a step is
    /// accepted.
    pub(super) fn copy_motion(&mut self, other: &Self) {
        self.time = other.time;
        self.poses_WB.copy_from_slice(&other.poses_WB);
        self.x.copy_from_slice(&other.x);
        self.v.copy_from_slice(&other.v);
        self.contact_change.copy_from_slice(&other.contact_change);
        self.impulses.clear();
        self.impulses.extend_from_slice(&other.impulses);
        self.limit_impulses.copy_from_slice(&other.limit_impulses);
        self.patch_loads.clone_from(&other.patch_loads);
    }

    /// Checks that a step can go on from this state.
    ///
    /// # Errors
    /// The state is not sound.
    pub fn check(&self) -> Result<(), Failure> {
        if self.is_sound() { Ok(()) } else { Err(Failure::NotFinite) }
    }

    /// True when every number is finite and nothing is farther than 1e9 m or faster than 1e9 m/s.
    pub fn is_sound(&self) -> bool {
        self.poses_WB.iter().all(is_sound_pose)
            && self.x.iter().all(is_sound_position)
            && self.v.iter().all(is_sound_velocity)
    }

    /// True when besides all that contact and limits remember is finite.
    pub fn is_finite(&self) -> bool {
        let finite = |v: &Vec3| v.iter().all(|v| v.is_finite());
        self.is_sound()
            && self.time.is_finite()
            && self.contact_change.iter().all(finite)
            && self.impulses.iter().all(|(_, impulse)| finite(impulse))
            && self.limit_impulses.iter().flatten().all(|impulse| impulse.is_finite())
            && self.patch_loads.iter().all(|(_, load)| load.is_finite())
            && self.faded.as_flattened().iter().all(|faded| faded.is_finite())
            && self.sides.as_slice().iter().all(|side| finite(&side.normal) && finite(&side.place))
            && self.sides.places().iter().all(HeldPlace::is_finite)
    }

    /// A hash of every bit of the state: equal states, equal hashes.
    pub fn hash(&self) -> u64 {
        let mut hash = Hasher::default();
        hash.number(self.time);
        for vectors in [&self.x, &self.v, &self.contact_change] {
            hash.vectors(vectors);
        }
        for pose in &self.poses_WB {
            hash.vectors(&[pose.position]);
            pose.rotation.coords.iter().for_each(|x| hash.number(*x));
        }
        for (key, impulse) in &self.impulses {
            hash.word(*key);
            hash.vectors(&[*impulse]);
        }
        for side in self.sides.as_slice() {
            hash.word(u64::from(side.vertex) << 32 | u64::from(side.other));
            hash.vectors(&[side.normal, side.place]);
        }
        for place in self.sides.places() {
            place.key.iter().for_each(|k| hash.word(u64::from(*k)));
            place.numbers().for_each(|x| hash.number(x));
        }
        self.limit_impulses.iter().flatten().for_each(|x| hash.number(*x));
        for (key, load) in &self.patch_loads {
            key.iter().for_each(|k| hash.word(u64::from(*k)));
            hash.number(*load);
        }
        self.faded.as_flattened().iter().for_each(|x| hash.number(*x));
        hash.finish()
    }
}

/// True for a place that a step can go on from.
pub fn is_sound_position(x: &Vec3) -> bool {
    x.iter().all(|x| x.abs() <= POSITION_MAX)
}

/// True for a velocity \[m/s or rad/s\] that a step can go on from.
pub fn is_sound_velocity(v: &Vec3) -> bool {
    v.iter().all(|v| v.abs() <= SPEED_MAX)
}

/// True for a pose that a step can go on from.
pub fn is_sound_pose(pose: &Pose) -> bool {
    is_sound_position(&pose.position) && pose.is_finite()
}

/// Memory that a step works in: nobody reads afterwards what is in it. The lists of contacts and
/// limits are lent by `Readout`, which has them between steps. (`coupled` says what of `A` is to be
/// cleared.)
#[derive(Clone, Debug)]
pub struct Scratch {
    /// The system matrix A.
    pub A: BlockMatrix,
    /// True when the blocks of A between bones and flesh may hold numbers.
    pub coupled: bool,
    /// Right-hand side b of the system.
    pub b: Vec<Vec3>,
    /// Bones' part of `b`, without the joint impulses of step 1.
    pub b_kept: Vec<Vec3>,
    /// Inverse D of the block diagonal of A.
    pub D: BlockDiagonal,
    /// The bones' system of step 1.
    pub bones: BoneSystem,
    /// Diagonal of the bones' system, kept while a solve overwrites it.
    pub S_kept: Vec<Mat6>,
    /// Linearised joints.
    pub joints: Vec<JointBlock>,
    /// Measured axes of the joints.
    pub axes: Vec<[Option<AxisState>; 2]>,
    /// Contribution of prescribed bodies to their rates.
    pub known: Vec<Vec6>,
    /// Step 1's solver.
    pub articulated: Articulated,
    /// Step 1: right-hand sides and results.
    pub r: Vec<Vec6>,
    /// Right-hand side of the joint rows.
    pub c: Vec<Vec6>,
    /// Change of bone velocities in step 1.
    pub dv: Vec<Vec6>,
    /// Joint impulses.
    pub lambda: Vec<Vec6>,
    /// Nodal mass that step 1 sees.
    pub step1_mass: Vec<f64>,
    /// Shares of offsets by pose.
    pub shares: Vec<KernelValue>,
    /// Conjugate gradients.
    pub cg: CgWorkspace,
    /// Bounds of joints that have rows.
    pub limits: CapacityVec<LimitRow>,
    /// Contacts found.
    pub found: CapacityVec<Contact>,
    /// The sides seen with them.
    pub sides: SeenSides,
    /// Rows of the contacts found.
    pub rows: ContactRows,
    /// Contact solver.
    pub anticipation: Anticipation,
    /// Contacts as reported.
    pub contacts: CapacityVec<ContactPoint>,
    /// Areas of the contacts reported \[m²\].
    pub areas: CapacityVec<f64>,
    /// Contacts and limits that touch reads, by weight.
    pub chosen: CapacityVec<u32>,
    /// Depth of each rigid, then each deformable body in others when the part began \[m\].
    pub depths: Vec<f64>,
    /// Gaps of the contacts reported at the end of the step \[m\]; before, those of all rows at its
    /// start.
    pub gaps: CapacityVec<f64>,
    /// Wishes of all rows for the pseudo-velocity that undoes overlaps.
    pub wishes: CapacityVec<PushTarget>,
    /// This pseudo-velocity: positions move by it, besides the velocities \[m/s\].
    pub push: Vec<Vec3>,
    /// True when this step has one.
    pub pushes: bool,
    /// Position to which velocities and pushes would have taken each node on a straight way.
    pub straight: Vec<Vec3>,
    /// Collision vertices of all deformable bodies, world, and their velocities.
    pub vertices: Vec<Vec3>,
    /// Velocities of these.
    pub vertex_velocities: Vec<Vec3>,
    /// Displacements of the vertices since the start of the part \[m\].
    pub vertex_ways: Vec<Vec3>,
    /// Groups of bodies that move each other.
    pub islands: Islands,
    /// Motion without joints, and memory to close these.
    pub moved: UnjointedMotion,
    /// The state before the step.
    pub before: State,
}

/// Pairs of block rows that joints and coupling tie.
fn ties(model: &Model) -> impl Iterator<Item = [usize; 2]> {
    let joints = model.joints.iter();
    let jointed = joints.filter_map(|j| j.parent.map(|p| [2 * p as usize, 2 * j.child as usize]));
    let row0 = 2 * model.rigids.len();
    let coupled = model.coupling.bound.iter().flat_map(move |bound| {
        bound.bones.map(|bone| [row0 + bound.node as usize, 2 * bone as usize])
    });
    jointed.chain(coupled)
}

impl Scratch {
    /// Room for everything a step of this model needs, but for what `Readout` lends.
    pub fn new(model: &Model, state: &State, [contacts_max, sides_max]: [usize; 2]) -> Self {
        let rigids = model.rigids.len();
        let nodes = model.flesh.mass.len();
        let rows = model.rows();
        let moves: Vec<bool> = model.rigids.iter().map(|r| r.moves).collect();
        let ends: Vec<(Option<u32>, u32)> =
            model.joints.iter().map(|j| (j.parent, j.child)).collect();
        let joint_rows: Vec<usize> = model.joints.iter().map(|j| j.kind.rows()).collect();
        let mut before = State { faded: Vec::new(), ..state.clone() };
        before.impulses.reserve(contacts_max);
        before.patch_loads.reserve(patches_max(model));
        Self {
            A: model.pattern.clone(),
            coupled: false,
            b: vec![Vec3::zeros(); rows],
            b_kept: vec![Vec3::zeros(); 2 * rigids],
            D: BlockDiagonal::new(rigids, nodes),
            bones: BoneSystem::new(rigids, model.joints.len()),
            S_kept: vec![Mat6::zeros(); rigids],
            joints: vec![JointBlock::empty(); model.joints.len()],
            axes: vec![[None; 2]; model.joints.len()],
            known: vec![Vec6::zeros(); model.joints.len()],
            articulated: Articulated::new(&moves, &ends, &joint_rows),
            r: vec![Vec6::zeros(); rigids],
            c: vec![Vec6::zeros(); model.joints.len()],
            dv: vec![Vec6::zeros(); rigids],
            lambda: vec![Vec6::zeros(); model.joints.len()],
            step1_mass: vec![0.0; nodes],
            shares: Vec::with_capacity(model.coupling.offsets.sample_count()),
            cg: CgWorkspace::new(rows),
            limits: CapacityVec::default(),
            found: CapacityVec::default(),
            sides: SeenSides::with_capacity(sides_max),
            rows: ContactRows::with_capacity(rigids, 0),
            anticipation: Anticipation::new(rigids, nodes),
            contacts: CapacityVec::default(),
            areas: CapacityVec::with_capacity(contacts_max),
            chosen: CapacityVec::with_capacity(contacts_max + limits::rows_max(model)),
            depths: vec![0.0; rigids + model.soft_nodes.len()],
            gaps: CapacityVec::with_capacity(contacts_max + limits::rows_max(model)),
            wishes: CapacityVec::with_capacity(contacts_max + limits::rows_max(model)),
            push: Vec::new(),
            pushes: false,
            straight: vec![Vec3::zeros(); state.x.len()],
            vertices: vec![Vec3::zeros(); model.vertices.len()],
            vertex_velocities: vec![Vec3::zeros(); model.vertices.len()],
            vertex_ways: vec![Vec3::zeros(); model.vertices.len()],
            islands: Islands::new(&moves, &model.pattern, ties(model)),
            moved: UnjointedMotion::new(model),
            before,
        }
    }

    /// Sets A to zero.
    pub fn clear_matrix(&mut self) {
        self.A.clear();
        self.coupled = false;
    }

    /// Keeps a copy of what a step changes before it is known to be sound, to go back to when it
    /// fails.
    pub fn remember(&mut self, state: &State) {
        self.before.copy_motion(state);
    }

    /// The pseudo-velocity of this step, where there is one.
    pub fn push(&self) -> Option<&[Vec3]> {
        self.pushes.then_some(&self.push)
    }

    /// The last step's contacts and limits are not those of the state.
    pub fn forget_contacts(&mut self) {
        self.found.clear();
        self.limits.clear();
        self.rows.clear();
        self.contacts.clear();
    }
}
