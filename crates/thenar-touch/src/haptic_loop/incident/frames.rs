//! Frames of the simulation, in one buffer whose oldest are overwritten.

use crate::haptic_loop::Frame;
use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

/// Room for frames \[B\]. One of a hand of 16 bones that responds takes 74 KiB for its compliance
/// and up to 300 with limits of joints and contacts: at 100 frames a second these are two seconds
/// and more.
const ROOM: usize = 64 << 20;
/// Frames at most, however small.
const COUNT: usize = 4096;

/// Frames that simulation and monitor share; the loop does not.
pub struct Frames(Mutex<Ring>);

struct Ring {
    bytes: Vec<u8>,
    /// Offset at which the next may begin.
    next: usize,
    /// Oldest first.
    frames: VecDeque<FrameEntry>,
}

/// A frame of a hand, by its step, and where it is.
struct FrameEntry {
    hand: u8,
    step: u64,
    place: Range<usize>,
}

impl Default for Frames {
    fn default() -> Self {
        Self::with_room(ROOM)
    }
}

impl Frames {
    fn with_room(room: usize) -> Self {
        let frames = VecDeque::with_capacity(COUNT + 1);
        Self(Mutex::new(Ring { bytes: vec![0; room], next: 0, frames }))
    }

    fn ring(&self) -> std::sync::MutexGuard<'_, Ring> {
        // A panic while it was held left at worst a frame that does not read.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Forgets all.
    pub fn clear(&self) {
        let mut ring = self.ring();
        ring.frames.clear();
        ring.next = 0;
    }

    /// Takes a frame down, over the oldest. Allocates nothing.
    pub fn put(&self, hand: usize, frame: &Frame) {
        self.ring().put(hand as u8, frame);
    }

    /// All frames that are there: hand, step, bytes.
    pub fn kept(&self) -> Vec<(u8, u64, Vec<u8>)> {
        let ring = self.ring();
        let copy =
            |kept: &FrameEntry| (kept.hand, kept.step, ring.bytes[kept.place.clone()].to_vec());
        ring.frames.iter().map(copy).collect()
    }
}

impl Ring {
    fn put(&mut self, hand: u8, frame: &Frame) {
        // Behind the last one, or from the start where the end has too little room.
        for begin in [self.next, 0] {
            let tried = &mut self.bytes[begin..];
            let room = tried.len();
            let length = postcard::to_slice(frame, tried).ok().map(|written| written.len());
            // What was written over is lost, also when it did not fit.
            let place = begin..begin + length.unwrap_or(room);
            self.frames
                .retain(|kept| kept.place.end <= place.start || place.end <= kept.place.start);
            if length.is_some() {
                self.next = place.end;
                if self.frames.len() == COUNT {
                    self.frames.pop_front();
                }
                self.frames.push_back(FrameEntry { hand, step: frame.bones.step, place });
                return;
            }
        }
        self.next = 0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::haptic_loop::FingerContact;
    use crate::{BoneFrame, RigidState};
    use thenar_core::Pose;

    fn frame(step: u64, bones: usize) -> Frame {
        let bones = vec![RigidState::at_rest(Pose::translation(step as f64, 0.0, 0.0)); bones];
        let mut frame = Frame {
            bones: BoneFrame::new(&bones, 0),
            made_ns: 10 * step,
            targets: Vec::new(),
            contacts: [FingerContact::default(); 5],
            beginnings: 0,
        };
        frame.bones.step = step;
        frame
    }

    /// Whatever their sizes, the newest are there, whole, and the last of them is the last that was
    /// put in.
    #[test]
    fn the_newest_frames_are_there_whole() {
        let frames = Frames::with_room(20_000);
        for step in 1..200_u64 {
            let bones = 1 + (step * 7 % 13) as usize;
            frames.put(0, &frame(step, bones));
            let kept = frames.kept();
            assert_eq!(kept.last().unwrap().1, step);
            // Thirteen bones of 104 bytes each, and the rest of a frame: more than ten fit whatever
            // their sizes.
            assert!(kept.len() as u64 >= step.min(5), "{step}: {}", kept.len());
            for (k, (hand, step, bytes)) in kept.iter().enumerate() {
                assert_eq!((*hand, *step), (0, kept[0].1 + k as u64), "no frame is missing");
                let read: Frame = postcard::from_bytes(bytes).unwrap();
                assert_eq!(
                    read.bones.bones,
                    frame(*step, 1 + (*step * 7 % 13) as usize).bones.bones
                );
            }
        }
        frames.clear();
        assert!(frames.kept().is_empty());
        // One that is larger than all the room leaves the others lost, and nothing worse.
        frames.put(0, &frame(1, 1));
        frames.put(0, &frame(2, 1000));
        assert!(frames.kept().is_empty());
        frames.put(0, &frame(3, 1));
        assert_eq!(frames.kept().len(), 1);
    }
}
