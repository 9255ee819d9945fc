//! The proxy bones (Sec. 5): rigid, without joints, each held by one 6-DoF viscoelastic coupling to
//! the tracked pose and by another to the simulated bone.
//!
//! ```text
//!  tracked pose ──[device coupling]── proxy ──[bone coupling]── simulated bone
//!        ▲ force to the wearer                                        ▲ the world's drive
//! ```
//!
//! A step solves `A_p v = b_p`, the 6×6 system of one proxy, by backward Euler. Couplings act at
//! the centre of mass and are isotropic, so `A_p` falls apart into a scalar for the three linear
//! unknowns and a 3×3 block for the angular ones, taken in the bone's own axes.
//!
//! Guaranteed, for any stiffness, damping and step: with targets that stand still, kinetic plus
//! spring energy never grows. Angular springs are `k log(R_t Rᵀ)`, exact up to half a turn: at rest
//! torque is stiffness times angle, and the way back is the shorter one. Their linearisation takes
//! stiffness k in all directions; the true one is less across the axis of a large turn (k/2 θ cot
//! θ/2), so a step errs on the slow side there, at second order in the step. Not guaranteed: the
//! direction of turn at exactly half a turn, where both are equally short.

use crate::RigidState;
use crate::turn::rotation_vector;
use thenar_core::math::{Mat3, Quat, Vec3, skew};
use thenar_core::model::Drive;

/// One proxy bone: constant.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Proxy {
    /// Mass \[kg\].
    pub mass: f64,
    /// Inertia about the centre of mass, in B \[kg m²\].
    pub inertia_B: Mat3,
    /// Coupling to the tracked pose.
    pub device: Drive,
    /// Coupling to the simulated bone.
    pub bone: Drive,
}

/// Why a set of proxies is refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ProxyError {
    /// Mass must be positive and finite.
    #[error("proxy {proxy}: mass {mass} kg is not positive and finite")]
    Mass {
        /// Index of the proxy.
        proxy: usize,
        /// Mass of the proxy \[kg\].
        mass: f64,
    },
    /// Inertia must be symmetric positive definite.
    #[error("proxy {proxy}: inertia is not symmetric positive definite")]
    Inertia {
        /// Index of the proxy.
        proxy: usize,
    },
    /// Coupling parameters must be finite and not negative.
    #[error("proxy {proxy}: coupling parameter {value} is negative or not finite")]
    Coupling {
        /// Index of the proxy.
        proxy: usize,
        /// The parameter.
        value: f64,
    },
}

/// Events in one step of the proxies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ProxyReport {
    /// Tracked poses that were not finite; these couplings let go for the step.
    pub bad_tracked: u32,
    /// Simulated bones that were not finite; these couplings let go for the step.
    pub bad_bones: u32,
    /// Proxies whose own state became senseless; they start again at rest at the tracked pose.
    pub restarted: u32,
}

/// Nothing a hand does reaches this \[m, m/s, rad/s\]; a proxy beyond it starts again.
const SENSELESS: f64 = 1e6;

/// All proxies of a hand and their state.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub struct Proxies {
    proxies: Vec<Proxy>,
    states: Vec<RigidState>,
    device_wrenches: Vec<[Vec3; 2]>,
    bone_wrenches: Vec<[Vec3; 2]>,
}

impl Proxies {
    /// Proxies at rest at these states; one state per proxy is expected (missing ones start at
    /// the world's origin).
    pub fn new(proxies: Vec<Proxy>, start: &[RigidState]) -> Result<Self, ProxyError> {
        for (index, proxy) in proxies.iter().enumerate() {
            check(index, proxy)?;
        }
        let origin = RigidState::at_rest(thenar_core::Pose::identity());
        let state = |i: usize| start.get(i).copied().unwrap_or(origin);
        Ok(Self {
            states: (0..proxies.len()).map(state).collect(),
            device_wrenches: vec![[Vec3::zeros(); 2]; proxies.len()],
            bone_wrenches: vec![[Vec3::zeros(); 2]; proxies.len()],
            proxies,
        })
    }

    /// The proxies.
    pub fn proxies(&self) -> &[Proxy] {
        &self.proxies
    }

    /// Returns the states of the proxies: the targets of the simulated bones.
    pub fn states(&self) -> &[RigidState] {
        &self.states
    }

