//! From a file to a session.

use super::{Probes, Session, Source, drive};
use crate::build::{BuiltHand, Files, build};
use crate::format::{PresetWord, Scene};
use crate::hands::{Hands, with_hands};
use crate::live::{LiveError, LiveHand};
use crate::text::{Fault, Node, Override, SceneError, apply_override, parse};
use crate::tuning::{HandBodies, Tuning};
use std::path::Path;
use std::sync::OnceLock;
use thenar_core::model::CouplingKind;
use thenar_core::world::StepReport;
use thenar_core::{Vec3, World};

/// Largest scene file \[bytes\].
const SCENE_BYTES_MAX: u64 = 8 << 20;

impl Session {
    /// Loads a scene from a file. An override is `key=value`, see
    /// [`apply_override`].
    ///
    /// # Errors
    /// The file cannot be read, or something in it is wrong; says what and where.
    pub fn load(path: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        Self::from_text(&read_scene(path)?, path, overrides)
    }

    /// Loads a scene from its text; `file` names it in messages and is where relative paths
    /// start.
    ///
    /// # Errors
    /// Something in the text is wrong; says what and where.
    pub fn from_text(text: &str, file: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        Self::open(&Source::new(text, file, overrides), Files::beside(file))
    }

    /// Makes a session from its source; `files` tells where those that the scene names are.
    ///
    /// # Errors
    /// Something in the scene is wrong; says what and where.
    pub fn open(source: &Source, files: Files) -> Result<Self, SceneError> {
        let Source { file, text, overrides, hands, lengths, usual_hand } = source;
        let locate = |fault: Fault| fault.locate(file, text, overrides);
        let mut scene = read(text, overrides).map_err(locate)?;
        let as_written = *hands == Hands::Scene && *lengths == [None; 2];
        if !as_written {
            with_hands(&mut scene, *hands, *lengths);
        }
        // Before there was another, a hand was the paper's unless the scene said.
        if *usual_hand == PresetWord::Paper {
            scene.hand.iter_mut().for_each(|hand| _ = hand.preset.get_or_insert(PresetWord::Paper));
        }
        let session = match as_written {
            true => Self::build(scene, file, files, &locate),
            false => Self::build(scene, file, files, &unlocated(file)),
        };
        Ok(Self { source: Some(source.clone()), ..session? })
    }

    /// Makes a scene that was read before, and perhaps changed, ready to be stepped; `file` names
    /// it in messages and is where relative paths start.
    ///
    /// # Errors
    /// Something in the scene is wrong; says what.
    pub fn from_scene(scene: Scene, file: &Path) -> Result<Self, SceneError> {
        Self::build(scene, file, Files::beside(file), &unlocated(file))
    }

    fn build(
        scene: Scene,
        file: &Path,
        files: Files,
        locate: &dyn Fn(Fault) -> SceneError,
    ) -> Result<Self, SceneError> {
        let mut built = build(&scene, &files).map_err(locate)?;
        let world = World::new(built.world.clone())
            .map_err(|e| SceneError::World { file: file.to_path_buf(), problem: e.to_string() })?;
        let probes = Probes::new(&scene, &built, &world).map_err(locate)?;
        let hands = built.hands.iter().map(|hand| HandBodies {
            on_bone: hand.hangs_on_bone(),
            bones: drive::bones(hand),
            soft: hand.flesh().map(|soft| soft as usize),
        });
        let figures = built.figures.iter().map(|figure| HandBodies {
            on_bone: true,
            bones: figure.handle.bones.start as usize..figure.handle.bones.end as usize,
            soft: Some(figure.handle.soft as usize),
        });
        let parts = hands.chain(figures).collect();
        let tuning = Tuning::new(built.world.clone(), parts);
        let live = built.hands.iter().map(live_hand).collect();
        let led = vec![None; built.hands.len()];
        let fingertips = built.hands.iter().map(|_| OnceLock::new()).collect();
        let grips = std::mem::take(&mut built.grips);
        let stem = file.file_stem().unwrap_or(file.as_os_str());
        let mut session = Self {
            name: stem.to_string_lossy().into_owned(),
            input: world.input(),
            scene,
            world,
            built,
            probes,
            live,
            led,
            grips,
            fingertips,
            tuning,
            report: StepReport::default(),
            start_overlaps: Vec::new(),
            steps: 0,
            source: None,
            files: files.into_used(),
            witness: None,
        };
        session.start();
        session.start_overlaps = session.find_overlaps();
        Ok(session)
    }

    /// Puts bodies into their start states.
    pub(super) fn start(&mut self) {
        for (soft, start) in self.built.node_starts.iter().enumerate() {
            if let Some(nodes) = start {
                self.world.set_nodes(soft as u32, nodes);
            }
        }
        for figure in &self.built.figures {
            for (bone, pose) in figure.handle.bones.clone().zip(figure.start.iter().flatten()) {
                self.world.set_rigid_state(bone, *pose, [Vec3::zeros(); 2]);
            }
            if figure.start.is_some() {
                place_bound(&mut self.world, figure.handle.soft);
            }
        }
        drive::fill_scripts(&mut self.input, &mut self.built, &self.world, 0.0);
        drive::motors(&mut self.input, &self.built, &self.world, 0.0);
        for hand in self.built.hands.iter().filter(|hand| hand.motion.is_some()) {
            for bone in hand.handle.bones.clone() {
                if let Some(target) = self.input.targets[bone as usize] {
                    self.world.set_rigid_state(bone, target.pose_WB, [Vec3::zeros(); 2]);
                }
            }
            if let Some(soft) = hand.flesh() {
                if hand.coupling == CouplingKind::Bone {
                    self.world.set_nodes(soft, &hand.skinned(&self.world));
                }
                place_bound(&mut self.world, soft);
            }
        }
        self.grips.iter_mut().flatten().for_each(|gripping| gripping.restart());
        for (hand, live) in self.built.hands.iter().zip(&mut self.live) {
            if let Ok(live) = live {
                live.restart(&self.input.targets[drive::bones(hand)]);
            }
        }
    }
}

/// Puts the nodes that springs bind to bones where these want them.
fn place_bound(world: &mut World, soft: u32) {
    let mut nodes = world.nodes(soft).to_vec();
    world.skin_targets(soft, &mut nodes);
    world.set_nodes(soft, &nodes);
}

/// Names a fault by its key alone, where the text is not at hand or has been changed.
fn unlocated(file: &Path) -> impl Fn(Fault) -> SceneError {
    move |fault| SceneError::World {
        file: file.to_path_buf(),
        problem: format!("`{}`: {}", fault.key, fault.problem),
    }
}

/// Prepares a hand to be moved by poses.
pub(super) fn live_hand(hand: &BuiltHand) -> Result<Box<LiveHand>, LiveError> {
    match hand.driven {
        true => LiveHand::new(&hand.name, &hand.model).map(Box::new),
        false => Err(LiveError::NotDriven { hand: hand.name.clone() }),
    }
}

/// The text of a scene file.
///
/// # Errors
/// The file cannot be read, is no plain file or too large.
pub fn read_scene(path: &Path) -> Result<String, SceneError> {
    thenar_input::read_text(path, SCENE_BYTES_MAX)
        .map_err(|e| SceneError::File { file: path.to_path_buf(), problem: e.to_string() })
}

/// Reads and checks a scene's text without building anything.
pub fn read(text: &str, overrides: &[String]) -> Result<Scene, Fault> {
    let mut root = Node::parse(text)?;
    for (i, given) in overrides.iter().enumerate() {
        apply_override(&mut root, &Override::new(given), i)?;
    }
    parse::<Scene>(&root)
}
