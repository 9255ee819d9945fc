//! Going on from elsewhere.

use super::item::DecodedFrame;
use super::keyframe::put;
use super::pace::FrameProgress;
use super::trust::Trust;
use super::{Event, Index, Replay, ReplayError};
use crate::recording::content::Keyframe;
use crate::recording::verdict::Verdict;
use std::path::Path;

impl Replay {
    /// Opens a recording to be replayed from the last keyframe before `seconds` on. What comes
    /// before is read, but no step of it is made.
    ///
    /// # Errors
    /// As for [`Replay::open`]; or the recording ends before.
    pub fn open_at(file: &Path, seconds: f64) -> Result<Self, ReplayError> {
        let mut replay = Self::open(file)?;
        let index = Index::of(file)?;
        index.reach(seconds)?;
        replay.go_to(&index, seconds)?;
        Ok(replay)
    }

    /// Goes to the last keyframe before `seconds`, or to the beginning of its scene when there is
    /// none: the session is as it was there. Events follow as after opening, the scene
    /// and its channels first; the verdict begins anew. Returns the time \[s\].
    ///
    /// # Errors
    /// The recording cannot be read, or its scene cannot be built.
    pub fn go_to(&mut self, index: &Index, seconds: f64) -> Result<f64, ReplayError> {
        (self.pending, self.begin, self.trust) = (None, None, Trust::Sound);
        self.mark = None;
        self.verdict = Verdict::default();
        self.told.clear();
        // Without a scene there is nothing to be found.
        let Some((scene, keyframe)) = index.before(seconds) else { return Ok(0.0) };
        self.verdict.scenes = scene.scene - 1;
        self.frames.go_to(&scene.place)?;
        let Some((time_ns, DecodedFrame::Scene(start))) = self.read()? else {
            return Err(self.nonsense("a scene was there when it was looked at first"));
        };
        self.start(time_ns, scene.place.offset(), &start)?;
        let mut time_ns = scene.time_ns;
        if let Some(mark) = keyframe {
            time_ns = mark.time_ns;
            let behind_scene = self.frames.place_of_next();
            self.frames.go_to(&mark.place)?;
            let Some((_, DecodedFrame::Keyframe(keyframe))) = self.read()? else {
                return Err(self.nonsense("a keyframe was there when it was looked at first"));
            };
            match &keyframe.kept {
                Some(_) => self.begin_at(&keyframe)?,
                // Tracked hands have to be led there.
                None => {
                    self.begin = Some(self.frames.offset());
                    self.frames.go_to(&behind_scene)?;
                    time_ns = scene.time_ns;
                }
            }
        }
        let before = |(offset, _): &&(u64, _)| *offset < self.frames.offset();
        self.pace = FrameProgress::at(time_ns);
        self.told.push_back(Event::Scene { time_ns });
        let announced = index.channels.iter().filter(before);
        self.channels = announced.clone().map(|(_, info)| (info.id, info.fields.len())).collect();
        self.told.extend(announced.map(|(_, info)| Event::Channel(info.clone())));
        Ok(time_ns as f64 * 1e-9)
    }

    fn begin_at(&mut self, keyframe: &Keyframe) -> Result<(), ReplayError> {
        let start = self.start_hash;
        let own = keyframe.kept.as_ref().is_some_and(|kept| kept.start == start);
        if !own || !self.session.as_mut().is_some_and(|session| put(session, keyframe)) {
            return Err(self.nonsense("it belongs to a scene that is not in the recording"));
        }
        (self.number, self.verdict.passed) = (keyframe.number, keyframe.number);
        Ok(())
    }
}