    /// Force \[N\] and torque about the bone's centre \[N m\] on the wearer, world, per proxy:
    /// what the device coupling did during the last step.
    pub fn device_wrenches(&self) -> &[[Vec3; 2]] {
        &self.device_wrenches
    }

    /// Force \[N\] and torque \[N m\] on the simulated bones, world, per proxy.
    pub fn bone_wrenches(&self) -> &[[Vec3; 2]] {
        &self.bone_wrenches
    }

    /// Puts a proxy somewhere, without force.
    pub fn place(&mut self, proxy: usize, state: RigidState) {
        self.states[proxy] = state;
        self.device_wrenches[proxy] = [Vec3::zeros(); 2];
        self.bone_wrenches[proxy] = [Vec3::zeros(); 2];
    }

    /// One step of `h` \[s\]; `tracked` and `bones` are where the ends of the couplings are at its
    /// end, one per proxy. A proxy without a usable end is held by the other alone; without both
    /// it stays where it is. A step that is not positive and finite changes nothing.
    pub fn step(&mut self, h: f64, tracked: &[RigidState], bones: &[RigidState]) -> ProxyReport {
        let mut report = ProxyReport::default();
        if !(h > 0.0 && h.is_finite()) {
            return report;
        }
        let ends = tracked.iter().zip(bones);
        for (i, (proxy, (tracked, bone))) in self.proxies.iter().zip(ends).enumerate() {
            let tracked = Some(tracked).filter(|end| end.is_finite());
            let bone = Some(bone).filter(|end| end.is_finite());
            report.bad_tracked += u32::from(tracked.is_none());
            report.bad_bones += u32::from(bone.is_none());
            let mut stepped = proxy.step(h, &self.states[i], tracked, bone);
            if !stepped.is_sensible() {
                report.restarted += 1;
                let near = tracked.or(bone).filter(|end| is_sensible(end));
                let pose = near.map_or(thenar_core::Pose::identity(), |end| end.pose_WB);
                stepped = ProxyStep::at_rest(RigidState::at_rest(pose));
            }
            self.states[i] = stepped.state;
            self.device_wrenches[i] = stepped.device_wrench;
            self.bone_wrenches[i] = stepped.bone_wrench;
        }
        report
    }

    /// Kinetic energy and that of both springs \[J\].
    pub fn energy(&self, tracked: &[RigidState], bones: &[RigidState]) -> f64 {
        let spring = |drive: &Drive, state: &RigidState, end: &RigidState| {
            thenar_core::kernels::drive_energy(drive, &end.target(), &state.pose_WB)
        };
        let each = self.proxies.iter().zip(&self.states).zip(tracked.iter().zip(bones));
        each.map(|((proxy, state), (tracked, bone))| {
            let omega = state.pose_WB.inverse_vector(&state.angular_velocity_W);
            let kinetic = proxy.mass * state.velocity_W.norm_squared()
                + omega.dot(&(proxy.inertia_B * omega));
            0.5 * kinetic + spring(&proxy.device, state, tracked) + spring(&proxy.bone, state, bone)
        })
        .sum()
    }
}

/// A proxy after a step and what its couplings did.
struct ProxyStep {
    state: RigidState,
    device_wrench: [Vec3; 2],
    bone_wrench: [Vec3; 2],
}

impl ProxyStep {
    fn at_rest(state: RigidState) -> Self {
        Self { state, device_wrench: [Vec3::zeros(); 2], bone_wrench: [Vec3::zeros(); 2] }
    }

    fn is_sensible(&self) -> bool {
        is_sensible(&self.state)
    }
}

/// Neither NaN, nor infinite, nor beyond reach.
fn is_sensible(state: &RigidState) -> bool {
    let largest = |v: &Vec3| v.x.abs() + v.y.abs() + v.z.abs();
    // A NaN makes the sum NaN, and the comparison false.
    largest(&state.pose_WB.position)
        + largest(&state.velocity_W)
        + largest(&state.angular_velocity_W)
        < SENSELESS
        && state.pose_WB.rotation.coords.iter().all(|x| x.is_finite())
}

