//! The press that a fit runs again and again: a scripted body of a scene comes down on what is
//! fitted, and the force on it along its way is read.

use super::data::PressData;
use super::least_squares::Trial;
use crate::building::unheard;
use crate::error::CliError;
use crate::interrupt;
use crate::lab::press::{Plate, moves};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use thenar_core::Vec3;
use thenar_core::model::{BodyId, Digit, Motion};
use thenar_scene::format::Probe;
use thenar_scene::session::Session;

/// The plate sets out so far from touch, and goes so much deeper than the data: room for an offset
/// \[m\].
pub const SLACK: f64 = 0.5e-3;
/// Keyframes that a measured course of depth is led by, at most: straight lines between.
const KEYS_MAX: usize = 2000;

/// A press that was run: time \[s\] and force \[N\] of each step, or why it could not be.
type PressResult = Result<(Vec<f64>, Vec<f64>), String>;

/// A press.
#[derive(Debug)]
pub struct Bench {
    text: String,
    file: PathBuf,
    changes: Vec<String>,
    body: String,
    touch: Vec3,
    way: Vec3,
    probe: String,
    /// The probe's forces are those on the body that moves.
    on_body: bool,
    /// Speed of the press where the data have no time, and of the approach \[m/s\].
    rate: f64,
    /// Presses that were run, by their changes: without times an offset is read from one of these.
    known: Mutex<BTreeMap<Vec<String>, Arc<PressResult>>>,
    presses: AtomicUsize,
}

/// A finger that is pressed in the built-in scene.
#[derive(Clone, Copy, Debug)]
pub struct Finger {
    /// Finger that is pressed.
    pub digit: Digit,
    /// Angle between plate and hand \[degrees\].
    pub angle_deg: f64,
}

impl Bench {
    /// Sets up a press of a scene's only scripted body that moves, or of the one named; of the
    /// built-in scene, on a finger.
    ///
    /// # Errors
    /// The scene is wrong, or does not press.
    pub fn new(
        text: String,
        file: PathBuf,
        changes: &[String],
        body: Option<&str>,
        finger: Option<Finger>,
        rate: f64,
    ) -> Result<Self, CliError> {
        let session = Session::from_text(&text, &file, changes)?;
        let wrong = |what: String| CliError::Input(format!("{}: {what}", file.display()));
        let body = presser(&session, body).map_err(wrong)?;
        let (probe, on_body) = contact(&session, &body).map_err(wrong)?;
        let mut bench = Self {
            text,
            changes: changes.to_vec(),
            probe,
            on_body,
            rate,
            touch: Vec3::zeros(),
            way: Vec3::y(),
            body,
            file: file.clone(),
            known: Mutex::default(),
            presses: AtomicUsize::new(0),
        };
        match finger {
            Some(Finger { digit, angle_deg }) => {
                let plate = Plate::at(&session, &bench.body, digit, angle_deg)
                    .ok_or_else(|| wrong(format!("the hand has no {}", digit.name())))?;
                bench.changes.extend(plate.changes);
                (bench.touch, bench.way) = (plate.touch, plate.way);
            }
            None => bench.find_touch(&session).map_err(wrong)?,
        }
        Ok(bench)
    }

