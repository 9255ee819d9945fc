//! Values of contacts in one tick, worked out as far as the tick needs them.
//!
//! A frame lists all that may touch before the next, and most of that stays open in most ticks. How
//! far an open contact is nobody needs to know, as long as it is open: what loads on the bones move
//! it by is no more than the product of its row's length and theirs. What may close is worked out
//! along its normal, and what closes, or bears force, along its tangents too. A contact that closes
//! sticks from where it was in the tick before, which is worked out then.

use super::Condensed;
use thenar_core::math::Vec3;

/// Beyond the bound by this part of it is beyond it for certain.
const ROUND_OFF: f64 = 1e-9;

/// Parts of a contact's value that are known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
enum KnownParts {
    /// The normal part, but for what loads do to it.
    Bound,
    /// The normal part.
    Normal,
    /// Normal and tangential parts, as far as friction needs them.
    All,
}

/// Values of all contacts of a frame.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Values {
    /// Contact values under those of the frame's forces that act here, as far as they are known
    /// \[m\].
    d: Vec<Vec3>,
    /// Changes of the values by all changes of forces since the frame \[m\], now and at the end of
    /// the tick before.
    answered: Vec<Vec3>,
    answered_before: Vec<Vec3>,
    known: Vec<KnownParts>,
    /// By so much the normal part may be less \[m\].
    slack: Vec<f64>,
    /// Places at which contacts stick: tangential values are measured from here \[m\].
    anchors: Vec<Vec3>,
    /// Was open in the tick before, so that its anchor is not known.
    open: Vec<bool>,
    /// Lengths of the normal row, by forces \[m/N\] and by torques \[m/(N m)\].
    reach: Vec<[f64; 2]>,
    /// Values that the forces of contacts that do not act here would take away \[m\].
    missed: Vec<Vec3>,
    /// Loads of the tick before \[N, N m\].
    load_before: Vec<f64>,
}

impl Values {
    /// For frames of this size.
    pub fn new(bones: usize, contacts_max: usize) -> Self {
        Self {
            d: Vec::with_capacity(contacts_max),
            answered: Vec::with_capacity(contacts_max),
            answered_before: Vec::with_capacity(contacts_max),
            known: Vec::with_capacity(contacts_max),
            slack: Vec::with_capacity(contacts_max),
            anchors: Vec::with_capacity(contacts_max),
            open: Vec::with_capacity(contacts_max),
            reach: Vec::with_capacity(contacts_max),
            missed: Vec::with_capacity(contacts_max),
            load_before: vec![0.0; 6 * bones],
        }
    }

    /// Starts from a new frame. Contacts that do not act never change their forces, which are none.
    pub fn begin(&mut self, frame: &Condensed, acts: impl Fn(usize) -> bool) {
        let (n, m) = (6 * frame.bones(), frame.contacts.len());
        self.anchors.clear();
        self.anchors.resize(m, Vec3::zeros());
        self.open.clear();
        self.open.resize(m, false);
        for values in [&mut self.answered, &mut self.answered_before, &mut self.missed] {
            values.clear();
            values.resize(m, Vec3::zeros());
        }
        self.reach.clear();
        for (i, contact) in frame.contacts.iter().enumerate() {
            let row = frame.lift.get(3 * i * n..(3 * i + 1) * n).unwrap_or_default();
            self.reach.push(if acts(i) { lengths(row) } else { [0.0; 2] });
            if !acts(i) && contact.force != Vec3::zeros() && frame.is_ready() {
                frame.add_response(i, &-contact.force, &mut self.missed);
            }
        }
    }

