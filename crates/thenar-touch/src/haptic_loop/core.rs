//! One tick of everything: all hands, all trackers, all guards. Time is an argument; nothing here
//! waits, allocates or reads a clock, so that tests run it on any clock they like.

mod state;

pub use state::CoreState;

use super::actuators::{Actuators, Capability, Liveness};
use super::hand::LoopHand;
use super::incident::{IncidentWriter, Input};
use super::record::TickRecord;
use crate::safety::{LimitError, Limits, Status, Trip};
use crate::{ForceDisplay, HandOutput, Rendering, Tracker};
use rtrb::Producer;
use thenar_track::live::Mover;

/// Core of the loop: its work in each tick.
pub struct Core {
    trackers: Vec<Box<dyn Tracker>>,
    /// Abilities of each display.
    displays: Vec<Capability>,
    hands: Vec<LoopHand>,
    /// Display by display, hand by hand.
    actuators: Vec<Actuators>,
    outputs: Vec<HandOutput>,
    /// Per display, when it was last heard \[ns\].
    heard: Vec<u64>,
    armed: bool,
    /// Trip that stopped all forces since they were armed. It outlives the hands and their guards.
    stopped: Option<Trip>,
    /// Trip that will have stopped all forces once they have faded.
    fading: Option<Trip>,
    records: Producer<TickRecord>,
    /// Tape that keeps all inputs for an incident.
    incident_writer: Option<IncidentWriter>,
    /// Records that found no room.
    lost: u64,
}

/// Timing of a tick.
#[derive(Clone, Copy, Debug, Default)]
pub struct TickTime {
    /// Present time \[ns\].
    pub now_ns: u64,
    /// Later than due by \[ns\].
    pub late_ns: u64,
    /// Cost of the tick before \[ns\].
    pub cost_ns: u64,
    /// Ticks left out since the one before.
    pub missed: u32,
}

impl Core {
    /// Without hands.
    ///
    /// # Errors
    /// A display's limits make no sense.
    pub fn new(
        trackers: Vec<Box<dyn Tracker>>,
        displays: Vec<Capability>,
        records: Producer<TickRecord>,
    ) -> Result<Self, LimitError> {
        for Capability { limits, torque_limits, .. } in &displays {
            limits.check()?;
            torque_limits.as_ref().map_or(Ok(()), Limits::check)?;
        }
        Ok(Self {
            trackers,
            heard: vec![0; displays.len()],
            displays,
            hands: Vec::new(),
            actuators: Vec::new(),
            outputs: Vec::new(),
            armed: false,
            stopped: None,
            fading: None,
            records,
            incident_writer: None,
            lost: 0,
        })
    }

    /// Guards of these displays, all off, for a number of hands; allocates, so it is called outside
    /// the loop.
    ///
    /// # Errors
    /// As [`Core::new`].
    pub fn guards(displays: &[Capability], hands: usize) -> Result<Vec<Actuators>, LimitError> {
        let each = displays.iter().flat_map(|display| std::iter::repeat_n(display, hands));
        each.map(Actuators::new).collect()
    }

    /// Keeps what enters by this from now on.
    pub fn keep_by(&mut self, incident_writer: IncidentWriter) {
        self.incident_writer = Some(incident_writer);
    }

    /// Takes down what enters.
    fn note(&mut self, input: Input) {
        if let Some(incident_writer) = &mut self.incident_writer {
            incident_writer.input(input);
        }
    }

    /// Puts other hands in place of those there are, and gives those back for whoever calls to
    /// drop. Guards begin anew: armed if these were, with wait and ramp; what was stopped stays so.
    pub fn replace(
        &mut self,
        hands: &mut Vec<LoopHand>,
        actuators: &mut Vec<Actuators>,
        outputs: &mut Vec<HandOutput>,
    ) {
        std::mem::swap(&mut self.hands, hands);
        std::mem::swap(&mut self.actuators, actuators);
        std::mem::swap(&mut self.outputs, outputs);
        if self.armed {
            self.actuators.iter_mut().for_each(Actuators::arm);
        }
        if let Some(reason) = self.stopped {
            self.stop(reason);
        }
        if let Some(incident_writer) = &mut self.incident_writer {
            incident_writer.begin();
        }
    }

    /// Lets forces through, after the guards' wait and ramp.
    pub fn arm(&mut self) {
        self.note(Input::Arm);
        (self.armed, self.stopped, self.fading) = (true, None, None);
        self.actuators.iter_mut().for_each(Actuators::arm);
    }

    /// Lets forces fade as fast as their slew limits allow, and then stops all displays until
    /// armed.
    pub fn fade_out(&mut self, reason: Trip) {
        self.note(Input::Fade(reason));
        if self.armed && self.stopped.is_none() {
            self.fading.get_or_insert(reason);
        }
    }

    /// Stops all displays until armed, those of hands that come later too.
    pub fn trip(&mut self, reason: Trip) {
        self.note(Input::Stop(reason));
        self.stop(reason);
    }

    fn stop(&mut self, reason: Trip) {
        if self.armed {
            self.stopped.get_or_insert(reason);
        }
        self.actuators.iter_mut().for_each(|actuators| actuators.trip(reason));
    }

    /// The first trip in force.
    pub fn tripped(&self) -> Option<Trip> {
        let of_guards = || {
            self.actuators.iter().find_map(|actuators| match actuators.status() {
                Status::Tripped(reason) => Some(reason),
                _ => None,
            })
        };
        self.stopped.or_else(of_guards)
    }

