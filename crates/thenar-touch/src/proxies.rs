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
use crate::lanes::{
    Quatx8, inverse, lane, load, normalized, numbers, product, quaternion, rotate,
    rotation_vectors, rotations,
};
use fearless_simd::{Level, Simd, dispatch, f64x8, prelude::*};
use thenar_core::math::lanes::{LANES, Vec3x8, cross, dot, three};
use thenar_core::math::{Mat3, Vec3};
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
        let n = self.proxies.len().min(tracked.len()).min(bones.len());
        for first in (0..n).step_by(LANES) {
            let some = first..n.min(first + LANES);
            let states = &mut self.states[some.clone()];
            let ends = [&tracked[some.clone()], &bones[some.clone()]];
            let mut usable = [[false; LANES]; 2];
            let mut held = [None; LANES];
            for (lane, state) in states.iter().enumerate() {
                let both = ends.map(|ends| ends[lane].is_finite());
                (usable[0][lane], usable[1][lane]) = (both[0], both[1]);
                report.bad_tracked += u32::from(!both[0]);
                report.bad_bones += u32::from(!both[1]);
                if both == [false; 2] {
                    held[lane] = Some(RigidState::at_rest(state.pose_WB));
                }
            }
            let eight = Eight { proxies: &self.proxies[some.clone()], ends, usable: &usable };
            let wrenches =
                [&mut self.device_wrenches[some.clone()], &mut self.bone_wrenches[some.clone()]];
            dispatch!(Level::new(), simd => eight.step(simd, h, states, wrenches));
            for (lane, i) in some.enumerate() {
                if let Some(held) = held[lane] {
                    self.place(i, held);
                }
                if !is_sensible(&self.states[i]) {
                    report.restarted += 1;
                    let near = [&tracked[i], &bones[i]].into_iter().find(|end| end.is_finite());
                    let near = near.filter(|end| is_sensible(end));
                    let pose = near.map_or(thenar_core::Pose::identity(), |end| end.pose_WB);
                    self.place(i, RigidState::at_rest(pose));
                }
            }
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

/// State in each lane: position and velocity \[m, m/s\], rotation and angular velocity \[rad/s\].
struct Statex8<S: Simd> {
    position: Vec3x8<S>,
    rotation: Quatx8<S>,
    velocity: Vec3x8<S>,
    spin: Vec3x8<S>,
}

impl<S: Simd> Statex8<S> {
    #[inline(always)]
    fn load<'a>(simd: S, bones: usize, of: impl Fn(usize) -> &'a RigidState) -> Self {
        let [x, y, z, a, b, c, d, u, v, w, p, q, r] = load(
            simd,
            bones,
            #[inline(always)]
            |lane| {
                let RigidState { pose_WB, velocity_W: v, angular_velocity_W: w } = of(lane);
                let (x, [a, b, c, d]) = (&pose_WB.position, numbers(&pose_WB.rotation));
                [x.x, x.y, x.z, a, b, c, d, v.x, v.y, v.z, w.x, w.y, w.z]
            },
        );
        let (position, rotation) = ([x, y, z], [a, b, c, d]);
        Self { position, rotation, velocity: [u, v, w], spin: [p, q, r] }
    }

    #[inline(always)]
    fn of(&self, i: usize) -> RigidState {
        let rotation = quaternion(lane(&self.rotation, i));
        RigidState {
            pose_WB: thenar_core::Pose::new(lane(&self.position, i).into(), rotation),
            velocity_W: lane(&self.velocity, i).into(),
            angular_velocity_W: lane(&self.spin, i).into(),
        }
    }
}

/// Coupling in each lane: its force and its torque in the bone's axes before the step \[N,
/// N m\], and its resistance to velocity \[N s/m, N m s\].
struct Loadx8<S: Simd> {
    force: Vec3x8<S>,
    torque_B: Vec3x8<S>,
    resists: f64x8<S>,
    resists_turns: f64x8<S>,
}

impl<S: Simd> Loadx8<S> {
    /// Between bones in these states and these ends.
    #[inline(always)]
    fn new(simd: S, h: f64, state: &Statex8<S>, end: &Statex8<S>, drive: [f64x8<S>; 4]) -> Self {
        let [k, c, angular_k, angular_c] = drive;
        let to_B = inverse(state.rotation);
        let turn_B = rotation_vectors(simd, &product(&to_B, &end.rotation));
        let rate_B = rotate(&to_B, &end.spin);
        let force = three(
            #[inline(always)]
            |i| (end.position[i] - state.position[i]).mul_add(k, end.velocity[i] * c),
        );
        let torque_B = three(
            #[inline(always)]
            |i| turn_B[i].mul_add(angular_k, rate_B[i] * angular_c),
        );
        let (resists, resists_turns) = (k.mul_add(h, c), angular_k.mul_add(h, angular_c));
        Self { force, torque_B, resists, resists_turns }
    }

    /// Force and torque of it on the other side \[N, N m\], once the bone has this velocity and, in
    /// its own axes, this spin; `rotation` is that before the step.
    #[inline(always)]
    fn reaction(&self, v: &Vec3x8<S>, spin_B: &Vec3x8<S>, rotation: &Quatx8<S>) -> [Vec3x8<S>; 2] {
        let force = three(
            #[inline(always)]
            |i| v[i].mul_sub(self.resists, self.force[i]),
        );
        let torque_B = three(
            #[inline(always)]
            |i| spin_B[i].mul_sub(self.resists_turns, self.torque_B[i]),
        );
        [force, rotate(rotation, &torque_B)]
    }
}

