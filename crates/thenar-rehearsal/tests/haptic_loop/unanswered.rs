//! Goal: a step whose matrix cannot be factored, so that its frame has no response, lets nobody
//! feel the hand's own flesh. Method: the default hand in the default mode, whose simulation does
//! not answer for a while.

use crate::rig::{MS, Rig, session};
use std::f64::consts::FRAC_PI_2;
use std::ops::Range;
use thenar_core::World;
use thenar_core::world::{Input, State, Target};
use thenar_link::Rendering;
use thenar_link::haptic_loop::{LoopMode, Settings, SimulatedHand, Simulation};
use thenar_scene::session::Session;
use thenar_touch::BoneFrame;
use thenar_track::live::{LiveError, LiveHand};

const HAND: &str = "version = 1\ntime_step = 0.016\n[[hand]]\nname = \"hand\"\nmodel = \"right\"\n";
const LOAD: &str = "[[load]]\nkind = \"force\"\nbody = \"hand/index-distal\"\nforce = [0, -1, 0]\npoint = [0, 0, 0]\n";
/// Time between frames \[ms\].
const FRAME: u64 = 16;

/// A session whose steps may have no response.
struct Moody {
    session: Session,
    answers: bool,
}

impl Simulation for Moody {
    fn world(&self) -> &World {
        self.session.world()
    }

    fn steps(&self) -> u64 {
        self.session.steps()
    }

    fn input(&self) -> &Input {
        self.session.input()
    }

    fn hand(&self, index: usize) -> Option<SimulatedHand<'_>> {
        Simulation::hand(&self.session, index)
    }

    fn live_hand(&self, index: usize) -> Result<LiveHand, LiveError> {
        self.session.live_hand(index)
    }

    fn resume(&mut self, state: &State) -> bool {
        self.session.resume(state)
    }

    fn lead(
        &mut self,
        index: usize,
        targets: impl ExactSizeIterator<Item = Target> + Clone,
    ) -> bool {
        self.session.lead(index, targets)
    }

    fn let_go(&mut self, index: usize) {
        self.session.let_go(index);
    }

    fn condense(&mut self, bones: Range<u32>, to: &mut BoneFrame) -> bool {
        if self.answers {
            return Simulation::condense(&mut self.session, bones, to);
        }
        to.response.clear();
        false
    }
}

/// The force of all couplings in each millisecond \[N\]: the finger bends, and after 1.2 s frames
/// have no response in these milliseconds from then.
fn felt(scene: &str, unanswered: Range<u64>, ms: u64) -> Vec<f64> {
    let settings = Settings { mode: LoopMode::Shared, grip: None, ..Settings::default() };
    let mut rig = Rig::of(scene, &settings, Rendering::Tendons);
    let mut moody = Moody { session: session(scene), answers: true };
    rig.port.attach(&moody).expect("a hand");
    let mut all = Vec::new();
    for k in 0..1200 + ms {
        if k % FRAME == 0 {
            moody.answers = k < 1200 || !unanswered.contains(&(k - 1200));
            rig.port.before_step(&mut moody, rig.now_ns).expect("hands as before");
            moody.session.step(&mut ());
            rig.port.after_step(&mut moody, rig.now_ns);
        }
        let pose = rig.pose(FRAC_PI_2 * (1e-3 * k as f64).min(1.0));
        rig.wearer.say(rig.now_ns, Some(pose));
        rig.now_ns += MS;
        rig.wearer.alive(rig.now_ns);
        assert!(rig.clock.tick(rig.now_ns));
        if k >= 1200 {
            let couplings = |core: &mut thenar_link::haptic_loop::Core| {
                let wrenches = core.hands()[0].touch().device_wrenches().to_vec();
                wrenches.iter().map(|[force, _]| *force).sum::<thenar_core::Vec3>().norm()
            };
            all.push(rig.clock.core(couplings));
        }
    }
    all
}

/// A bent finger in empty air: for one frame, for twelve, and from then on.
#[test]
fn without_a_response_the_flesh_is_not_felt() {
    for unanswered in [0..FRAME, 0..200, 0..600] {
        let most = felt(HAND, unanswered.clone(), 600).into_iter().fold(0.0, f64::max);
        println!("{unanswered:?} ms: {most} N");
        assert!(most < 0.02, "{unanswered:?} ms without a response: {most} N");
    }
}

/// A weight of 1 N stays for a frame without a response, and is back after many; meanwhile it fades
/// within 0.1 s.
#[test]
fn what_was_felt_is_kept_for_a_frame_and_then_fades() {
    let loaded = format!("{HAND}{LOAD}");
    let once = felt(&loaded, 0..FRAME, 300);
    assert!(once.iter().all(|force| (force - 1.0).abs() < 0.05), "{once:?}");
    let long = felt(&loaded, 0..304, 700);
    println!("{:?}", long.iter().step_by(20).collect::<Vec<_>>());
    assert!(long[..45].iter().all(|force| (force - 1.0).abs() < 0.05));
    assert!(long[45..125].windows(2).all(|pair| pair[1] < pair[0] + 0.005), "{:?}", &long[45..125]);
    assert!(long[130..300].iter().all(|force| *force < 0.02), "{:?}", &long[130..300]);
    assert!(long[450..].iter().all(|force| (force - 1.0).abs() < 0.05), "{:?}", &long[450..]);
    assert!(long.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.06), "{long:?}");
}
