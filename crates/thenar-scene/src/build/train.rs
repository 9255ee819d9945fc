//! Motors that a linkage shares between a joint and those that mimic it.

use super::motor::Motor;
use thenar_core::World;
use thenar_core::kinematics::stretch;
use thenar_core::model::{Axis, JointDesc};
use thenar_core::world::{Input, JointTarget};
use thenar_rig::figure::Mimic;

/// Spring of the link between a joint and one that mimics it, over that of the motor, both at the
/// leader.
///
/// A load τ on one of two joints parts them by τ/(k/2 + 2 x k) for the factor x: 0.12 of what the
/// motor gives way. Either side knows the other's angle as it was when the step began, so that the
/// link also damps the motion of both like a damper of x k h: stiffer links slow the train down.
const LINK: f64 = 4.0;
/// Laws less steep than this hold their joint where they say and hardly lead it.
const FLAT: f64 = 1e-3;
/// Places at which the steepness of a law is looked up.
const LOOKS: u32 = 64;

/// One motor and what it moves: a joint's axis, and axes that mimic it.
#[derive(Clone, Debug)]
pub struct Train {
    /// Motor of the first joint; its largest torque is that of all.
    motor: Motor,
    /// Axes that it moves, the leader's first.
    members: Vec<Member>,
    /// Share of the motor's spring and damper in each member, at the leader \[N m/rad, N m s/rad\].
    share: [f64; 2],
    /// Spring of each link, at the leader \[N m/rad\].
    link: f64,
}

/// An axis that a train moves.
#[derive(Clone, Debug)]
struct Member {
    joint: u32,
    axis: usize,
    /// Laws from the leader to here; none of the leader.
    laws: Vec<Mimic>,
    /// Largest slope of the angle over the leader's.
    steepest: f64,
}

/// Angle and rate of an axis.
#[derive(Clone, Copy)]
struct AxisState {
    angle: f64,
    rate: f64,
}

/// Angle and rate to which the motor leads an axis.
#[derive(Clone, Copy)]
struct AxisTarget {
    angle: f64,
    rate: f64,
}

impl Member {
    /// Angle for this one of the leader \[rad\], and how it changes with it.
    fn at(&self, leader: f64) -> (f64, f64) {
        self.laws.iter().fold((leader, 1.0), |(angle, slope), law| {
            let (next, steep) = law.at(angle);
            (next, slope * steep)
        })
    }

    /// Springs and dampers at the leader, as they are here.
    fn here(&self, at_leader: f64) -> f64 {
        at_leader / (self.steepest * self.steepest)
    }

    fn state(&self, world: &World) -> AxisState {
        let [angles, rates] = [world.joint_angles(self.joint), world.joint_rates(self.joint)];
        let axis = Axis { rest_angle: 0.0, ..*self.desc(world) };
        // Within the range, where that goes on past half a turn.
        AxisState { angle: stretch(&axis, angles[self.axis]), rate: rates[self.axis] }
    }

    fn desc<'a>(&self, world: &'a World) -> &'a Axis {
        &world.desc().joints[self.joint as usize].axes[self.axis]
    }

    fn goal(&self, leader: &AxisTarget) -> AxisTarget {
        let (angle, slope) = self.at(leader.angle);
        AxisTarget { angle, rate: slope * leader.rate }
    }

    /// Angle by which the axis is past this one \[rad\].
    fn past(&self, world: &World, angle: f64, seen: f64) -> f64 {
        stretch(&Axis { rest_angle: angle, ..*self.desc(world) }, seen)
    }
}

impl Train {
    /// The train of a motor and of the laws that lead from its axis to others, those between first.
    /// The world's joints get the springs that the train needs.
    pub fn new(
        motor: Motor,
        axis: usize,
        laws: Vec<Vec<Mimic>>,
        first_joint: u32,
        joints: &mut [JointDesc],
    ) -> Self {
        let leader = joints[motor.joint as usize].axes[axis];
        let (joint, own) = (motor.joint, Vec::new());
        let mut members = vec![Member { joint, axis, laws: own, steepest: 1.0 }];
        for laws in laws {
            let Some(last) = laws.last() else { continue };
            let (joint, axis) = (first_joint + last.joint, usize::from(last.axis));
            let mut member = Member { joint, axis, laws, steepest: 1.0 };
            member.steepest = steepest(&member, &leader);
            members.push(member);
        }
        let count = members.len() as f64;
        let share = [leader.stiffness, leader.damping].map(|whole| whole / count);
        let link = LINK * leader.stiffness;
        let train = Self { motor, members, share, link };
        for (i, member) in train.members.iter().enumerate() {
            let axis = &mut joints[member.joint as usize].axes[member.axis];
            axis.stiffness = train.spring(i);
            axis.damping = member.here(train.share[1]);
        }
        train
    }

    /// Whole spring of a member \[N m/rad\].
    fn spring(&self, member: usize) -> f64 {
        let links = if member == 0 { self.members.len() - 1 } else { 1 };
        self.members[member].here(self.share[0] + links as f64 * self.link)
    }

