//! Bones that turn far from their frame: joints stay closed, and forces keep their levers.
//!
//! The response of a frame is linear: a bone that turns moves on the tangent of its arc. What
//! contact does between two frames turns bones by little, but the hand in empty air is answered by
//! the frame of a hand that holds something, and nothing holds its fingers off there. Off their
//! arcs, couplings would pull at them with forces that no hand has. With a joint at `a_P` in the
//! parent and `a_C` in the child, arms `r = R₀ a` in the frame's rotation R₀, and a bone that
//! turned by the rotation vector θ:
//!
//! ```text
//! places:   x_C is off its tangent by as much as x_P is, and by s_P - s_C,   s = R a - r - θ × r
//! torques:  t_P × F on the parent,   -t_C × F on the child,                  t = R a - r
//! ```
//!
//! F is the force with which couplings pull at the child and all that it carries. Where contact
//! bears load in the frame, it balances them there: of such a hand only what has changed since
//! counts. Besides, rotations do not add up: a coupling turns its bone by the vector between two
//! rotations, the response by the difference of two vectors.
//!
//! Each tick finds these at poses that go half of the way to the bones in every tick, and the
//! response takes them as loads. Where that comes to rest, forces and torques balance on the arcs.
//! It does so up to [`FARTHEST`], beyond which bones count as turned so far: found by trial on
//! fingers as those of this module's test, some of which do not come to rest beyond it, nor without
//! halving.
//!
//! Not included: axes of joints stay as in the frame, as flesh answers as it did there; and
//! contacts are found on the tangents, from which bones that something holds go by little within a
//! frame.

use crate::lanes::{turn_by, turns_between};
use crate::shared::SharedConstraints;
use crate::turn::rotation_vector;
use crate::{BoneFrame, RigidState};
use thenar_core::model::Drive;
use thenar_core::{Pose, Quat, Vec3};

/// Turn beyond which a bone's arc counts as ended \[rad\].
const FARTHEST: f64 = 0.5;

/// A joint of two bones: its place in the frame of each \[m\].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct BoneJoint {
    /// The bone nearer to the palm; its number is lower.
    pub parent: usize,
    /// The bone that the joint leads.
    pub child: usize,
    /// Place in the parent.
    pub at_parent: Vec3,
    /// Place in the child.
    pub at_child: Vec3,
}

/// Turn of a bone since its frame.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
struct Turn {
    /// Rotation vector, world, and no longer than [`FARTHEST`].
    whole: Vec3,
    by: Vec3,
    /// Rotation of the bone, turned by that.
    to: Quat,
    /// Part of second-order changes that counts: 1 up to [`FARTHEST`].
    part: f64,
}

impl Turn {
    /// By the vector `whole` from one rotation to another.
    fn new(whole: Vec3, from: &Quat, to: Quat) -> Self {
        let square = whole.norm_squared();
        if square <= FARTHEST * FARTHEST {
            return Self { whole, by: whole, to, part: 1.0 };
        }
        let part = FARTHEST / square.sqrt();
        if !part.is_finite() {
            return Self { whole, by: Vec3::zeros(), to: *from, part: 0.0 };
        }
        let by = whole * part;
        Self { whole, by, to: Quat::from_scaled_axis(by) * from, part: part * part }
    }

    /// Way of an arm's end, and how far that is from the tangent \[m\]; `arm` is in the bone, `was`
    /// in the world before the turn.
    fn of_arm(&self, arm: &Vec3, was: &Vec3) -> [Vec3; 2] {
        let way = self.to * arm - was;
        [way, way - self.by.cross(was)]
    }
}

/// Pose of a bone under shared constraints over the last ticks, later ones weighing more, and the
/// pull of its coupling.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct Settled {
    pose_WB: Pose,
    /// Force of its coupling there \[N\].
    pull_W: Vec3,
}

impl Settled {
    /// A bone that nothing pulls at yet.
    pub fn at(pose_WB: Pose) -> Self {
        Self { pose_WB, pull_W: Vec3::zeros() }
    }

    /// Goes half of the way to this pose, with this force.
    fn follow(&mut self, pose_WB: &Pose, pull_W: &Vec3) {
        let half =
            Self { pose_WB: halfway(&self.pose_WB, pose_WB), pull_W: (self.pull_W + pull_W) * 0.5 };
        let sound = half.pose_WB.is_finite() && half.pull_W.iter().all(|x| x.is_finite());
        *self = if sound { half } else { Self::at(*pose_WB) };
    }
}

