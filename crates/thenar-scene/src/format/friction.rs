//! Friction of a pair: a number, or the name of a table of skin on a material.

use crate::text::{Cx, Defs, Fault, Node, Read, Value, words};
use serde_json::{Value as Json, json};

words! {
    /// Skin of a fingertip on a material.
    pub enum SkinOnWord {
        /// Clean dry aluminium.
        "skin-on-aluminium" => Aluminium,
        /// Clean dry rubber.
        "skin-on-rubber" => Rubber,
        /// Clean dry glass, just touched.
        "skin-on-glass-dry" => GlassDry,
        /// Wet smooth glass.
        "skin-on-glass-wet" => GlassWet,
    }
}

impl SkinOnWord {
    /// Coefficients by load, as `[load [N], coefficient]`; of one row, the same at every load.
    ///
    /// Aluminium and rubber: `μ = μ₁ N^p`, which falls by 46 % from 1 to 20 N, so
    /// `p = ln 0.54 / ln 20` = -0.2057, with the mean of twelve people, 0.6 and 0.9, taken over the
    /// loads tried, 1, 10 and 20 N (Seo et al. 2009). The rows at 0.5 N go on beyond what was
    /// measured. Wet glass: 0.78 with a standard deviation of 0.35 between people, of stationary
    /// sliding (Derler and Rotaru 2013); where it sticks and slips, 0.53 with 0.21. Dry glass: the
    /// same at every load while contact is short (Dzidek et al. 2017); its value, 0.6, is that of
    /// aluminium, smooth and impermeable as well, for want of a table: a band of 0.3 to 1, and up
    /// to 10 times as much after some ten seconds of contact, when sweat has softened the skin
    /// (Adams et al. 2013).
    pub fn points(self) -> &'static [[f64; 2]] {
        match self {
            Self::Aluminium => &[
                [0.5, 0.960],
                [1.0, 0.832],
                [2.0, 0.722],
                [5.0, 0.598],
                [10.0, 0.518],
                [20.0, 0.449],
            ],
            Self::Rubber => &[
                [0.5, 1.440],
                [1.0, 1.248],
                [2.0, 1.083],
                [5.0, 0.897],
                [10.0, 0.777],
                [20.0, 0.674],
            ],
            Self::GlassDry => &[[1.0, 0.6]],
            Self::GlassWet => &[[1.0, 0.78]],
        }
    }
}

/// Value of a pair's `friction`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PairFriction {
    /// One coefficient.
    Coefficient(f64),
    /// Coefficients by load, by the name of what skin is on.
    Skin(SkinOnWord),
}

impl Read for PairFriction {
    fn read(node: &Node, cx: &Cx<'_>) -> Result<Self, Fault> {
        match node.value {
            Value::Text(_) => SkinOnWord::read(node, cx).map(Self::Skin),
            _ => f64::read(node, cx).map(Self::Coefficient),
        }
    }

    fn schema(defs: &mut Defs, cx: &Cx<'_>) -> Json {
        json!({ "oneOf": [f64::schema(defs, cx), SkinOnWord::schema(defs, cx)] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The power law that the rows were rounded from, and its mean, against the published figures.
    #[test]
    fn tables_fall_by_46_percent_around_the_means_measured() {
        let p = 0.54_f64.ln() / 20_f64.ln();
        assert!((p + 0.2057).abs() < 5e-5, "{p}");
        let mean = [1.0, 10.0, 20.0_f64].map(|load| load.powf(p)).iter().sum::<f64>() / 3.0;
        for (word, want) in [(SkinOnWord::Aluminium, 0.6), (SkinOnWord::Rubber, 0.9)] {
            let rows = word.points();
            let at_one = rows[1][1];
            for [load, mu] in rows {
                assert!((mu - at_one * load.powf(p)).abs() < 2e-3, "{word:?}: {mu} at {load} N");
            }
            let [first, last] = [at_one, rows[rows.len() - 1][1]];
            assert!((last / first - 0.54).abs() < 1e-3, "{word:?}: {first} to {last}");
            assert!((at_one * mean / want - 1.0).abs() < 1e-3, "{word:?}: {}", at_one * mean);
        }
    }
}
