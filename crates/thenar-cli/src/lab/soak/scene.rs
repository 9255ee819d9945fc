//! Scene of a soak: a closed pen with a table, a car, a loaf and a hand that goes anywhere in it.

use std::fmt::Write as _;
use std::path::Path;
use thenar_core::model::BodyId;
use thenar_scene::session::{Random, Session, StartOverlap};

/// Half the width of the pen that keeps everything within reach, and its height \[m\].
const PEN: [f64; 2] = [0.25, 0.4];
/// Places for the hand's start that are tried: where one in ten is without overlap, all fail for
/// one seed in 800.
const TRIES: u32 = 64;

/// Opens the scene of a seed where the hand overlaps nothing; also tells how many places were tried
/// before. A seed always gives one place, and one motion after it wherever it begins.
///
/// # Errors
/// The scene is wrong, or everything that was tried overlaps.
pub fn open(seconds: f64, seed: u32, overrides: &[String]) -> Result<(Session, u32), String> {
    let mut last = String::new();
    for attempt in 0..TRIES {
        let text = scene(seconds, seed, attempt);
        let session = Session::from_text(&text, Path::new("soak.toml"), overrides);
        let session = session.map_err(|e| e.to_string())?;
        let overlaps = session.start_overlaps();
        // What overlaps without the hand does so wherever the hand is.
        if let Some(overlap) = overlaps.iter().find(|overlap| !is_of_hand(overlap)) {
            return Err(format!("no start without overlap: {overlap}"));
        }
        match overlaps.first() {
            None => return Ok((session, attempt)),
            Some(overlap) => last = overlap.to_string(),
        }
    }
    Err(format!("no start without overlap among {TRIES} of seed {seed}; of the last: {last}"))
}

/// True when the hand is one of the bodies.
fn is_of_hand(overlap: &StartOverlap) -> bool {
    overlap
        .bodies
        .iter()
        .any(|body| body == "hand" || body.starts_with("hand (") || body.starts_with("hand/"))
}

/// A closed pen with a table, a car, a loaf and a hand that goes anywhere in it at random.
fn scene(seconds: f64, seed: u32, attempt: u32) -> String {
    let mut random = Random::new(u64::from(seed));
    let mut text = String::from(
        r#"
version = 1
gravity = [0, -9.81, 0]

[[rigid]]
name = "table"
shape = { kind = "plane" }
motion = "fixed"
"#,
    );
    let [half, height] = PEN;
    let walls = [
        ("east", [half, 0.0], 90.0, [0, 0, 1]),
        ("west", [-half, 0.0], -90.0, [0, 0, 1]),
        ("north", [0.0, half], -90.0, [1, 0, 0]),
        ("south", [0.0, -half], 90.0, [1, 0, 0]),
    ];
    for (name, [x, z], angle, axis) in walls {
        let _ = write!(
            text,
            "\n[[rigid]]\nname = \"{name}\"\nshape = {{ kind = \"plane\" }}\nmotion = \"fixed\"\n\
             position = [{x}, 0, {z}]\nrotation = {{ axis = {axis:?}, angle_deg = {angle} }}\n"
        );
    }
    let _ = write!(
        text,
        r#"
[[rigid]]
name = "lid"
shape = {{ kind = "plane" }}
motion = "fixed"
position = [0, {height}, 0]
rotation = {{ axis = [0, 0, 1], angle_deg = 180 }}

[[rigid]]
name = "car"
shape = {{ kind = "car" }}
mass = 0.1
position = [0.1, 0.03, 0.1]

[[soft]]
name = "bread"
shape = {{ kind = "bread" }}
position = [-0.1, 0.06, 0]
material = {{ young = 12e3, poisson = 0.25, density = 250 }}
stiffness_damping = 0.005

[[hand]]
name = "hand"
position = [0, 0.2, 0]
motion = {{ kind = "keyframes", limits = "clamp", key = [
"#
    );
    // It begins above everything.
    let (mut t, mut lowest) = (0.0, 0.2);
    while t < seconds + 1.0 {
        let mut key = key(&mut random, lowest);
        if t == 0.0 && attempt > 0 {
            let mut elsewhere = Random::new(u64::from(attempt) << 32 | u64::from(seed));
            key = self::key(&mut elsewhere, lowest);
        }
        let _ = writeln!(text, "{{ time = {t:.3}, {key} }},");
        t += random.range(0.25, 0.9);
        lowest = 0.02;
    }
    text.push_str("] }\n");
    text
}

/// A pose at random, its wrist no lower than this \[m\].
fn key(random: &mut Random, lowest: f64) -> String {
    let position: Vec<String> = [-0.15, lowest, -0.15]
        .iter()
        .zip([0.15, 0.25, 0.15])
        .map(|(low, high)| format!("{:.4}", random.range(*low, high)))
        .collect();
    let curl: Vec<String> = ["thumb", "index", "middle", "ring", "little"]
        .iter()
        .map(|finger| format!("{finger} = {:.3}", random.range(0.0, 1.0)))
        .collect();
    let fingers: Vec<String> = (0..3).map(|_| format!("{:.3}", random.symmetric())).collect();
    let back: Vec<String> = (0..3).map(|_| format!("{:.3}", random.symmetric())).collect();
    format!(
        "wrist = {{ position = [{}], fingers = [{}], back = [{}] }}, curl = {{ {} }}",
        position.join(", "),
        fingers.join(", "),
        back.join(", "),
        curl.join(", ")
    )
}

/// Name of a body of the scene.
pub fn name_of(body: BodyId) -> &'static str {
    match body {
        BodyId::Soft(0) => "the hand",
        BodyId::Soft(_) => "the bread",
        BodyId::Rigid(0) => "the table",
        BodyId::Rigid(1..=4) => "a wall",
        BodyId::Rigid(5) => "the lid",
        BodyId::Rigid(6) => "the car",
        BodyId::Rigid(_) => "a bone",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The hand that is built soonest.
    const PAPER: &str = "hand.hand.preset=paper";

    fn opened(seed: u32, attempt: u32) -> Session {
        let text = scene(1.0, seed, attempt);
        Session::from_text(&text, Path::new("soak.toml"), &[PAPER.into()]).unwrap()
    }

    /// Seed 202 would begin 48 mm inside a wall. Another place is found, the same each time.
    #[test]
    fn a_soak_begins_where_nothing_overlaps() {
        let deepest = opened(202, 0).start_overlaps()[0].depth;
        assert!((deepest - 0.048).abs() < 0.001, "{deepest} m");
        let (session, tries) = open(1.0, 202, &[PAPER.into()]).unwrap();
        assert!(tries > 0 && session.start_overlaps().is_empty());
        let again = open(1.0, 202, &[PAPER.into()]).unwrap();
        assert_eq!(again.1, tries);
        assert_eq!(again.0.world().state_hash(), session.world().state_hash());
    }

    /// The motion after the start is that of the seed.
    #[test]
    fn only_the_first_pose_depends_on_the_attempt() {
        let [one, other] = [0, 1].map(|attempt| scene(5.0, 3, attempt));
        let apart: Vec<_> = one.lines().zip(other.lines()).filter(|(a, b)| a != b).collect();
        assert_eq!(apart.len(), 1);
        assert!(apart[0].0.starts_with("{ time = 0.000, "), "{apart:?}");
    }
}