/// The joints of a hand, and work space.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct Arcs {
    /// Parents first, one for each child.
    joints: Vec<BoneJoint>,
    turns: Vec<Turn>,
    /// Arms of each joint in parent and child, in the frame's rotations \[m\]; ways of their ends
    /// with the turns, and how far these are from the tangents \[m\].
    arms: Vec<[Vec3; 2]>,
    ways: Vec<[[Vec3; 2]; 2]>,
    /// Turn from each bone to its target in the frame \[rad\].
    leads: Vec<Vec3>,
    /// Force of each coupling in the frame \[N\].
    pulls: Vec<Vec3>,
    /// Turns of the bones, of the proxies since the frame, and from bones to proxies \[rad\].
    wholes: Vec<Vec3>,
    turned: Vec<Vec3>,
    ahead: Vec<Vec3>,
    /// Offsets of bones from their tangents \[m\], and the velocities at which they leave them, or
    /// moved before \[m/s\].
    off: Vec<Vec3>,
    leaving: Vec<Vec3>,
    /// Forces of couplings on each bone and all that it carries \[N\], and torques from levers \[N
    /// m\].
    forces: Vec<Vec3>,
    torques: Vec<Vec3>,
}

impl Arcs {
    /// For a hand of this size, without joints.
    pub fn new(bones: usize) -> Self {
        let none = vec![Vec3::zeros(); bones];
        Self {
            joints: Vec::with_capacity(bones),
            turns: vec![Turn::new(Vec3::zeros(), &Quat::identity(), Quat::identity()); bones],
            arms: Vec::with_capacity(bones),
            ways: Vec::with_capacity(bones),
            leads: none.clone(),
            pulls: none.clone(),
            wholes: none.clone(),
            turned: none.clone(),
            ahead: none.clone(),
            off: none.clone(),
            leaving: none.clone(),
            forces: none.clone(),
            torques: none,
        }
    }

    /// Takes these joints from the next frame on. Of those between bones that there are, with the
    /// parent's number below the child's, the first of each child counts.
    pub fn set_joints(&mut self, joints: impl IntoIterator<Item = BoneJoint>) {
        self.joints.clear();
        self.arms.clear();
        for joint in joints {
            let tied = self.joints.iter().any(|other| other.child == joint.child);
            if joint.parent < joint.child && joint.child < self.turns.len() && !tied {
                self.joints.push(joint);
            }
        }
        self.joints.sort_by_key(|joint| joint.child);
    }

    /// Starts from a new frame.
    pub fn begin(&mut self, frame: &BoneFrame) {
        let response = &frame.response;
        let ends = frame.bones.iter().zip(&response.targets).zip(&response.springs);
        let known = self.leads.iter_mut().zip(&mut self.pulls);
        for ((lead, force), ((bone, target), spring)) in known.zip(ends) {
            let turn = target.pose_WB.rotation * bone.pose_WB.rotation.inverse();
            *lead = rotation_vector(&turn);
            *force = pull(spring, target, &bone.pose_WB.position);
        }
        self.arms.clear();
        let bones = &frame.bones;
        if bones.len() == self.turns.len() {
            self.arms.extend(self.joints.iter().map(|joint| {
                let of = |bone: usize, arm: &Vec3| bones[bone].pose_WB.rotation * arm;
                [of(joint.parent, &joint.at_parent), of(joint.child, &joint.at_child)]
            }));
        }
    }

    /// True if there are joints, a frame has begun with them, and frame and lists are of the hand's
    /// size.
    fn fits(&self, frame: &BoneFrame, bones: usize) -> bool {
        let all = self.turns.len();
        let known = frame.bones.len() == all && frame.response.springs.len() == all;
        let begun = self.arms.len() == self.joints.len();
        !self.joints.is_empty() && begun && known && bones == all
    }

    /// Notes how bones at these rotations have turned, by `wholes` of at most half a turn, and how
    /// far they are from their tangents.
    fn turn(&mut self, frame: &BoneFrame, rotation: impl Fn(usize) -> Quat) {
        for (i, (turn, whole)) in self.turns.iter_mut().zip(&self.wholes).enumerate() {
            *turn = Turn::new(*whole, &frame.bones[i].pose_WB.rotation, rotation(i));
        }
        self.off.fill(Vec3::zeros());
        self.ways.clear();
        for (joint, [of_parent, of_child]) in self.joints.iter().zip(&self.arms) {
            let parent = self.turns[joint.parent].of_arm(&joint.at_parent, of_parent);
            let child = self.turns[joint.child].of_arm(&joint.at_child, of_child);
            self.ways.push([parent, child]);
            let more = parent[1] - child[1];
            let more = if more.iter().all(|x| x.is_finite()) { more } else { Vec3::zeros() };
            self.off[joint.child] = self.off[joint.parent] + more;
        }
    }

