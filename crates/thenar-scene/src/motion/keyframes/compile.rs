//! From keys to curves.

use super::desc::{JointKey, Key, KeyframesDesc, LimitPolicy, WristKey};
use crate::motion::error::MotionError;
use crate::motion::interpolate::{RotationTrack, ScalarTrack, VectorTrack};
use crate::motion::preset::Preset;
use crate::motion::shapes::Shapes;
use thenar_core::model::{Digit, HandModel};
use thenar_core::{Mat3, Pose, Quat, Vec3};
use thenar_track::reach::Fingertips;
use thenar_track::{Anatomy, Articulation, JointRole};

/// Part of the way to a fist after which the thumb, aside until then, comes over the fingers.
const THUMB_LAST: f64 = 0.75;

/// A pad that ends farther from its place is short of it \[m\]: as far as skin gives way under a
/// light touch.
const SHORT: f64 = 1e-3;

fn bad_key(k: usize, key: &Key, cause: String) -> MotionError {
    MotionError::Key { number: k + 1, time: key.time, cause }
}

/// Times must be finite and increase by a microsecond at least; returns the last.
pub fn check_times(keys: &[Key]) -> Result<f64, MotionError> {
    let mut last = None;
    for (k, key) in keys.iter().enumerate() {
        if !(0.0..=1e6).contains(&key.time) {
            return Err(bad_key(k, key, "time must be between 0 and 1e6 s".into()));
        }
        if last.is_some_and(|last| key.time < last + 1e-6) {
            return Err(bad_key(k, key, "time must be later than that of the key before".into()));
        }
        last = Some(key.time);
    }
    last.ok_or(MotionError::NoKeys)
}

pub fn wrist_tracks(
    keys: &[Key],
    home: &Pose,
) -> Result<(VectorTrack, RotationTrack), MotionError> {
    let (mut positions, mut rotations) = (Vec::new(), Vec::new());
    for (k, key) in keys.iter().enumerate() {
        let Some(wrist) = &key.wrist else { continue };
        if let Some(position) = wrist.position {
            if !position.iter().all(|x| x.abs() <= 1e3) {
                let cause = format!("wrist position {position:?} is not within 1 km");
                return Err(bad_key(k, key, cause));
            }
            positions.push((key.time, Vec3::from(position)));
        }
        if let Some(rotation) = wrist_rotation(wrist).map_err(|c| bad_key(k, key, c))? {
            rotations.push((key.time, rotation));
        }
    }
    if positions.is_empty() {
        positions.push((0.0, home.position));
    }
    if rotations.is_empty() {
        rotations.push((0.0, home.rotation));
    }
    Ok((VectorTrack::new(&positions), RotationTrack::new(&rotations)))
}

fn wrist_rotation(wrist: &WristKey) -> Result<Option<Quat>, String> {
    match (wrist.rotation, wrist.fingers, wrist.back) {
        (None, None, None) => Ok(None),
        (Some(q), None, None) => unit_quaternion(q).map(Some),
        (None, Some(fingers), Some(back)) => directions(fingers, back).map(Some),
        _ => Err("wrist needs either `rotation`, or both `fingers` and `back`".into()),
    }
}

fn unit_quaternion([x, y, z, w]: [f64; 4]) -> Result<Quat, String> {
    let q = nalgebra::Quaternion::new(w, x, y, z);
    let norm = q.norm();
    if norm.is_nan() || (norm - 1.0).abs() > 1e-2 {
        return Err(format!("wrist rotation must be a unit quaternion, its length is {norm}"));
    }
    Ok(Quat::from_quaternion(q))
}

fn directions(fingers: [f64; 3], back: [f64; 3]) -> Result<Quat, String> {
    let unit = |v: Vec3| v.try_normalize(1e-9).filter(|v| v.iter().all(|x| x.is_finite()));
    let axes = unit(-Vec3::from(fingers)).and_then(|z| {
        let y = unit(Vec3::from(back)).and_then(|back| unit(back - z * z.dot(&back)))?;
        Some(Mat3::from_columns(&[y.cross(&z), y, z]))
    });
    axes.map(|R| Quat::from_rotation_matrix(&nalgebra::Rotation3::from_matrix_unchecked(R)))
        .ok_or_else(|| "wrist `fingers` and `back` must be two directions, not parallel".into())
}

/// Two curves per joint, one for each angle, and a warning for each clamped angle.
pub fn joint_tracks(
    desc: &KeyframesDesc,
    hand: &HandModel,
    articulation: &Articulation,
    anatomy: &Anatomy,
    wrist: &dyn Fn(f64) -> Pose,
) -> Result<(Vec<[ScalarTrack; 2]>, Vec<String>), MotionError> {
    let shapes = Shapes::new(hand, articulation, anatomy);
    let mut compiler = Compiler::new(desc.limits, articulation, anatomy, shapes);
    if desc.key.iter().any(|key| !key.tips.is_empty()) {
        compiler.tips = Some(Fingertips::new(hand)?);
    }
    for (k, key) in desc.key.iter().enumerate() {
        compiler.add(key, &wrist(key.time)).map_err(|cause| bad_key(k, key, cause))?;
    }
    Ok(compiler.finish())
}

