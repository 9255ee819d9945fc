//! The size of a body in words, and the unit that its file may be in.

use thenar_core::Vec3;

/// Hands hold nothing longer than this \[m\], and tables are shorter too.
const LONGEST: f64 = 4.0;
/// Nothing that stands still around hands is longer \[m\]: a hall.
const LONGEST_STILL: f64 = 100.0;
/// Hands neither lift nor push what is heavier than this \[kg\]: over a floor with friction 0.2 it
/// takes 390 N, half the weight of a person of 80 kg. A choice, not measured.
const HEAVIEST: f64 = 200.0;
/// Hands hold nothing shorter than this \[m\]: a grain of sand.
const SHORTEST: f64 = 1e-3;
/// Lengths of things that hands hold \[m\].
const HANDY: [f64; 2] = [2e-3, 0.8];
/// Units that meshes come in, and metres in each.
const UNITS: [(&str, f64); 5] = [
    ("millimetres", 1e-3),
    ("centimetres", 1e-2),
    ("inches", 0.0254),
    ("feet", 0.3048),
    ("metres", 1.0),
];

/// A length \[m\] in the unit in which it reads well.
pub fn length_in_words(metres: f64) -> String {
    match metres {
        1e-5..1.0 => format!("{:.2} mm", metres * 1e3),
        1.0..1e4 => format!("{metres:.3} m"),
        0.0 => "0 mm".into(),
        _ => format!("{metres:.2e} m"),
    }
}

/// Edge lengths of a box \[m\] in words.
pub fn size_in_words(size: &Vec3) -> String {
    let [x, y, z] = [size.x, size.y, size.z].map(length_in_words);
    format!("{x} x {y} x {z}")
}

/// A mass \[kg\] in words.
pub fn mass_in_words(mass: f64) -> String {
    match mass {
        1e-5..1.0 => format!("{:.2} g", mass * 1e3),
        1.0..1e4 => format!("{mass:.3} kg"),
        0.0 => "0 kg".into(),
        _ => format!("{mass:.2e} kg"),
    }
}

/// A volume \[m³\] in the unit in which it reads well.
pub fn volume_in_words(volume: f64) -> String {
    match volume {
        1e-9..1e-3 => format!("{:.3} ml", volume * 1e6),
        1e-3..1.0 => format!("{:.3} l", volume * 1e3),
        1.0..1e4 => format!("{volume:.3} m³"),
        0.0 => "0 ml".into(),
        _ => format!("{volume:.2e} m³"),
    }
}

/// A body as it was read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Longest side \[m\].
    pub longest: f64,
    /// Mass \[kg\]; 0 where it is not known, or does not count since no hand is to move it.
    pub mass: f64,
    /// True of what stands still, which may be a room.
    pub still: bool,
}

impl Extent {
    /// True if hands may have to do with such a body: it is neither a speck nor a house, and what
    /// moves and is longer than what hands hold weighs no more than they can push.
    fn is_plausible(&self) -> bool {
        let most = if self.still { LONGEST_STILL } else { LONGEST };
        let heavy = !self.still && self.longest > HANDY[1] && self.mass > HEAVIEST;
        (SHORTEST..=most).contains(&self.longest) && !heavy
    }
}

