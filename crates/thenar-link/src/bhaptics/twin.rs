//! The maker's player, as far as it can be felt.

use crate::DIGITS;
use serde::Deserialize;
use thenar_core::model::Side;

/// Status that the player sends when a host has called: a pair of gloves.
pub const STATUS: &str = r#"{"ConnectedPositions":["GloveL","GloveR"]}"#;

/// Submission of a host.
#[derive(Deserialize)]
struct Request {
    #[serde(default, rename = "Submit")]
    submit: Vec<Submission>,
}

#[derive(Deserialize)]
struct Submission {
    #[serde(rename = "Frame")]
    frame: Frame,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Frame {
    duration_millis: u64,
    position: String,
    dot_points: Vec<Dot>,
}

#[derive(Deserialize)]
struct Dot {
    index: usize,
    intensity: u8,
}

/// A pair of gloves. Pure: time and messages in, vibration out.
#[derive(Clone, Debug, Default)]
pub struct SimulatedPlayer {
    /// Left, right: intensities, and when they end \[ns\].
    gloves: [([u8; DIGITS], u64); 2],
}

impl SimulatedPlayer {
    /// Takes a message of the host.
    ///
    /// # Errors
    /// It is none.
    pub fn receive(&mut self, now_ns: u64, text: &str) -> Result<(), serde_json::Error> {
        let request: Request = serde_json::from_str(text)?;
        for Submission { frame } in request.submit {
            let glove = match frame.position.as_str() {
                "GloveL" => &mut self.gloves[0],
                "GloveR" => &mut self.gloves[1],
                _ => continue,
            };
            let mut tips = [0; DIGITS];
            for dot in frame.dot_points {
                if let Some(tip) = tips.get_mut(dot.index) {
                    *tip = dot.intensity.min(100);
                }
            }
            *glove = (tips, now_ns.saturating_add(frame.duration_millis.saturating_mul(1_000_000)));
        }
        Ok(())
    }

    /// Vibration of each fingertip, 0 to 100, thumb first.
    pub fn felt(&self, side: Side, now_ns: u64) -> [u8; DIGITS] {
        let (tips, until) = self.gloves[side as usize];
        if now_ns < until { tips } else { [0; DIGITS] }
    }
}
