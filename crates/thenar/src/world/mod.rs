//! The stepped world.

mod io;

pub use io::{ContactPoint, Energy, Input, Stage, StageTimer, StepReport, Target};

/*
Planned surface of `World` (in the making):

pub struct World;
impl World {
    pub fn new(desc: WorldDesc) -> Result<World, ModelError>;
    pub fn input(&self) -> Input;
    pub fn step(&mut self, input: &Input, timer: &mut impl StageTimer) -> StepReport;
    pub fn time(&self) -> f64;
    pub fn time_step(&self) -> f64;
    pub fn set_time_step(&mut self, h: f64);
    pub fn rigid_pose(&self, i: u32) -> Pose;                 // pose_WB
    pub fn rigid_velocity(&self, i: u32) -> [Vec3; 2];        // linear, angular, world
    pub fn set_rigid_state(&mut self, i: u32, pose: Pose, velocity: [Vec3; 2]);
    pub fn joint_angles(&self, j: u32) -> [f64; 2];
    pub fn joint_rates(&self, j: u32) -> [f64; 2];
    pub fn nodes(&self, soft: u32) -> &[Vec3];                // world positions
    pub fn node_velocities(&self, soft: u32) -> &[Vec3];
    pub fn node_range(&self, soft: u32) -> Range<usize>;      // into Input::node_forces
    pub fn collision_vertices(&self, soft: u32) -> &[Vec3];   // embedded, world
    pub fn skin_targets(&self, soft: u32, out: &mut [Vec3]);  // f_i of Eq. 6
    pub fn contacts(&self) -> &[ContactPoint];
    pub fn energy(&self, input: &Input) -> Energy;
    pub fn drive_wrench(&self, i: u32) -> [Vec3; 2];          // force, torque the drive put on bone i
    pub fn state_hash(&self) -> u64;
    pub fn desc(&self) -> &WorldDesc;
}
*/