/// A question about a body that was read at this scale; `None` where its size and mass are
/// plausible. `key` is what a user writes before a scale: `--scale `, `scale = `.
pub fn unit_question(body: &Extent, scale: f64, key: &str) -> Option<String> {
    if body.is_plausible() {
        return None;
    }
    let longest = body.longest;
    let long = |metres: f64| longest / scale * metres;
    let fits = |(_, metres): &&(&str, f64)| (HANDY[0]..=HANDY[1]).contains(&long(*metres));
    let fitting: Vec<&(&str, f64)> = UNITS.iter().filter(fits).collect();
    Some(match fitting[..] {
        [] => format!("is the scale ({key}{scale}) right?"),
        [(unit, metres)] => format!(
            "are these {unit}? Then give {key}{metres}, and it is {} long",
            length_in_words(long(*metres))
        ),
        _ => {
            let one = |(unit, metres): &&(&str, f64)| {
                format!("{unit} ({key}{metres}: {} long)", length_in_words(long(*metres)))
            };
            let all: Vec<String> = fitting.iter().map(one).collect();
            format!("are these {}?", all.join(" or "))
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_of_20_mm_read_in_metres_is_asked_about() {
        let body = |longest, still| Extent { longest, mass: 0.0, still };
        let asked = |longest, scale| unit_question(&body(longest, false), scale, "--scale ");
        let question = asked(20.0, 1.0).unwrap();
        assert!(
            question.contains("millimetres (--scale 0.001: 20.00 mm long)")
                && question.contains("centimetres (--scale 0.01: 200.00 mm long)"),
            "{question}"
        );
        assert_eq!(asked(0.02, 1.0), None);
        assert_eq!(asked(0.02, 0.001), None, "what was scaled rightly is let be");
        // A statue in centimetres as a game has it, scaled by the wrong factor.
        assert!(asked(50.0, 10.0).unwrap().contains("millimetres"));
        assert!(asked(5e4, 1.0).unwrap().contains("is the scale (--scale 1)"));
        // A cup in metres, taken for one in units a thousand times as small.
        let small = asked(1.3e-4, 1e-3).unwrap();
        assert!(small.contains("metres (--scale 1: 130.00 mm long)"), "{small}");
        // A floor of 8 m is no cup; one of 130 m may be.
        assert!(asked(8.0, 1.0).is_some());
        assert_eq!(unit_question(&body(8.0, true), 1.0, "scale = "), None);
        let in_scene = unit_question(&body(130.0, true), 1.0, "scale = ").unwrap();
        assert!(in_scene.contains("give scale = 0.001, and it is 130.00 mm"), "{in_scene}");
    }

    /// A tool of 60 mm in inches, read in metres, and a sack of 40 kg that is as long as a hand can
    /// hold.
    #[test]
    fn what_no_hand_moves_is_asked_about() {
        let asked =
            |longest, mass, still| unit_question(&Extent { longest, mass, still }, 1.0, "--scale ");
        let question = asked(2.36, 6.7e3, false).unwrap();
        assert!(question.contains("inches (--scale 0.0254: 59.94 mm long)"), "{question}");
        assert!(question.contains("feet (--scale 0.3048: 719.33 mm long)"), "{question}");
        assert_eq!(asked(2.36, 6.7e3, true), None, "a shelf that stands still");
        assert_eq!(asked(2.36, 6.7, false), None, "a long pole");
        assert_eq!(asked(1.0, 40.0, false), None);
        assert_eq!(asked(1.0, 199.0, false), None);
        assert!(asked(1.0, 201.0, false).is_some());
        // As long as what hands hold: whatever it weighs, its unit is right.
        assert_eq!(asked(0.3, 210.0, false), None, "a ball of lead");
    }

    #[test]
    fn lengths_masses_and_volumes_read_well() {
        let words = [1e-6, 5e-5, 0.02, 1.5, 130.0, 5e4].map(length_in_words);
        assert_eq!(words, ["1.00e-6 m", "0.05 mm", "20.00 mm", "1.500 m", "130.000 m", "5.00e4 m"]);
        assert_eq!(size_in_words(&Vec3::new(0.02, 0.03, 2.0)), "20.00 mm x 30.00 mm x 2.000 m");
        let words = [0.018, 0.3, 12.5, 2.2e9, 0.0].map(mass_in_words);
        assert_eq!(words, ["18.00 g", "300.00 g", "12.500 kg", "2.20e9 kg", "0 kg"]);
        let words = [3.6e-5, 0.002, 8.0, 1.384e5, 0.0].map(volume_in_words);
        assert_eq!(words, ["36.000 ml", "2.000 l", "8.000 m³", "1.38e5 m³", "0 ml"]);
    }
}
