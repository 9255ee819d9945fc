//! Judgement of a run: which of its figures are to be trusted, and why.

use crate::lab::soak::{DEEP, JOINT_GAP_MAX, MISS_MAX};
use crate::words::{counted, short};
use serde_json::{Value, json};
use thenar_core::model::{SolverKind, SolverSettings};
use thenar_scene::session::{StartOverlap, Summary, TakenBack};

/// At most this share of the steps may be off by more and leave the run's mean forces right to as
/// much.
const OFTEN: f64 = 0.01;
/// Tetrahedra that are inside out for this long are no swing through a shape that they leave again
/// \[s\].
const INVERTED_TIME_MAX: f64 = 0.1;

/// Facts that a run is judged by.
#[derive(Clone, Copy, Debug)]
pub struct Evidence<'a> {
    /// Steps that were made.
    pub steps: u64,
    /// Time that a step simulates \[s\].
    pub time_step: f64,
    /// Extremes of the whole run.
    pub summary: &'a Summary,
    /// Accuracy that was asked for.
    pub settings: &'a SolverSettings,
    /// Tetrahedra of all flesh, and how many of them are inside out at the end.
    pub tets: usize,
    /// See `tets`.
    pub inverted: u32,
    /// Bodies that started inside each other, the deepest first.
    pub overlaps: &'a [StartOverlap],
}

/// Figures that can be wrong while others are right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Figures {
    /// Places of bodies, and times.
    Positions,
    /// Contact forces, slip and pressure.
    Forces,
    /// Shapes of flesh.
    Shapes,
}

impl Figures {
    fn word(self) -> &'static str {
        match self {
            Self::Positions => "positions",
            Self::Forces => "forces",
            Self::Shapes => "shapes",
        }
    }
}

/// A reason for doubt, and the figures that it is about.
type Caveat = (Figures, String);

/// Judgement of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Figures that are doubtful, each once; none where the run is to be trusted.
    doubtful: Vec<Figures>,
    /// The run has failed: nothing of it is to be trusted.
    failed: bool,
    reasons: Vec<String>,
}

impl Verdict {
    /// Judges a run.
    pub fn new(e: &Evidence) -> Self {
        let judges = [taken_back, missed, fell_back, left_out, overlapped, deep, apart, inverted];
        let doubts: Vec<Caveat> = judges.iter().filter_map(|judge| judge(e)).collect();
        let mut doubtful: Vec<Figures> = doubts.iter().map(|(figures, _)| *figures).collect();
        doubtful.sort_unstable();
        doubtful.dedup();
        let mut reasons: Vec<String> = doubts.into_iter().map(|(_, reason)| reason).collect();
        if reasons.is_empty() {
            reasons = went_well(e);
        }
        let failed = TakenBack::judge(e.summary.non_finite, e.steps).is_err();
        Self { doubtful, failed, reasons }
    }

    fn word(&self) -> &'static str {
        match (self.failed, self.doubtful.is_empty()) {
            (true, _) => "no",
            (false, true) => "yes",
            (false, false) => "doubtful",
        }
    }

    /// The judgement in one line.
    pub fn line(&self) -> String {
        let words: Vec<&str> = self.doubtful.iter().map(|figures| figures.word()).collect();
        let whole = match (self.word(), words.split_last()) {
            ("doubtful", Some((last, []))) => format!("{last} are doubtful"),
            ("doubtful", Some((last, rest))) => {
                format!("{} and {last} are doubtful", rest.join(", "))
            }
            (word, _) => word.into(),
        };
        format!("trust: {whole}: {}", self.reasons.join("; "))
    }

    /// The judgement for programs.
    pub fn json(&self) -> Value {
        let doubtful: Vec<&str> = self.doubtful.iter().map(|figures| figures.word()).collect();
        json!({ "verdict": self.word(), "doubtful": doubtful, "reasons": self.reasons })
    }
}

/// Good things to say of a run that nothing is said against.
fn went_well(e: &Evidence) -> Vec<String> {
    let steps = counted(e.steps, "step");
    let shapes = (e.summary.inverted_tets_max > 0)
        .then(|| format!("{}, too short to matter", inverted_before(e)));
    if e.summary.contacts_max == 0 {
        let went = format!("nothing touched in {steps}, and none of them went wrong");
        return [went].into_iter().chain(shapes).collect();
    }
    let contact = match e.summary.contact_unconverged {
        0 => format!("contact met its accuracy in all {steps}"),
        _ => format!("{}, too little to matter", misses(e)),
    };
    // Rounded up, so that it is so.
    let microns = (e.summary.penetration_max * 1e6).ceil();
    let depth = match microns > 0.0 {
        true => format!("nothing was deeper than {:.3} mm", microns * 1e-3),
        false => "nothing was inside anything else".into(),
    };
    [contact, depth].into_iter().chain(shapes).collect()
}