    /// Axes besides the leader's, and where they start \[rad\].
    pub fn starts(&self) -> impl Iterator<Item = (u32, usize, f64)> + '_ {
        let leader = self.wanted(0.0).angle;
        let following = self.members.iter().skip(1);
        following.map(move |member| (member.joint, member.axis, member.at(leader).0))
    }

    fn wanted(&self, t: f64) -> AxisTarget {
        let (wanted, axis) = (self.motor.wanted(t), self.members[0].axis);
        AxisTarget { angle: wanted.angles[axis], rate: wanted.rates[axis] }
    }

    /// Leads the axes for the step that ends at time `t` \[s\].
    ///
    /// The motor's spring and damper are shared evenly, or all of its largest torque is, where they
    /// would give more. Links pull both of their ends by what these differ, as they are when the
    /// step begins; a motor that is not at its limit takes both along meanwhile.
    pub fn lead(&self, input: &mut Input, world: &World, t: f64) {
        let goal = self.wanted(t);
        let asked = self.asked(&goal, world);
        let most = self.motor.torque_max.unwrap_or(f64::INFINITY);
        // A motor at its limit has no spring: its torque acts.
        let (holds, torque) =
            if asked.abs() <= most { (1.0, 0.0) } else { (0.0, most.copysign(asked)) };
        let leader = self.members[0].state(world);
        let on = AxisTarget { angle: leader.angle, rate: holds * goal.rate };
        let mut leading = CombinedSpring::of_motor(holds * self.share[0], goal.angle);
        for (i, member) in self.members.iter().enumerate().skip(1) {
            let (seen, wanted) = (member.state(world), member.goal(&goal));
            let (_, slope) = member.at(leader.angle);
            let link = member.here(self.link);
            let mut pull =
                CombinedSpring::of_motor(member.here(holds * self.share[0]), wanted.angle);
            pull.add(link, member.at(leader.angle + world.time_step() * on.rate).0);
            // What the link does here it does to the leader, the other way and by the slope.
            let then = seen.angle + world.time_step() * holds * wanted.rate;
            let past = member.past(world, member.at(leader.angle).0, then);
            leading.add_torque(link * slope * slope, leader.angle, link * slope * past);
            let rate = if holds > 0.0 { wanted.rate } else { seen.rate };
            let part = torque / self.members.len() as f64;
            self.set(input, world, i, &pull, rate, member.here(part * slope));
        }
        let rate = if holds > 0.0 { goal.rate } else { leader.rate };
        self.set(input, world, 0, &leading, rate, torque / self.members.len() as f64);
    }

    /// Torque about the leader's axis that all shares of the motor's spring and damper would give
    /// \[N m\].
    fn asked(&self, goal: &AxisTarget, world: &World) -> f64 {
        let leader = self.members[0].state(world).angle;
        let share = |member: &Member| {
            let (seen, goal) = (member.state(world), member.goal(goal));
            let then = seen.angle + world.time_step() * seen.rate;
            let [stiffness, damping] = self.share.map(|whole| member.here(whole));
            let past = member.past(world, goal.angle, then);
            member.at(leader).1 * (damping * (goal.rate - seen.rate) - stiffness * past)
        };
        self.members.iter().map(share).sum()
    }

    fn set(
        &self,
        input: &mut Input,
        world: &World,
        member: usize,
        pull: &CombinedSpring,
        rate: f64,
        torque: f64,
    ) {
        let Member { joint, axis: k, .. } = self.members[member];
        let j = joint as usize;
        let rest = world.desc().joints[j].axes.map(|axis| axis.rest_angle);
        let target = input.joint_targets[j]
            .get_or_insert(JointTarget { angles: rest, ..JointTarget::default() });
        let (angle, gain) = pull.at(self.spring(member));
        (target.angles[k], target.rates[k], target.gains[k]) = (angle, rate, gain);
        input.joint_torques[j][k] += torque;
    }
}

/// Springs about one axis, as one.
struct CombinedSpring {
    stiffness: f64,
    /// Stiffness times where it is relaxed \[N m\].
    moment: f64,
    /// Angle at which the first spring is relaxed \[rad\].
    first: f64,
}

impl CombinedSpring {
    fn of_motor(stiffness: f64, angle: f64) -> Self {
        Self { stiffness, moment: stiffness * angle, first: angle }
    }

    fn add(&mut self, stiffness: f64, angle: f64) {
        self.add_torque(stiffness, angle, 0.0);
    }

    /// A spring that gives this torque at this angle.
    fn add_torque(&mut self, stiffness: f64, angle: f64, torque: f64) {
        self.stiffness += stiffness;
        self.moment += stiffness * angle + torque;
    }

    /// Angle at which they are relaxed together, and their part of the joint's own spring.
    fn at(&self, whole: f64) -> (f64, f64) {
        match self.stiffness > 0.0 {
            true => (self.moment / self.stiffness, (self.stiffness / whole).min(1.0)),
            false => (self.first, 0.0),
        }
    }
}

/// The largest slope of a member's angle over the leader's range; of half a turn to both sides
/// where that has none.
fn steepest(member: &Member, leader: &Axis) -> f64 {
    use std::f64::consts::PI;
    let [low, high] = leader.limit.map_or([-PI, PI], |limit| [limit.min, limit.max]);
    let slope = |i: u32| member.at(low + (high - low) * f64::from(i) / f64::from(LOOKS)).1.abs();
    match (0..=LOOKS).map(slope).fold(0.0, f64::max) {
        most if most > FLAT => most,
        _ => 1.0,
    }
}
