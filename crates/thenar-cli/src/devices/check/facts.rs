//! Facts that a Linux machine states of itself, as far as they bear on touch.

use std::path::{Path, PathBuf};

/// Bits of capabilities in `/proc/self/status`: a process may lock memory, and raise its priority.
const CAP_IPC_LOCK: u32 = 14;
/// See [`CAP_IPC_LOCK`].
const CAP_SYS_NICE: u32 = 23;

/// A limit of the system on this process: now, and as far as the process may raise it; `None` for
/// no limit.
pub type Limit = [Option<u64>; 2];

/// A serial port of this machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// Path of the port.
    pub path: PathBuf,
    /// True if the process may read and write it.
    pub ours: bool,
    /// Group of the port.
    pub group: u32,
    /// Time for which its driver collects bytes before it hands them over \[ms\], where stated.
    pub collects: Option<u32>,
}

/// All that is read; `None` for what the machine does not say.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Facts {
    /// Largest real-time priority.
    pub priority: Option<Limit>,
    /// Memory that may be locked \[B\].
    pub memory: Option<Limit>,
    /// The process may raise priorities, and lock memory, whatever the limits.
    pub privileged: [bool; 2],
    /// Preemption of the kernel: `PREEMPT_RT`, or `full`, `lazy`, `voluntary`, `none`.
    pub preemption: Option<String>,
    /// Time that real-time threads may use \[us\], of [`Facts::period`]; -1 for all.
    pub runtime: Option<i64>,
    /// Period of that \[us\].
    pub period: Option<i64>,
    /// Number of processors.
    pub processors: usize,
    /// Processors whose clock is not governed by `performance`, and by what instead.
    pub slow: Vec<(PathBuf, String)>,
    /// The longest that a processor takes to wake from an idle state that is allowed \[us\].
    pub wakes: Option<u32>,
    /// Serial ports that gloves come with.
    pub ports: Vec<Port>,
}

impl Facts {
    /// Reads a machine whose files are below `root`: `/`, but in tests.
    pub fn read(root: &Path) -> Self {
        let text = |path: &str| std::fs::read_to_string(root.join(path)).ok();
        let number = |path: &str| text(path)?.trim().parse().ok();
        let limits = text("proc/self/limits").unwrap_or_default();
        let status = text("proc/self/status").unwrap_or_default();
        let cpus = processors(root);
        Self {
            priority: limit(&limits, "Max realtime priority"),
            memory: limit(&limits, "Max locked memory"),
            privileged: [CAP_SYS_NICE, CAP_IPC_LOCK].map(|bit| capable(&status, bit)),
            preemption: preemption(
                &text("proc/version").unwrap_or_default(),
                &text("sys/kernel/debug/sched/preempt").unwrap_or_default(),
                &text("proc/cmdline").unwrap_or_default(),
            ),
            runtime: number("proc/sys/kernel/sched_rt_runtime_us"),
            period: number("proc/sys/kernel/sched_rt_period_us"),
            processors: cpus.len(),
            slow: cpus.iter().filter_map(|cpu| slow(cpu)).collect(),
            wakes: cpus.first().and_then(|cpu| wakes(cpu)),
            ports: ports(root, &status),
        }
    }
}

/// A row of `/proc/self/limits`.
fn limit(limits: &str, name: &str) -> Option<Limit> {
    let row = limits.lines().find_map(|line| line.strip_prefix(name))?;
    let mut words = row.split_whitespace();
    let mut next = || match words.next()? {
        "unlimited" => Some(None),
        number => number.parse().ok().map(Some),
    };
    Some([next()?, next()?])
}

/// A line of `/proc/self/status`.
fn line<'a>(status: &'a str, key: &str) -> Option<&'a str> {
    status.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':')).map(str::trim)
}