/// Steps that were taken back let no time pass: everything is late by that.
fn taken_back(e: &Evidence) -> Option<Caveat> {
    let count = e.summary.non_finite;
    let verb = if count == 1 { "was" } else { "were" };
    (count > 0).then(|| {
        let of = of_steps(count, e);
        (Figures::Positions, format!("{of} gave numbers that are not finite and {verb} taken back"))
    })
}

/// Steps that missed the accuracy of contact, and by how much at most.
fn misses(e: &Evidence) -> String {
    let (settings, worst) = (e.settings, e.summary.contact_residual_max);
    let of = of_steps(e.summary.contact_unconverged, e);
    match settings.kind {
        SolverKind::Monolithic => format!(
            "contact missed its accuracy of {} mm/s in {of} (worst {} mm/s)",
            short(settings.velocity_tolerance * 1e3),
            short(worst * 1e3)
        ),
        _ => format!(
            "contact missed its relative accuracy of {} % in {of} (worst {} %)",
            short(settings.contact_tolerance * 100.0),
            short(worst * 100.0)
        ),
    }
}

/// Misses matter where they are more than a soak allows. The other solvers measure a part of the
/// change, not a speed: there small numbers mean nothing.
fn missed(e: &Evidence) -> Option<Caveat> {
    let s = e.summary;
    let is_small = e.settings.kind == SolverKind::Monolithic && s.contact_residual_max <= MISS_MAX;
    if s.contact_unconverged == 0 || is_small {
        return None;
    }
    let advice = if s.contact_cut_short > 0 {
        format!(
            "contact_work_max cut it short in {}, and the error of these is estimated, mostly too high",
            counted(s.contact_cut_short, "step")
        )
    } else if s.contact_unconverged as f64 <= OFTEN * e.steps as f64 {
        "the other steps are as accurate as asked".into()
    } else {
        "a shorter time_step helps, or a larger contact_sweeps_max".into()
    };
    Some((Figures::Forces, format!("{}: {advice}", misses(e))))
}

fn fell_back(e: &Evidence) -> Option<Caveat> {
    let count = e.summary.fell_back;
    let verb = if count == 1 { "was" } else { "were" };
    (count > 0).then(|| {
        let of = of_steps(count, e);
        (Figures::Forces, format!("{of} did not converge and {verb} made safely instead"))
    })
}

fn left_out(e: &Evidence) -> Option<Caveat> {
    let most = e.summary.contacts_dropped_max;
    (most > 0).then(|| {
        let crowd =
            "or pairs of bodies in a crowd, of a step were left out: too many are in one place";
        (Figures::Forces, format!("up to {}, {crowd}", counted(most, "contact")))
    })
}

/// Bodies that start in each other are pushed apart by what no scene asks for.
fn overlapped(e: &Evidence) -> Option<Caveat> {
    let deep: Vec<_> = e.overlaps.iter().filter(|overlap| overlap.depth >= DEEP).collect();
    let (deepest, rest) = deep.split_first()?;
    let [a, b] = &deepest.bodies;
    let more = match rest.len() {
        0 => String::new(),
        count => format!(", and so did {}", counted(count as u64, "more pair")),
    };
    let depth = deepest.depth * 1e3;
    Some((Figures::Forces, format!("{a} and {b} started {depth:.3} mm inside each other{more}")))
}

fn deep(e: &Evidence) -> Option<Caveat> {
    let depth = e.summary.penetration_max;
    (depth >= DEEP).then(|| {
        let depth = depth * 1e3;
        (Figures::Forces, format!("bodies were up to {depth:.3} mm inside each other after a step"))
    })
}

fn apart(e: &Evidence) -> Option<Caveat> {
    let gap = e.summary.joint_gap_max;
    (gap >= JOINT_GAP_MAX).then(|| {
        (Figures::Positions, format!("joints came apart by up to {} mm", short(gap * 1e3)))
    })
}

/// Flesh that stays inside out, in the end or for long before.
fn inverted(e: &Evidence) -> Option<Caveat> {
    // Steps that last as long as the limit, but for rounding, reach it.
    let long = inverted_time(e) >= INVERTED_TIME_MAX * (1.0 - 1e-9);
    let verb = if e.inverted == 1 { "is" } else { "are" };
    let reason = match (long, e.inverted) {
        (false, 0) => return None,
        (false, now) => format!("{now} of {} tetrahedra {verb} inside out at the end", e.tets),
        (true, 0) => inverted_before(e),
        (true, now) => format!("{}, and {now} {verb} so at the end", inverted_before(e)),
    };
    Some((Figures::Shapes, reason))
}

