//! A recording as a tracker: in real time, or at times that are given.

use crate::options::Options;
use crate::pose_stream::{LINE_BYTES_MAX, Line, natural_order};
use crate::{Driver, FoundDevice, HandSample, LinkError, Opened, Tracker, now_ns};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::Arc;
use thenar_core::model::Side;
use thenar_track::RECORDING_BYTES_MAX;
use thenar_track::live::LivePose;

/// Between the last sample and the first of the next round \[s\].
const PAUSE: f64 = 0.011;

/// Samples of one hand: time \[s\], from the first of either hand, and pose.
type Samples = Vec<(f64, Option<LivePose>)>;

/// A recording of two hands.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Left, right.
    hands: [Samples; 2],
    /// Time of the last sample \[s\].
    pub duration: f64,
}

impl Motion {
    /// Reads a recording: the lines of a pose stream, with times that do not go back.
    ///
    /// # Errors
    /// The file cannot be read, or a line is wrong: its number and the cause.
    pub fn open(path: &Path) -> Result<Self, LinkError> {
        let what = format!("recording {}", path.display());
        let refuse = |cause: String| LinkError::Setting { what: what.clone(), cause };
        let (file, _) = thenar_input::open_plain(path).map_err(|e| refuse(e.to_string()))?;
        Self::read(BufReader::new(file)).map_err(refuse)
    }

    /// Reads the lines of a recording.
    ///
    /// # Errors
    /// As [`Self::open`], without the file's name.
    pub fn read(mut lines: impl BufRead) -> Result<Self, String> {
        let (mut motion, mut order) = (Self::default(), natural_order());
        let (mut text, mut bytes, mut first) = (Vec::new(), 0, None);
        for number in 1.. {
            text.clear();
            let longest = LINE_BYTES_MAX as u64 + 1;
            let read = (&mut lines).take(longest).read_until(b'\n', &mut text);
            let read = read.map_err(|e| e.to_string())? as u64;
            bytes += read;
            if read == 0 {
                break;
            }
            if read == longest || bytes > RECORDING_BYTES_MAX {
                return Err(format!("line {number}: the line or the file is too long"));
            }
            if text.trim_ascii().is_empty() {
                continue;
            }
            let line = Line::read(text.trim_ascii(), &order);
            match line.map_err(|cause| format!("line {number}: {cause}"))? {
                Line::Header(new) => order = new,
                Line::Hand { time: None, .. } => {
                    return Err(format!("line {number}: t is missing"));
                }
                Line::Hand { side, time: Some(time), pose } => {
                    let time = time - *first.get_or_insert(time);
                    let samples = &mut motion.hands[side as usize];
                    if time < samples.last().map_or(0.0, |last| last.0) {
                        return Err(format!("line {number}: time goes back"));
                    }
                    motion.duration = motion.duration.max(time);
                    samples.push((time, pose));
                }
            }
        }
        match motion.hands.iter().all(Vec::is_empty) {
            true => Err("no sample of any hand".into()),
            false => Ok(motion),
        }
    }
}

/// Settings for playing a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Over and over.
    pub looping: bool,
    /// Seconds of the recording per second.
    pub speed: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { looping: false, speed: 1.0 }
    }
}

/// Plays a recording.
#[derive(Clone, Debug)]
pub struct Replay {
    motion: Arc<Motion>,
    settings: Settings,
    start_ns: u64,
    /// The time that was given; `None` for the process's own clock.
    given_ns: Option<u64>,
    /// Samples of each hand that were told: whole rounds and the number in this one.
    told: [Option<(u64, usize)>; 2],
    newest: [HandSample; 2],
    heard_ns: Option<u64>,
}

impl Replay {
    /// Plays from now on, in real time.
    pub fn new(motion: Arc<Motion>, settings: Settings) -> Self {
        Self::starting(motion, settings, now_ns(), None)
    }

    /// Plays by the times that [`Self::step_to`] gives, from `start_ns` on.
    pub fn stepped(motion: Arc<Motion>, settings: Settings, start_ns: u64) -> Self {
        Self::starting(motion, settings, start_ns, Some(start_ns))
    }

    fn starting(
        motion: Arc<Motion>,
        settings: Settings,
        start_ns: u64,
        given_ns: Option<u64>,
    ) -> Self {
        let newest = [Side::Left, Side::Right];
        let newest = newest.map(|side| HandSample { side, time_ns: start_ns, pose: None });
        let (told, heard_ns) = ([None; 2], None);
        Self { motion, settings, start_ns, given_ns, told, newest, heard_ns }
    }

    /// Moves the replay on to this time.
    pub fn step_to(&mut self, now_ns: u64) {
        self.given_ns = Some(now_ns);
    }
}

impl Tracker for Replay {
    fn latest(&mut self, side: Side) -> Option<&HandSample> {
        let now = self.given_ns.unwrap_or_else(now_ns);
        let passed = now.checked_sub(self.start_ns)? as f64 * 1e-9 * self.settings.speed;
        let round_time = self.motion.duration + PAUSE;
        let round = if self.settings.looping { (passed / round_time).floor() } else { 0.0 };
        let samples = &self.motion.hands[side as usize];
        let due = samples.partition_point(|(time, _)| *time <= passed - round * round_time);
        let number = due.checked_sub(1)?;
        let told = &mut self.told[side as usize];
        if *told >= Some((round as u64, number)) {
            return None;
        }
        *told = Some((round as u64, number));
        let (time, pose) = &samples[number];
        let after = (round * round_time + time) / self.settings.speed;
        let newest = &mut self.newest[side as usize];
        newest.time_ns = self.start_ns + (after * 1e9) as u64;
        newest.pose.clone_from(pose);
        self.heard_ns = Some(newest.time_ns);
        Some(newest)
    }

