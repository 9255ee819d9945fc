//! Stress relaxation: the memory of tissue.

/// Most terms of a relaxation.
pub const TERMS_MAX: usize = 4;

/// One exponential term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Term {
    /// Part of the instantaneous stress that fades by this term, above 0.
    pub weight: f64,
    /// Time in which a factor e of it fades \[s\], above 0.
    pub time: f64,
}

/// The reduced relaxation function of quasi-linear viscoelasticity (Fung 1993, Sec. 7.6) as a Prony
/// series: a strain that is held keeps of the stress at its beginning the part
///
/// ```text
///   G(t) = g∞ + Σ gᵢ exp(-t/τᵢ),   g∞ = 1 - Σ gᵢ > 0
/// ```
///
/// Moduli of a material are the instantaneous ones, `G(0) = 1`. No term: the material is elastic.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "Vec<[f64; 2]>", into = "Vec<[f64; 2]>"))]
pub struct Relaxation {
    /// Terms beyond `count` have weight 0 and time 1.
    terms: [Term; TERMS_MAX],
    count: usize,
}

/// Why a list of terms is no relaxation.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RelaxationError {
    /// Too many.
    #[error("expected at most {TERMS_MAX} terms, got {0}")]
    Terms(usize),
    /// A weight is not positive.
    #[error("the weight of term {term} must be above 0, got {got}")]
    Weight {
        /// Counted from 1.
        term: usize,
        /// Weight given.
        got: f64,
    },
    /// A time is not positive.
    #[error("the time of term {term} must be above 0 s and finite, got {got}")]
    Time {
        /// Counted from 1.
        term: usize,
        /// Time given \[s\].
        got: f64,
    },
    /// Nothing would be left.
    #[error("the weights must sum to less than 1, so that some stress stays, got {0}")]
    Sum(f64),
}

impl Relaxation {
    /// No memory.
    pub const NONE: Self = Self { terms: [Term { weight: 0.0, time: 1.0 }; TERMS_MAX], count: 0 };

    /// From weight and time \[s\] of each term.
    ///
    /// # Errors
    /// There are more than [`TERMS_MAX`], a number is not positive, or the weights sum to 1 or
    /// more.
    pub fn new(terms: &[[f64; 2]]) -> Result<Self, RelaxationError> {
        if terms.len() > TERMS_MAX {
            return Err(RelaxationError::Terms(terms.len()));
        }
        let mut relaxation = Self { count: terms.len(), ..Self::NONE };
        for (k, &[weight, time]) in terms.iter().enumerate() {
            let term = k + 1;
            if weight.is_nan() || weight <= 0.0 {
                return Err(RelaxationError::Weight { term, got: weight });
            }
            if time <= 0.0 || !time.is_finite() {
                return Err(RelaxationError::Time { term, got: time });
            }
            relaxation.terms[k] = Term { weight, time };
        }
        let sum = relaxation.weight();
        if sum < 1.0 { Ok(relaxation) } else { Err(RelaxationError::Sum(sum)) }
    }

    /// The terms.
    pub fn terms(&self) -> &[Term] {
        &self.terms[..self.count]
    }

    /// True without terms.
    pub fn is_none(&self) -> bool {
        self.count == 0
    }

    /// `Σ gᵢ`.
    pub fn weight(&self) -> f64 {
        self.terms().iter().map(|term| term.weight).sum()
    }
}

impl Default for Relaxation {
    fn default() -> Self {
        Self::NONE
    }
}

impl TryFrom<Vec<[f64; 2]>> for Relaxation {
    type Error = RelaxationError;

    fn try_from(terms: Vec<[f64; 2]>) -> Result<Self, RelaxationError> {
        Self::new(&terms)
    }
}

impl From<Relaxation> for Vec<[f64; 2]> {
    fn from(relaxation: Relaxation) -> Self {
        relaxation.terms().iter().map(|term| [term.weight, term.time]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_relaxation_is_refused_with_its_reason() {
        let error = |terms: &[[f64; 2]]| Relaxation::new(terms).unwrap_err().to_string();
        let ones = [[0.1, 1.0]; 5];
        assert_eq!(error(&ones), "expected at most 4 terms, got 5");
        assert_eq!(error(&[[0.1, 1.0], [0.0, 1.0]]), "the weight of term 2 must be above 0, got 0");
        assert!(error(&[[f64::NAN, 1.0]]).starts_with("the weight of term 1"));
        for time in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert!(error(&[[0.1, time]]).starts_with("the time of term 1 must be above 0 s"));
        }
        assert!(error(&[[0.5, 1.0], [0.5, 2.0]]).ends_with("got 1"));
        assert!(error(&[[f64::INFINITY, 1.0]]).ends_with("got inf"));
        assert!(Relaxation::new(&[]).unwrap().is_none());
        assert_eq!(Relaxation::new(&ones[..4]).unwrap().terms().len(), 4);
    }
}
