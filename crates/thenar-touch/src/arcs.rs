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
    /// Rotation of the bone in the frame, and turned by that.
    from: Quat,
    to: Quat,
    /// Part of second-order changes that counts: 1 up to [`FARTHEST`].
    part: f64,
}

impl Turn {
    fn between(from: Quat, to: Quat) -> Self {
        let whole = rotation_vector(&(to * from.inverse()));
        let angle = whole.norm();
        if angle <= FARTHEST {
            return Self { whole, by: whole, from, to, part: 1.0 };
        }
        let part = FARTHEST / angle;
        if !part.is_finite() {
            return Self { whole, by: Vec3::zeros(), from, to: from, part: 0.0 };
        }
        let by = whole * part;
        Self { whole, by, from, to: Quat::from_scaled_axis(by) * from, part: part * part }
    }

    /// Way of this arm's end, and how far that is from the tangent \[m\].
    fn of_arm(&self, arm: &Vec3) -> [Vec3; 2] {
        let was = self.from * arm;
        let way = self.to * arm - was;
        [way, way - self.by.cross(&was)]
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
    /// Turn from each bone to its target in the frame \[rad\].
    leads: Vec<Vec3>,
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
            turns: vec![Turn::between(Quat::identity(), Quat::identity()); bones],
            leads: none.clone(),
            off: none.clone(),
            leaving: none.clone(),
            forces: none.clone(),
            torques: none,
        }
    }

    /// Takes these joints. Of those between bones that there are, with the parent's number below
    /// the child's, the first of each child counts.
    pub fn set_joints(&mut self, joints: impl IntoIterator<Item = BoneJoint>) {
        self.joints.clear();
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
        let both = frame.bones.iter().zip(&frame.response.targets);
        for (lead, (bone, target)) in self.leads.iter_mut().zip(both) {
            *lead = between(target.pose_WB.rotation, bone.pose_WB.rotation);
        }
    }

    /// True if there are joints, and frame and lists are of the hand's size.
    fn fits(&self, frame: &BoneFrame, bones: usize) -> bool {
        let all = self.turns.len();
        let known = frame.bones.len() == all && frame.response.springs.len() == all;
        !self.joints.is_empty() && known && bones == all
    }

    /// Notes how bones at these rotations have turned, and how far they are from their tangents.
    fn turn(&mut self, frame: &BoneFrame, rotations: impl Iterator<Item = Quat>) {
        let both = frame.bones.iter().zip(rotations);
        for (turn, (was, now)) in self.turns.iter_mut().zip(both) {
            *turn = Turn::between(was.pose_WB.rotation, now);
        }
        self.off.fill(Vec3::zeros());
        for joint in &self.joints {
            let [_, parent] = self.turns[joint.parent].of_arm(&joint.at_parent);
            let [_, child] = self.turns[joint.child].of_arm(&joint.at_child);
            let more = parent - child;
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
        self.turn(frame, settled.iter().map(|bone| bone.pose_WB.rotation));
        let response = &frame.response;
        let balanced = shared.bears(response);
        for (i, (bone, force)) in settled.iter().zip(&mut self.forces).enumerate() {
            *force = bone.pull_W;
            if balanced {
                *force -= pull(&response.springs[i], &response.targets[i], &frame.bones[i]);
            }
        }
        self.torques.fill(Vec3::zeros());
        for joint in self.joints.iter().rev() {
            let force = self.forces[joint.child];
            let [parent, _] = self.turns[joint.parent].of_arm(&joint.at_parent);
            let [child, _] = self.turns[joint.child].of_arm(&joint.at_child);
            self.torques[joint.parent] += parent.cross(&force);
            self.torques[joint.child] -= child.cross(&force);
            self.forces[joint.parent] += force;
        }
        for (i, proxy) in proxies.iter().enumerate() {
            let target = response.targets[i].pose_WB.rotation;
            let [proxy, now] = [proxy.pose_WB.rotation, settled[i].pose_WB.rotation];
            let turned = between(proxy, target);
            let linear = self.leads[i] + turned - self.turns[i].whole;
            let more = (between(proxy, now) - linear) * self.turns[i].part;
            let torque = self.torques[i] + more * response.springs[i].angular_stiffness;
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
        for (i, (bone, of_frame)) in bones.iter_mut().zip(&frame.bones).enumerate() {
            if let Some(before) = self.leaving.get_mut(i) {
                *before = bone.velocity_W;
            }
            *bone = shared.bone(i, of_frame);
        }
        if fits {
            self.turn(frame, bones.iter().map(|bone| bone.pose_WB.rotation));
            for (i, (settled, bone)) in settled.iter_mut().zip(&*bones).enumerate() {
                let position = bone.pose_WB.position + self.off[i];
                let on_arc = Pose::new(position, bone.pose_WB.rotation);
                let spring = &frame.response.springs[i];
                let pull_W = pull(spring, &proxies[i], &RigidState::at_rest(on_arc));
                settled.follow(&on_arc, &pull_W);
            }
        }
        for bone in &mut *bones {
            bone.pose_WB = bone.pose_after(h);
        }
        if !fits {
            return;
        }
        self.turn(frame, bones.iter().map(|bone| bone.pose_WB.rotation));
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
        let leaves = |turn: &Turn, bone: &RigidState, arm: &Vec3| {
            let [way, _] = turn.of_arm(arm);
            let leaves = bone.angular_velocity_W.cross(&way);
            let counts = turn.part == 1.0 && leaves.iter().all(|x| x.is_finite());
            if counts { leaves } else { Vec3::zeros() }
        };
        self.leaving.fill(Vec3::zeros());
        for joint in &self.joints {
            let parent = leaves(&self.turns[joint.parent], &bones[joint.parent], &joint.at_parent);
            let child = leaves(&self.turns[joint.child], &bones[joint.child], &joint.at_child);
            self.leaving[joint.child] = self.leaving[joint.parent] + parent - child;
        }
    }
}

/// Turn from one rotation to another, world \[rad\].
fn between(to: Quat, from: Quat) -> Vec3 {
    rotation_vector(&(to * from.inverse()))
}

/// Force with which a coupling to this proxy pulls at a bone \[N\]; none where the proxy is not
/// finite.
fn pull(spring: &Drive, proxy: &RigidState, bone: &RigidState) -> Vec3 {
    let way = proxy.pose_WB.position - bone.pose_WB.position;
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