    /// Finds where the body first touches on the way between its first and last keyframe, by
    /// running the scene's own press until there is a force: the gap that is left a step before
    /// gives the place.
    fn find_touch(&mut self, session: &Session) -> Result<(), String> {
        let index = rigid(session, &self.body).ok_or("the body is gone")?;
        let scene = session.scene();
        let keys = scene.rigid.iter().find(|r| r.name.value == self.body).map(|r| &r.keyframes);
        let keys: Vec<_> = keys.into_iter().flatten().map(|k| &k.value).collect();
        if keys.iter().any(|key| key.rotation.is_some()) {
            return Err(format!("the keyframes of `{}` turn it; a press goes straight", self.body));
        }
        let from = session.world().rigid_pose(index).position;
        let places: Vec<Vec3> = keys.iter().filter_map(|key| key.position).collect();
        let [first, .., last] = places[..] else {
            return Err(format!(
                "`{}` needs two keyframes with positions to show its way",
                self.body
            ));
        };
        let length = (last - first).norm();
        if length.is_nan() || length <= 0.0 {
            return Err(format!("`{}` ends where it starts: it shows no way", self.body));
        }
        self.way = (last - first) / length;
        // The body's frame may lie beside that of its keyframes (meshes): what counts is the way
        // gone.
        let course =
            moves(&self.body, &first, &self.way, &[[0.0, 0.0], [length / self.rate, length]]);
        let mut session = self.open(&course).map_err(|e| e.to_string())?;
        let mut gone = 0.0;
        let mut touch = 0.0;
        for _ in 0..session.steps_wanted() {
            if interrupt::asked() {
                return Err("interrupted".into());
            }
            session.step(&mut ());
            let touching = session.world().contacts().iter().filter(|c| {
                c.bodies.contains(&BodyId::Rigid(index)) && c.normal_W.dot(&self.way).abs() > 0.1
            });
            let gaps =
                touching.map(|c| (c.gap / c.normal_W.dot(&self.way).abs(), c.force_W.norm()));
            let (gap, force) = gaps
                .fold((f64::INFINITY, 0.0), |(g, f): (f64, f64), (gap, force)| {
                    (g.min(gap), f + force)
                });
            if gap.is_finite() {
                touch = gone + gap;
            }
            if force > 0.0 {
                self.touch = first + self.way * touch;
                return Ok(());
            }
            gone = (session.world().rigid_pose(index).position - from).dot(&self.way);
        }
        Err(format!("`{}` touches nothing on its way", self.body))
    }

    fn open(&self, more: &[String]) -> Result<Session, CliError> {
        let changes: Vec<String> = self.changes.iter().chain(more).cloned().collect();
        Ok(unheard(|| Session::from_text(&self.text, &self.file, &changes))?)
    }

    /// The scene as it is, for what can be read from it.
    ///
    /// # Errors
    /// The scene is wrong.
    pub fn session(&self) -> Result<Session, CliError> {
        self.open(&[])
    }

    /// The course of a press: `[time, depth]`, and when the data begin.
    fn course(&self, data: &PressData, offset: f64) -> (Vec<[f64; 2]>, f64) {
        let Some(times) = &data.time else {
            let end = data.depth.iter().copied().fold(0.0, f64::max) + SLACK;
            return (vec![[0.0, -SLACK], [(end + SLACK) / self.rate, end]], 0.0);
        };
        // Down to the first depth at the usual rate, then as measured.
        let first = data.depth[0] + offset;
        let low = first.min(-SLACK);
        let begin = ((first - low) / self.rate).max(1e-6);
        let every = times.len().div_ceil(KEYS_MAX);
        let mut keys = vec![[0.0, low]];
        let last = times.len() - 1;
        for i in (0..times.len()).filter(|i| i % every == 0 || *i == last) {
            keys.push([begin + times[i] - times[0], data.depth[i] + offset]);
        }
        (keys, begin)
    }

    /// Presses computed so far.
    pub fn presses(&self) -> usize {
        self.presses.load(Ordering::Relaxed)
    }

