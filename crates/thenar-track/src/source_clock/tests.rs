//! Clocks of devices that run as they should, jump, stand still, drift.

use super::*;

const MS: u64 = 1_000_000;

/// The device's clock is 5 s ahead and 100 ppm slow, the network takes 2 ms to 9 ms: after a
/// second, times are carried over to within a millisecond of the shortest way.
#[test]
fn jitter_of_the_network_goes() {
    let mut clock = SourceClock::default();
    let mut worst = 0u64;
    for k in 0..6000u64 {
        let measured = 10_000 * MS + k * 11 * MS;
        let source = (measured as f64 * (1.0 - 1e-4)) as i64 + 5_000_000_000;
        let delay = 2 * MS + (k * 7919 % 8) * MS;
        let carried = clock.carry(measured + delay, source);
        assert!(!carried.jumped && carried.time_ns <= measured + delay);
        if k > 100 {
            worst = worst.max((carried.time_ns).abs_diff(measured + 2 * MS));
        }
    }
    assert!(worst < MS, "{worst}");
}

#[test]
fn jumps_are_noticed_and_followed() {
    let mut clock = SourceClock::default();
    let hour = 3_600_000_000_000i64;
    let mut run = |from: u64, shift: i64| -> Vec<bool> {
        (0..20u64)
            .map(|k| {
                let now = (from + 10 * k) * MS;
                let carried = clock.carry(now, now as i64 + shift);
                // Whatever the device's clock does, fresh samples are fresh but after a jump
                // forward of our own doing.
                assert!(now - carried.time_ns < 300 * MS);
                carried.jumped
            })
            .collect()
    };
    let once = |told: &[bool]| told.iter().filter(|j| **j).count() == 1 && told[0];
    assert!(run(1000, 0).iter().all(|jumped| !jumped));
    assert!(once(&run(2000, hour)), "an hour ahead");
    assert!(once(&run(3000, -hour)), "and back");
    assert!(run(4000, -hour).iter().all(|jumped| !jumped));
}

/// By as little as clocks are set back over a network: old for a second, then followed.
#[test]
fn a_small_step_back_for_good_is_followed_after_a_second() {
    for back_ms in [120, 150, 199] {
        let mut clock = SourceClock::default();
        (0..100).for_each(|k| _ = clock.carry(k * 10 * MS, (k * 10 * MS) as i64));
        let mut jumps = Vec::new();
        for k in 100..400u64 {
            let now = k * 10 * MS;
            let carried = clock.carry(now, (now - back_ms * MS) as i64);
            jumps.extend(carried.jumped.then_some(k));
            let age = now - carried.time_ns;
            match jumps.is_empty() {
                // The offset may have drifted by 0.4 ms meanwhile.
                true => assert!(age.abs_diff(back_ms * MS) < MS, "{k} {age}"),
                false => assert!(age < MS, "{k} {age}"),
            }
        }
        assert_eq!(jumps, [201], "back by {back_ms} ms");
    }
}

/// However long the same is repeated, it gets no fresher, and that is reported; two hands of one
/// frame have the same time and are no trouble.
#[test]
fn a_clock_that_stands_still_makes_nothing_fresh() {
    let mut clock = SourceClock::default();
    for k in 0..1000u64 {
        let now = (5000 + 10 * k) * MS;
        let carried = clock.carry(now, 77);
        assert_eq!(carried.time_ns, 5000 * MS);
        assert_eq!((carried.jumped, carried.stands_still), (false, k > 100), "{k}");
    }
    let mut clock = SourceClock::default();
    for k in 0..1000u64 {
        let now = (15_000 + 10 * k) * MS;
        for _hand in 0..2 {
            let carried = clock.carry(now, (10 * k * MS) as i64);
            assert!(!carried.stands_still);
            assert_eq!(carried.time_ns, now, "{k}");
        }
    }
}

/// Wi-Fi stalls: samples come late, all at once, and are known to be old.
#[test]
fn a_burst_of_late_samples_is_late() {
    let mut clock = SourceClock::default();
    (0..100).for_each(|k| _ = clock.carry(k * 10 * MS, (k * 10 * MS) as i64));
    let now = 1500 * MS;
    for k in 100..140u64 {
        let carried = clock.carry(now, (k * 10 * MS) as i64);
        assert!(!carried.jumped && carried.time_ns.abs_diff(k * 10 * MS) < MS);
    }
}

