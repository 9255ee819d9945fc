//! A scene and the product's own loop beside it, on a clock that is counted and not read.

use crate::{RehearsalError, TICK_NS};
use thenar_link::{ForceDisplay, Tracker};
use thenar_scene::session::Session;
use thenar_touch::haptic_loop::{LoopHand, LoopMode, ManualLoop, Settings, SimulationPort};

/// The loop and a scene, which step in turn: a frame that a step makes arrives a whole period after
/// the step's inputs were taken.
pub struct Stage {
    session: Session,
    clock: ManualLoop,
    port: SimulationPort,
    mode: LoopMode,
    /// From one step of the scene to the next \[ms\].
    period: u64,
    /// A step is under way.
    begun: bool,
    ms: u64,
}

impl Stage {
    /// Puts the hands of a scene into a loop with these devices.
    ///
    /// # Errors
    /// The scene has no hand that could be felt, or the loop cannot be made.
    pub fn new(
        session: Session,
        settings: &Settings,
        trackers: Vec<Box<dyn Tracker>>,
        displays: Vec<Box<dyn ForceDisplay>>,
    ) -> Result<Self, RehearsalError> {
        let clock = ManualLoop::new(settings, trackers, displays)?;
        let mut port = clock.port();
        port.attach(&session)?;
        let period = ((1e3 * session.world().time_step()).round() as u64).max(1);
        Ok(Self { session, clock, port, mode: settings.mode, period, begun: false, ms: 0 })
    }

    /// The scene, as its last step left it.
    pub fn session(&self) -> &Session {
        &self.session
    }

    /// The loop.
    pub fn clock(&mut self) -> &mut ManualLoop {
        &mut self.clock
    }

    /// Returns the mode in which touch joins hand and scene.
    pub fn mode(&self) -> LoopMode {
        self.mode
    }

    /// From one step of the scene to the next \[ms\].
    pub fn period(&self) -> u64 {
        self.period
    }

    /// Time of the tick that comes \[ns\].
    pub fn next_ns(&self) -> u64 {
        (self.ms + 1) * TICK_NS
    }

    /// Looks at the first hand in the loop.
    pub fn hand<T>(&self, look: impl FnOnce(&LoopHand) -> T) -> T {
        self.clock.core(|core| look(&core.hands()[0]))
    }

    /// One millisecond. `stalled` keeps the scene from ending or beginning a step.
    ///
    /// # Errors
    /// The hands cannot be felt any more.
    pub fn tick(&mut self, stalled: bool) -> Result<(), RehearsalError> {
        let now_ns = self.next_ns();
        self.ms += 1;
        if self.ms.is_multiple_of(self.period) && !stalled {
            // The step that began a period ago is done; the next begins.
            if self.begun {
                self.session.step(&mut ());
                self.port.after_step(&mut self.session, now_ns);
            }
            self.port.before_step(&mut self.session, now_ns)?;
            self.begun = true;
        }
        self.clock.tick(now_ns);
        while self.clock.records.pop().is_ok() {}
        Ok(())
    }
}
