//! Old spellings of words that scenes, settings and recordings may still have.

use std::path::Path;
use thenar_core::model::SolverKind;
use thenar_scene::session::Session;
use thenar_scene::tuning::SettingValue;

/// A ball above a plane, by the paper's solver or another.
fn ball(solver: &str) -> String {
    format!(
        "version = 1\ntime_step = 0.005\n[solver]\nkind = \"{solver}\"\n\
         [[rigid]]\nname = \"ball\"\nposition = [0, 1, 0]\n\
         mass = 0.1\nshape = {{ kind = \"sphere\", radius = 0.05 }}\n"
    )
}

fn kind(session: &Session) -> SolverKind {
    session.world().desc().solver.kind
}

#[test]
fn scenes_and_overrides_may_call_the_monolithic_solver_exact() {
    let open = |solver: &str, overrides: &[String]| {
        Session::from_text(&ball(solver), Path::new("ball.toml"), overrides)
            .unwrap_or_else(|e| panic!("{e}"))
    };
    assert_eq!(kind(&open("exact", &[])), SolverKind::Monolithic);
    assert_eq!(kind(&open("monolithic", &[])), SolverKind::Monolithic);
    let overridden = open("two-step", &["solver.kind=exact".into()]);
    assert_eq!(kind(&overridden), SolverKind::Monolithic);
}

#[test]
fn settings_may_call_the_monolithic_solver_exact_and_say_its_present_name() {
    let mut session = Session::from_text(&ball("two-step"), Path::new("ball.toml"), &[])
        .unwrap_or_else(|e| panic!("{e}"));
    session.set("solver", &SettingValue::Choice("exact".into())).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(kind(&session), SolverKind::Monolithic);
    let of_solver = session.settings().into_iter().find(|s| s.key == "solver");
    let value = of_solver.map(|setting| setting.value);
    assert_eq!(value, Some(SettingValue::Choice("monolithic".into())));
    // The word is old for this setting alone.
    let error = session.set("cone", &SettingValue::Choice("exact".into())).unwrap_err();
    let offered = "`cone`: expected one of \"circular\", \"linearised\", got \"exact\"";
    assert_eq!(error.to_string(), offered);
    let error = session.set("solver", &SettingValue::Choice("precise".into())).unwrap_err();
    assert!(!error.to_string().contains("exact"), "{error}");
}
