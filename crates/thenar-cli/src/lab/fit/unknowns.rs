//! Unknowns of a fit: names of parameters, the keys of the scene that they stand for, and where
//! each starts.

use super::assess::{Parameter, Scale};
use thenar_core::model::Law;
use thenar_scene::session::Session;

/// The parameter that moves the zero of depth.
pub const OFFSET: &str = "offset";
/// Unit of an offset \[m\]: as far as first touch is commonly misjudged.
const OFFSET_UNIT: f64 = 0.25e-3;

/// A parameter and the key of the scene that it changes; the offset has none.
#[derive(Clone, Debug, PartialEq)]
pub struct Unknown {
    /// The parameter.
    pub parameter: Parameter,
    /// Key, e.g. `hand.hand.material.young`.
    pub key: Option<String>,
}

impl Unknown {
    /// The zero of depth.
    pub fn offset() -> Self {
        let (name, unit) = (OFFSET.to_string(), "m".to_string());
        let parameter =
            Parameter { name, unit, of: OFFSET_UNIT, scale: Scale::Distance, nuisance: true };
        Self { parameter, key: None }
    }

    /// Reads `young`, `young=3e4`, or a key of the scene with its start,
    /// `hand.hand.material.young=3e4`.
    ///
    /// # Errors
    /// The name is unknown, or there is nowhere to start.
    pub fn read(text: &str, session: &Session) -> Result<Self, String> {
        let (name, start) = match text.split_once('=') {
            Some((name, start)) => {
                let start = start.trim();
                let value: f64 = start.parse().map_err(|_| format!("`{start}` is not a number"))?;
                if !(value.is_finite() && value > 0.0) {
                    return Err(format!("`{text}`: a parameter starts above zero"));
                }
                (name.trim(), Some(value))
            }
            None => (text.trim(), None),
        };
        let factor = |name: &str, unit: &str, of: f64| Parameter {
            name: name.into(),
            unit: unit.into(),
            of,
            scale: Scale::Factor,
            nuisance: false,
        };
        if name.contains('.') {
            let start = start.ok_or(format!("`{name}` needs a start, as in `{name}=1000`"))?;
            return Ok(Self { parameter: factor(name, "", start), key: Some(name.into()) });
        }
        let flesh = Flesh::of(session)?;
        let (tail, unit, found) = flesh.known(name).ok_or_else(|| {
            format!("no parameter `{name}`; there are young, alpha, part1 to part4, time1 to time4, and keys such as {}.young=5e4", flesh.prefix)
        })?;
        let start = start.or(found).ok_or_else(|| {
            let why = match name {
                "alpha" => "its law is not Ogden's",
                _ => "it has no such term of memory (`relaxation`)",
            };
            format!("`{name}` is not a parameter of {}: {why}", flesh.prefix)
        })?;
        Ok(Self {
            parameter: factor(name, unit, start),
            key: Some(format!("{}.{tail}", flesh.prefix)),
        })
    }
}

/// The material that short names speak of: of the first hand, or of the first soft body.
struct Flesh {
    prefix: String,
    young: f64,
    alpha: Option<f64>,
    terms: Vec<[f64; 2]>,
}

impl Flesh {
    fn of(session: &Session) -> Result<Self, String> {
        let softs = &session.world().desc().softs;
        let of_hand = session
            .hands()
            .iter()
            .find_map(|hand| Some((format!("hand.{}.material", hand.name), hand.flesh()?)));
        let of_soft = || Some((format!("soft.{}.material", softs.first()?.name), 0));
        let (prefix, soft) =
            of_hand.or_else(of_soft).ok_or("the scene has no flesh whose moduli could be found")?;
        let flesh = &softs[soft as usize].flesh;
        let young = flesh.materials.iter().map(|m| m.young).fold(0.0, f64::max);
        let alpha = flesh.materials.iter().find_map(|m| match m.law {
            Law::Ogden { alpha } => Some(alpha),
            _ => None,
        });
        let terms = flesh.relaxation.first().map_or(Vec::new(), |r| {
            r.terms().iter().map(|term| [term.weight, term.time]).collect()
        });
        Ok(Self { prefix, young, alpha, terms })
    }

    /// Key behind the prefix, unit and present value of a short name.
    fn known(&self, name: &str) -> Option<(String, &'static str, Option<f64>)> {
        let term = |k: usize, column: usize| {
            let start = self.terms.get(k).map(|term| term[column]);
            (format!("relaxation.{k}.{column}"), ["", "s"][column], start)
        };
        let numbered = |word: &str| {
            let k: usize = name.strip_prefix(word)?.parse().ok()?;
            (1..=4).contains(&k).then(|| k - 1)
        };
        match name {
            "young" => Some(("young".into(), "Pa", Some(self.young))),
            "alpha" => Some(("alpha".into(), "", self.alpha)),
            _ => numbered("part")
                .map(|k| term(k, 0))
                .or_else(|| numbered("time").map(|k| term(k, 1))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn session(material: &str) -> Session {
        let text = format!(
            "version = 1\n[[soft]]\nname = \"pad\"\nshape = {{ kind = \"lattice\", size = [1, 1, 1], cells = [1, 1, 1] }}\n\
             material = {{ {material} }}"
        );
        Session::from_text(&text, Path::new("s.toml"), &[]).unwrap()
    }

    #[test]
    fn short_names_stand_for_keys_and_start_where_the_scene_is() {
        let s = session(
            "young = 3e4, law = \"ogden\", alpha = 8, relaxation = [[0.3, 0.01], [0.2, 1.5]]",
        );
        for (text, key, start) in [
            ("young", "soft.pad.material.young", 3e4),
            ("young=1e5", "soft.pad.material.young", 1e5),
            ("alpha", "soft.pad.material.alpha", 8.0),
            ("part2", "soft.pad.material.relaxation.1.0", 0.2),
            ("time1", "soft.pad.material.relaxation.0.1", 0.01),
            ("soft.pad.material.poisson=0.4", "soft.pad.material.poisson", 0.4),
        ] {
            let u = Unknown::read(text, &s).unwrap();
            assert_eq!((u.key.as_deref(), u.parameter.of), (Some(key), start), "{text}");
        }
    }

    #[test]
    fn what_is_no_parameter_is_refused_with_the_reason() {
        let s = session("young = 3e4");
        for (text, reason) in [
            ("yung", "no parameter `yung`; there are young, alpha"),
            ("part5", "no parameter `part5`"),
            ("alpha", "its law is not Ogden's"),
            ("part1", "no such term of memory"),
            ("young=x", "`x` is not a number"),
            ("young=-3", "starts above zero"),
            ("soft.pad.material.young", "needs a start"),
        ] {
            let error = Unknown::read(text, &s).unwrap_err();
            assert!(error.contains(reason), "{text}: {error}");
        }
        let bare = Session::from_text("version = 1", Path::new("s.toml"), &[]).unwrap();
        assert!(Unknown::read("young", &bare).unwrap_err().contains("no flesh"));
    }
}
