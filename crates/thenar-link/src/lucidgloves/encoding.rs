//! Lines of LucidGloves and OpenGloves firmware, in both encodings.

use std::str::FromStr;

/// A line of the glove.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// Fingers and buttons.
    State(State),
    /// About the glove itself.
    Info(Info),
}

/// Raw sensor values, `None` where the line had none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State {
    /// Curl of each whole finger, thumb first.
    pub curl: [Option<u16>; 5],
    /// Curl of each joint: four per finger, from the wrist outwards (the thumb's fourth is unused).
    pub joints: [[Option<u16>; 4]; 5],
    /// Splay of each finger.
    pub splay: [Option<u16>; 5],
    /// True if the line was in the older encoding; the glove then expects that one.
    pub legacy: bool,
}

impl State {
    /// Takes over what `newer` tells; sensors that it leaves out keep their value.
    pub fn take(&mut self, newer: &Self) {
        let update = |old: &mut Option<u16>, new: &Option<u16>| *old = new.or(*old);
        self.curl.iter_mut().zip(&newer.curl).for_each(|(old, new)| update(old, new));
        self.splay.iter_mut().zip(&newer.splay).for_each(|(old, new)| update(old, new));
        let joints = newer.joints.iter().flatten();
        self.joints.iter_mut().flatten().zip(joints).for_each(|(old, new)| update(old, new));
        self.legacy = newer.legacy;
    }
}

/// An info packet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Info {
    /// Firmware version.
    pub firmware: Option<u32>,
    /// Kind of glove.
    pub kind: Option<u32>,
    /// Side of the hand: 0 left, 1 right.
    pub hand: Option<u32>,
}

impl std::fmt::Display for Info {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let known = [("firmware", self.firmware), ("type", self.kind)];
        f.write_str("an OpenGloves glove")?;
        for (name, value) in known {
            if let Some(value) = value {
                write!(f, ", {name} {value}")?;
            }
        }
        match self.hand {
            Some(0) => f.write_str(", left hand"),
            Some(1) => f.write_str(", right hand"),
            _ => Ok(()),
        }
    }
}

/// Reads a line. `None` when nothing in it makes sense, or a number is not one of the glove's
/// (larger than `analog_max`): noise must not move a finger.
pub fn parse(line: &[u8], analog_max: u16) -> Option<Line> {
    let text = std::str::from_utf8(line).ok()?.trim();
    if text.contains('&') { legacy(text, analog_max) } else { alpha(text, analog_max) }
}

/// `thumb&index&middle&ring&little&joy x&joy y&` and six buttons; longer lines are of firmware
/// yet to come.
fn legacy(text: &str, analog_max: u16) -> Option<Line> {
    let mut state = State { legacy: true, ..State::default() };
    let mut count = 0;
    for (k, part) in text.split('&').enumerate() {
        let value = u16::from_str(part.trim()).ok()?;
        if let Some(curl) = state.curl.get_mut(k) {
            *curl = Some(within(value, analog_max)?);
        }
        count = k + 1;
    }
    (count >= 13).then_some(Line::State(state))
}

/// Keys, each with a number or none: one capital, or several in brackets. Keys that are not known
/// are left out; anything that is neither key nor number makes the line noise.
fn alpha(text: &str, analog_max: u16) -> Option<Line> {
    let (mut state, mut info, mut is_info) = (State::default(), Info::default(), false);
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let key_length = match first {
            '(' => rest.find(')')? + 1,
            'A'..='Z' => 1,
            _ => return None,
        };
        let (key, after) = rest.split_at(key_length);
        let digits = after.find(|c: char| !c.is_ascii_digit()).unwrap_or(after.len());
        let (number, after) = after.split_at(digits);
        rest = after;
        let key = key.as_bytes();
        match key {
            [finger @ b'A'..=b'E'] => {
                set(&mut state.curl[digit(*finger)], number, analog_max)?;
            }
            [b'(', finger @ b'A'..=b'E', b'B', b')'] => {
                set(&mut state.splay[digit(*finger)], number, analog_max)?;
            }
            [b'(', finger @ b'A'..=b'E', b'A', joint @ b'A'..=b'D', b')'] => {
                let value = &mut state.joints[digit(*finger)][usize::from(joint - b'A')];
                set(value, number, analog_max)?;
            }
            b"Z" => is_info = true,
            [b'(', b'Z', what, b')'] => {
                is_info = true;
                let value = number.parse().ok();
                match what {
                    b'V' => info.firmware = value,
                    b'G' => info.kind = value,
                    b'H' => info.hand = value,
                    _ => {}
                }
            }
            [b'(', inner @ .., b')'] if !inner.iter().all(u8::is_ascii_uppercase) => return None,
            _ => {}
        }
    }
    let any = |values: &[Option<u16>]| values.iter().any(Option::is_some);
    if is_info {
        return Some(Line::Info(info));
    }
    let told = any(&state.curl) || state.joints.iter().any(|joints| any(joints));
    told.then_some(Line::State(state))
}

