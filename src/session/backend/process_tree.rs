//! Processes of a run on Unix, which end with the run.
//!
//! The `mdi` of ADAMS is a script that starts the solver, and the solver holds the licence. A program may also start a new session. It is
//! therefore not enough to end the program itself.
//!
//! Each run is the leader of a process group, and all its processes inherit a mark in their environment. On Linux, orphaned processes
//! become children of `admire` (PR_SET_CHILD_SUBREAPER). The processes of a run are found by their group, mark and parent.

use std::process::{Child, Command, ExitStatus};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// All current runs: the id of the process that was started, and the mark of the run.
static RUNNING: Mutex<Vec<(u32, String)>> = Mutex::new(Vec::new());

/// True if `admire` already had child processes before its first run. A shell may have started them before it executed `admire`.
static HAS_OTHERS: std::sync::OnceLock<bool> = std::sync::OnceLock::new();

/// Environment variable that contains the mark of a run.
const MARK: &str = "ADMIRE_RUN";

/// The processes of one run; they end when this value is dropped.
#[derive(Debug)]
pub(super) struct ProcessTree {
    child: Child,
    root: u32,
    mark: String,
}

/// Starts a command as the root of a new process tree.
///
/// # Errors
/// Returns an error if the command cannot be started.
pub(super) fn start(mut command: Command) -> std::io::Result<ProcessTree> {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let mark = format!("{}-{count}", std::process::id());
    command.env(MARK, &mark);
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    #[cfg(target_os = "linux")]
    {
        // If this call fails, orphaned processes are still found by their mark.
        let _ = nix::sys::prctl::set_child_subreaper(true);
    }
    // Earlier children must be looked up before the first run can leave orphans.
    running(|runs| {
        HAS_OTHERS.get_or_init(|| {
            let me = std::process::id();
            processes(&mark).iter().any(|process| process.parent == me)
        });
        let child = command.spawn()?;
        let root = child.id();
        runs.push((root, mark.clone()));
        Ok(ProcessTree { child, root, mark })
    })
}

impl ProcessTree {
    /// Returns the exit status of the program, or `None` while the program is running.
    ///
    /// # Errors
    /// Returns an error if the operating system does not report the status.
    pub(super) fn try_wait(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }
}

impl Drop for ProcessTree {
    fn drop(&mut self) {
        end(self.root, &self.mark);
        // The program may already have ended, so an error is ignored.
        let _ = self.child.kill();
        let _ = self.child.wait();
        running(|runs| runs.retain(|(root, _)| *root != self.root));
    }
}

/// Ends all current runs; called before the process of `admire` ends.
pub(super) fn end_runs() {
    for (root, mark) in running(|runs| runs.clone()) {
        end(root, &mark);
    }
}

fn running<T>(work: impl FnOnce(&mut Vec<(u32, String)>) -> T) -> T {
    work(&mut RUNNING.lock().unwrap_or_else(PoisonError::into_inner))
}

/// One process of the operating system.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Process {
    id: u32,
    parent: u32,
    group: u32,
    /// True if the environment of the process contains the mark of the run.
    marked: bool,
}

