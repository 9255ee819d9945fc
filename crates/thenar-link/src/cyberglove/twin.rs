//! CyberGloves as they speak, with sensors on a hand that curls.

use super::sensors::{SENSORS, place};
use crate::twin::Twin;

/// Between records at 100 Hz \[ns\].
const PERIOD_NS: u64 = 10_000_000;

/// Sensor values 0 to 1 for curls, of a wearer whom the shipped gains and offsets fit: fingers bend
/// by up to 80, 95 and 55 degrees, the thumb by 15, 45 and 60, and is spread by 5 to 22.
fn values(curls: &[f64; 5]) -> [f64; SENSORS] {
    let bend = |degrees: f64| degrees / 110.0 + 0.1;
    let spread = |degrees: f64| degrees / 40.0 + 0.2;
    let [thumb, ..] = *curls;
    let mut values = [0.5; SENSORS];
    values[..4].copy_from_slice(&[
        bend(15.0 * thumb),
        bend(45.0 * thumb),
        bend(60.0 * thumb),
        spread(5.0 + 17.0 * thumb),
    ]);
    for (first, curl) in [4, 7, 11, 15].into_iter().zip(&curls[1..]) {
        for (joint, degrees) in [80.0, 95.0, 55.0].into_iter().enumerate() {
            values[first + joint] = bend(degrees * curl);
        }
    }
    for spread_sensor in [10, 14, 18] {
        values[spread_sensor] = spread(0.0);
    }
    values
}

/// CyberGlove I or II.
pub struct ClassicTwin {
    sensors: usize,
    values: [f64; SENSORS],
    command: Vec<u8>,
    /// Due time of its next record; `None` while it does not stream.
    next_ns: Option<u64>,
}

impl ClassicTwin {
    /// A glove with 18 or 22 sensors.
    pub fn new(sensors: usize) -> Self {
        Self { sensors, values: values(&[0.0; 5]), command: Vec::new(), next_ns: None }
    }

    /// The record that its sensors make.
    pub fn record(&self) -> Vec<u8> {
        let of_place = |k| self.values[place(k, self.sensors).unwrap_or(0)];
        let byte = |k| 1 + (of_place(k).clamp(0.0, 1.0) * 254.0).round() as u8;
        let values = (0..self.sensors).map(byte);
        std::iter::once(b'S').chain(values).chain([0]).collect()
    }
}

impl Twin for ClassicTwin {
    fn power_on(&mut self, _: u64) {
        self.command.clear();
        self.next_ns = None;
    }

    fn step(&mut self, now_ns: u64, received: &[u8], send: &mut dyn FnMut(&[u8])) {
        for byte in received {
            match byte {
                3 => self.next_ns = None,
                // While it streams it hears nothing but the stop.
                _ if self.next_ns.is_some() => {}
                b'S' if self.command.is_empty() => self.next_ns = Some(now_ns),
                b'G' if self.command.is_empty() => send(&self.record()),
                b'\r' => {
                    // It echoes what it was told, and answers queries.
                    if self.command.ends_with(b"?") {
                        self.command.push(1);
                    }
                    send(&self.command);
                    self.command.clear();
                }
                byte if self.command.len() < 32 => self.command.push(*byte),
                _ => self.command.clear(),
            }
        }
        if let Some(next) = self.next_ns.filter(|next| now_ns >= *next) {
            send(&self.record());
            // A late step does not bring a burst.
            self.next_ns = Some((next + PERIOD_NS).max(now_ns));
        }
    }

    fn set_curls(&mut self, curls: [f64; 5]) {
        self.values = values(&curls);
    }

    fn felt(&self) -> [f64; 5] {
        [0.0; 5]
    }
}

/// CyberGlove III.
pub struct ThirdTwin {
    values: [f64; SENSORS],
    command: Vec<u8>,
    set_up: bool,
    next_ns: Option<u64>,
    /// Streams were started so often.
    pub starts: u32,
}

impl Default for ThirdTwin {
    fn default() -> Self {
        let values = values(&[0.0; 5]);
        Self { values, command: Vec::new(), set_up: false, next_ns: None, starts: 0 }
    }
}

impl ThirdTwin {
    /// The packet that its sensors make at this time.
    pub fn packet(&self, now_ns: u64) -> Vec<u8> {
        let hundredths = now_ns / 10_000_000;
        let seconds = hundredths / 100;
        let mut packet = format!(
            "{:02}:{:02}:{:02}:{:02}:{}S",
            seconds / 3600 % 24,
            seconds / 60 % 60,
            seconds % 60,
            hundredths % 100,
            now_ns / 1_000_000 % 10
        )
        .into_bytes();
        for value in self.values {
            let raw = (value.clamp(0.0, 1.0) * 4095.0).round() as u16;
            packet.extend_from_slice(&raw.to_be_bytes());
        }
        packet.extend_from_slice(&[0, 0, 0]);
        packet
    }
}

impl Twin for ThirdTwin {
    fn power_on(&mut self, _: u64) {
        self.command.clear();
        (self.set_up, self.next_ns) = (false, None);
    }

    fn step(&mut self, now_ns: u64, received: &[u8], send: &mut dyn FnMut(&[u8])) {
        for byte in received {
            match byte {
                3 => self.next_ns = None,
                0 => {
                    match self.command.as_slice() {
                        b"1E4010111" => self.set_up = true,
                        b"1S" if self.set_up => {
                            self.next_ns = Some(now_ns);
                            self.starts += 1;
                        }
                        _ => {}
                    }
                    self.command.clear();
                }
                byte if self.command.len() < 32 => self.command.push(*byte),
                _ => self.command.clear(),
            }
        }
        if let Some(next) = self.next_ns.filter(|next| now_ns >= *next) {
            send(&self.packet(now_ns));
            self.next_ns = Some((next + PERIOD_NS).max(now_ns));
        }
    }

    fn set_curls(&mut self, curls: [f64; 5]) {
        self.values = values(&curls);
    }

    fn felt(&self) -> [f64; 5] {
        [0.0; 5]
    }
}
