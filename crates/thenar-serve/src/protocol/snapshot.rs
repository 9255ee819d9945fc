//! The snapshot message: where everything is after a step.

use super::contact::{self, CONTACTS_MAX};
use super::{VERSION, kind};
use thenar_core::world::Energy;
use thenar_core::{Pose, Vec3};
use thenar_scene::session::Session;

/// Flags of a snapshot.
pub mod flags {
    /// Flag of a paused simulation.
    pub const PAUSED: u16 = 1;
    /// The last step failed and was taken back.
    pub const FAILED: u16 = 2;
    /// Slower than real time.
    pub const SLOW: u16 = 4;
    /// More contacts than a snapshot holds.
    pub const CONTACTS_LEFT_OUT: u16 = 8;
    /// The script moves the hands.
    pub const SCRIPT: u16 = 16;
    /// A tracked pose moves a hand.
    pub const TRACKED: u16 = 32;
}

/// Parts of a snapshot that the session does not know.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pace {
    /// Flags; those of failure and of contacts left out are added.
    pub flags: u16,
    /// Counts models.
    pub epoch: u32,
    /// Counts snapshots.
    pub number: u32,
    /// Cost of the last step \[ms\].
    pub cost_ms: f64,
    /// Cost that a step may have at the chosen speed \[ms\].
    pub budget_ms: f64,
    /// Simulated over real time, as reached.
    pub speed: f64,
    /// Newest pose message that acted in the step, 0 if none.
    pub pose: u32,
    /// Energies at the end of the step.
    pub energy: Energy,
}

/// Little-endian bytes.
#[derive(Clone, Debug, Default)]
pub struct Bytes(Vec<u8>);

impl Bytes {
    pub(super) fn u16(&mut self, x: u16) {
        self.0.extend_from_slice(&x.to_le_bytes());
    }

    pub(super) fn i16(&mut self, x: i16) {
        self.0.extend_from_slice(&x.to_le_bytes());
    }

    fn u32(&mut self, x: u32) {
        self.0.extend_from_slice(&x.to_le_bytes());
    }

    pub(super) fn f32(&mut self, x: f64) {
        self.0.extend_from_slice(&(x as f32).to_le_bytes());
    }

    fn u32s<const N: usize>(&mut self, numbers: [u32; N]) {
        numbers.into_iter().for_each(|x| self.u32(x));
    }

    fn f32s<const N: usize>(&mut self, numbers: [f64; N]) {
        numbers.into_iter().for_each(|x| self.f32(x));
    }

    pub(super) fn vector(&mut self, v: &Vec3) {
        v.iter().for_each(|x| self.f32(*x));
    }

    fn pose(&mut self, pose: &Pose) {
        self.vector(&pose.position);
        pose.rotation.coords.iter().for_each(|x| self.f32(*x));
    }
}

/// Writes snapshots, one after another into the same memory.
#[derive(Clone, Debug, Default)]
pub struct Snapshots {
    out: Bytes,
}

impl Snapshots {
    /// The snapshot of a session's present state. Allocates nothing once it has seen the session
    /// with as many contacts.
    pub fn write(&mut self, session: &Session, pace: &Pace) -> &[u8] {
        let (world, state) = (session.world(), session.world().state());
        let contacts = world.contacts();
        let pressing = contacts.iter().filter(|c| contact::presses(c)).count();
        let sent = pressing.min(CONTACTS_MAX);
        let targets: usize = session.hands().iter().map(|h| h.handle.bones.len()).sum();
        let counts = [state.poses_WB.len(), state.x.len(), targets, sent];

        let out = &mut self.out;
        out.0.clear();
        out.0.extend_from_slice(&[kind::SNAPSHOT, VERSION]);
        let left_out = if pressing > sent { flags::CONTACTS_LEFT_OUT } else { 0 };
        let failed = if session.report().non_finite { flags::FAILED } else { 0 };
        out.u16(pace.flags | failed | left_out);
        out.u32s([pace.epoch, pace.number, session.steps() as u32]);
        out.0.extend_from_slice(&world.time().to_le_bytes());
        out.f32s([pace.cost_ms, pace.budget_ms, pace.speed]);
        let report = session.report();
        out.f32s([pace.energy.total(), pace.energy.kinetic, pace.energy.elastic]);
        out.f32s([report.penetration_max, report.joint_gap_max]);
        out.u32s([pace.pose, report.contact_sweeps]);
        out.u32s(counts.map(|count| count as u32));
        out.u32s([session.hands().len() as u32, 0]);

        state.poses_WB.iter().for_each(|pose| out.pose(pose));
        state.x.iter().for_each(|x| out.vector(x));
        for bone in session.hands().iter().flat_map(|h| h.handle.bones.clone()) {
            match session.input().target(bone as usize) {
                Some(target) => out.pose(&target.pose_WB),
                None => out.f32s([f64::NAN; 7]),
            }
        }
        for hand in 0..session.hands().len() {
            for load in session.hand_loads(hand) {
                out.f32s(load.figures());
            }
        }
        let pressing = contacts.iter().filter(|c| contact::presses(c));
        pressing.take(sent).for_each(|c| contact::put(c, out));
        &self.out.0
    }
}