fn capable(status: &str, bit: u32) -> bool {
    let effective = line(status, "CapEff").and_then(|mask| u64::from_str_radix(mask, 16).ok());
    effective.is_some_and(|mask| mask & (1 << bit) != 0)
}

/// The model by the kernel's own word, else as it was started, else as it was built.
fn preemption(version: &str, debug: &str, cmdline: &str) -> Option<String> {
    let built = |name: &str| version.split_whitespace().any(|word| word == name);
    if built("PREEMPT_RT") || built("PREEMPT_RT,") {
        return Some("PREEMPT_RT".into());
    }
    let now = debug.split_whitespace().find_map(|word| word.strip_prefix('(')?.strip_suffix(')'));
    let asked = || cmdline.split_whitespace().find_map(|word| word.strip_prefix("preempt="));
    let of_build = || match (built("PREEMPT_DYNAMIC"), built("PREEMPT"), version.is_empty()) {
        (_, _, true) => None,
        // Which of them is not readable by everybody; distributions build it with this default.
        (true, _, _) => Some("voluntary"),
        (false, true, _) => Some("full"),
        (false, false, _) => Some("none"),
    };
    now.or_else(asked).or_else(of_build).map(str::to_owned)
}

/// Folders of the processors, in order.
fn processors(root: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(root.join("sys/devices/system/cpu"));
    let mut found: Vec<(u32, PathBuf)> = entries
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name();
            Some((name.to_str()?.strip_prefix("cpu")?.parse().ok()?, entry.path()))
        })
        .collect();
    found.sort();
    found.into_iter().map(|(_, path)| path).collect()
}

fn slow(cpu: &Path) -> Option<(PathBuf, String)> {
    let path = cpu.join("cpufreq/scaling_governor");
    let governor = std::fs::read_to_string(&path).ok()?.trim().to_owned();
    (governor != "performance").then_some((path, governor))
}

fn wakes(cpu: &Path) -> Option<u32> {
    let states = std::fs::read_dir(cpu.join("cpuidle")).ok()?;
    let number = |state: &Path, file: &str| -> Option<u32> {
        std::fs::read_to_string(state.join(file)).ok()?.trim().parse().ok()
    };
    let allowed = states.flatten().map(|state| state.path());
    let allowed = allowed.filter(|state| number(state, "disable").unwrap_or(0) == 0);
    allowed.filter_map(|state| number(&state, "latency")).max()
}

#[cfg(unix)]
fn ports(root: &Path, status: &str) -> Vec<Port> {
    use std::os::unix::fs::MetadataExt;
    let ids = |key: &str| -> Vec<u32> {
        let all = line(status, key).unwrap_or("");
        all.split_whitespace().filter_map(|id| id.parse().ok()).collect()
    };
    // Of the four user and group ids the second is the effective one.
    let [uid, gid] = ["Uid", "Gid"].map(|key| ids(key).get(1).copied());
    let groups = ids("Groups");
    let mut found: Vec<Port> = std::fs::read_dir(root.join("dev"))
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            let gloves = ["ttyUSB", "ttyACM", "rfcomm"];
            let data =
                entry.metadata().ok().filter(|_| gloves.iter().any(|g| name.starts_with(g)))?;
            let (mode, group) = (data.mode(), data.gid());
            let grouped = gid == Some(group) || groups.contains(&group);
            let both = |shift: u32| mode >> shift & 0o6 == 0o6;
            let ours = uid == Some(0)
                || uid == Some(data.uid()) && both(6)
                || grouped && both(3)
                || both(0);
            let timer = format!("sys/bus/usb-serial/devices/{name}/latency_timer");
            let timer = std::fs::read_to_string(root.join(timer)).ok();
            let collects = timer.and_then(|text| text.trim().parse().ok());
            Some(Port { path: Path::new("/dev").join(name), ours, group, collects })
        })
        .collect();
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

#[cfg(not(unix))]
fn ports(_: &Path, _: &str) -> Vec<Port> {
    Vec::new()
}