fn digit(letter: u8) -> usize {
    usize::from(letter - b'A')
}

/// A key without a number tells nothing.
fn set(value: &mut Option<u16>, number: &str, analog_max: u16) -> Option<()> {
    if !number.is_empty() {
        *value = Some(within(number.parse().ok()?, analog_max)?);
    }
    Some(())
}

fn within(value: u16, analog_max: u16) -> Option<u16> {
    (value <= analog_max).then_some(value)
}

/// The line to the glove: where each finger is stopped, 0 free to 1000 blocked open. Always all
/// five, since the firmware takes a missing one for 0.
pub fn stops(stops: &[u16; 5], legacy: bool) -> String {
    let [a, b, c, d, e] = stops.map(|stop| stop.min(1000));
    if legacy { format!("{a}&{b}&{c}&{d}&{e}\n") } else { format!("A{a}B{b}C{c}D{d}E{e}\n") }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(text: &str) -> Option<State> {
        match parse(text.as_bytes(), 4095)? {
            Line::State(state) => Some(state),
            Line::Info(_) => None,
        }
    }

    #[test]
    fn both_encodings_are_read() {
        let expected = [Some(0), Some(1), Some(22), Some(333), Some(4095)];
        let alpha = state("A0B1C22D333E4095F2047G2047P0HIJ(AB)7(BB)8(CB)9(DB)10(EB)11\r").unwrap();
        assert_eq!(alpha.curl, expected);
        assert_eq!(alpha.splay, [Some(7), Some(8), Some(9), Some(10), Some(11)]);
        assert!(!alpha.legacy);
        let legacy = state("0&1&22&333&4095&2047&2047&0&0&0&1&0&1").unwrap();
        assert_eq!((legacy.curl, legacy.legacy), (expected, true));
        let joints = state("A5(BAA)1(BAB)2(BAC)3(BAD)4").unwrap();
        assert_eq!(joints.joints[1], [Some(1), Some(2), Some(3), Some(4)]);
        assert_eq!(joints.curl, [Some(5), None, None, None, None]);
    }

    #[test]
    fn keys_without_numbers_and_keys_of_other_firmware_are_left_out() {
        let read = state("AB7Y9(QQ)3(XYZ)C8").unwrap();
        assert_eq!(read.curl, [None, Some(7), Some(8), None, None]);
    }

    #[test]
    fn noise_moves_no_finger() {
        for noise in [
            "",
            "F3",
            "A",
            "A4096",
            "A99999999999",
            "A1b2",
            "A1 B2",
            "A-1",
            "(A",
            "(ab)3A1",
            "1&2&3",
            "1&2&3&4&9999&6&7&8&9&10&11&12&13",
            "A1B2C\u{fffd}",
            "(A1)2",
        ] {
            assert_eq!(parse(noise.as_bytes(), 4095), None, "{noise:?}");
        }
        assert_eq!(parse(b"A1\xff\xfe", 4095), None);
    }

    #[test]
    fn the_glove_tells_about_itself() {
        let info = Info { firmware: Some(7), kind: Some(2), hand: Some(1) };
        assert_eq!(parse(b"Z(ZV)7(ZG)2(ZH)1", 4095), Some(Line::Info(info)));
    }

    #[test]
    fn all_five_fingers_are_always_told() {
        assert_eq!(stops(&[0; 5], false), "A0B0C0D0E0\n");
        assert_eq!(stops(&[1, 20, 300, 1000, 2000], false), "A1B20C300D1000E1000\n");
        assert_eq!(stops(&[1, 20, 300, 1000, 2000], true), "1&20&300&1000&1000\n");
    }
}
