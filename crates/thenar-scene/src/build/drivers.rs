//! Rigid bodies that are scripted, or pulled by a drive.

use super::{Built, place};
use crate::format::{DriveTable, InterpolationWord, MotionWord, Rigid, Scene};
use crate::math::{Pose, Vec3};
use crate::text::Fault;
use thenar_core::model::Drive;

/// Coupling of a body to the pose that its driver gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Follow {
    /// The body is there.
    Exactly,
    /// A spring pulls the body there.
    BySpring,
}

/// A body whose pose over time is given.
#[derive(Clone, Debug)]
pub struct Driver {
    /// Rigid body.
    pub rigid: u32,
    /// Coupling of the body to the pose.
    pub follow: Follow,
    /// Pose over time.
    pub track: PoseTrack,
}

/// A pose over time.
#[derive(Clone, Debug)]
pub enum PoseTrack {
    /// Between keyframes; still before the first and after the last.
    Keys {
        /// Times \[s\], ascending, and poses in the world; at least one.
        keys: Vec<(f64, Pose)>,
        /// Interpolation from one key to the next.
        interpolation: InterpolationWord,
    },
    /// Constant velocity, linear \[m/s\] and angular \[rad/s\].
    Constant {
        /// Start pose.
        start: Pose,
        /// Velocities, linear and angular.
        velocity: [Vec3; 2],
    },
}

/// Part of the way and its rate \[1/s\] at part `u` of a time `span` \[s\].
pub fn ease(interpolation: InterpolationWord, u: f64, span: f64) -> (f64, f64) {
    match interpolation {
        InterpolationWord::Linear => (u, 1.0 / span),
        InterpolationWord::Smooth => {
            let way = u * u * u * (10.0 + u * (6.0 * u - 15.0));
            let slope = 30.0 * u * u * (1.0 - u) * (1.0 - u);
            (way, slope / span)
        }
    }
}

impl PoseTrack {
    /// Pose and velocity, linear \[m/s\] and angular \[rad/s\], at time `t` \[s\].
    pub fn at(&self, t: f64) -> (Pose, [Vec3; 2]) {
        let still = [Vec3::zeros(); 2];
        match self {
            Self::Constant { start, velocity } => {
                let turn = thenar_core::Quat::from_scaled_axis(velocity[1] * t);
                let pose = Pose::new(start.position + velocity[0] * t, turn * start.rotation);
                (pose, *velocity)
            }
            Self::Keys { keys, interpolation } => {
                let after = keys.partition_point(|(time, _)| *time <= t);
                let (Some((_, last)), Some((_, first))) = (keys.last(), keys.first()) else {
                    return (Pose::identity(), still);
                };
                if after == 0 {
                    return (*first, still);
                }
                if after == keys.len() {
                    return (*last, still);
                }
                between(keys[after - 1], keys[after], *interpolation, t)
            }
        }
    }
}

fn between(
    (t0, a): (f64, Pose),
    (t1, b): (f64, Pose),
    interpolation: InterpolationWord,
    t: f64,
) -> (Pose, [Vec3; 2]) {
    let span = t1 - t0;
    let (way, rate) = ease(interpolation, (t - t0) / span, span);
    let step = b.position - a.position;
    let turn = (b.rotation * a.rotation.inverse()).scaled_axis();
    let rotation = thenar_core::Quat::from_scaled_axis(turn * way) * a.rotation;
    (Pose::new(a.position + step * way, rotation), [step * rate, turn * rate])
}

/// Adds all drivers and drives.
pub fn add_all(built: &mut Built, scene: &Scene) -> Result<(), Fault> {
    for (i, rigid) in scene.rigid.iter().enumerate() {
        let follow = match (rigid.motion, &rigid.drive) {
            (MotionWord::Scripted, None) => Follow::Exactly,
            (MotionWord::Dynamic, Some(drive)) => {
                built.world.drives[i] = Some(settings(&drive.value));
                Follow::BySpring
            }
            (_, Some(drive)) => return Err(drive.fault("only a dynamic body can have a drive")),
            (_, None) => match rigid.keyframes.first() {
                None => continue,
                Some(key) => {
                    return Err(key.fault(
                        "keyframes need motion = \"scripted\", or a dynamic body with a `drive`",
                    ));
                }
            },
        };
        let pose_WB = built.world.rigids[i].pose_WB;
        let pose_MB = built.looks[i].pose_MB;
        let track = track(rigid, follow, &(pose_WB * pose_MB.inverse()), &pose_MB)?;
        if follow == Follow::Exactly {
            built.world.rigids[i].pose_WB = track.at(0.0).0;
        }
        built.drivers.push(Driver { rigid: i as u32, follow, track });
    }
    Ok(())
}

/// A drive's settings.
pub fn settings(table: &DriveTable) -> Drive {
    Drive {
        stiffness: table.stiffness,
        damping: table.damping,
        angular_stiffness: table.angular_stiffness,
        angular_damping: table.angular_damping,
    }
}

/// Keyframes place the frame M that the body's shape was drawn in, as its start pose does.
fn track(rigid: &Rigid, follow: Follow, start: &Pose, pose_MB: &Pose) -> Result<PoseTrack, Fault> {
    let mut keys: Vec<(f64, Pose)> = Vec::new();
    for key in &rigid.keyframes {
        let before = keys.last().map_or(*start, |k| k.1);
        if keys.last().is_some_and(|k| key.value.time - k.0 < 1e-9) {
            return Err(key.fault("expected a later `time` than that of the keyframe before"));
        }
        let rotation = match &key.value.rotation {
            Some(_) => place::rotation(key.value.rotation.as_ref())?,
            None => before.rotation,
        };
        let position = key.value.position.unwrap_or(before.position);
        keys.push((key.value.time, Pose::new(position, rotation)));
    }
    keys.iter_mut().for_each(|(_, pose)| *pose = *pose * *pose_MB);
    let start = *start * *pose_MB;
    match (keys.is_empty(), follow) {
        (true, Follow::Exactly) => {
            Ok(PoseTrack::Constant { start, velocity: [rigid.velocity, rigid.angular_velocity] })
        }
        (true, Follow::BySpring) => {
            Ok(PoseTrack::Keys { keys: vec![(0.0, start)], interpolation: rigid.interpolation })
        }
        (false, _) => Ok(PoseTrack::Keys { keys, interpolation: rigid.interpolation }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use thenar_core::Quat;

    #[test]
    fn velocity_is_the_derivative_of_the_pose() {
        let turned = Quat::from_scaled_axis(Vec3::new(0.3, -1.2, 0.5));
        let keys = vec![
            (0.5, Pose::translation(1.0, 0.0, 0.0)),
            (1.5, Pose::new(Vec3::new(0.0, 2.0, 0.0), turned)),
        ];
        for interpolation in [InterpolationWord::Smooth, InterpolationWord::Linear] {
            let track = PoseTrack::Keys { keys: keys.clone(), interpolation };
            for t in [0.6, 0.9, 1.2, 1.45] {
                let (_, [v, w]) = track.at(t);
                let e = 1e-6;
                let [v_fd, w_fd] = thenar_core::kinematics::velocity_between(
                    &track.at(t - e).0,
                    &track.at(t + e).0,
                    2.0 * e,
                );
                assert!((v - v_fd).norm() < 1e-7, "{v} {v_fd}");
                assert!((w - w_fd).norm() < 1e-7, "{w} {w_fd}");
            }
            assert_eq!(track.at(0.2).0, keys[0].1);
            assert_eq!(track.at(9.0).0, keys[1].1);
        }
    }
}
