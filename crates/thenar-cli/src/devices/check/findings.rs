//! Findings on what a machine lacks for touch, and the command that mends it.

use super::facts::{Facts, Limit, Port};
use thenar_link::realtime::PriorityClass;

/// The longest that waking a processor may take \[us\]: a tenth of a tick.
const WAKES_MAX: u32 = 100;
/// Part of the time that real-time threads must have: the loop and all devices use less than a
/// tenth.
const RUNTIME_MIN: f64 = 0.5;
/// The longest that a port's driver may collect bytes \[ms\]: a tick.
const COLLECTS_MAX: u32 = 1;

/// One thing that was looked at.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// Name of the thing.
    pub what: &'static str,
    /// State of the thing, and what that means.
    pub state: String,
    /// The command that mends it; `None` where nothing is lacking.
    pub mend: Option<String>,
}

impl Finding {
    fn good(what: &'static str, state: impl Into<String>) -> Self {
        Self { what, state: state.into(), mend: None }
    }

    fn lacks(what: &'static str, state: impl Into<String>, mend: impl Into<String>) -> Self {
        Self { what, state: state.into(), mend: Some(mend.into()) }
    }
}

/// Judges a machine. `tried` is what the system answered when priority was raised and memory was
/// locked.
pub fn judge(facts: &Facts, tried: &[Result<(), String>; 2]) -> Vec<Finding> {
    let mut all = vec![priority(facts, &tried[0]), memory(facts, &tried[1])];
    all.extend(preemption(facts));
    all.extend(runtime(facts));
    all.extend(governor(facts));
    all.extend(facts.wakes.map(wakes));
    all.extend(processors(facts));
    all.extend(facts.ports.iter().flat_map(port));
    all
}

/// Permits for good, for members of a group: limits of a login.
fn for_good(item: &str, value: &str) -> String {
    format!(
        "echo '@audio - {item} {value}' | sudo tee -a /etc/security/limits.d/thenar.conf; \
         sudo usermod -aG audio $USER; then log in again"
    )
}

/// In this shell where the login allows it, else for good.
fn permit(limit: Option<Limit>, wanted: Option<u64>, option: &str, item: &str) -> String {
    let word = wanted.map_or("unlimited".to_owned(), |n| n.to_string());
    let allows = limit.is_some_and(|[_, most]| match (most, wanted) {
        (None, _) => true,
        (Some(most), Some(wanted)) => most >= wanted,
        (Some(_), None) => false,
    });
    if allows { format!("ulimit {option} {word}") } else { for_good(item, &word) }
}

fn priority(facts: &Facts, tried: &Result<(), String>) -> Finding {
    let what = "real-time priority";
    let wanted = u64::from(PriorityClass::Keeper.priority());
    let state = match (facts.priority, facts.privileged[0]) {
        (_, true) => "allowed by a capability".to_owned(),
        (Some([Some(now), _]), false) => format!("allowed up to {now} of {wanted}"),
        (Some([None, _]), false) => "allowed".to_owned(),
        (None, false) => "the system does not say how far it is allowed".to_owned(),
    };
    match tried {
        Ok(()) => Finding::good(what, state),
        Err(cause) => Finding::lacks(
            what,
            format!("{state}; refused ({cause}): ticks and releases are late on a busy machine"),
            permit(facts.priority, Some(80), "-r", "rtprio"),
        ),
    }
}

fn memory(facts: &Facts, tried: &Result<(), String>) -> Finding {
    let what = "locked memory";
    let state = match (facts.memory, facts.privileged[1]) {
        (_, true) => "allowed by a capability".to_owned(),
        (Some([Some(now), _]), false) => format!("allowed up to {} KiB", now / 1024),
        (Some([None, _]), false) => "allowed".to_owned(),
        (None, false) => "the system does not say how much is allowed".to_owned(),
    };
    // All that a program has mapped counts, used or not: a trial of a small program that went well
    // says nothing of a hand's.
    let enough = facts.privileged[1] || facts.memory.is_none_or(|[now, _]| now.is_none());
    let refused =
        tried.as_ref().err().map_or(String::new(), |cause| format!("; refused ({cause})"));
    if enough && tried.is_ok() {
        return Finding::good(what, state);
    }
    Finding::lacks(
        what,
        format!("{state}{refused}: a tick may wait for the disk"),
        permit(facts.memory, None, "-l", "memlock"),
    )
}

fn preemption(facts: &Facts) -> Option<Finding> {
    let what = "kernel preemption";
    Some(match facts.preemption.as_deref()? {
        "PREEMPT_RT" => Finding::good(what, "PREEMPT_RT: late by some tens of us at most"),
        "full" => Finding::good(what, "full: late by a millisecond now and then"),
        other => Finding::lacks(
            what,
            format!("{other}: ticks wait while the kernel works, for milliseconds at times"),
            "sudo apt install linux-image-rt-amd64 (Debian), or add preempt=full to the kernel's \
             command line; then start again",
        ),
    })
}

fn runtime(facts: &Facts) -> Option<Finding> {
    let what = "time for real-time threads";
    let (runtime, period) = (facts.runtime?, facts.period.unwrap_or(1_000_000));
    Some(match runtime {
        -1 => Finding::good(what, "all of it"),
        us if us as f64 >= RUNTIME_MIN * period as f64 => {
            Finding::good(what, format!("{us} us of {period} us"))
        }
        us => Finding::lacks(
            what,
            format!("{us} us of {period} us: real-time threads stand still for the rest"),
            "sudo sysctl kernel.sched_rt_runtime_us=950000",
        ),
    })
}

/// A machine that governs nothing, as most virtual ones, is left out.
fn governor(facts: &Facts) -> Option<Finding> {
    facts.slow.first().map(|(_, governor)| {
        Finding::lacks(
            "processor's clock",
            format!("governed by `{governor}`: it is slow when a tick begins"),
            "echo performance | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor",
        )
    })
}

fn wakes(us: u32) -> Finding {
    let what = "idle processors";
    if us <= WAKES_MAX {
        return Finding::good(what, format!("wake within {us} us"));
    }
    Finding::lacks(
        what,
        format!("wake within {us} us"),
        format!("sudo cpupower idle-set -D {WAKES_MAX}"),
    )
}

fn processors(facts: &Facts) -> Option<Finding> {
    let what = "processors";
    Some(match facts.processors {
        0 => return None,
        1 => Finding::lacks(
            what,
            "1: simulation and loop share it",
            "thenar touch --mode multirate, whose ticks cost least",
        ),
        n => Finding::good(what, n.to_string()),
    })
}

fn port(port: &Port) -> Vec<Finding> {
    let what = "serial port";
    let path = port.path.display();
    let mut all = Vec::new();
    if !port.ours {
        let group = port.group;
        all.push(Finding::lacks(
            what,
            format!("{path} is of group {group}, and this user is not"),
            format!("sudo usermod -aG $(stat -c %G {path}) $USER; then log in again"),
        ));
    }
    if let Some(ms) = port.collects.filter(|ms| *ms > COLLECTS_MAX) {
        let name = port.path.file_name().unwrap_or_default().to_string_lossy();
        all.push(Finding::lacks(
            what,
            format!(
                "{path} collects bytes for {ms} ms: what is felt is no stiffer than that bears"
            ),
            format!(
                "echo {COLLECTS_MAX} | sudo tee /sys/bus/usb-serial/devices/{name}/latency_timer"
            ),
        ));
    }
    if all.is_empty() {
        all.push(Finding::good(what, format!("{path} is ours to open")));
    }
    all
}