/// Gathers the angles of all joints key by key.
struct Compiler<'a> {
    policy: LimitPolicy,
    articulation: &'a Articulation,
    anatomy: &'a Anatomy,
    shapes: Shapes<'a>,
    /// Present where a key gives places of fingertips.
    tips: Option<Fingertips>,
    knots: Vec<[Vec<(f64, f64)>; 2]>,
    /// Shape with the thumb over bent fingers that the last key with a shape made.
    thumb_over: Option<Preset>,
    warnings: Vec<String>,
}

impl<'a> Compiler<'a> {
    fn new(
        policy: LimitPolicy,
        articulation: &'a Articulation,
        anatomy: &'a Anatomy,
        shapes: Shapes<'a>,
    ) -> Self {
        let knots = vec![[Vec::new(), Vec::new()]; anatomy.roles.len()];
        Self {
            policy,
            articulation,
            anatomy,
            shapes,
            tips: None,
            knots,
            thumb_over: None,
            warnings: Vec::new(),
        }
    }

    fn add(&mut self, key: &Key, wrist: &Pose) -> Result<(), String> {
        let mut wanted = vec![[None; 2]; self.knots.len()];
        for (j, role) in self.anatomy.roles.iter().enumerate() {
            if let Some(preset) = key.pose {
                wanted[j] = self.shapes.angles(preset, j).map(Some);
            }
            if let Some(curl) = key.curl.get(&role.digit) {
                wanted[j] = self.curl(j, role, *curl)?;
            }
        }
        for digit in key.curl.keys() {
            if self.anatomy.joints_of(*digit).next().is_none() {
                return Err(format!("curl: the hand has no {}", digit.name()));
            }
        }
        for (name, joint) in &key.joints {
            self.joint(name, joint, key.time, &mut wanted)?;
        }
        self.reach(key, wrist, &mut wanted)?;
        self.thumb_aside(key, &wanted);
        for (knots, wanted) in self.knots.iter_mut().zip(wanted) {
            for (knots, wanted) in knots.iter_mut().zip(wanted) {
                knots.extend(wanted.map(|angle| (key.time, angle)));
            }
        }
        Ok(())
    }

    /// Bends digits so that their pads are where the key wants them.
    fn reach(
        &mut self,
        key: &Key,
        wrist: &Pose,
        wanted: &mut [[Option<f64>; 2]],
    ) -> Result<(), String> {
        let Some(tips) = self.tips.as_ref().filter(|_| !key.tips.is_empty()) else { return Ok(()) };
        let places = Digit::FINGERS.map(|digit| key.tips.get(&digit).map(|x| Vec3::from(*x)));
        if let Some(place) = places.iter().flatten().find(|x| !x.iter().all(|x| x.abs() <= 1e3)) {
            return Err(format!("tips: {:?} is not within 1 km", place.as_slice()));
        }
        // From the shape of this key, and at rest where it gives none.
        let rest = &self.articulation.rest_angles;
        let shape = wanted.iter().zip(rest);
        let mut angles: Vec<[f64; 2]> =
            shape.map(|(wanted, rest)| [0, 1].map(|k| wanted[k].unwrap_or(rest[k]))).collect();
        let misses = tips.bend(wrist, &places, &mut angles);
        for (digit, miss) in Digit::FINGERS.into_iter().zip(misses) {
            if !key.tips.contains_key(&digit) {
                continue;
            }
            if miss == f64::INFINITY {
                return Err(format!("tips: the hand has no {} that can be led", digit.name()));
            }
            for j in self.anatomy.joints_of(digit) {
                wanted[j] = angles[j].map(Some);
            }
            if miss > SHORT {
                let text = format!(
                    "tips: the {}'s pad ends {:.0} mm from its place: out of reach of the wrist there",
                    digit.name(),
                    1e3 * miss
                );
                match self.policy {
                    LimitPolicy::Error => return Err(text),
                    LimitPolicy::Clamp => {
                        self.warnings.push(format!("time {} s: {text}", key.time));
                    }
                }
            }
        }
        Ok(())
    }

