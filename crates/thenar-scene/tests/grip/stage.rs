//! A hand above a thing on a peg, as a scene: it grips, lifts by 100 mm, and holds.

use std::path::Path;
use thenar_core::Vec3;
use thenar_scene::grip::{GripHand, GripKind, pads_middle_at};
use thenar_scene::session::Session;

/// What is gripped, and how.
#[derive(Clone, Debug)]
pub struct Stage {
    /// Of the hand.
    pub preset: &'static str,
    /// Of the hand.
    pub side: &'static str,
    /// Kind of grip.
    pub kind: GripKind,
    /// Tables `[[rigid]]` or `[[soft]]` of the object, named "thing", without position.
    pub object: String,
    /// Its width between the pads [m], and its height over the peg's top [m].
    pub size: [f64; 2],
    /// What is asked [N].
    pub force: f64,
    /// Time step [s].
    pub h: f64,
    /// Friction of skin and thing.
    pub friction: f64,
    /// How much lower the thing is than the middle of the pads [m].
    pub drop: f64,
    /// The end of the hold [s].
    pub until: f64,
    /// Keys of the grip.
    pub more: String,
}

impl Stage {
    pub fn ball(preset: &'static str, kind: GripKind, force: f64, h: f64) -> Self {
        Self {
            preset,
            side: "right",
            kind,
            object: "[[rigid]]\nshape = { kind = \"sphere\", radius = 0.02 }\nmass = 0.05".into(),
            size: [0.04, 0.04],
            force,
            h,
            friction: 0.8,
            drop: 0.0,
            until: 4.5,
            more: String::new(),
        }
    }

    /// A ball of 80 mm and 150 g in a power grip, held above its middle.
    pub fn large_ball(preset: &'static str, force: f64, h: f64) -> Self {
        Self {
            object: "[[rigid]]\nshape = { kind = \"sphere\", radius = 0.04 }\nmass = 0.15".into(),
            size: [0.08, 0.08],
            drop: 0.02,
            ..Self::ball(preset, GripKind::Power, force, h)
        }
    }

    fn hand(&self, model: &str) -> String {
        format!(
            "[[hand]]\nname = \"hand\"\npreset = \"{}\"\nmodel = '{model}'\nfriction = {}\n",
            self.preset, self.friction
        )
    }

    /// Middle of the pads where the wrist is at the origin, fingers along -z, back up [m].
    pub fn middle(&self) -> Vec3 {
        let key = "[hand.motion]\nkind = \"keyframes\"\n[[hand.motion.key]]\ntime = 0\npose = \"rest\"\n\
                   wrist = { position = [0, 0, 0], fingers = [0, 0, -1], back = [0, 1, 0] }\n";
        let text = format!("version = 1\n{}{key}", self.hand(self.side));
        let session = open(&text);
        let hand = &session.hands()[0];
        let bodies = session.world().desc().rigids.len();
        let mut gripping = GripHand::new(hand, bodies).expect("a hand that grips");
        gripping.learn(hand, self.kind).expect("a kind");
        let palm = session.world().rigid_pose(hand.handle.bones.start);
        pads_middle_at(&palm, gripping.opposition(self.kind).expect("learnt"), self.size[0])
    }

    /// The scene's text: sets out at 0.1 s, lifts from 2 to 2.8 s, holds from then on.
    pub fn text(&self) -> String {
        self.text_with(&self.grip(), self.side, -self.middle())
    }

    /// The same with nothing to grip it.
    pub fn text_without_grip(&self) -> String {
        self.text_with("", self.side, -self.middle())
    }

    /// The mirror image in the plane x = 0, for a thing that is its own, with the hand of a file.
    pub fn text_mirrored(&self, model: &Path) -> String {
        let at = -self.middle();
        self.text_with(&self.grip(), &model.to_string_lossy(), Vec3::new(-at.x, at.y, at.z))
    }

