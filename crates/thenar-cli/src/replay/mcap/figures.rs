//! Numbers of a session, to be plotted.

use super::numbers::Numbers;
use thenar_record::ChannelInfo;
use thenar_scene::session::{HandLoad, PARTS, Session};

/// Numbers on the timing of steps.
pub fn timing_numbers() -> Numbers {
    let fields = [
        // Steps of the replay so far.
        ("step", "1"),
        ("simulated", "s"),
        // What the step took when it was recorded.
        ("cost", "s"),
        // Time since the step before, in the recording.
        ("period", "s"),
    ];
    Numbers::new("Timing", fields)
}

/// Values of [`timing_numbers`].
pub fn timing(session: &Session, cost: Option<f64>, period: Option<f64>) -> [f64; 4] {
    let known = |x: Option<f64>| x.unwrap_or(f64::NAN);
    [session.steps() as f64, session.world().time(), known(cost), known(period)]
}

/// Numbers that steps report.
pub fn step_numbers() -> Numbers {
    let fields = [
        ("contacts", "1"),
        ("contacts_active", "1"),
        ("penetration", "m"),
        ("joint_gap", "m"),
        ("contact_residual", "m/s"),
        ("iterations", "1"),
        ("kinetic", "J"),
        ("potential", "J"),
        ("elastic", "J"),
        ("energy", "J"),
    ];
    Numbers::new("Step", fields)
}

/// Values of [`step_numbers`].
pub fn step(session: &Session) -> [f64; 10] {
    let report = session.report();
    let energy = session.world().energy(session.input());
    [
        report.contacts as f64,
        report.contacts_active as f64,
        report.penetration_max,
        report.joint_gap_max,
        report.contact_residual,
        f64::from(report.cg_iterations),
        energy.kinetic,
        energy.gravity,
        energy.elastic,
        energy.total(),
    ]
}

/// Numbers on the forces on each part of each hand: `right_index_normal`.
pub fn force_numbers(session: &Session) -> Numbers {
    let of = |hand: &str| {
        let part = |name: &str| {
            HandLoad::FIGURES.map(|(figure, unit)| (format!("{hand}_{name}_{figure}"), unit))
        };
        PARTS.iter().flat_map(|digit| part(digit.name())).collect::<Vec<_>>()
    };
    Numbers::new("Force", session.hands().iter().flat_map(|hand| of(&hand.name)))
}

/// Values of [`force_numbers`].
pub fn force(session: &Session) -> impl Iterator<Item = f64> {
    let hands = 0..session.hands().len();
    hands.flat_map(|k| session.hand_loads(k)).flat_map(|load| load.figures())
}

/// The scene's probes.
pub fn probe_numbers(session: &Session) -> Numbers {
    let columns = session.columns().iter();
    Numbers::new("Probes", columns.map(|c| (c.name.clone(), c.unit.to_string())))
}

/// The records of a channel.
pub fn channel_numbers(info: &ChannelInfo) -> Numbers {
    let fields = info.fields.iter().map(|field| (field.name.clone(), field.unit.clone()));
    Numbers::new(&format!("channel_{}", info.name), fields)
}