    /// Values under these loads on the bones \[N, N m\] and the frame's forces, `d₀ + J C k δ` from
    /// the anchors; those of contacts that bear force are worked out.
    pub fn measure(
        &mut self,
        frame: &Condensed,
        load: &[f64],
        forces: &[Vec3],
        acts: impl Fn(usize) -> bool,
    ) {
        let loads = lengths(load);
        self.d.clear();
        self.known.clear();
        self.slack.clear();
        for (i, contact) in frame.contacts.iter().enumerate() {
            let [force, torque] = self.reach[i];
            let slack = (force * loads[0] + torque * loads[1]) * (1.0 + ROUND_OFF);
            let bears = forces[i] != Vec3::zeros();
            let stays_open = contact.value.x > slack;
            self.d.push(Vec3::new(contact.value.x, 0.0, 0.0));
            self.known.push(KnownParts::Bound);
            self.slack.push(slack);
            if bears && acts(i) {
                self.work_out(frame, load, i);
            } else if acts(i) && !stays_open {
                self.work_out_normal(frame, load, i);
            }
        }
        self.d.iter_mut().zip(&self.missed).for_each(|(d, missed)| *d += missed);
    }

    /// Adds what a `change` of the force of contact `i` \[N\] does to all values.
    pub fn add_response(&mut self, frame: &Condensed, i: usize, change: &Vec3) {
        frame.add_response(i, change, &mut self.answered);
    }

    /// Normal part of a value, as far as it is known \[m\].
    fn normal(&self, i: usize) -> f64 {
        self.d[i].x + self.answered[i].x
    }

    /// The value of contact `i`, which bears this force \[m\]; `None` while it is open and bears
    /// none.
    pub fn of(&mut self, frame: &Condensed, load: &[f64], i: usize, force: &Vec3) -> Option<Vec3> {
        if self.known[i] != KnownParts::All && *force == Vec3::zeros() {
            if self.normal(i) > self.slack[i] {
                return None;
            }
            self.work_out_normal(frame, load, i);
            if self.normal(i) > 0.0 {
                return None;
            }
        }
        self.work_out(frame, load, i);
        Some(self.d[i] + self.answered[i])
    }

    /// Ends a tick: what slid or was open sticks, if it does, from where it is now.
    pub fn settle(&mut self, load: &[f64]) {
        for i in 0..self.d.len() {
            self.open[i] = self.known[i] != KnownParts::All;
            if !self.open[i] {
                let value = self.d[i] + self.answered[i];
                self.anchors[i] += Vec3::new(0.0, value.y, value.z);
            }
        }
        self.load_before.copy_from_slice(load);
        self.answered_before.copy_from_slice(&self.answered);
    }

    fn work_out_normal(&mut self, frame: &Condensed, load: &[f64], i: usize) {
        if self.known[i] == KnownParts::Bound {
            self.d[i].x += frame.lift_row_times(3 * i, load);
            (self.known[i], self.slack[i]) = (KnownParts::Normal, 0.0);
        }
    }

    fn work_out(&mut self, frame: &Condensed, load: &[f64], i: usize) {
        if self.known[i] == KnownParts::All {
            return;
        }
        let contact = &frame.contacts[i];
        if contact.friction > 0.0 {
            if self.open[i] {
                self.anchors[i] = self.place_before(frame, i);
            }
            let lift = frame.lift_times(i, load);
            let place = contact.value + lift - self.anchors[i];
            let normal = if self.known[i] == KnownParts::Bound { lift.x } else { 0.0 };
            self.d[i] += Vec3::new(normal, place.y, place.z);
        } else {
            self.work_out_normal(frame, load, i);
        }
        (self.known[i], self.slack[i]) = (KnownParts::All, 0.0);
    }

    /// Place of a contact at the end of the tick before, along its tangents \[m\].
    fn place_before(&self, frame: &Condensed, i: usize) -> Vec3 {
        let lift = frame.lift_times(i, &self.load_before);
        let place = frame.contacts[i].value + lift + self.missed[i] + self.answered_before[i];
        Vec3::new(0.0, place.y, place.z)
    }

    #[cfg(test)]
    pub fn worked_out(&self) -> usize {
        self.known.iter().filter(|known| **known == KnownParts::All).count()
    }
}

/// Lengths of the forces, or displacements, and of the torques, or turns, in a list of both for
/// each bone.
fn lengths(list: &[f64]) -> [f64; 2] {
    let mut squares = [0.0; 2];
    for both in list.as_chunks::<6>().0 {
        for k in 0..3 {
            squares[0] += both[k] * both[k];
            squares[1] += both[3 + k] * both[3 + k];
        }
    }
    squares.map(f64::sqrt)
}