    /// Notes when display `display` was last heard \[ns\], if it ever was.
    pub fn hear(&mut self, display: usize, heard_ns: Option<u64>, now_ns: u64) {
        let silent = match self.displays[display].rendering {
            // Vibrating players never answer and cannot hold a hand.
            Rendering::Vibration => now_ns,
            Rendering::Tendons | Rendering::Stops | Rendering::Wrench => 0,
        };
        let heard_ns = heard_ns.unwrap_or(silent);
        if std::mem::replace(&mut self.heard[display], heard_ns) != heard_ns {
            self.note(Input::Heard(display as u8, heard_ns));
        }
    }

    /// A display was last heard then \[ns\]; `None` if there is no such display.
    pub fn hear_at(&mut self, display: usize, heard_ns: u64) -> Option<()> {
        *self.heard.get_mut(display)? = heard_ns;
        Some(())
    }

    /// One tick: poses in, steps, guards, outputs. Allocates nothing.
    pub fn tick(&mut self, time: &TickTime, enabled: bool) {
        let now_ns = time.now_ns;
        let held = enabled;
        let enabled = enabled && self.fading.is_none();
        for (number, hand) in self.hands.iter_mut().enumerate() {
            let frame = hand.update(now_ns);
            if let (Some(step), Some(incident_writer)) = (frame, &mut self.incident_writer) {
                incident_writer.input(Input::Frame(number as u8, step));
            }
            for (index, tracker) in self.trackers.iter_mut().enumerate() {
                let timing = tracker.timing();
                if let Some(sample) = tracker.latest(hand.side()) {
                    if let Some(incident_writer) = &mut self.incident_writer {
                        incident_writer.sample(index, sample, timing);
                    }
                    hand.take_timed(index, sample, now_ns, timing);
                }
            }
            hand.tick(now_ns);
        }
        let hands = self.hands.len().max(1);
        for (i, actuators) in self.actuators.iter_mut().enumerate() {
            let heard = Liveness { device_ns: self.heard[i / hands], enabled };
            self.outputs[i] = actuators.tick(now_ns, &mut self.hands[i % hands], heard);
        }
        if let Some(reason) = self.fading.filter(|_| self.is_forceless()) {
            self.stop(reason);
            self.fading = None;
        }
        // One trip stops all: a wearer has two hands.
        if let Some(reason) = self.tripped() {
            self.stop(reason);
            for output in &mut self.outputs {
                *output = HandOutput::released(output.side, now_ns);
            }
        }
        self.write_records(time);
        self.note(Input::Tick(now_ns, held));
        // Out of its place for as long as it looks at all the rest.
        if let Some(mut incident_writer) = self.incident_writer.take() {
            incident_writer.state(now_ns, |room| self.write_state(room));
            self.incident_writer = Some(incident_writer);
        }
    }

    /// No force and no torque went out in the last tick.
    fn is_forceless(&self) -> bool {
        self.actuators.iter().flat_map(Actuators::axes).all(|axis| axis.output == 0.0)
            && self.outputs.iter().all(|output| output.torque_W.norm() == 0.0)
    }

    /// Hands the outputs of the last tick to the displays.
    pub fn show(&self, displays: &mut [Box<dyn ForceDisplay>]) {
        let hands = self.hands.len().max(1);
        for (i, output) in self.outputs.iter().enumerate() {
            if let Some(display) = displays.get_mut(i / hands) {
                display.show(output);
            }
        }
    }

    fn write_records(&mut self, time: &TickTime) {
        let hands = self.hands.len();
        let narrow = |ns: u64| ns.min(u64::from(u32::MAX)) as u32;
        for k in 0..self.actuators.len().max(hands) {
            let hand = &self.hands[k % hands.max(1)];
            let actuators = self.actuators.get(k);
            let report = hand.report();
            let record = TickRecord {
                time_ns: time.now_ns,
                late_ns: narrow(time.late_ns),
                cost_ns: narrow(time.cost_ns),
                missed: time.missed,
                first: k == 0,
                side: hand.side(),
                tracker: hand.tracker().map(|t| t as u8),
                pose_ns: hand.fresh_ns(),
                tracked: hand.mover() == Mover::Live,
                display: actuators.map(|_| (k / hands) as u8),
                ages: [hand.tracking_age(time.now_ns) as f32, report.simulation_age as f32],
                contacts: report.contact.active,
                status: actuators.map_or(Status::Off, Actuators::status),
                stiffness: hand.felt_stiffness() as f32,
                delay: hand.delay() as f32,
                axes: actuators.map_or_else(Default::default, |actuators| *actuators.axes()),
            };
            if self.records.push(record).is_err() {
                self.lost += 1;
            }
        }
    }

    /// Returns the abilities of each display.
    pub fn displays(&self) -> &[Capability] {
        &self.displays
    }

    /// The outputs of the last tick.
    pub fn outputs(&self) -> &[HandOutput] {
        &self.outputs
    }

    /// The guards, display by display, hand by hand.
    pub fn actuators(&self) -> &[Actuators] {
        &self.actuators
    }

    /// Hands, for tests and read-outs.
    pub fn hands(&self) -> &[LoopHand] {
        &self.hands
    }

    /// Records that found no room so far.
    pub fn lost(&self) -> u64 {
        self.lost
    }
}
