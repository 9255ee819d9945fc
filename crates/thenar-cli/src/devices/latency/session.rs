//! One or two trackers that are watched while a person moves.

use crate::devices::keys::{AnyKey, Key, Keys};
use crate::error::CliError;
use crate::interrupt;
use std::time::{Duration, Instant};
use thenar_core::model::Side;
use thenar_link::latency::Trace;
use thenar_link::{Tracker, now_ns};

/// Between two looks at a tracker.
const LOOK: Duration = Duration::from_micros(500);
/// A silent tracker is given up after this.
const PATIENCE: Duration = Duration::from_secs(5);
/// A person who taps no more is given up after this.
const TAP_PATIENCE: Duration = Duration::from_secs(30);
/// A key that comes sooner after another repeats it, or bounces \[s\].
const REPEATS: f64 = 0.3;
/// The last tap is seen within so long after its key \[s\].
const SEEN_BY: f64 = 0.8;

/// The trackers, and what they told since the last [`Session::watch`] began.
pub struct Session {
    pub tracker: Box<dyn Tracker>,
    pub reference: Option<Box<dyn Tracker>>,
    pub side: Side,
    pub trace: Trace,
    pub second: Trace,
    names: [String; 2],
}

impl Session {
    /// Opens them.
    ///
    /// # Errors
    /// An address is wrong, or its device sends no poses.
    pub fn open(address: &str, reference: Option<&str>) -> Result<Self, CliError> {
        let open = |address: &str| {
            let opened = thenar_link::open(address)?;
            opened.tracker.ok_or_else(|| CliError::Input(format!("{address} sends no poses")))
        };
        let (tracker, side) = (open(address)?, Side::Right);
        let names = [address.to_string(), reference.unwrap_or_default().to_string()];
        let reference = reference.map(open).transpose()?;
        let (trace, second) = Default::default();
        Ok(Self { tracker, reference, side, trace, second, names })
    }

    /// Waits until all of them see this hand, or the same one.
    ///
    /// # Errors
    /// One of them does not.
    pub fn meet(&mut self, side: Option<Side>) -> Result<(), CliError> {
        let start = Instant::now();
        loop {
            for hand in
                [Side::Left, Side::Right].into_iter().filter(|hand| side.is_none_or(|s| s == *hand))
            {
                self.side = hand;
                self.look();
                if self.trace.seen.is_empty() {
                    continue;
                }
                // The other one may be a little later, and must see the same hand.
                while self.reference.is_some() && self.second.seen.is_empty() {
                    self.wait(start)?;
                    self.look();
                }
                return Ok(());
            }
            self.wait(start)?;
        }
    }

    /// A pause before the next look, if there is still hope.
    fn wait(&mut self, start: Instant) -> Result<(), CliError> {
        std::thread::sleep(LOOK);
        if start.elapsed() < PATIENCE && !interrupt::asked() {
            return Ok(());
        }
        let [first, second] = &self.names;
        let (name, told) = match &mut self.reference {
            Some(reference) if !self.trace.seen.is_empty() => (second, reference.messages()),
            _ => (first, self.tracker.messages()),
        };
        let hand = if self.side == Side::Left { "left" } else { "right" };
        let told = if told.is_empty() { String::new() } else { format!(": {}", told.join("; ")) };
        Err(CliError::Other(format!("{name} sends no pose of the {hand} hand{told}")))
    }

    /// Takes what came.
    fn look(&mut self) {
        self.trace.take(&mut *self.tracker, self.side, now_ns());
        if let Some(reference) = &mut self.reference {
            self.second.take(&mut **reference, self.side, now_ns());
        }
    }

    /// Forgets what was told before.
    fn begin(&mut self) {
        self.look();
        (self.trace, self.second) = Default::default();
    }

    /// Watches for so long \[s\].
    ///
    /// # Errors
    /// The program is to end.
    pub fn watch(&mut self, seconds: f64) -> Result<(), CliError> {
        self.begin();
        let start = Instant::now();
        while start.elapsed().as_secs_f64() < seconds {
            if interrupt::asked() {
                return Err(CliError::Other(super::UNFINISHED.into()));
            }
            self.look();
            std::thread::sleep(LOOK);
        }
        Ok(())
    }

    /// Watches until `count` keys were pressed, and returns when they were \[s\].
    ///
    /// # Errors
    /// The program is to end. An input that ends, or a person who does, leaves fewer keys.
    pub fn watch_keys(&mut self, count: usize, keys: &Keys) -> Result<Vec<f64>, CliError> {
        let _any = AnyKey::counts();
        self.begin();
        let (mut told, mut last) = (Vec::new(), Instant::now());
        while told.len() < count && last.elapsed() < TAP_PATIENCE {
            if interrupt::asked() {
                return Err(CliError::Other(super::UNFINISHED.into()));
            }
            match keys.heard() {
                Some(Key::Closed) => break,
                Some(Key::Pressed(time_ns)) => {
                    let at = time_ns as f64 * 1e-9;
                    if told.last().is_none_or(|before| at - before > REPEATS) {
                        told.push(at);
                        last = Instant::now();
                    }
                }
                None => {}
            }
            self.look();
            std::thread::sleep(LOOK);
        }
        let end = Instant::now();
        while end.elapsed().as_secs_f64() < SEEN_BY {
            self.look();
            std::thread::sleep(LOOK);
        }
        Ok(told)
    }

    /// Samples per second while it was last watched \[Hz\].
    pub fn rate(&self) -> Option<f64> {
        self.trace.rate()
    }
}
