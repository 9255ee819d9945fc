//! Stiffness that a device allows a coupling: rules for one axis of a sampled spring.
//!
//! With device damping b, coupling damping B, sampling period T, further delay t_d, Coulomb
//! friction f_c and position resolution Δ:
//!
//! | rule | bound on K | source |
//! |---|---|---|
//! | passive | `2 (b - abs(B)) / T` | Colgate and Schenkel 1997: `b > K T/2 + abs(B)` |
//! | stable, delay included | `(b + B) / (T/2 + t_d)` | Gil et al. 2009, an approximation |
//! | passive despite quantisation | `2 f_c / Δ` | Abbott and Okamura 2005 |
//!
//! The first and the last guarantee that nothing the wearer does makes the display active. The
//! second says when it oscillates by itself.

use thenar_core::model::Drive;

/// Properties of a device and its loop on one axis.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct LoopProfile {
    /// Sampling period \[s\].
    pub period: f64,
    /// Delay on top of the period's zero-order hold: transport, filters, actuators \[s\].
    pub delay: f64,
    /// Viscous damping of the mechanism \[N s/m\].
    pub damping: f64,
    /// Coulomb friction of the mechanism \[N\].
    pub friction: f64,
    /// Position resolution \[m\]; zero when it does not matter.
    pub resolution: f64,
    /// Stiffness its maker rates \[N/m\]; infinite when unknown.
    pub rated_stiffness: f64,
}

impl LoopProfile {
    /// Largest stiffness that keeps the display passive \[N/m\] under this coupling damping.
    pub fn passive_stiffness_max(&self, coupling_damping: f64) -> f64 {
        (2.0 * (self.damping - coupling_damping.abs()) / self.period).max(0.0)
    }

    /// About the largest stiffness that does not oscillate by itself \[N/m\].
    pub fn stable_stiffness_max(&self, coupling_damping: f64) -> f64 {
        (self.damping + coupling_damping) / (0.5 * self.period + self.delay)
    }

    /// Largest stiffness whose quantisation noise friction swallows \[N/m\].
    pub fn quantised_stiffness_max(&self) -> f64 {
        if self.resolution > 0.0 { 2.0 * self.friction / self.resolution } else { f64::INFINITY }
    }

    /// Returns warnings about this device coupling. A proxy only softens it, so the coupling is
    /// judged as if the proxy stood still.
    pub fn warnings(&self, coupling: &Drive) -> Vec<CouplingWarning> {
        let stiffness = coupling.stiffness;
        let bounds = [
            (CouplingRule::Passive, self.passive_stiffness_max(coupling.damping)),
            (CouplingRule::Stable, self.stable_stiffness_max(coupling.damping)),
            (CouplingRule::Quantised, self.quantised_stiffness_max()),
            (CouplingRule::Rated, self.rated_stiffness),
        ];
        (bounds.into_iter())
            // Written so that a bound that is not a number warns as well.
            .filter(|(_, bound)| !matches!(stiffness.partial_cmp(bound), Some(o) if o.is_le()))
            .map(|(rule, stiffness_max)| CouplingWarning { rule, stiffness, stiffness_max })
            .collect()
    }
}

/// A bound on coupling stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CouplingRule {
    /// Above it the display can give out energy.
    Passive,
    /// Above it the display oscillates by itself.
    Stable,
    /// Above it the steps of the position sensor can be felt as buzzing.
    Quantised,
    /// Above it the device's maker promises nothing.
    Rated,
}

/// A coupling that is too stiff for its device by one rule.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("coupling of {stiffness:.0} N/m is above the {} limit of {stiffness_max:.0} N/m", self.rule.name())]
pub struct CouplingWarning {
    /// The rule.
    pub rule: CouplingRule,
    /// The coupling's stiffness \[N/m\].
    pub stiffness: f64,
    /// Stiffness that the rule allows \[N/m\].
    pub stiffness_max: f64,
}

impl CouplingRule {
    /// Returns the name for messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Passive => "passivity",
            Self::Stable => "stability",
            Self::Quantised => "quantisation",
            Self::Rated => "rated",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: LoopProfile = LoopProfile {
        period: 1e-3,
        delay: 0.0,
        damping: 1.0,
        friction: 0.05,
        resolution: 1e-4,
        rated_stiffness: f64::INFINITY,
    };

    /// Validation E1 and E8: at 1 ms and 1 N s/m, 2000 N/m; with B = 0.5 N s/m, 1000 N/m;
    /// 0.05 N against 0.1 mm, 1000 N/m.
    #[test]
    fn the_published_limits() {
        assert_eq!(ONE.passive_stiffness_max(0.0), 2000.0);
        assert_eq!(ONE.passive_stiffness_max(0.5), 1000.0);
        assert_eq!(ONE.passive_stiffness_max(2.0), 0.0);
        assert_eq!(ONE.stable_stiffness_max(0.0), 2000.0);
        assert_eq!(ONE.quantised_stiffness_max(), 1000.0);
    }

    #[test]
    fn a_coupling_is_told_which_limits_it_breaks() {
        let coupling = |stiffness: f64, damping: f64| Drive {
            stiffness,
            damping,
            angular_stiffness: 0.0,
            angular_damping: 0.0,
        };
        let rules = |k: f64, b: f64| -> Vec<CouplingRule> {
            ONE.warnings(&coupling(k, b)).iter().map(|w| w.rule).collect()
        };
        assert_eq!(rules(900.0, 0.1), []);
        assert_eq!(rules(1500.0, 0.0), [CouplingRule::Quantised]);
        assert_eq!(rules(1500.0, 0.5), [CouplingRule::Passive, CouplingRule::Quantised]);
        assert_eq!(rules(f64::NAN, 0.0).len(), 4);
        let slow = LoopProfile { period: 10e-3, ..ONE };
        let all: Vec<_> = slow.warnings(&coupling(900.0, 0.1));
        assert_eq!(
            all[0].to_string(),
            "coupling of 900 N/m is above the passivity limit of 180 N/m"
        );
        assert_eq!(all[1].rule, CouplingRule::Stable);
    }
}
