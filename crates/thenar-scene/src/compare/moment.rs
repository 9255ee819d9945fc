//! Results of two solvers at one moment.

use super::bodies::poses_apart;
use super::{Bodies, Deviation, MONOLITHIC, TWO_STEP};
use crate::session::{HandLoad, Session};

/// Both solvers at one moment, and how far they are apart.
#[derive(Clone, Debug, Default)]
pub struct Moment {
    /// Simulated time \[s\].
    pub time: f64,
    /// Bones: distance \[m\]. This and the next are `None` where a side has diverged, or there is
    /// nothing to compare.
    pub position: Option<Deviation>,
    /// Bones: angle \[rad\].
    pub rotation: Option<Deviation>,
    /// Force that the drives put on bones \[N\], as a difference of vectors.
    pub drive_force: Option<Deviation>,
    /// Objects: distance \[m\] and angle \[rad\].
    pub objects: Vec<Option<[f64; 2]>>,
    /// Each side; `None` where it has diverged.
    pub sides: [Option<SideMoment>; 2],
}

/// One solver at one moment.
#[derive(Clone, Debug, Default)]
pub struct SideMoment {
    /// Largest distance between the two sides of a joint \[m\].
    pub joint_gap: f64,
    /// Largest misalignment of a joint's axes \[rad\].
    pub joint_misalignment: f64,
    /// Deepest penetration \[m\].
    pub penetration: f64,
    /// Contacts that carry force.
    pub contacts: u32,
    /// Total energy \[J\].
    pub energy: f64,
    /// Loads on palm and fingers of each hand.
    pub loads: Vec<[HandLoad; 6]>,
}

impl SideMoment {
    fn of(session: &Session, bodies: &Bodies) -> Self {
        let report = session.report();
        Self {
            joint_gap: report.joint_gap_max,
            joint_misalignment: report.joint_misalignment_max,
            penetration: report.penetration_max,
            contacts: report.contacts_active,
            energy: session.world().energy(session.input()).total(),
            loads: bodies.hands.iter().map(|&hand| session.hand_loads(hand)).collect(),
        }
    }
}

impl Moment {
    /// Measures; `usable` says which side has a state worth it.
    pub fn of(sessions: &[Session; 2], bodies: &Bodies, usable: [bool; 2]) -> Self {
        let side = |s: usize| usable[s].then(|| SideMoment::of(&sessions[s], bodies));
        let survivor = if usable[MONOLITHIC] { MONOLITHIC } else { TWO_STEP };
        let mut moment = Self {
            time: sessions[survivor].world().time(),
            objects: vec![None; bodies.objects.len()],
            sides: [side(TWO_STEP), side(MONOLITHIC)],
            ..Self::default()
        };
        if usable != [true; 2] {
            return moment;
        }
        let [a, b] = sessions.each_ref().map(Session::world);
        let bone = |&i: &u32| poses_apart(&a.rigid_pose(i), &b.rigid_pose(i));
        moment.position = Deviation::over(bodies.bones.iter().map(|i| bone(i)[0]));
        moment.rotation = Deviation::over(bodies.bones.iter().map(|i| bone(i)[1]));
        moment.drive_force = Deviation::over(bodies.driven.iter().map(|&i| {
            let force = |session: &Session| session.world().drive_wrench(i, session.input())[0];
            (force(&sessions[TWO_STEP]) - force(&sessions[MONOLITHIC])).norm()
        }));
        for (apart, object) in moment.objects.iter_mut().zip(&bodies.objects) {
            *apart = Some(object.apart(a, b));
        }
        moment
    }
}
