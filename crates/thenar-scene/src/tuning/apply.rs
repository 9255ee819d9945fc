//! Effects of settings on a description.

use std::ops::Range;
use thenar_core::Vec3;
use thenar_core::model::{
    Cone, FleshInStep1, Material, Motion, SolverKind, SolverSettings, Springs, WorldDesc,
};

/// Step 1 with flesh that yields.
pub const TWO_STEP: &str = "two-step";
/// Step 1 as in the paper.
pub const FROZEN: &str = "two-step, frozen flesh (paper)";
/// Joints, flesh and contact in one system.
pub const MONOLITHIC: &str = "monolithic";

/// Bodies of a hand, or of a figure, in the description.
#[derive(Clone, Debug)]
pub struct HandBodies {
    /// Springs in bone hold only what lies in the place of bone.
    pub on_bone: bool,
    /// Bones of the hand among the rigid bodies.
    pub bones: Range<usize>,
    /// Flesh of the hand among the soft bodies, if it has any.
    pub soft: Option<usize>,
}

/// Bodies of a description, by what they are in the scene.
#[derive(Clone, Debug)]
pub struct SceneBodies {
    /// Hands of the scene.
    pub hands: Vec<HandBodies>,
    /// Soft bodies that are no hands.
    pub objects: Vec<usize>,
    /// Dynamic rigid bodies that are no bones.
    pub rigids: Vec<usize>,
    /// Solver as the scene has it.
    pub solver: SolverSettings,
}

impl SceneBodies {
    /// Finds them.
    pub fn new(desc: &WorldDesc, hands: Vec<HandBodies>) -> Self {
        let is_hand = |i: &usize| hands.iter().any(|hand| hand.soft == Some(*i));
        let is_bone = |i: &usize| hands.iter().any(|hand| hand.bones.contains(i));
        let moves = |i: &usize| desc.rigids[*i].motion == Motion::Dynamic;
        Self {
            objects: (0..desc.softs.len()).filter(|i| !is_hand(i)).collect(),
            rigids: (0..desc.rigids.len()).filter(|i| !is_bone(i)).filter(moves).collect(),
            solver: desc.solver,
            hands,
        }
    }

    /// The flesh of the hands.
    pub fn flesh(&self) -> impl Iterator<Item = usize> {
        self.hands.iter().filter_map(|hand| hand.soft)
    }
}

/// Largest value of a material constant in a body.
pub fn largest(desc: &WorldDesc, soft: usize, of: fn(&Material) -> f64) -> f64 {
    desc.softs[soft].flesh.materials.iter().map(of).fold(f64::MIN_POSITIVE, f64::max)
}

/// Scales a body's moduli so that the largest is `young` \[Pa\].
pub fn set_young(desc: &mut WorldDesc, soft: usize, young: f64) {
    let factor = young / largest(desc, soft, |m| m.young);
    desc.softs[soft].flesh.materials.iter_mut().for_each(|m| m.young *= factor);
}

/// Gives all elements of a body this ratio.
pub fn set_poisson(desc: &mut WorldDesc, soft: usize, poisson: f64) {
    desc.softs[soft].flesh.materials.iter_mut().for_each(|m| m.poisson = poisson);
}

/// One coefficient for all bodies and pairs that touch.
pub fn set_friction(desc: &mut WorldDesc, friction: f64) {
    desc.rigids.iter_mut().for_each(|rigid| rigid.friction = friction);
    desc.softs.iter_mut().for_each(|soft| soft.flesh.friction = friction);
    for rule in &mut desc.pairs {
        rule.friction = rule.friction.map(|_| friction);
    }
    desc.friction_tables.clear();
}

/// Drives of all hands, stiffer by `factor`, each as well damped as before.
pub fn scale_drives(desc: &mut WorldDesc, parts: &SceneBodies, factor: f64) {
    for bone in parts.hands.iter().flat_map(|hand| hand.bones.clone()) {
        if let Some(drive) = &mut desc.drives[bone] {
            drive.stiffness *= factor;
            drive.angular_stiffness *= factor;
            drive.damping *= factor.sqrt();
            drive.angular_damping *= factor.sqrt();
        }
    }
}

/// Springs between flesh and bones of all hands, per volume \[N/m⁴\].
pub fn set_coupling(desc: &mut WorldDesc, parts: &SceneBodies, stiffness: f64) {
    for soft in parts.flesh() {
        let springs = desc.softs[soft].coupling.as_mut().map(|coupling| &mut coupling.springs);
        if let Some(Springs::PerVolume { stiffness: own, .. }) = springs
            && *own > 0.0
        {
            *own = stiffness;
        }
    }
}

/// Springs between flesh and bones of the first hand that has flesh, per volume \[N/m⁴\].
pub fn coupling(desc: &WorldDesc, parts: &SceneBodies) -> Option<f64> {
    let soft = parts.flesh().next()?;
    match desc.softs[soft].coupling.as_ref()?.springs {
        Springs::PerVolume { stiffness, .. } => Some(stiffness),
        Springs::PerNode(_) => None,
    }
}

/// Scales masses and inertias of all loose rigid bodies so that the heaviest weighs `mass` \[kg\].
pub fn set_mass(desc: &mut WorldDesc, parts: &SceneBodies, mass: f64) {
    let Some(heaviest) = heaviest(desc, parts) else { return };
    for rigid in &parts.rigids {
        let rigid = &mut desc.rigids[*rigid];
        rigid.mass *= mass / heaviest;
        rigid.inertia *= mass / heaviest;
    }
}

/// Mass of the heaviest loose rigid body \[kg\].
pub fn heaviest(desc: &WorldDesc, parts: &SceneBodies) -> Option<f64> {
    parts.rigids.iter().map(|i| desc.rigids[*i].mass).max_by(f64::total_cmp)
}

/// Gravity of this size, downwards as before.
pub fn set_gravity(desc: &mut WorldDesc, size: f64) {
    let down = desc.gravity.try_normalize(1e-9).unwrap_or(-Vec3::y());
    desc.gravity = down * size;
}

/// The word for a solver.
pub fn solver_word(solver: &SolverSettings) -> &'static str {
    match (solver.kind, solver.step1_flesh) {
        (SolverKind::TwoStep, FleshInStep1::Lumped) => TWO_STEP,
        (SolverKind::TwoStep, FleshInStep1::Frozen) => FROZEN,
        _ => MONOLITHIC,
    }
}

/// Chooses a solver by its word.
pub fn set_solver(desc: &mut WorldDesc, parts: &SceneBodies, word: &str) {
    let solver = &mut desc.solver;
    if word == solver_word(&parts.solver) {
        (solver.kind, solver.step1_flesh) = (parts.solver.kind, parts.solver.step1_flesh);
        solver.close_joints = parts.solver.close_joints;
        return;
    }
    solver.kind = match word {
        MONOLITHIC => SolverKind::Monolithic,
        _ => SolverKind::TwoStep,
    };
    solver.step1_flesh = if word == FROZEN { FleshInStep1::Frozen } else { FleshInStep1::Lumped };
    // The paper leaves the joints to the next step.
    solver.close_joints = word != FROZEN;
}

/// The word for a cone.
pub fn cone_word(cone: Cone) -> &'static str {
    match cone {
        Cone::Circular => "circular",
        Cone::Linearised => "linearised",
    }
}
