//! Why a grip is not had as it was asked for.

use super::loss::Loss;
use super::opposition::Opposition;
use serde::{Deserialize, Serialize};

/// Trouble of a grip. Lengths in m, forces in N.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Trouble {
    /// The object is wider than the pads open, wherever they could go.
    TooLarge {
        /// Least width of the object where the hand is.
        width: f64,
        /// Width that the pads span.
        opening: f64,
    },
    /// No two places of the object near the hand face away from each other.
    NoOpposite {
        /// Width that the pads span.
        opening: f64,
    },
    /// The object is nowhere near the pads.
    Far {
        /// From the pads to the object.
        distance: f64,
    },
    /// A pad does not get to its place.
    OutOfReach {
        /// Number of the pad: the base 0, the fingers from 1.
        pad: u8,
        /// Distance at which it ends from there.
        miss: f64,
    },
    /// The fingers are closed as far as they go, and bear less than asked.
    Weak {
        /// Force that they bear.
        felt: f64,
    },
    /// Nothing was touched where the object was to be.
    Missed,
    /// The object slips out of pads that press no harder.
    Slippery {
        /// Force that would keep it from slipping under its weight.
        needed: f64,
        /// Friction between it and the hand.
        friction: f64,
    },
    /// The object was held, and has slipped out.
    Lost {
        /// Force that was wanted last.
        wanted: f64,
    },
    /// The object is nearly as wide as the pads open, and from where the hand is one of them does
    /// not get around it.
    Wide {
        /// Width of the object where pads go.
        width: f64,
        /// Width that the pads span.
        opening: f64,
        /// Number of the pad: the base 0, the fingers from 1.
        pad: u8,
        /// Distance at which it ends from its place.
        miss: f64,
    },
    /// The object was held, and has slipped out for a cause that is known.
    LostFor {
        /// Force that was wanted last.
        wanted: f64,
        /// Cause of the slip.
        cause: Loss,
    },
}

impl Trouble {
    /// One sentence that names the object, the kind and the figure.
    pub fn sentence(&self, opposition: &Opposition, object: &str, force: f64) -> String {
        let kind = opposition.kind.name();
        let [base, fingers] = opposition.sides();
        let mm = |x: f64| (x * 1e3).round();
        // To a hundredth, and what is less to two digits.
        let newtons = |x: f64| {
            let unit = 10f64.powf(x.abs().max(1e-9).log10().floor() - 1.0).min(0.01);
            let decimals = (-unit.log10()).round().max(0.0) as usize;
            format!("{x:.decimals$}").parse::<f64>().unwrap_or(x)
        };
        let digit = |pad: u8| match opposition.chain(usize::from(pad)) {
            Some(chain) => chain.digit.name(),
            None => "palm",
        };
        match self {
            Self::TooLarge { width, opening } => format!(
                "{kind}: `{object}` of {} mm across does not fit between {base} and {fingers}, which open to {} mm",
                mm(*width),
                mm(*opening)
            ),
            Self::NoOpposite { opening } => format!(
                "{kind}: `{object}` has no opposed places near the hand for {base} and {fingers}, which open to {} mm",
                mm(*opening)
            ),
            Self::Far { distance } => format!(
                "{kind}: `{object}` is {} mm from where {base} and {fingers} close: too far for the fingers, move the wrist",
                mm(*distance)
            ),
            Self::OutOfReach { pad, miss } => format!(
                "{kind}: the {} ends {} mm short of its place on `{object}`",
                digit(*pad),
                mm(*miss)
            ),
            Self::Wide { width, opening, pad, miss } => format!(
                "{kind}: `{object}` of {} mm across is too large from here: {base} and {fingers} open to {} mm, and the {} ends {} mm short of its place",
                mm(*width),
                mm(*opening),
                digit(*pad),
                mm(*miss)
            ),
            Self::Weak { felt } => format!(
                "{kind}: `{object}` is held with {felt:.2} N instead of {} N: the fingers' drives give no more",
                newtons(force)
            ),
            Self::Slippery { needed, friction } => format!(
                "{kind}: `{object}` slips out: its weight needs more than {needed:.2} N at a friction of {friction:.2}, and {} N are asked",
                newtons(force)
            ),
            Self::Lost { wanted } => format!(
                "{kind}: `{object}` slipped out of {base} and {fingers}, which were to press with {wanted:.2} N"
            ),
            Self::LostFor { wanted, cause } => format!(
                "{kind}: `{object}` slipped out of {base} and {fingers}, which were to press with {wanted:.2} N: {}",
                cause.clause(|pad| digit(pad).to_owned())
            ),
            Self::Missed => {
                format!(
                    "{kind}: the fingers closed and `{object}` was not between {base} and {fingers}"
                )
            }
        }
    }
}