impl Proxy {
    /// Backward Euler, forces linearised once (Eq. 4):
    /// linear `(m + h c + h² k) v = m v₀ + h Σ (k (x_t - x₀) + c v_t)`;
    /// angular, in B, `(I - h [I ω₀]× + h c + h² k) ω = I ω₀ + h Σ (k φ_t + c ω_t)`,
    /// where the gyroscopic term is taken as `ω × I ω₀`, which does no work.
    fn step(
        &self,
        h: f64,
        state: &RigidState,
        tracked: Option<&RigidState>,
        bone: Option<&RigidState>,
    ) -> ProxyStep {
        let rotation = &state.pose_WB.rotation;
        let ends = [(&self.device, tracked), (&self.bone, bone)];
        if tracked.is_none() && bone.is_none() {
            return ProxyStep::at_rest(RigidState::at_rest(state.pose_WB));
        }
        let spin_B = rotation.inverse_transform_vector(&state.angular_velocity_W);
        let momentum_B = self.inertia_B * spin_B;

        // What both couplings add: force and torque (in B) before the step, and their resistance.
        let mut loads = [[Vec3::zeros(); 2]; 2];
        let mut resist = [[0.0; 2]; 2];
        for (i, (drive, end)) in ends.into_iter().enumerate() {
            let Some(end) = end else { continue };
            let offset = end.pose_WB.position - state.pose_WB.position;
            let turn_B = rotation_vector(&(rotation.inverse() * end.pose_WB.rotation));
            let rate_B = rotation.inverse_transform_vector(&end.angular_velocity_W);
            loads[i] = [
                offset * drive.stiffness + end.velocity_W * drive.damping,
                turn_B * drive.angular_stiffness + rate_B * drive.angular_damping,
            ];
            resist[i] = [
                drive.damping + h * drive.stiffness,
                drive.angular_damping + h * drive.angular_stiffness,
            ];
        }

        let linear = self.mass + h * (resist[0][0] + resist[1][0]);
        let velocity_W = (state.velocity_W * self.mass + (loads[0][0] + loads[1][0]) * h) / linear;
        let angular = self.inertia_B - skew(&momentum_B) * h
            + Mat3::from_diagonal_element(h * (resist[0][1] + resist[1][1]));
        let spin_B = solve3(&angular, &(momentum_B + (loads[0][1] + loads[1][1]) * h));

        let turn = Quat::from_scaled_axis(spin_B * h);
        let pose_WB = thenar_core::Pose::new(
            state.pose_WB.position + velocity_W * h,
            Quat::new_normalize((rotation * turn).into_inner()),
        );
        // The wearer and the bone feel the opposite of what the couplings did to the proxy.
        let reaction = |i: usize| {
            [
                velocity_W * resist[i][0] - loads[i][0],
                rotation * (spin_B * resist[i][1] - loads[i][1]),
            ]
        };
        ProxyStep {
            state: RigidState { pose_WB, velocity_W, angular_velocity_W: rotation * spin_B },
            device_wrench: reaction(0),
            bone_wrench: reaction(1),
        }
    }
}

/// Solves `A x = b` by cofactors: A is definite plus antisymmetric, so its determinant is positive.
fn solve3(a: &Mat3, b: &Vec3) -> Vec3 {
    let (c0, c1, c2) =
        (a.column(0).into_owned(), a.column(1).into_owned(), a.column(2).into_owned());
    let n0 = c1.cross(&c2);
    let determinant = c0.dot(&n0);
    Vec3::new(n0.dot(b), c2.cross(&c0).dot(b), c0.cross(&c1).dot(b)) / determinant
}

fn check(index: usize, proxy: &Proxy) -> Result<(), ProxyError> {
    if !(proxy.mass > 0.0 && proxy.mass.is_finite()) {
        return Err(ProxyError::Mass { proxy: index, mass: proxy.mass });
    }
    let inertia = &proxy.inertia_B;
    let symmetric = (inertia - inertia.transpose()).norm() <= 1e-9 * inertia.norm();
    if !(symmetric && inertia.cholesky().is_some()) {
        return Err(ProxyError::Inertia { proxy: index });
    }
    for drive in [&proxy.device, &proxy.bone] {
        for value in
            [drive.stiffness, drive.damping, drive.angular_stiffness, drive.angular_damping]
        {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(ProxyError::Coupling { proxy: index, value });
            }
        }
    }
    Ok(())
}