    /// Tells the response what bones do, where they settled, that it does not know, with proxies at
    /// these.
    pub fn bend(
        &mut self,
        frame: &BoneFrame,
        proxies: &[RigidState],
        settled: &[Settled],
        shared: &mut SharedConstraints,
    ) {
        if !self.fits(frame, proxies.len()) {
            shared.straighten();
            return;
        }
        let response = &frame.response;
        let now = |i: usize| settled[i].pose_WB.rotation;
        let proxy = |i: usize| proxies[i].pose_WB.rotation;
        turns_between(|i| [now(i), frame.bones[i].pose_WB.rotation], &mut self.wholes);
        turns_between(|i| [proxy(i), response.targets[i].pose_WB.rotation], &mut self.turned);
        turns_between(|i| [proxy(i), now(i)], &mut self.ahead);
        self.turn(frame, now);
        let balanced = shared.bears(response);
        for (i, (bone, force)) in settled.iter().zip(&mut self.forces).enumerate() {
            *force = if balanced { bone.pull_W - self.pulls[i] } else { bone.pull_W };
        }
        self.torques.fill(Vec3::zeros());
        for (joint, [[parent, _], [child, _]]) in self.joints.iter().zip(&self.ways).rev() {
            let force = self.forces[joint.child];
            self.torques[joint.parent] += parent.cross(&force);
            self.torques[joint.child] -= child.cross(&force);
            self.forces[joint.parent] += force;
        }
        for (i, spring) in response.springs.iter().enumerate() {
            let turned = self.turned[i];
            let linear = self.leads[i] + turned - self.turns[i].whole;
            let more = (self.ahead[i] - linear) * self.turns[i].part;
            let torque = self.torques[i] + more * spring.angular_stiffness;
            let sound = torque.iter().all(|x| x.is_finite());
            let torque = if sound { torque } else { Vec3::zeros() };
            shared.bend(i, self.off[i], torque, turned);
        }
    }

    /// Puts bones where the response has them after another `h` \[s\] at their velocities, on their
    /// arcs; `settled` follows them.
    pub fn place(
        &mut self,
        frame: &BoneFrame,
        (proxies, shared): (&[RigidState], &SharedConstraints),
        h: f64,
        settled: &mut [Settled],
        bones: &mut [RigidState],
    ) {
        let fits = self.fits(frame, bones.len());
        for (before, bone) in self.leaving.iter_mut().zip(&*bones) {
            *before = bone.velocity_W;
        }
        shared.place(&frame.bones, bones);
        if fits {
            self.wholes.iter_mut().enumerate().for_each(|(i, whole)| *whole = shared.turn(i));
            self.turn(frame, |i| bones[i].pose_WB.rotation);
            for (i, (settled, bone)) in settled.iter_mut().zip(&*bones).enumerate() {
                let position = bone.pose_WB.position + self.off[i];
                let on_arc = Pose::new(position, bone.pose_WB.rotation);
                let spring = &frame.response.springs[i];
                let pull_W = pull(spring, &proxies[i], &position);
                settled.follow(&on_arc, &pull_W);
            }
        }
        move_on(bones, h);
        if !fits {
            return;
        }
        let now = |i: usize| bones[i].pose_WB.rotation;
        turns_between(|i| [now(i), frame.bones[i].pose_WB.rotation], &mut self.wholes);
        self.turn(frame, now);
        // The first tick of a frame knows no velocities of its own: that of the last tick goes on.
        let is_rated = shared.is_rated();
        if is_rated {
            self.leave(bones);
        }
        for (i, bone) in bones.iter_mut().enumerate() {
            bone.pose_WB.position += self.off[i];
            let along = if is_rated { bone.velocity_W } else { Vec3::zeros() };
            bone.velocity_W = along + self.leaving[i];
        }
    }

    /// Finds how fast bones with these velocities on their tangents leave them.
    fn leave(&mut self, bones: &[RigidState]) {
        let leaves = |bone: usize, way: &Vec3| {
            let leaves = bones[bone].angular_velocity_W.cross(way);
            let counts = self.turns[bone].part == 1.0 && leaves.iter().all(|x| x.is_finite());
            if counts { leaves } else { Vec3::zeros() }
        };
        self.leaving.fill(Vec3::zeros());
        for (joint, [[parent, _], [child, _]]) in self.joints.iter().zip(&self.ways) {
            let more = leaves(joint.parent, parent) - leaves(joint.child, child);
            self.leaving[joint.child] = self.leaving[joint.parent] + more;
        }
    }
}

/// Moves bones on for `h` \[s\] at their velocities.
fn move_on(bones: &mut [RigidState], h: f64) {
    turn_by(bones, |_, bone| (bone.angular_velocity_W * h, bone.pose_WB.rotation));
    for bone in bones {
        bone.pose_WB.position += bone.velocity_W * h;
    }
}

/// Force with which a coupling to this proxy pulls at a bone at this place \[N\]; none where the
/// proxy is not finite.
fn pull(spring: &Drive, proxy: &RigidState, bone: &Vec3) -> Vec3 {
    let way = proxy.pose_WB.position - bone;
    if proxy.is_finite() { way * spring.stiffness } else { Vec3::zeros() }
}

/// The pose in the middle of two.
fn halfway(from: &Pose, to: &Pose) -> Pose {
    let [a, b] = [from, to].map(|pose| pose.rotation.into_inner());
    let b = if a.dot(&b) < 0.0 { -b } else { b };
    Pose::new((from.position + to.position) * 0.5, Quat::new_normalize(a + b))
}

#[cfg(test)]
#[path = "arcs_tests.rs"]
mod tests;
