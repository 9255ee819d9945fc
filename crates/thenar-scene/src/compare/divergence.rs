//! Criteria by which a solver has lost its scene.

use crate::session::Session;
use std::fmt;

/// Energy \[times the other's\] at which a motion counts as lost.
const ENERGY_FACTOR: f64 = 10.0;
/// Speed \[m/s\] of everything that moves, whose kinetic energy is granted besides.
const SPEED: f64 = 1.0;

/// Why a motion counts as lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cause {
    /// A step gave a number that is not finite.
    NotFinite,
    /// Energy of motion and deformation \[J\] is above ten times the other solver's largest so far
    /// plus that of the whole scene moving at 1 m/s.
    Energy {
        /// Energy that was found \[J\].
        energy: f64,
        /// Energy that is allowed \[J\].
        bound: f64,
    },
}

/// A solver lost its scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Divergence {
    /// Time of divergence \[s\].
    pub time: f64,
    /// Cause of the divergence.
    pub cause: Cause,
}

impl fmt::Display for Divergence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "diverged at {:.4} s: ", self.time)?;
        match self.cause {
            Cause::NotFinite => write!(f, "a number is not finite"),
            Cause::Energy { energy, bound } => {
                write!(f, "energy {energy:.3e} J, bound {bound:.3e} J")
            }
        }
    }
}

/// Looks out for divergence of one session.
#[derive(Clone, Copy, Debug)]
pub struct DivergenceMonitor {
    /// Kinetic energy of everything that moves, at `SPEED` \[J\].
    granted: f64,
    /// Largest energy of motion and deformation so far \[J\].
    pub energy_max: f64,
}

impl DivergenceMonitor {
    /// From now on.
    pub fn new(session: &Session) -> Self {
        let model = session.world().model();
        let rigid = model.rigids.iter().filter(|r| r.moves).map(|r| r.mass).sum::<f64>();
        let mass = rigid + model.flesh.mass.iter().sum::<f64>();
        Self { granted: 0.5 * mass * SPEED * SPEED, energy_max: inner_energy(session) }
    }

    /// The divergence, if the step just done lost the scene. `other` is the largest energy of the
    /// other solver before this step \[J\]; none where that has diverged.
    pub fn find(&self, session: &Session, energy: f64, other: Option<f64>) -> Option<Divergence> {
        let time = session.world().time();
        if session.report().non_finite {
            return Some(Divergence { time, cause: Cause::NotFinite });
        }
        let bound = ENERGY_FACTOR * other? + self.granted;
        (energy > bound || energy.is_nan())
            .then_some(Divergence { time, cause: Cause::Energy { energy, bound } })
    }
}

/// Energy of motion and deformation \[J\]: all that cannot be below zero, without drives.
pub fn inner_energy(session: &Session) -> f64 {
    let e = session.world().energy(session.input());
    e.kinetic + e.elastic + e.coupling + e.joint
}