    fn grip(&self) -> String {
        format!(
            "[[hand.grip]]\nobject = \"thing\"\nkind = \"{}\"\nforce = {}\nat = 0.1\n{}\n",
            self.kind.name(),
            self.force,
            self.more
        )
    }

    /// The scene's text with a grip, a hand, and where its wrist begins [m].
    fn text_with(&self, grip: &str, model: &str, at: Vec3) -> String {
        let low = -0.5 * self.size[1];
        let key = |(t, y): (f64, f64)| {
            let [x, y, z] = [at.x, at.y + self.drop + y, at.z];
            format!(
                "[[hand.motion.key]]\ntime = {t}\npose = \"rest\"\n\
                 wrist = {{ position = [{x}, {y}, {z}], fingers = [0, 0, -1], back = [0, 1, 0] }}\n"
            )
        };
        let keys = [(0.0, 0.0), (2.0, 0.0), (2.8, 0.1), (self.until, 0.1)].map(key).concat();
        let Self { h, object, friction, until, .. } = self;
        let peg = low - 0.01;
        let hand = self.hand(model);
        format!(
            "version = 1\ntime_step = {h}\nduration = {until}\n\
             [[rigid]]\nname = \"peg\"\nshape = {{ kind = \"box\", size = [0.012, 0.02, 0.012] }}\n\
             motion = \"fixed\"\nposition = [0, {peg}, 0]\nfriction = 0.8\n\
             {object}\nname = \"thing\"\nfriction = {friction}\n\
             {hand}{grip}[hand.motion]\nkind = \"keyframes\"\n{keys}"
        )
    }

    pub fn session(&self) -> Session {
        open(&self.text())
    }
}

pub fn open(text: &str) -> Session {
    Session::from_text(text, Path::new("grip.toml"), &[]).unwrap_or_else(|e| panic!("{e}\n{text}"))
}

/// The end of a grip.
#[derive(Debug)]
pub struct Held {
    /// Force at the end, and the most there was [N].
    pub force: f64,
    pub most: f64,
    /// How far the thing went up [m].
    pub lift: f64,
    /// How far it goes in the hand in the last second, in which that holds still [m]: twice what is
    /// between its mean places in both halves of it, since things swing about the line between
    /// pads.
    pub slip: f64,
    /// Farthest from its mean place in that second [m].
    pub swing: f64,
    pub trouble: Option<String>,
}

pub fn middle(session: &Session) -> Vec3 {
    let desc = session.world().desc();
    match desc.rigids.iter().position(|rigid| rigid.name == "thing") {
        Some(i) => session.world().rigid_pose(i as u32).position,
        None => {
            let soft = desc.softs.iter().position(|soft| soft.name == "thing").expect("a thing");
            let nodes = session.world().nodes(soft as u32);
            nodes.iter().sum::<Vec3>() / nodes.len() as f64
        }
    }
}

pub fn hold(session: &mut Session) -> Held {
    let start = middle(session);
    let end = session.steps_wanted() as f64 * session.world().time_step();
    let (mut most, mut still) = (0.0f64, Vec::new());
    for _ in 0..session.steps_wanted() {
        assert!(!session.step(&mut ()).non_finite);
        most = most.max(session.grip_state(0).map_or(0.0, |state| state.force));
        if session.world().time() > end - 1.0 {
            still.push(session.hand_wrist(0).inverse_point(&middle(session)));
        }
    }
    let mean = |at: &[Vec3]| at.iter().sum::<Vec3>() / at.len() as f64;
    let [before, after] = [&still[..still.len() / 2], &still[still.len() / 2..]].map(mean);
    let all = mean(&still);
    Held {
        force: session.grip_state(0).map_or(0.0, |state| state.force),
        most,
        lift: middle(session).y - start.y,
        slip: 2.0 * (after - before).norm(),
        swing: still.iter().map(|at| (at - all).norm()).fold(0.0, f64::max),
        trouble: session.grip_trouble(0),
    }
}
