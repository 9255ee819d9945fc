//! Goal: what is kept is what was measured, where it belongs. Method: addresses and numbers.

use super::*;
use clap::Parser;

#[derive(clap::Parser)]
struct Line {
    #[command(flatten)]
    args: Args,
}

fn args(line: &[&str]) -> Args {
    Line::parse_from([&["latency"], line].concat()).args
}

#[test]
fn the_profile_is_the_addresss_own() {
    let file = |line: &[&str]| {
        let args = args(line);
        let (driver, rest) = args.address.split_once(':').unwrap();
        profile_of(&args, driver, rest)
    };
    assert_eq!(file(&["hts:9000?profile=a.toml"]), Some("a.toml".into()));
    assert_eq!(file(&["hts:9000?profile=a.toml", "--output", "b.toml"]), Some("b.toml".into()));
    let paired = ["cyberglove:/dev/x?side=left&profile=a.toml&wrist=hts:9000?profile=b.toml"];
    assert_eq!(file(&paired), Some("a.toml".into()));
    assert_ne!(file(&["cyberglove:/dev/x?wrist=hts:9000?profile=b.toml"]), Some("b.toml".into()));
    // Nothing is stated of these.
    assert_eq!(file(&["poses:9010"]), None);
    assert_eq!(file(&["replay:a.jsonl"]), None);
}

#[test]
fn numbers_are_kept_as_a_person_writes_them() {
    let tracking = Tracking { rate: 89.96432, latency: 0.045_163_2, noise: 1.0349e-3 };
    let told = rounded(&tracking);
    assert_eq!((told.rate, told.latency, told.noise), (90.0, 0.0452, 0.001));
    let still = rounded(&Tracking { noise: 2.57e-5, ..tracking });
    assert_eq!(still.noise, 2.6e-5);
    assert_eq!(rounded(&Tracking { noise: 0.0, ..tracking }).noise, 0.0);
}

#[test]
fn ways_are_not_mixed() {
    let refused = |line: &[&str]| Line::try_parse_from([&["latency"], line].concat()).is_err();
    assert!(refused(&["hts:9000", "--with", "openxr:", "--taps", "20"]));
    assert!(refused(&["hts:9000", "--reference-latency", "0.01"]));
    assert!(refused(&["hts:9000", "--with", "openxr:", "--reference-latency", "9"]));
    assert!(refused(&["hts:9000", "--taps", "3"]));
    assert!(!refused(&["hts:9000", "--taps", "10", "--finger", "middle"]));
}