#[test]
fn no_number_breaks_it() {
    let mut clock = SourceClock::default();
    let odd = [0, 1, -1, i64::MAX, i64::MIN, i64::MAX - 1, 1 << 62, -(1 << 62), 5];
    for now in [0, 1, u64::MAX, 7 * MS, 1 << 63] {
        for source in odd {
            assert!(clock.carry(now, source).time_ns <= now);
        }
    }
}

/// Samples of a device at 90 Hz over ten minutes: when each was measured and arrived, by our clock,
/// in order of arrival. The shortest way takes 3 ms, others up to tens of milliseconds more
/// (exponential, 4 ms on the mean), one in twenty is lost, and at 200 s all are for two seconds.
fn sent(seed: u64) -> Vec<(u64, u64)> {
    let mut random = thenar_core::random::Random::new(seed);
    let mut samples = Vec::new();
    for k in 0..54_000u64 {
        let measured = 10_000 * MS + k * 1_000_000_000 / 90;
        let way = 3e6 - 4e6 * (1.0 - random.unit()).max(1e-9).ln();
        let lost = random.unit() < 0.05 || (18_000..18_180).contains(&k);
        samples.extend((!lost).then_some((measured, measured + way as u64)));
    }
    samples.sort_by_key(|(_, arrived)| *arrived);
    samples
}

/// A clock that runs off by 1e-3 shows 0.6 s more or less after ten minutes. Times are carried over
/// to within 3 ms of the shortest way after 3 s, in which the rate is found, and within 1 ms after
/// 25 s; and nothing is taken for a jump but the hour by which the clock is set, at 400 s.
#[test]
fn clocks_that_run_off_are_followed() {
    for rate in [0.0, 2e-4, -2e-4, 1e-3, -1e-3] {
        for seed in 1..=3 {
            let mut clock = SourceClock::default();
            let (mut jumps, mut set_ns, mut worst) = (Vec::new(), 10_000 * MS, [0.0_f64; 2]);
            for (measured, arrived) in sent(seed) {
                let hour = if measured > 410_000 * MS { 3_600_000_000_000 } else { 0 };
                let source = (measured as f64 * (1.0 + rate)) as i64 + hour;
                let carried = clock.carry(arrived, source);
                if carried.jumped {
                    jumps.push(arrived / MS);
                    set_ns = arrived;
                }
                let off = carried.time_ns as f64 - (measured + 3 * MS) as f64;
                for (worst, after) in worst.iter_mut().zip([3, 25]) {
                    if arrived > set_ns + after * 1000 * MS {
                        *worst = worst.max(1e-6 * off.abs());
                    }
                }
            }
            println!("{rate}, seed {seed}: off by {worst:?} ms at most, jumps {jumps:?} ms");
            assert!(jumps.len() == 1 && jumps[0].abs_diff(410_000) < 50, "{rate}: {jumps:?}");
            assert!(worst[0] < 3.0 && worst[1] < 1.0, "{rate}: {worst:?} ms");
        }
    }
}

/// A way that becomes longer by 20 ms for good: samples are older by as much, and the longer it
/// lasts the less it is taken for their age, as nothing tells it from a clock that was set back.
/// Never younger than the shortest way.
#[test]
fn a_longer_way_makes_samples_older() {
    let mut clock = SourceClock::default();
    for (measured, arrived) in sent(4) {
        let far = if measured > 60_000 * MS { 20 * MS } else { 0 };
        let carried = clock.carry(arrived + far, measured as i64);
        let age = (carried.time_ns as f64 - (measured + 3 * MS) as f64) * 1e-6;
        assert!(!carried.jumped && age > -1.0, "{measured}: {age} ms");
        let since = measured.saturating_sub(60_000 * MS) / MS;
        assert!(since > 8_000 || age < 4.0, "{since} ms: {age} ms");
        assert!(since < 40_000 || (age - 20.0).abs() < 1.0, "{since} ms: {age} ms");
    }
}
