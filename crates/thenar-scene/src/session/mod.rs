//! A running scene: its drivers and loads fill the input of each step, its probes read the state.

mod drive;
mod felt;
mod figures;
mod grip;
mod keep_up;
mod library;
mod live;
mod load;
mod loads;
mod memory;
mod open;
mod overlap;
mod probe;
mod replay;
mod source;
mod summary;
mod table;
mod taken_back;
mod units;
mod warn;
mod witness;

pub(crate) use drive::bones;
pub use figures::{Figure, Figures, NamedFigure};
pub use grip::{FORCE_MAX, GripError, GripsRef, IfNone, ReflexesRef};
pub use keep_up::live_overrides;
pub use library::{Builtin, builtin, builtins};
pub use loads::{HandLoad, PARTS};
pub use memory::{Memory, MemoryRef};
pub use open::{read, read_scene};
pub use overlap::StartOverlap;
pub use probe::{Column, Probes};
pub use source::Source;
pub use summary::Summary;
pub use table::{TableFormat, TableWriter};
pub use taken_back::TakenBack;
pub use thenar_core::random::{Random, random_at};
pub use witness::{Entry, Witness};

use crate::build::{Built, BuiltHand, Mesh, RigidAppearance, SoftBuild};
use crate::format::{Camera, Scene};
use crate::grip::GripHand;
use crate::live::{LiveError, LiveHand, LivePose, checked};
use crate::motion::AngleRange;
use crate::tuning::Tuning;
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;
use std::sync::OnceLock;
use thenar_core::condensed::BoneFrame;
use thenar_core::world::{Input, StageTimer, StepReport, Target};
use thenar_core::{Pose, Vec3, World};
use thenar_track::reach::Fingertips;

/// A scene that can be stepped.
#[derive(Debug)]
pub struct Session {
    scene: Scene,
    name: String,
    world: World,
    input: Input,
    built: Built,
    probes: Probes,
    /// One per hand; why not, for a hand that poses cannot move.
    live: Vec<Result<Box<LiveHand>, LiveError>>,
    /// One per hand: where its bones are led, by the haptic loop; `None` for a hand that is not.
    led: Vec<Option<Vec<Target>>>,
    /// One per hand: what it grips; `None` for a hand that was never asked to.
    grips: Vec<Option<Box<GripHand>>>,
    /// One per hand: its digits as chains, once a fingertip was wanted somewhere.
    fingertips: Vec<OnceLock<Box<Fingertips>>>,
    tuning: Tuning,
    report: StepReport,
    start_overlaps: Vec<StartOverlap>,
    steps: u64,
    /// `None` for a scene that was changed by a program.
    source: Option<Source>,
    /// Files that the scene names, as it names them.
    files: BTreeMap<String, PathBuf>,
    witness: Option<Box<dyn Witness>>,
}

impl Session {
    /// Moves the scene forward by one time step. Allocates nothing.
    pub fn step(&mut self, timer: &mut impl StageTimer) -> StepReport {
        if let Some(witness) = &mut self.witness {
            witness.stepping();
        }
        let t = self.world.time() + self.world.time_step();
        drive::fill(&mut self.input, &mut self.built, &mut self.live, &self.world, t);
        load::fill(&mut self.input, &self.built.loads, &self.world, t);
        drive::hold(&mut self.input, &mut self.built, &self.led, &self.world);
        self.steer_grips(t);
        drive::follow_leaders(&mut self.input, &self.built, &self.led);
        drive::motors(&mut self.input, &self.built, &self.world, t);
        drive::carry(&mut self.input, &self.built, &self.led, &self.world);
        self.report = self.world.step(&self.input, timer);
        self.feel_grips();
        self.steps += 1;
        if let Some(mut witness) = self.witness.take() {
            witness.stepped(self);
            self.witness = Some(witness);
        }
        self.report
    }

    /// Evaluates all probes at the present state, in the order of [`Session::columns`].
    pub fn probe(&mut self) -> &[f64] {
        self.probes.evaluate(&self.world, &self.input, &self.report, &self.built)
    }

    /// Name, unit and meaning of each number that [`Session::probe`] gives.
    pub fn columns(&self) -> &[Column] {
        self.probes.columns()
    }

    /// Steps between rows of the probe table.
    pub fn probe_every(&self) -> u64 {
        let steps = self.scene.probe_interval.unwrap_or(0.0) / self.world.time_step();
        (steps.round() as u64).max(1)
    }

    /// Steps that the scene's own duration takes.
    pub fn steps_wanted(&self) -> u64 {
        (self.scene.duration / self.world.time_step()).round().clamp(0.0, 1e15) as u64
    }

    /// Steps done.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Source that it was made from; `None` for a scene that a program has changed.
    pub fn source(&self) -> Option<&Source> {
        self.source.as_ref()
    }