    /// Forces \[N\] at the data's depths, or times, with these changes of the scene and the zero of
    /// depth moved by `offset` \[m\].
    ///
    /// # Errors
    /// Ctrl-C was pressed.
    pub fn forces(
        &self,
        data: &PressData,
        changes: &[String],
        offset: f64,
    ) -> Result<Trial, CliError> {
        let (keys, begin) = self.course(data, offset);
        let mut changes = changes.to_vec();
        changes.extend(moves(&self.body, &self.touch, &self.way, &keys));
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&changes).cloned();
        let pressed = match found {
            Some(pressed) => pressed,
            None => {
                let pressed = Arc::new(self.press(&changes)?);
                known().insert(changes, Arc::clone(&pressed));
                pressed
            }
        };
        let (at, force) = match pressed.as_ref() {
            Ok(curve) => curve,
            Err(reason) => return Ok(Trial::Impossible(reason.clone())),
        };
        let wanted = |i: usize| match &data.time {
            Some(times) => begin + times[i] - times[0],
            None => (data.depth[i] + offset + SLACK) / self.rate,
        };
        let values = (0..data.depth.len()).map(|i| between(at, force, wanted(i)));
        Ok(Trial::Values(values.collect()))
    }

    /// Runs a press.
    fn press(&self, changes: &[String]) -> Result<PressResult, CliError> {
        self.presses.fetch_add(1, Ordering::Relaxed);
        let mut session = match self.open(changes) {
            Ok(session) => session,
            Err(refused) => return Ok(Err(refused.to_string())),
        };
        let columns = ["fx", "fy", "fz"].map(|axis| {
            let name = format!("{}.{axis}", self.probe);
            session.columns().iter().position(|c| c.name == name)
        });
        let [Some(x), Some(y), Some(z)] = columns else {
            return Ok(Err("the probe has no force".into()));
        };
        // The body is pushed back: against its way.
        let sign = if self.on_body { -1.0 } else { 1.0 };
        let (mut at, mut force) = (vec![0.0], vec![0.0]);
        for _ in 0..session.steps_wanted() {
            if interrupt::asked() {
                return Err(CliError::Other("interrupted".into()));
            }
            let report = session.step(&mut ());
            if report.failure.is_some() || report.non_finite {
                let time = session.world().time();
                return Ok(Err(format!("the press cannot be computed at {time} s")));
            }
            let values = session.probe();
            let F = Vec3::new(values[x], values[y], values[z]);
            force.push(sign * F.dot(&self.way));
            at.push(session.world().time());
        }
        Ok(Ok((at, force)))
    }
}

/// Straight between points; before the first and after the last, what they have.
fn between(x: &[f64], y: &[f64], at: f64) -> f64 {
    let k = x.partition_point(|x| *x <= at);
    if k == 0 {
        return y[0];
    }
    if k == x.len() {
        return y[k - 1];
    }
    let part = (at - x[k - 1]) / (x[k] - x[k - 1]);
    y[k - 1] + part * (y[k] - y[k - 1])
}

fn rigid(session: &Session, name: &str) -> Option<u32> {
    session.world().desc().rigids.iter().position(|r| r.name == name).map(|i| i as u32)
}

/// The body that presses.
fn presser(session: &Session, wanted: Option<&str>) -> Result<String, String> {
    let desc = session.world().desc();
    let scripted = |name: &str| rigid(session, name).map(|i| desc.rigids[i as usize].motion);
    if let Some(name) = wanted {
        return match scripted(name) {
            Some(Motion::Prescribed) => Ok(name.into()),
            Some(_) => Err(format!("`{name}` is not scripted: give it `motion = \"scripted\"`")),
            None => Err(format!("there is no rigid body `{name}`")),
        };
    }
    let moving = session.scene().rigid.iter().filter(|r| r.keyframes.len() > 1);
    let moving: Vec<&str> = moving
        .map(|r| r.name.value.as_str())
        .filter(|name| scripted(name) == Some(Motion::Prescribed))
        .collect();
    match moving[..] {
        [name] => Ok(name.into()),
        [] => Err("no scripted body with keyframes presses on anything".into()),
        _ => Err(format!(
            "several scripted bodies move ({}): say which, with --body",
            moving.join(", ")
        )),
    }
}

/// The contact probe that has a body, and whether it is the first of its two.
fn contact(session: &Session, body: &str) -> Result<(String, bool), String> {
    session
        .scene()
        .probe
        .iter()
        .find_map(|probe| match probe {
            Probe::Contact(contact) => {
                let at = contact.bodies.iter().position(|b| b.value == body)?;
                Some((contact.name.value.clone(), at == 0))
            }
            _ => None,
        })
        .ok_or_else(|| {
            format!(
                "no probe measures what `{body}` presses on: add [[probe]] with measure = \"contact\" and \
                 bodies = […, \"{body}\"]"
            )
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_are_read_between_steps() {
        let (x, y) = ([0.0, 1.0, 3.0], [1.0, 2.0, 6.0]);
        for (at, want) in
            [(-1.0, 1.0), (0.0, 1.0), (0.5, 1.5), (1.0, 2.0), (2.0, 4.0), (3.0, 6.0), (9.0, 6.0)]
        {
            assert_eq!(between(&x, &y, at), want, "{at}");
        }
    }
}
