//! What a child may take of the machine, set by itself before it does anything.

use rustix::process::{Resource, Rlimit, setrlimit};
use std::path::Path;

/// Memory that a child has before its task comes: the program's data, and the stacks and first blocks of its threads.
const OWN: u64 = 256 << 20;
/// Children go first when the memory of the machine runs out (proc_pid_oom_score_adj(5): −1000 never to 1000 always).
const GOES_FIRST: &str = "500";

/// Limits the data of this process to `memory` bytes beyond what it has by itself.
///
/// `RLIMIT_DATA` counts private memory that can be written, touched or not: heaps, columns, buffers of OpenBLAS and stacks.
/// `RLIMIT_AS` would also count what is reserved only, 64 MB for every arena of the C library and thread, so that its limit would
/// mean something else on every machine; `RLIMIT_RSS` does nothing. What cannot be set is left: then the limits of the system
/// hold.
pub fn confine(memory: u64) {
    let most = |bytes: u64| Rlimit {
        current: Some(bytes),
        maximum: Some(bytes),
    };
    let _ = setrlimit(Resource::Data, most(memory.saturating_add(OWN)));
    // Gigabytes of a core file would fill the disk that the results need.
    let _ = setrlimit(Resource::Core, most(0));
    let _ = std::fs::write("/proc/self/oom_score_adj", GOES_FIRST);
}

/// Memory of the machine, or of the container that this process is in (bytes).
pub fn memory_of_machine() -> u64 {
    let machine = rustix::system::sysinfo();
    let all = machine.totalram as u64 * u64::from(machine.mem_unit);
    limits_of_groups().fold(all, u64::min)
}

/// Memory limits of the control group of this process and those around it (version 2; bytes).
fn limits_of_groups() -> impl Iterator<Item = u64> {
    let groups = std::fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let own = groups.lines().find_map(|line| line.strip_prefix("0::/")).unwrap_or_default();
    let folder = Path::new("/sys/fs/cgroup").join(own);
    let limit = |folder: &Path| std::fs::read_to_string(folder.join("memory.max")).ok()?.trim().parse().ok();
    folder.ancestors().filter_map(limit).collect::<Vec<u64>>().into_iter()
}

/// Memory that a process holds (bytes); `None` where the system does not say.
pub fn held_by(pid: u32) -> Option<u64> {
    let text = std::fs::read_to_string(format!("/proc/{pid}/status")).ok()?;
    let held = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: u64 = held.trim().trim_end_matches(" kB").parse().ok()?;
    Some(kilobytes << 10)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_holds_less_than_its_machine_has() {
        let held = held_by(std::process::id()).expect("Linux says it");
        assert!(
            held > 1 << 20 && held < memory_of_machine(),
            "{held} of {}",
            memory_of_machine()
        );
    }
}