    /// The files that the scene names: what it calls them, and where they are.
    pub fn files(&self) -> &BTreeMap<String, PathBuf> {
        &self.files
    }

    /// The file's name without folder and ending.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The scene as it was read.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The world, to be changed.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Fills how bones answer, for the haptic loop; see [`World::condense`]. After a step that was
    /// taken back, or left to the stand-in, nobody knows the contact forces: there is no response.
    pub fn condense(&mut self, bones: Range<u32>, to: &mut BoneFrame) -> bool {
        if self.report.non_finite || self.report.fell_back {
            to.response.clear();
            return false;
        }
        let responds = self.world.condense(bones.clone(), &self.input, to);
        drive::weigh(&self.input, &self.built, &self.led, &self.world, bones.start, to);
        responds
    }

    /// Input of the last step.
    pub fn input(&self) -> &Input {
        &self.input
    }

    /// Report of the last step.
    pub fn report(&self) -> &StepReport {
        &self.report
    }

    /// The hands.
    pub fn hands(&self) -> &[BuiltHand] {
        &self.built.hands
    }

    /// Pose of a hand's wrist in the world.
    ///
    /// # Panics
    /// When there is no hand `hand`.
    pub fn hand_wrist(&self, hand: usize) -> Pose {
        let hand = &self.built.hands[hand];
        self.world.rigid_pose(hand.handle.bones.start) * hand.wrist_B()
    }

    /// The twenty angles of a hand as they are \[rad\], see [`BuiltHand::angles`]; NaN for those
    /// that it lacks.
    ///
    /// # Panics
    /// When there is no hand `hand`.
    pub fn hand_angles(&self, hand: usize) -> [f64; 20] {
        let hand = &self.built.hands[hand];
        let first = hand.handle.joints.start;
        let angle = |range: AngleRange| {
            let angles = self.world.joint_angles(first + range.index as u32);
            range.sense * angles[range.axis]
        };
        hand.angles().map(|range| range.map_or(f64::NAN, angle))
    }

    /// A pose of a hand with its wrist's frame there in the world, digits bent from rest so that
    /// the middle of each one's pad comes to its place (thumb first, world \[m\]), and how far each
    /// ends from it \[m\]: infinity for a digit that the hand lacks, zero for one without a place.
    /// For [`Session::live_pose`].
    ///
    /// # Errors
    /// There is no such hand, poses cannot move it, wrist or places are not finite, or the wrist is
    /// far away.
    pub fn reaching(
        &self,
        hand: usize,
        wrist: Pose,
        places_W: &[Option<Vec3>; 5],
    ) -> Result<(LivePose, [f64; 5]), LiveError> {
        let count = self.live.len();
        let live = self.live.get(hand).ok_or(LiveError::NoHand { hand, count })?;
        live.as_ref().map_err(LiveError::clone)?;
        let LivePose::Angles { wrist, .. } = checked(0.0, &LivePose::flat(wrist))? else {
            return Err(LiveError::NotFinite { what: "the wrist" });
        };
        if !places_W.iter().flatten().all(|place| place.iter().all(|x| x.is_finite())) {
            return Err(LiveError::NotFinite { what: "a fingertip's place" });
        }
        let model = &self.built.hands[hand].model;
        let made = &self.fingertips[hand];
        let tips = match made.get() {
            Some(tips) => tips,
            None => {
                let tips = Fingertips::new(model).map_err(|e| {
                    let hand = self.built.hands[hand].name.clone();
                    LiveError::Unfit { hand, cause: e.to_string() }
                })?;
                made.get_or_init(|| Box::new(tips))
            }
        };
        let (angles, misses) = tips.angles(model, &wrist, places_W);
        Ok((LivePose::Angles { wrist, angles }, misses))
    }

    /// Loads on the palm, thumb, index, middle, ring and little finger of a hand; zero for a hand
    /// without flesh.
    ///
    /// # Panics
    /// When there is no hand `hand`.
    pub fn hand_loads(&self, hand: usize) -> [HandLoad; 6] {
        loads::hand_loads(&self.world, &self.built.hands[hand])
    }

    /// The soft bodies that are no hands.
    pub fn softs(&self) -> &[SoftBuild] {
        &self.built.softs
    }

    /// Rest mesh of each deformable body of the world.
    pub fn meshes(&self) -> &[Mesh] {
        &self.built.meshes
    }

    /// Appearance of each rigid body of the world.
    pub fn looks(&self) -> &[RigidAppearance] {
        &self.built.looks
    }

    /// Viewpoint of pictures, if the scene gives one.
    pub fn camera(&self) -> Option<&Camera> {
        self.scene.camera.as_ref()
    }
}
