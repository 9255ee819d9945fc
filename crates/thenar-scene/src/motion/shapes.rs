//! Named shapes as the angles of one hand.

use super::fist::fist;
use super::preset::{Preset, Shape, THUMB_ASIDE};
use std::cell::OnceCell;
use thenar_core::model::{Digit, HandModel};
use thenar_track::{ANGLES, Anatomy, Articulation, hand_angles};

/// The named shapes of a hand. Those that follow from the hand itself are found when they are first
/// asked for.
#[derive(Debug)]
pub struct Shapes<'a> {
    hand: &'a HandModel,
    articulation: &'a Articulation,
    anatomy: &'a Anatomy,
    /// Two angles of each joint in shapes that the hand itself gives; none where it cannot make the
    /// shape.
    own: [OnceCell<Option<Vec<[f64; 2]>>>; Preset::NAMED.len()],
}

impl<'a> Shapes<'a> {
    /// The shapes of `hand`, whose skeleton and joints' roles are given.
    pub fn new(hand: &'a HandModel, articulation: &'a Articulation, anatomy: &'a Anatomy) -> Self {
        Self { hand, articulation, anatomy, own: Default::default() }
    }

    /// Both angles of joint `j` in a shape \[rad\], within their ranges but for a fist's, which is
    /// pulled against their ends.
    pub fn angles(&self, shape: Preset, j: usize) -> [f64; 2] {
        let own = self.own[shape as usize].get_or_init(|| self.own(shape));
        match own {
            Some(own) => own[j],
            None => self.table(shape, j),
        }
    }

    /// Both angles of joint `j` in a shape of any hand, within their ranges \[rad\].
    pub(super) fn table(&self, shape: Preset, j: usize) -> [f64; 2] {
        self.articulation.tree.clamp(j, self.usual(shape, j))
    }

    /// A shape as the twenty angles of a hand (see [`hand_angles`]) \[rad\]; 0 for joints that it
    /// lacks.
    pub fn twenty(&self, shape: Preset) -> [f64; ANGLES] {
        hand_angles(self.hand, self.articulation)
            .map(|angle| angle.map_or(0.0, |at| at.sense * self.angles(shape, at.index)[at.axis]))
    }

    /// Both angles of a joint `j` of the thumb where it lets fingers pass, within their ranges
    /// \[rad\].
    pub(super) fn thumb_aside(&self, j: usize) -> [f64; 2] {
        self.articulation.tree.clamp(j, self.bent(j, THUMB_ASIDE))
    }

    /// Angles that hands take which give no shape of their own.
    fn usual(&self, shape: Preset, j: usize) -> [f64; 2] {
        let role = &self.anatomy.roles[j];
        match shape.angles_deg(role.digit) {
            Some(shape) => self.bent(j, shape),
            None => self.articulation.rest_angles[j],
        }
    }

    fn bent(&self, j: usize, (flexion, spread): Shape) -> [f64; 2] {
        let mut angles = self.articulation.rest_angles[j];
        let role = &self.anatomy.roles[j];
        if let Some((axis, sense)) = role.flexion {
            angles[axis] = sense * flexion[role.place.min(2)].to_radians();
        }
        if let Some((axis, sense)) = role.spread {
            angles[axis] = sense * spread.to_radians();
        }
        angles
    }

    fn own(&self, shape: Preset) -> Option<Vec<[f64; 2]>> {
        let usual = || (0..self.articulation.rest_angles.len()).map(|j| self.usual(shape, j));
        let fist = |over: &[Digit]| fist(self.hand, self.articulation, self.anatomy, over);
        match shape {
            Preset::Pinch => {
                let mut angles: Vec<_> = usual().collect();
                for (joint, axis, angle) in Preset::pinch(self.hand)? {
                    angles[joint][axis] = angle;
                }
                let clamp = |(j, angles)| self.articulation.tree.clamp(j, angles);
                Some(angles.into_iter().enumerate().map(clamp).collect())
            }
            Preset::Fist => fist(&[Digit::Index, Digit::Middle]),
            Preset::Point => {
                let mut angles = fist(&[Digit::Middle])?;
                for (j, usual) in usual().enumerate() {
                    if self.anatomy.roles[j].digit == Digit::Index {
                        angles[j] = self.articulation.tree.clamp(j, usual);
                    }
                }
                Some(angles)
            }
            _ => None,
        }
    }
}
