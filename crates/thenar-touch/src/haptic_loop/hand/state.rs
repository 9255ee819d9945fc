//! A hand in the loop, as it is kept for an incident and taken up again.

use super::LoopHand;
use super::held::{HeldSample, NewestTime};
use crate::haptic_loop::exchange::LoopEndpoints;
use crate::{DIGITS, FeltStiffness, HapticHand, Pad, TickReport};
use serde::{Deserialize, Serialize};
use thenar_core::Pose;
use thenar_core::model::Side;
use thenar_core::world::Target;
use thenar_track::live::LiveHand;

/// All that the next tick depends on besides what enters it; borrowed, to be written without a
/// copy.
#[derive(Serialize)]
pub struct HandStateRef<'a> {
    side: Side,
    live: &'a LiveHand,
    touch: &'a HapticHand,
    targets: &'a [Option<Target>],
    pads: &'a [Option<Pad>; DIGITS],
    felt: &'a Option<FeltStiffness>,
    turn: &'a Option<FeltStiffness>,
    last_ns: Option<u64>,
    beginnings: u64,
    tracker: Option<(usize, u64)>,
    held: &'a Option<HeldSample>,
    newest: NewestTime,
    tracked_ns: u64,
    palm_last: Option<Pose>,
    /// Step of the frame that the hand is on.
    frame: u64,
}

/// [`HandStateRef`], read.
#[derive(Deserialize)]
pub struct HandState {
    side: Side,
    live: LiveHand,
    touch: HapticHand,
    targets: Vec<Option<Target>>,
    pads: [Option<Pad>; DIGITS],
    felt: Option<FeltStiffness>,
    turn: Option<FeltStiffness>,
    last_ns: Option<u64>,
    beginnings: u64,
    tracker: Option<(usize, u64)>,
    held: Option<HeldSample>,
    newest: NewestTime,
    tracked_ns: u64,
    palm_last: Option<Pose>,
    /// Step of the frame that the hand was on.
    pub frame: u64,
}

impl LoopHand {
    /// The state after a tick; none in single-rate, where a whole simulation is part of it.
    pub fn state(&self) -> Option<HandStateRef<'_>> {
        Some(HandStateRef {
            side: self.side,
            live: &self.live,
            touch: self.touch.beside()?,
            targets: &self.targets,
            pads: &self.pads,
            felt: &self.felt,
            turn: &self.turn,
            last_ns: self.last_ns,
            beginnings: self.beginnings,
            tracker: self.tracker,
            held: &self.held,
            newest: self.newest,
            tracked_ns: self.tracked_ns,
            palm_last: self.palm_last,
            frame: self.frame_step,
        })
    }

    /// Goes on from a state, with these ends, whose frame is the one that the hand was on.
    pub fn recall(state: HandState, ends: LoopEndpoints) -> Self {
        Self {
            side: state.side,
            live: state.live,
            touch: Box::new(state.touch),
            ends,
            targets: state.targets,
            pads: state.pads,
            readings: [None; DIGITS],
            felt: state.felt,
            turn: state.turn,
            report: TickReport::default(),
            last_ns: state.last_ns,
            beginnings: state.beginnings,
            frame_step: state.frame,
            tracker: state.tracker,
            held: state.held,
            newest: state.newest,
            fresh_ns: None,
            tracked_ns: state.tracked_ns,
            palm_last: state.palm_last,
            palm_velocity: [[0.0; 3]; 2],
        }
    }
}
