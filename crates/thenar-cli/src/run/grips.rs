//! Troubles of grips while a scene runs.

use std::mem::discriminant;
use thenar_scene::grip::Trouble;
use thenar_scene::session::Session;

/// Tells of each trouble of each hand's grips when it begins.
#[derive(Debug)]
pub struct GripReporter {
    told: Vec<Option<Trouble>>,
}

impl GripReporter {
    /// Nothing is reported yet.
    pub fn new(session: &Session) -> Self {
        Self { told: vec![None; session.hands().len()] }
    }

    /// Says on the error output what has newly gone amiss.
    pub fn tell(&mut self, session: &Session) {
        for (hand, told) in self.told.iter_mut().enumerate() {
            let trouble = session.grip_state(hand).and_then(|state| state.trouble);
            if trouble.is_some()
                && told.as_ref().map(discriminant) != trouble.as_ref().map(discriminant)
            {
                let said = session.grip_trouble(hand).unwrap_or_default();
                eprintln!("warning: {:.2} s: {said}", session.world().time());
            }
            *told = trouble;
        }
    }
}
