//! Frames, understood.

use super::{Replay, ReplayError};
use crate::recording::content::{Keyframe, SceneStart, StepMark};
use crate::recording::entry::Input;
use thenar_record::{ChannelInfo, Frame, FrameKind, Gap, Record};

/// A frame, understood.
#[derive(Debug)]
pub enum DecodedFrame {
    Scene(Box<SceneStart>),
    Input(Box<Input>),
    Step(StepMark),
    Keyframe(Box<Keyframe>),
    Channel(ChannelInfo),
    Record(u32, Vec<f64>),
    Gap(Gap),
    Other,
}

impl DecodedFrame {
    /// Carries the session's time.
    pub fn is_of_session(&self) -> bool {
        matches!(self, Self::Scene(_) | Self::Input(_) | Self::Step(_) | Self::Keyframe(_))
    }

    /// Steps made since the scene frame when it was written, for what stands between steps.
    pub fn number(&self) -> Option<u64> {
        match self {
            Self::Input(input) => Some(input.number),
            Self::Step(mark) => Some(mark.number),
            Self::Keyframe(keyframe) => Some(keyframe.number),
            _ => None,
        }
    }

    pub(super) fn of(frame: &Frame) -> Option<Self> {
        let body = frame.body;
        match frame.kind {
            Some(FrameKind::Scene) => SceneStart::read(body).map(|s| Self::Scene(Box::new(s))),
            Some(FrameKind::Input) => {
                postcard::from_bytes(body).ok().map(|i| Self::Input(Box::new(i)))
            }
            Some(FrameKind::Step) => StepMark::read(body).map(Self::Step),
            Some(FrameKind::Keyframe) => Keyframe::read(body).map(|k| Self::Keyframe(Box::new(k))),
            Some(FrameKind::Channel) => serde_json::from_slice(body).ok().map(Self::Channel),
            Some(FrameKind::Record) => Record::read(body)
                .map(|record| Self::Record(record.channel, record.values().collect())),
            Some(FrameKind::Gap) => Gap::read(body).map(Self::Gap),
            Some(FrameKind::Header | FrameKind::End) | None => Some(Self::Other),
        }
    }
}

impl Replay {
    /// The next frame and its time \[ns\].
    pub(super) fn read(&mut self) -> Result<Option<(u64, DecodedFrame)>, ReplayError> {
        let Some(frame) = self.frames.next()? else {
            self.meet_damage();
            return Ok(None);
        };
        let (time_ns, item) = (frame.time_ns, DecodedFrame::of(&frame));
        let item = item.ok_or_else(|| self.nonsense("its body cannot be decoded"))?;
        self.meet_damage();
        Ok(Some((time_ns, item)))
    }

    /// The frame read last makes no sense.
    pub(super) fn nonsense(&self, what: &'static str) -> ReplayError {
        ReplayError::Content { offset: self.frames.offset(), what }
    }
}