/// Most tetrahedra that were inside out at once, and the longest time that some were.
fn inverted_before(e: &Evidence) -> String {
    let (most, time) = (e.summary.inverted_tets_max, inverted_time(e));
    let verb = if most == 1 { "was" } else { "were" };
    format!("up to {most} of {} tetrahedra {verb} inside out, for up to {time:.3} s", e.tets)
}

/// Longest time without a break that some tetrahedron was inside out \[s\].
fn inverted_time(e: &Evidence) -> f64 {
    e.summary.inverted_longest as f64 * e.time_step
}

fn of_steps(count: u64, e: &Evidence) -> String {
    format!("{count} of {}", counted(e.steps, "step"))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run in which contact is asked for to 0.01 mm/s.
    fn of(
        summary: &Summary,
        kind: SolverKind,
        overlaps: &[StartOverlap],
        inverted: u32,
    ) -> Verdict {
        let settings = SolverSettings {
            kind,
            velocity_tolerance: 1e-5,
            contact_tolerance: 1e-4,
            ..SolverSettings::default()
        };
        let (settings, steps, time_step, tets) = (&settings, 1000, 0.01, 600);
        Verdict::new(&Evidence { steps, time_step, summary, settings, tets, inverted, overlaps })
    }

    fn line(summary: Summary) -> String {
        of(&summary, SolverKind::Monolithic, &[], 0).line()
    }

    fn touching() -> Summary {
        Summary { contacts_max: 4, ..Summary::default() }
    }

    fn missing(contact_unconverged: u64, contact_residual_max: f64) -> Summary {
        Summary { contact_unconverged, contact_residual_max, ..touching() }
    }

    fn overlap(depth: f64) -> StartOverlap {
        let bodies = ["ball".into(), "table".into()];
        StartOverlap { bodies, depth, place_W: thenar_core::Vec3::zeros() }
    }

    #[test]
    fn a_clean_run_is_trusted() {
        let summary = Summary { penetration_max: 1.832e-4, joint_gap_max: 4e-5, ..touching() };
        let verdict = of(&summary, SolverKind::Monolithic, &[], 0);
        assert_eq!(
            verdict.line(),
            "trust: yes: contact met its accuracy in all 1000 steps; nothing was deeper than 0.184 mm"
        );
        assert_eq!(verdict.json()["verdict"], "yes");
        assert_eq!(verdict.json()["doubtful"], json!([]));
        assert_eq!(
            line(Summary::default()),
            "trust: yes: nothing touched in 1000 steps, and none of them went wrong"
        );
    }

    /// Below 1 mm/s an error moves nothing by what anyone sees, however many steps have it.
    #[test]
    fn small_misses_do_not_matter() {
        assert_eq!(
            line(missing(700, 4e-5)),
            "trust: yes: contact missed its accuracy of 0.01 mm/s in 700 of 1000 steps (worst 0.04 mm/s), \
             too little to matter; nothing was inside anything else"
        );
        assert!(line(missing(1000, MISS_MAX)).starts_with("trust: yes: "));
    }

    #[test]
    fn few_large_misses_spoil_only_themselves() {
        assert_eq!(
            line(missing(10, 0.02)),
            "trust: forces are doubtful: contact missed its accuracy of 0.01 mm/s in 10 of 1000 steps (worst \
             20 mm/s): the other steps are as accurate as asked"
        );
    }

    /// The paper's solver measures a part of the change, not a speed: small numbers mean nothing
    /// there.
    #[test]
    fn many_large_misses_are_met_with_advice() {
        let advice = ": a shorter time_step helps, or a larger contact_sweeps_max";
        let begin = "trust: forces are doubtful: contact missed its";
        assert_eq!(
            line(missing(11, 2e-3)),
            format!("{begin} accuracy of 0.01 mm/s in 11 of 1000 steps (worst 2 mm/s){advice}")
        );
        assert_eq!(
            of(&missing(11, 5e-4), SolverKind::TwoStep, &[], 0).line(),
            format!(
                "{begin} relative accuracy of 0.01 % in 11 of 1000 steps (worst 0.05 %){advice}"
            )
        );
        let cut = Summary { contact_cut_short: 1, ..missing(11, 2e-3) };
        assert!(line(cut.clone()).contains("contact_work_max cut it short in 1 step, "));
        // What met its accuracy all the same is as good as asked.
        let met = Summary { contact_unconverged: 0, contact_residual_max: 0.0, ..cut };
        assert!(line(met).starts_with("trust: yes: contact met its accuracy"));
    }

    #[test]
    fn each_reason_is_named_and_nothing_else() {
        let (begin, with) = ("trust: forces are doubtful: ", touching);
        for (summary, expected) in [
            (
                Summary { fell_back: 1, ..with() },
                "1 of 1000 steps did not converge and was made safely instead",
            ),
            (
                Summary { contacts_dropped_max: 12, ..with() },
                "up to 12 contacts, or pairs of bodies in a crowd, of a step were left out: too many are in one place",
            ),
            (
                Summary { penetration_max: 1.25e-3, ..with() },
                "bodies were up to 1.250 mm inside each other after a step",
            ),
        ] {
            assert_eq!(line(summary), format!("{begin}{expected}"));
        }
        assert_eq!(
            line(Summary { joint_gap_max: 1.2e-4, ..with() }),
            "trust: positions are doubtful: joints came apart by up to 0.12 mm"
        );
        assert_eq!(
            of(&with(), SolverKind::Monolithic, &[], 3).line(),
            "trust: shapes are doubtful: 3 of 600 tetrahedra are inside out at the end"
        );
    }

    /// In steps of 10 ms, nine are 0.09 s and ten the limit of 0.1 s.
    #[test]
    fn flesh_that_was_inside_out_for_long_is_doubted_whatever_the_end() {
        let with = |inverted_longest, inverted_tets_max, end| {
            let summary = Summary { inverted_longest, inverted_tets_max, ..touching() };
            of(&summary, SolverKind::Monolithic, &[], end).line()
        };
        let short = with(9, 7, 0);
        let said =
            "; up to 7 of 600 tetrahedra were inside out, for up to 0.090 s, too short to matter";
        assert!(short.starts_with("trust: yes: ") && short.ends_with(said), "{short}");
        let begin = "trust: shapes are doubtful: up to";
        let long = format!("{begin} 7 of 600 tetrahedra were inside out, for up to 0.100 s");
        assert_eq!(with(10, 7, 0), long);
        assert_eq!(with(10, 7, 3), format!("{long}, and 3 are so at the end"));
        assert_eq!(
            with(250, 1, 0),
            format!("{begin} 1 of 600 tetrahedra was inside out, for up to 2.500 s")
        );
        assert_eq!(
            with(2, 7, 1),
            "trust: shapes are doubtful: 1 of 600 tetrahedra is inside out at the end"
        );
        let alone = Summary { inverted_longest: 1, inverted_tets_max: 2, ..Summary::default() };
        let said =
            "up to 2 of 600 tetrahedra were inside out, for up to 0.010 s, too short to matter";
        assert_eq!(line(alone), format!("{}; {said}", line(Summary::default())));
    }

    /// The limits are those of a soak: what reaches 1 mm counts, and what stays below does not.
    #[test]
    fn overlaps_at_the_start_count_from_a_millimetre() {
        let with = |depths: &[f64]| {
            let overlaps: Vec<_> = depths.iter().map(|depth| overlap(*depth)).collect();
            of(&touching(), SolverKind::Monolithic, &overlaps, 0).line()
        };
        let begin = "trust: forces are doubtful: ball and table started 9.900 mm inside each other";
        assert_eq!(with(&[9.9e-3]), begin);
        assert_eq!(with(&[9.9e-3, 2e-3, 5e-4]), format!("{begin}, and so did 1 more pair"));
        assert!(with(&[0.99e-3]).starts_with("trust: yes: "));
        assert!(with(&[1e-3]).starts_with("trust: forces "));
    }

    /// One in a hundred is what a run that succeeds may take back.
    #[test]
    fn steps_taken_back_are_doubted_and_many_fail_the_run() {
        let taken = |non_finite| Summary { non_finite, ..touching() };
        assert_eq!(
            line(taken(10)),
            "trust: positions are doubtful: 10 of 1000 steps gave numbers that are not finite and were taken back"
        );
        let failed = of(&taken(11), SolverKind::Monolithic, &[], 0);
        assert_eq!(
            failed.line(),
            "trust: no: 11 of 1000 steps gave numbers that are not finite and were taken back"
        );
        assert_eq!(failed.json()["verdict"], "no");
    }

    #[test]
    fn several_reasons_stand_in_one_line() {
        let summary = Summary { joint_gap_max: 1e-3, non_finite: 1, ..missing(11, 2e-3) };
        let verdict = of(&summary, SolverKind::Monolithic, &[overlap(2e-3)], 1);
        let begin = "trust: positions, forces and shapes are doubtful: 1 of 1000 steps gave ";
        assert!(verdict.line().starts_with(begin), "{}", verdict.line());
        let json = verdict.json();
        assert_eq!(json["verdict"], "doubtful");
        assert_eq!(json["doubtful"], json!(["positions", "forces", "shapes"]));
        assert_eq!(json["reasons"].as_array().unwrap().len(), 5);
        assert!(verdict.line().ends_with("1 of 600 tetrahedra is inside out at the end"));
    }
}