/// Kills the processes of a run until none is left. A process that was started meanwhile is found in the next pass.
fn end(root: u32, mark: &str) {
    use nix::sys::signal::{Signal, kill};
    use nix::sys::wait::{WaitPidFlag, waitpid};
    use nix::unistd::Pid;
    let me = std::process::id();
    let pid = |id: u32| i32::try_from(id).ok().map(Pid::from_raw);
    let mut ended: Vec<u32> = Vec::new();
    for _ in 0..100 {
        // While the lock is held, no other run can start.
        let found = running(|runs| {
            let others: Vec<u32> = runs
                .iter()
                .map(|run| run.0)
                .filter(|id| *id != root)
                .collect();
            let alone = others.is_empty() && HAS_OTHERS.get() == Some(&false);
            let found = members(&processes(mark), root, me, &others, alone);
            for id in &found {
                // The process may just have ended, so an error is ignored.
                let _ = pid(*id).map(|id| kill(id, Signal::SIGKILL));
            }
            found
        });
        ended.extend(found.iter().filter(|id| **id != root));
        for id in &ended {
            // Orphaned processes are now children of `admire` and must be waited for. The root is excluded, because its `ProcessTree` waits
            // for it.
            let _ = pid(*id).map(|id| waitpid(id, Some(WaitPidFlag::WNOHANG)));
        }
        if found.is_empty() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

/// Returns the ids of all processes that belong to a run.
///
/// They are the processes with the mark, the process group of the root, and all their descendants. If `alone` is true, no other run or
/// earlier child exists, and orphaned processes outside of the process group of `admire` belong to the run as well. `me` is the process of
/// `admire`, and `others` are the roots of other runs.
fn members(all: &[Process], root: u32, me: u32, others: &[u32], alone: bool) -> Vec<u32> {
    let own_group = all.iter().find(|p| p.id == me).map(|p| p.group);
    let mut found: Vec<u32> = Vec::new();
    loop {
        let before = found.len();
        for process in all {
            let orphan = process.parent == me
                && own_group.is_some_and(|group| group != process.group)
                && alone;
            let belongs = process.marked
                || process.id == root
                || process.group == root
                || found.contains(&process.parent)
                || orphan;
            let other = process.id == me || others.contains(&process.id);
            if belongs && !other && !found.contains(&process.id) {
                found.push(process.id);
            }
        }
        if found.len() == before {
            return found;
        }
    }
}

/// Returns all processes of the operating system that have not ended.
#[cfg(target_os = "linux")]
fn processes(mark: &str) -> Vec<Process> {
    let mark = format!("{MARK}={mark}");
    let Ok(entries) = std::fs::read_dir("/proc") else {
        return Vec::new();
    };
    entries
        .flatten()
        .filter_map(|entry| {
            let id: u32 = entry.file_name().to_str()?.parse().ok()?;
            let stat = std::fs::read(entry.path().join("stat")).ok()?;
            let (parent, group) = parent_and_group(&stat)?;
            let environment = std::fs::read(entry.path().join("environ")).unwrap_or_default();
            let marked = environment
                .split(|byte| *byte == 0)
                .any(|word| word == mark.as_bytes());
            Some(Process {
                id,
                parent,
                group,
                marked,
            })
        })
        .collect()
}

/// Parses the parent and the process group from a line of /proc: `id (name) state parent group`. The name may contain any characters.
/// Returns `None` for a process that has ended.
#[cfg(target_os = "linux")]
fn parent_and_group(stat: &[u8]) -> Option<(u32, u32)> {
    let behind = stat.iter().rposition(|byte| *byte == b')')? + 1;
    let mut words = std::str::from_utf8(&stat[behind..])
        .ok()?
        .split_whitespace();
    let state = words.next()?;
    let (parent, group) = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
    (!matches!(state, "Z" | "X")).then_some((parent, group))
}

/// Returns all processes of the operating system that have not ended. The marks of processes cannot be read on this system.
#[cfg(not(target_os = "linux"))]
fn processes(_: &str) -> Vec<Process> {
    let listed = Command::new("ps")
        .args(["-A", "-o", "pid=,ppid=,pgid=,stat="])
        .output();
    let table = listed.map(|listed| listed.stdout).unwrap_or_default();
    String::from_utf8_lossy(&table)
        .lines()
        .filter_map(|line| {
            let mut words = line.split_whitespace();
            let mut number = || words.next()?.parse().ok();
            let (id, parent, group) = (number()?, number()?, number()?);
            let ended = words.next()?.starts_with('Z');
            (!ended).then_some(Process {
                id,
                parent,
                group,
                marked: false,
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_run_started_is_found_and_strangers_are_not() {
        let process = |id, parent, group| Process {
            id,
            parent,
            group,
            marked: id == 40,
        };
        let all = [
            process(1, 0, 1),
            process(10, 1, 10),
            // The processes are the run, its child, a grandchild in a session of its own, and an orphan that left the group. A marked
            // process elsewhere and a child of the marked process follow.
            process(20, 10, 20),
            process(21, 20, 20),
            process(22, 21, 22),
            process(30, 10, 30),
            process(40, 1, 40),
            process(41, 40, 41),
            // Two processes that do not belong to the run: another child of this process, in the group of this process, and an unrelated
            // process.
            process(50, 10, 10),
            process(60, 1, 60),
        ];
        let mut found = members(&all, 20, 10, &[], true);
        found.sort_unstable();
        assert_eq!(found, [20, 21, 22, 30, 40, 41]);
        // While run 30 exists as well, it is unknown which run left the orphaned process.
        let mut found = members(&all, 20, 10, &[30], false);
        found.sort_unstable();
        assert_eq!(found, [20, 21, 22, 40, 41]);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn names_of_processes_may_hold_anything() {
        assert_eq!(parent_and_group(b"7 (a) S 9 (b) S 3 5 5 0"), Some((3, 5)));
        assert_eq!(parent_and_group(b"7 (a) Z 3 5 5 0"), None);
    }
}
