//! Single-rate touch: the whole simulation steps within the haptic tick. Nothing is smoothed and
//! nothing is late; it must fit into a tick.
//!
//! There are no proxies: tracked poses are the targets of the bones' drives, and what the drives do
//! is felt from their other end ([`drive_reaction`]). A drive then stands for both couplings in
//! series ([`series_drive`]).

use crate::led_hand::LedHand;
use crate::{
    BoneFrame, EmptyAirHand, ProxyTargets, RigidState, TickReport, Touch, drive_reaction,
    series_stiffness,
};
use std::ops::Range;
use thenar_core::math::Vec3;
use thenar_core::model::Drive;
use thenar_core::world::{Input, ModelError, StepReport, World};

/// Settings for stepping a simulation within the tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleRateSettings {
    /// A tick longer than this is stepped as if it were this long \[s\]: the simulation falls
    /// behind rather than leap.
    pub step_max: f64,
    /// Shorter times wait for the next tick \[s\].
    pub step_min: f64,
    /// Whoever fills the input carries the hand's weight.
    pub weightless: bool,
}

impl Default for SingleRateSettings {
    fn default() -> Self {
        Self { step_max: 0.02, step_min: 1e-4, weightless: false }
    }
}

/// The hand does what it would do in empty air when its couplings bear no more than this beyond
/// \[N\], \[N m\]: a fiftieth of what a finger feels, and that at the lever of half a phalanx.
const ALIKE: [f64; 2] = [1e-4, 2e-6];

/// A hand whose world steps within the haptic tick.
#[derive(Clone, Debug)]
pub struct SingleRate {
    settings: SingleRateSettings,
    world: World,
    input: Input,
    /// The hand's bones among the rigid bodies.
    first: usize,
    hand: LedHand,
    bones: Vec<RigidState>,
    /// Counterpart of this hand in empty air, and whether it differs from this one.
    free: EmptyAirHand,
    differs: bool,
    /// Wrenches that drives bear, less those in empty air; then the part that is shown.
    felt: Vec<[Vec3; 2]>,
    wrenches: Vec<[Vec3; 2]>,
    /// Parts of the drives' forces and torques that are shown.
    shown: Vec<[f64; 2]>,
    /// Time that has passed and is not simulated yet \[s\].
    owed: f64,
    ticks: u64,
}

impl SingleRate {
    /// `bones` are the hand's among the world's rigid bodies, those with a drive are felt.
    /// Allocates all it needs.
    ///
    /// # Errors
    /// The hand cannot be taken out of its world: what it does in empty air, which is not to be
    /// felt, is not known.
    pub fn new(
        settings: SingleRateSettings,
        world: World,
        bones: Range<u32>,
    ) -> Result<Self, ModelError> {
        let end = (bones.end as usize).min(world.model().rigids.len());
        let first = (bones.start as usize).min(end);
        let n = end - first;
        let at = |i: usize| RigidState::of(&world, (first + i) as u32);
        let states: Vec<RigidState> = (0..n).map(at).collect();
        let free = EmptyAirHand::of(&world, first as u32..end as u32, settings.weightless)?;
        Ok(Self {
            free,
            differs: false,
            settings,
            input: world.input(),
            first,
            hand: LedHand::new(&states),
            bones: states,
            felt: vec![[Vec3::zeros(); 2]; n],
            wrenches: vec![[Vec3::zeros(); 2]; n],
            shown: vec![[1.0; 2]; n],
            owed: 0.0,
            ticks: 0,
            world,
        })
    }

    /// Shows only these parts of a bone's force and torque to the wearer, 0 to 1.
    pub fn show(&mut self, bone: usize, parts: [f64; 2]) {
        self.shown[bone] = parts;
    }

    /// The bones' targets; one that was never tracked is let go, and nothing is felt of it.
    fn lead_bones(&mut self) {
        for (i, target) in self.hand.states().iter().enumerate() {
            let target = Some(target.target()).filter(|_| self.hand.is_known(i));
            self.input.targets[self.first + i] = target;
        }
    }

