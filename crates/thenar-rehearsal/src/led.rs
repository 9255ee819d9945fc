//! A hand that is led through exact poses, seen by a tracker, in the product's own loop.

use crate::glove::{self, LateTracker, WearerEndpoint};
use crate::{RehearsalError, Stage, TICK_NS, moved, white};
use thenar_core::Vec3;
use thenar_core::model::Side;
use thenar_link::{DIGITS, HandSample};
use thenar_scene::session::{Random, Session};
use thenar_touch::TrackerTiming;
use thenar_touch::haptic_loop::Settings;
use thenar_touch::safety::Limits;
use thenar_track::live::{LiveError, LivePose};

/// The first hand of a scene, led exactly: it gives way to nothing.
pub struct Led {
    stage: Stage,
    ends: WearerEndpoint,
    tracker: LateTracker,
    /// Noise of what the tracker sees \[m\].
    noise: f64,
    random: Random,
    side: Side,
}

impl Led {
    /// With a tracker of this timing, which the loop knows, and without a display: what is felt is
    /// what the couplings would have the wearer feel.
    ///
    /// # Errors
    /// The scene has no hand that could be felt.
    pub fn new(
        session: Session,
        settings: &Settings,
        timing: TrackerTiming,
    ) -> Result<Self, RehearsalError> {
        let (ends, tracker, _) = glove::pair(timing, Limits::cybergrasp());
        let stage = Stage::new(session, settings, vec![tracker], Vec::new())?;
        let side = stage.session().hands()[0].model.side.unwrap_or(Side::Right);
        let (noise, random) = (timing.noise, Random::new(1));
        Ok(Self { stage, ends, tracker: LateTracker::new(timing), noise, random, side })
    }

    /// Loop and scene.
    pub fn stage(&self) -> &Stage {
        &self.stage
    }

    /// One millisecond in which the hand is there; one that is not seen is `None`. `stalled` as for
    /// [`Stage::tick`].
    ///
    /// # Errors
    /// The hand cannot be felt any more.
    pub fn tick(&mut self, pose: Option<&LivePose>, stalled: bool) -> Result<(), RehearsalError> {
        let now_ns = self.stage.next_ns();
        if self.tracker.is_due(now_ns / TICK_NS) {
            let off = Vec3::from_fn(|_, _| white(self.noise, &mut self.random));
            let pose = pose.map(|pose| moved(pose, off));
            self.tracker.see(HandSample { side: self.side, time_ns: now_ns, pose });
        }
        if let Some(sample) = self.tracker.arrived(now_ns) {
            self.ends.tell(sample, now_ns);
        }
        self.stage.tick(stalled)
    }

    /// Force of all couplings on the wearer in the last tick, world, as it is felt \[N\].
    pub fn force(&self) -> Vec3 {
        self.stage.hand(|hand| {
            let each = hand.touch().device_wrenches().iter().enumerate();
            each.map(|(bone, [force, _])| force * hand.felt_part(bone)).sum()
        })
    }

    /// Power given to the wearer by what is felt of all couplings in the last tick, at the speeds
    /// at which the loop leads the bones \[W\].
    pub fn power(&self) -> f64 {
        self.stage.hand(|hand| {
            let touch = hand.touch();
            let each = touch.tracked().iter().zip(touch.device_wrenches()).enumerate();
            let power = each.map(|(bone, (led, [force, torque]))| {
                let power = force.dot(&led.velocity_W) + torque.dot(&led.angular_velocity_W);
                hand.felt_part(bone) * power
            });
            power.sum()
        })
    }

    /// Returns the force on each pad, thumb first \[N\]; zero for a finger that the hand lacks.
    pub fn pads(&self) -> [f64; DIGITS] {
        self.stage.hand(|hand| hand.readings().map(|pad| pad.map_or(0.0, |pad| pad.pad_force)))
    }
}

/// Returns the pose that a scene's first hand has by its script at a time \[s\], or else has now.
///
/// # Errors
/// There is no such hand, or poses cannot move it.
pub fn scripted(session: &Session, time: f64) -> Result<LivePose, LiveError> {
    let mut live = session.live_hand(0)?;
    let hand = &session.hands()[0];
    let bones = hand.handle.bones.start as usize..hand.handle.bones.end as usize;
    let mut targets = session.input().targets[bones].to_vec();
    if let Some(motion) = &hand.motion {
        motion.clone().sample(time, &mut targets);
    }
    Ok(live.pose_of(&targets))
}