/// Up to eight proxies, the ends of their couplings to hand and bones, and which of these are
/// usable.
struct Eight<'a> {
    proxies: &'a [Proxy],
    ends: [&'a [RigidState]; 2],
    usable: &'a [[bool; LANES]; 2],
}

impl Eight<'_> {
    /// Backward Euler, forces linearised once (Eq. 4):
    /// linear `(m + h c + h² k) v = m v₀ + h Σ (k (x_t - x₀) + c v_t)`;
    /// angular, in B, `(I - h [I ω₀]× + h c + h² k) ω = I ω₀ + h Σ (k φ_t + c ω_t)`,
    /// where the gyroscopic term is taken as `ω × I ω₀`, which does no work.
    #[inline(always)]
    fn step<S: Simd>(
        &self,
        simd: S,
        h: f64,
        states: &mut [RigidState],
        wrenches: [&mut [[Vec3; 2]]; 2],
    ) {
        let state = Statex8::load(
            simd,
            states.len(),
            #[inline(always)]
            |lane| &states[lane],
        );
        let device = self.load(simd, h, states, &state, 0);
        let bone = self.load(simd, h, states, &state, 1);
        let [mass, xx, yy, zz, xy, xz, yz] = load(
            simd,
            states.len(),
            #[inline(always)]
            |lane| {
                let Proxy { mass, inertia_B: i, .. } = &self.proxies[lane];
                [*mass, i.m11, i.m22, i.m33, i.m12, i.m13, i.m23]
            },
        );

        let linear = (device.resists + bone.resists).mul_add(h, mass);
        let velocity = three(
            #[inline(always)]
            |i| {
                let pull = (device.force[i] + bone.force[i]) * h;
                state.velocity[i].mul_add(mass, pull) / linear
            },
        );
        let spin_B = rotate(&inverse(state.rotation), &state.spin);
        let momentum_B =
            [dot(&[xx, xy, xz], &spin_B), dot(&[xy, yy, yz], &spin_B), dot(&[xz, yz, zz], &spin_B)];
        let resists = (device.resists_turns + bone.resists_turns) * h;
        let [mx, my, mz] = momentum_B;
        let (mx, my, mz) = (mx * h, my * h, mz * h);
        let columns = [
            [xx + resists, xy - mz, xz + my],
            [xy + mz, yy + resists, yz - mx],
            [xz - my, yz + mx, zz + resists],
        ];
        let turns = three(
            #[inline(always)]
            |i| (device.torque_B[i] + bone.torque_B[i]).mul_add(h, momentum_B[i]),
        );
        let spin_B = solve3(&columns, &turns);

        let turn = rotations(simd, &[spin_B[0] * h, spin_B[1] * h, spin_B[2] * h]);
        let position = three(
            #[inline(always)]
            |i| velocity[i].mul_add(h, state.position[i]),
        );
        let after = Statex8 {
            position,
            rotation: normalized(product(&state.rotation, &turn)),
            velocity,
            spin: rotate(&state.rotation, &spin_B),
        };
        let reactions = [
            device.reaction(&velocity, &spin_B, &state.rotation),
            bone.reaction(&velocity, &spin_B, &state.rotation),
        ];
        for (i, state) in states.iter_mut().enumerate() {
            *state = after.of(i);
        }
        for (wrenches, [force, torque]) in wrenches.into_iter().zip(&reactions) {
            for (i, wrench) in wrenches.iter_mut().enumerate() {
                *wrench = [lane(force, i).into(), lane(torque, i).into()];
            }
        }
    }

    /// Loads by the couplings to the hand (0) or to the bones (1). An end that is not usable pulls
    /// nothing.
    #[inline(always)]
    fn load<S: Simd>(
        &self,
        simd: S,
        h: f64,
        states: &[RigidState],
        state: &Statex8<S>,
        side: usize,
    ) -> Loadx8<S> {
        let (ends, usable) = (self.ends[side], &self.usable[side]);
        let end = Statex8::load(
            simd,
            states.len(),
            #[inline(always)]
            |lane| if usable[lane] { &ends[lane] } else { &states[lane] },
        );
        let drive = load(
            simd,
            states.len(),
            #[inline(always)]
            |lane| {
                let Proxy { device, bone, .. } = &self.proxies[lane];
                let drive = [device, bone][side];
                let Drive { stiffness, damping, angular_stiffness, angular_damping } = *drive;
                let numbers = [stiffness, damping, angular_stiffness, angular_damping];
                if usable[lane] { numbers } else { [0.0; 4] }
            },
        );
        Loadx8::new(simd, h, state, &end, drive)
    }
}

/// Solves `A x = b` by cofactors, A by columns: it is definite plus antisymmetric, so its
/// determinant is positive.
#[inline(always)]
fn solve3<S: Simd>([a, b, c]: &[Vec3x8<S>; 3], right: &Vec3x8<S>) -> Vec3x8<S> {
    let rows = [cross(b, c), cross(c, a), cross(a, b)];
    let determinant = dot(a, &rows[0]);
    three(
        #[inline(always)]
        |i| dot(&rows[i], right) / determinant,
    )
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