    /// The world's step, and that of the hand in empty air where it does something else.
    fn step(&mut self) -> StepReport {
        let Self { world, free, input, .. } = self;
        if !self.differs {
            free.resume(world.state());
        }
        world.set_time_step(self.owed);
        let report = world.step(input, &mut ());
        let acts = self.is_acted_on();
        if acts || self.differs {
            let bones = self.first..self.first + self.bones.len();
            let targets = self.input.targets[bones].iter().copied();
            self.free.step(self.owed, targets, &self.input);
            self.differs = true;
        }
        self.owed = 0.0;
        self.feel();
        // Nothing acts, and nothing is left of what did.
        let alike = |wrench: &[Vec3; 2]| wrench[0].norm() < ALIKE[0] && wrench[1].norm() < ALIKE[1];
        if !acts && self.felt.iter().all(alike) {
            self.differs = false;
        }
        report
    }

    /// True if contact or a load acts on the hand: what it would not meet in empty air.
    fn is_acted_on(&self) -> bool {
        let bones = self.first as u32..(self.first + self.bones.len()) as u32;
        let gravity = if self.settings.weightless { self.input.gravity } else { Vec3::zeros() };
        let loaded = |b: u32| {
            let [force, torque] = self.input.wrenches[b as usize];
            let weight = gravity * self.world.model().rigids[b as usize].mass;
            force + weight != Vec3::zeros() || torque != Vec3::zeros()
        };
        self.world.is_touched(bones.clone()) || bones.clone().any(loaded)
    }

    fn feel(&mut self) {
        for i in 0..self.bones.len() {
            self.bones[i] = RigidState::of(&self.world, (self.first + i) as u32);
            let drive = self.world.desc().drives[self.first + i];
            let held = drive.filter(|_| self.input.targets[self.first + i].is_some());
            let bears = |drive: &Drive, bone: &RigidState| {
                drive_reaction(drive, &self.hand.states()[i], bone)
            };
            self.felt[i] = match held {
                Some(drive) if self.differs => {
                    let (whole, own) =
                        (bears(&drive, &self.bones[i]), bears(&drive, &self.free.bone(i)));
                    [whole[0] - own[0], whole[1] - own[1]]
                }
                _ => [Vec3::zeros(); 2],
            };
        }
    }

    /// Sets the part that the wearer is shown.
    fn show_felt(&mut self) {
        for (i, [force, torque]) in self.felt.iter().enumerate() {
            let [linear, angular] = self.shown[i];
            self.wrenches[i] = [force * linear, torque * angular];
        }
    }
}

impl Touch for SingleRate {
    fn hand(&self) -> &LedHand {
        &self.hand
    }

    fn hand_mut(&mut self) -> &mut LedHand {
        &mut self.hand
    }

    fn tick(&mut self, now_ns: u64, _: &BoneFrame) -> TickReport {
        let h = self.hand.passed(now_ns, self.settings.step_max);
        self.owed = (self.owed + h).min(self.settings.step_max);
        self.hand.place(&self.bones);
        self.lead_bones();
        let mut world = None;
        if self.owed >= self.settings.step_min && self.owed > 0.0 {
            world = Some(self.step());
        } else {
            self.feel();
        }
        self.show_felt();
        self.ticks += 1;
        TickReport { step: h, world, ..TickReport::default() }
    }

    fn write_targets(&self, now_ns: u64, to: &mut ProxyTargets) {
        (to.time_ns, to.tick) = (now_ns, self.ticks);
        to.proxies.copy_from_slice(self.hand.states());
        to.free.copy_from_slice(self.hand.states());
    }

    fn bones(&self) -> &[RigidState] {
        &self.bones
    }

    fn added_delay(&self, _: usize, observed: f64) -> f64 {
        observed
    }

    fn device_wrenches(&self) -> &[[Vec3; 2]] {
        &self.wrenches
    }

    fn input_mut(&mut self) -> Option<&mut Input> {
        Some(&mut self.input)
    }

    fn world(&self) -> Option<&World> {
        Some(&self.world)
    }
}

/// The drive that feels like a proxy between two couplings, once it is at rest: springs in series,
/// dampers in series.
pub fn series_drive(device: &Drive, bone: &Drive) -> Drive {
    Drive {
        stiffness: series_stiffness(device.stiffness, bone.stiffness),
        damping: series_stiffness(device.damping, bone.damping),
        angular_stiffness: series_stiffness(device.angular_stiffness, bone.angular_stiffness),
        angular_damping: series_stiffness(device.angular_damping, bone.angular_damping),
    }
}