    /// Leads the thumb aside on its way over bent fingers, until they have bent, and on its way
    /// from there. A thumb whose angles a key names goes its own way.
    fn thumb_aside(&mut self, key: &Key, wanted: &[[Option<f64>; 2]]) {
        let thumb: Vec<usize> = self.anatomy.joints_of(Digit::Thumb).collect();
        let mut named = key.joints.keys().filter_map(|name| self.anatomy.find(name));
        let own = key.curl.contains_key(&Digit::Thumb)
            || key.tips.contains_key(&Digit::Thumb)
            || named.any(|j| thumb.contains(&j));
        if !own && key.pose.is_none() {
            return;
        }
        let over = key.pose.filter(|pose| !own && pose.is_closed());
        let before = std::mem::replace(&mut self.thumb_over, over);
        if own || over == before {
            return;
        }
        // Off the fingers before the first of them sets out, and over them after the last.
        let fingers = self.anatomy.roles.iter().zip(&self.knots).zip(wanted);
        let moving = fingers.filter(|((role, _), wanted)| {
            role.digit != Digit::Thumb && wanted.iter().any(Option::is_some)
        });
        let set_out = moving.filter_map(|((_, knots), _)| {
            knots.iter().filter_map(|knots| knots.last()).map(|(time, _)| *time).reduce(f64::max)
        });
        let [first, last] =
            set_out.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], t| [a.min(t), b.max(t)]);
        if first > last {
            return;
        }
        let leaves = before.map(|_| (first, 1.0 - THUMB_LAST));
        let arrives = over.map(|_| (last, THUMB_LAST));
        for j in thumb {
            let aside = self.shapes.thumb_aside(j);
            for (k, knots) in self.knots[j].iter_mut().enumerate() {
                let (Some((own, angle)), Some(_)) = (knots.last().copied(), wanted[j][k]) else {
                    continue;
                };
                let start = |from: f64| from.max(own);
                if let Some((from, _)) = leaves.or(arrives).filter(|(from, _)| *from > own) {
                    knots.push((from, angle));
                }
                for (from, part) in [leaves, arrives].into_iter().flatten() {
                    knots.push((start(from) + part * (key.time - start(from)), aside[k]));
                }
            }
        }
    }

    fn curl(&self, j: usize, role: &JointRole, curl: f64) -> Result<[Option<f64>; 2], String> {
        if !(0.0..=1.0).contains(&curl) {
            return Err(format!("curl of {} must be in 0..1, got {curl}", role.digit.name()));
        }
        // One finger alone is closed, not squeezed.
        let [open, fist] = [Preset::Open, Preset::Fist].map(|shape| self.shapes.table(shape, j));
        Ok([0, 1].map(|k| Some(open[k] + curl * (fist[k] - open[k]))))
    }

    fn joint(
        &mut self,
        name: &str,
        key: &JointKey,
        time: f64,
        wanted: &mut [[Option<f64>; 2]],
    ) -> Result<(), String> {
        let Some(j) = self.anatomy.find(name) else {
            let known: Vec<_> = self.anatomy.roles.iter().map(|r| r.bone.as_str()).collect();
            return Err(format!("the hand has no joint `{name}`; it has {}", known.join(", ")));
        };
        let role = &self.anatomy.roles[j];
        let parts =
            [("flexion", key.flexion_deg, role.flexion), ("spread", key.spread_deg, role.spread)];
        for (what, degrees, axis) in parts {
            let Some(degrees) = degrees else { continue };
            let Some((axis, sense)) = axis else {
                return Err(format!("joint `{name}` has no {what}"));
            };
            if !degrees.is_finite() {
                return Err(format!("joint `{name}`: {what} {degrees} is not a number"));
            }
            let angle = self.admit(j, axis, sense, what, name, degrees, time)?;
            wanted[j][axis] = Some(angle);
        }
        Ok(())
    }

    /// The angle \[rad\], checked against the joint's range.
    fn admit(
        &mut self,
        j: usize,
        axis: usize,
        sense: f64,
        what: &str,
        name: &str,
        degrees: f64,
        time: f64,
    ) -> Result<f64, String> {
        let angle = sense * degrees.to_radians();
        let mut angles = self.articulation.rest_angles[j];
        angles[axis] = angle;
        let clamped = self.articulation.tree.clamp(j, angles)[axis];
        if (clamped - angle).abs() < 1e-9 {
            return Ok(clamped);
        }
        let nearest = sense * clamped.to_degrees();
        let text = format!(
            "joint `{name}`: {what} {degrees}° is out of range, the nearest is {nearest:.1}°"
        );
        match self.policy {
            LimitPolicy::Error => Err(text),
            LimitPolicy::Clamp => {
                self.warnings.push(format!("time {time} s: {text}, taken instead"));
                Ok(clamped)
            }
        }
    }

    fn finish(self) -> (Vec<[ScalarTrack; 2]>, Vec<String>) {
        let rest = &self.articulation.rest_angles;
        let tracks = self.knots.iter().zip(rest).map(|(knots, rest)| {
            [0, 1].map(|k| match knots[k].is_empty() {
                true => ScalarTrack::new(&[(0.0, rest[k])]),
                false => ScalarTrack::new(&knots[k]),
            })
        });
        (tracks.collect(), self.warnings)
    }
}