    fn heard_ns(&mut self) -> Option<u64> {
        self.heard_ns
    }

    fn messages(&mut self) -> Vec<String> {
        Vec::new()
    }
}

/// Driver of addresses `replay:FILE`.
pub struct ReplayDriver;

impl Driver for ReplayDriver {
    fn name(&self) -> &'static str {
        "replay"
    }

    fn about(&self) -> &'static str {
        "a recording of hands, replay:FILE.jsonl?loop=yes&speed=0.5"
    }

    fn enumerate(&self) -> Vec<FoundDevice> {
        Vec::new()
    }

    fn open(&self, address: &str) -> Result<Opened, LinkError> {
        let options = Options::parse(self.name(), address, &["loop", "speed"])?;
        let looping = match options.text("loop") {
            None | Some("no") => false,
            Some("yes") => true,
            Some(other) => {
                return Err(options.refuse(format!("loop is `{other}`, expected yes or no")));
            }
        };
        let speed = options.value("speed", "a number")?.unwrap_or(1.0);
        if !(0.01..=100.0).contains(&speed) {
            return Err(options.refuse(format!("speed is {speed}, expected 0.01 to 100")));
        }
        open(Path::new(options.place), &Settings { looping, speed })
    }
}

/// Opens a recording.
pub(crate) fn open(path: &Path, settings: &Settings) -> Result<Opened, LinkError> {
    let motion = Arc::new(Motion::open(path)?);
    Ok(Opened { tracker: Some(Box::new(Replay::new(motion, *settings))), display: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pose_stream::write;
    use crate::testing::hands;

    const MS: u64 = 1_000_000;

    /// Left hand at 0, 10, ... 90 ms after 5 s; it is lost at 100 ms; the right hand at 45 ms.
    fn motion() -> Arc<Motion> {
        let hand = |side| LivePose::Joints { joints: hands(side)[0], radii: [0.01; 25] };
        let mut text = String::new();
        for k in 0..10 {
            text += &write(Side::Left, 5.0 + 0.01 * f64::from(k), Some(&hand(Side::Left)));
        }
        text += &write(Side::Right, 5.045, Some(&hand(Side::Right)));
        text += &write(Side::Left, 5.1, None);
        Arc::new(Motion::read(text.as_bytes()).unwrap())
    }

    fn times(replay: &mut Replay, side: Side, to_ms: u64) -> Vec<u64> {
        let mut times = Vec::new();
        for tick in 0..to_ms * 4 {
            replay.step_to(1000 * MS + tick * MS / 4);
            times.extend(replay.latest(side).map(|sample| sample.time_ns.div_ceil(100_000)));
        }
        times
    }

    /// In tenths of milliseconds.
    #[test]
    fn samples_come_when_they_are_due_and_once() {
        let mut replay = Replay::stepped(motion(), Settings::default(), 1000 * MS);
        let left: Vec<u64> = (0..=10).map(|k| 10_000 + 100 * k).collect();
        assert_eq!(times(&mut replay, Side::Left, 500), left);
        assert!(replay.newest[0].pose.is_none(), "the hand was lost at the end");
        let mut replay = Replay::stepped(motion(), Settings::default(), 1000 * MS);
        assert_eq!(times(&mut replay, Side::Right, 500), [10_450]);
        let half = Settings { speed: 0.5, looping: false };
        let mut replay = Replay::stepped(motion(), half, 1000 * MS);
        assert_eq!(times(&mut replay, Side::Right, 500), [10_900]);
    }

    #[test]
    fn a_loop_goes_on_with_rising_times() {
        let settings = Settings { looping: true, speed: 1.0 };
        let mut replay = Replay::stepped(motion(), settings, 1000 * MS);
        let right: Vec<u64> = (0..5).map(|round| 10_450 + 1110 * round).collect();
        assert_eq!(times(&mut replay, Side::Right, 550), right);
        // A loop that looks rarely sees the newest only.
        let mut replay = Replay::stepped(motion(), settings, 0);
        replay.step_to(10_000 * MS);
        assert!(replay.latest(Side::Left).is_some() && replay.latest(Side::Left).is_none());
        replay.step_to(9_000 * MS);
        assert!(replay.latest(Side::Left).is_none(), "a clock that goes back tells nothing");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let told = |text: &str| Motion::read(text.as_bytes()).unwrap_err();
        assert_eq!(told(""), "no sample of any hand");
        let lost = "{\"t\":1,\"hand\":\"left\",\"tracked\":false}\n";
        assert!(told(&format!("{lost}\n{{\"t\":2}}")).starts_with("line 3: column"));
        assert_eq!(told("{\"hand\":\"left\",\"tracked\":false}"), "line 1: t is missing");
        assert_eq!(told(&format!("{lost}{}", lost.replace(":1", ":0"))), "line 2: time goes back");
        assert!(told(&" ".repeat(LINE_BYTES_MAX + 5)).contains("too long"));
        let error = Motion::open(Path::new("no such file")).unwrap_err().to_string();
        assert!(error.starts_with("recording no such file: "), "{error}");
    }
}
