//! Machines made of files: what is read of them, and what they lack.

use super::facts::{Facts, Port};
use super::findings::{Finding, judge};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// A machine's files, in a folder of their own.
struct Machine(PathBuf);

impl Machine {
    fn new(name: &str, files: &[(&str, &str)]) -> Self {
        // Tests beside each other make machines of one name.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let folder = format!("thenar-machine-{name}-{}-{count}", std::process::id());
        let root = std::env::temp_dir().join(folder);
        for (path, text) in files {
            let path = root.join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        Self(root)
    }

    fn read(&self) -> Facts {
        Facts::read(&self.0)
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const LIMITS: &str = "\
Limit                     Soft Limit           Hard Limit           Units     
Max locked memory         8388608              8388608              bytes     
Max realtime priority     0                    95                   
";
/// A process of uid and gid 1000, in group 29, without capabilities.
const STATUS: &str = "Name:\tx\nUid:\t1000\t1000\t1000\t1000\nGid:\t1000\t1000\t1000\t1000\n\
                      Groups:\t29 1000 \nCapEff:\t0000000000000000\n";

/// A laptop as it is bought.
fn laptop() -> Machine {
    Machine::new(
        "laptop",
        &[
            ("proc/self/limits", LIMITS),
            ("proc/self/status", STATUS),
            ("proc/version", "Linux version 6.1.0-18-amd64 #1 SMP PREEMPT_DYNAMIC Debian"),
            ("proc/cmdline", "root=/dev/sda1 quiet"),
            ("proc/sys/kernel/sched_rt_runtime_us", "950000\n"),
            ("proc/sys/kernel/sched_rt_period_us", "1000000\n"),
            ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n"),
            ("sys/devices/system/cpu/cpu0/cpuidle/state1/latency", "2\n"),
            ("sys/devices/system/cpu/cpu0/cpuidle/state2/latency", "890\n"),
            ("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "performance\n"),
            ("sys/devices/system/cpu/cpufreq/boost", "1\n"),
            ("sys/bus/usb-serial/devices/ttyUSB0/latency_timer", "16\n"),
            ("dev/ttyUSB0", ""),
        ],
    )
}

#[test]
fn a_machine_is_read() {
    let facts = laptop().read();
    assert_eq!(facts.priority, Some([Some(0), Some(95)]));
    assert_eq!(facts.memory, Some([Some(8_388_608), Some(8_388_608)]));
    assert_eq!(facts.privileged, [false; 2]);
    assert_eq!(facts.preemption.as_deref(), Some("voluntary"));
    assert_eq!((facts.runtime, facts.period), (Some(950_000), Some(1_000_000)));
    assert_eq!((facts.processors, facts.wakes), (2, Some(890)));
    let slow: Vec<_> = facts.slow.iter().map(|(_, governor)| governor.as_str()).collect();
    assert_eq!(slow, ["powersave"]);
    let [Port { path, collects, .. }] = &facts.ports[..] else { panic!("{:?}", facts.ports) };
    assert_eq!((path.as_path(), *collects), (Path::new("/dev/ttyUSB0"), Some(16)));
    // One that says nothing.
    let nothing = Machine::new("nothing", &[("proc/self/limits", "?")]).read();
    assert_eq!(nothing, Facts::default());
}

#[test]
fn the_kernel_says_how_it_may_be_interrupted() {
    let of = |version: &str, debug: &str, cmdline: &str| {
        let files = [
            ("proc/version", version),
            ("sys/kernel/debug/sched/preempt", debug),
            ("proc/cmdline", cmdline),
        ];
        let name = format!("kernel-{}", version.len() + debug.len() + cmdline.len());
        Machine::new(&name, &files).read().preemption.unwrap()
    };
    let dynamic = "Linux #1 SMP PREEMPT_DYNAMIC Debian";
    assert_eq!(of("Linux #1 SMP PREEMPT_RT Debian", "", "preempt=none"), "PREEMPT_RT");
    assert_eq!(of(dynamic, "none voluntary (full) lazy\n", "preempt=none"), "full");
    assert_eq!(of(dynamic, "", "quiet preempt=full"), "full");
    assert_eq!(of("Linux #1 SMP PREEMPT", "", ""), "full");
    assert_eq!(of("Linux #1 SMP", "", ""), "none");
}

fn lacking(findings: &[Finding]) -> Vec<(&str, &str)> {
    findings.iter().filter_map(|f| Some((f.what, f.mend.as_deref()?))).collect()
}

/// Each thing that is lacking comes with a command: one for this shell where the login allows it.
#[test]
fn what_is_lacking_comes_with_its_command() {
    let facts = laptop().read();
    let refused = || Err("Operation not permitted".to_owned());
    let all = judge(&facts, &[refused(), Ok(())]);
    let lacks = lacking(&all);
    let command = |what: &str| lacks.iter().find(|(w, _)| *w == what).expect(what).1;
    assert_eq!(command("real-time priority"), "ulimit -r 80");
    // A trial of this small program went well; a hand's would not.
    assert!(command("locked memory").contains("memlock unlimited"), "{lacks:?}");
    assert!(command("kernel preemption").contains("preempt=full"));
    assert!(command("processor's clock").contains("scaling_governor"));
    assert_eq!(command("idle processors"), "sudo cpupower idle-set -D 100");
    assert!(lacks.iter().any(|(_, mend)| mend.contains("ttyUSB0/latency_timer")), "{lacks:?}");
    let good = |what: &str| all.iter().any(|f| f.what == what && f.mend.is_none());
    assert!(good("time for real-time threads") && good("processors"));
}

/// A machine set up for it, with one processor and no time for real-time threads.
#[test]
fn what_is_good_is_not_lacking() {
    let machine = Machine::new(
        "lab",
        &[
            ("proc/self/limits", "Max locked memory  unlimited unlimited bytes\n"),
            ("proc/self/status", "Uid:\t0\t0\t0\t0\nCapEff:\t0000000000800000\n"),
            ("proc/version", "Linux #1 SMP PREEMPT_RT"),
            ("proc/sys/kernel/sched_rt_runtime_us", "0"),
            ("sys/devices/system/cpu/cpu0/cpuidle/state1/latency", "2"),
            ("sys/devices/system/cpu/cpu0/cpuidle/state2/latency", "890"),
            ("sys/devices/system/cpu/cpu0/cpuidle/state2/disable", "1"),
            ("dev/ttyACM0", ""),
            ("dev/tty1", ""),
        ],
    );
    let facts = machine.read();
    assert_eq!(facts.privileged, [true, false]);
    let all = judge(&facts, &[Ok(()), Ok(())]);
    let lacks: Vec<_> = lacking(&all).into_iter().map(|(what, _)| what).collect();
    assert_eq!(lacks, ["time for real-time threads", "processors"]);
    assert!(all.iter().any(|f| f.state.contains("/dev/ttyACM0 is ours")), "{all:?}");
}

/// The port is of another user and group; a stranger may not write.
#[cfg(unix)]
#[test]
fn a_port_that_is_not_ours_is_lacking() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let machine = Machine::new("port", &[("dev/ttyUSB0", "")]);
    let path = machine.0.join("dev/ttyUSB0");
    let data = std::fs::metadata(&path).unwrap();
    let status = |uid: u32, groups: &str| {
        let text = format!("Uid:\t{uid}\t{uid}\t{uid}\t{uid}\nGroups:\t{groups}\n");
        std::fs::create_dir_all(machine.0.join("proc/self")).unwrap();
        std::fs::write(machine.0.join("proc/self/status"), text).unwrap();
    };
    let ours = || machine.read().ports[0].ours;
    let group = data.gid().to_string();
    for (mode, uid, groups, wanted) in [
        (0o660, data.uid() + 1, "7", false),
        (0o660, data.uid() + 1, group.as_str(), true),
        (0o640, data.uid() + 1, group.as_str(), false),
        (0o666, data.uid() + 1, "7", true),
        (0o600, data.uid(), "7", true),
        (0o000, 0, "7", true),
    ] {
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(mode)).unwrap();
        status(uid, groups);
        assert_eq!(ours(), wanted, "{mode:o} {uid} {groups}");
    }
    std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o660)).unwrap();
    status(data.uid() + 1, "7");
    let all = judge(&machine.read(), &[Ok(()), Ok(())]);
    assert!(lacking(&all).iter().any(|(_, mend)| mend.contains("usermod")), "{all:?}");
}
