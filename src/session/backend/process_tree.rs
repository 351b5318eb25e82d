//! Process tree of a run on Unix, which ends with the run.
//!
//! ADAMS' own `mdi` is a script, and the solver behind it holds the licence. A program may also start a session of its own. Therefore a run
//! leads a process group, and its processes carry a mark in their environment. On Linux orphans become children of this process
//! (PR_SET_CHILD_SUBREAPER). Together these find every process of the run.

use std::process::{Child, Command, ExitStatus};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Current runs: the id of the started process, and the mark of its processes.
static RUNNING: Mutex<Vec<(u32, String)>> = Mutex::new(Vec::new());

/// True if this process had children before its first run, which a shell may have started before it executed this program.
static HAS_OTHERS: std::sync::OnceLock<bool> = std::sync::OnceLock::new();

/// Environment variable that carries the mark.
const MARK: &str = "ADMIRE_RUN";

/// The processes of one run; they end when this value is dropped.
#[derive(Debug)]
pub(super) struct ProcessTree {
    child: Child,
    root: u32,
    mark: String,
}

/// Starts a command that leads a process tree of its own.
///
/// # Errors
/// When it cannot be started.
pub(super) fn start(mut command: Command) -> std::io::Result<ProcessTree> {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let count = COUNT.fetch_add(1, Ordering::Relaxed);
    let mark = format!("{}-{count}", std::process::id());
    command.env(MARK, &mark);
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    #[cfg(target_os = "linux")]
    {
        // Without this, orphans are still found by their mark.
        let _ = nix::sys::prctl::set_child_subreaper(true);
    }
    // This must be known before any search for orphans.
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
    /// Returns the exit status of the program, or `None` while it is running.
    ///
    /// # Errors
    /// When the system does not report the status.
    pub(super) fn try_wait(&mut self) -> std::io::Result<Option<ExitStatus>> {
        self.child.try_wait()
    }
}

impl Drop for ProcessTree {
    fn drop(&mut self) {
        end(self.root, &self.mark);
        // It is no error if the program has already ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
        running(|runs| runs.retain(|(root, _)| *root != self.root));
    }
}

/// Ends all current runs, before this process itself ends.
pub(super) fn end_runs() {
    for (root, mark) in running(|runs| runs.clone()) {
        end(root, &mark);
    }
}

fn running<T>(work: impl FnOnce(&mut Vec<(u32, String)>) -> T) -> T {
    work(&mut RUNNING.lock().unwrap_or_else(PoisonError::into_inner))
}

/// One process of the system.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
struct Process {
    id: u32,
    parent: u32,
    group: u32,
    /// True if the process carries the mark of the run.
    marked: bool,
}

/// Kills the processes of a run, repeatedly until none is left. A process started in the meantime is found in the next pass.
fn end(root: u32, mark: &str) {
    use nix::sys::signal::{Signal, kill};
    use nix::sys::wait::{WaitPidFlag, waitpid};
    use nix::unistd::Pid;
    let me = std::process::id();
    let pid = |id: u32| i32::try_from(id).ok().map(Pid::from_raw);
    let mut ended: Vec<u32> = Vec::new();
    for _ in 0..100 {
        // The lock prevents other runs from starting meanwhile.
        let found = running(|runs| {
            let others: Vec<u32> = runs
                .iter()
                .map(|run| run.0)
                .filter(|id| *id != root)
                .collect();
            let alone = others.is_empty() && HAS_OTHERS.get() == Some(&false);
            let found = members(&processes(mark), root, me, &others, alone);
            for id in &found {
                // It is no error if the process has just ended.
                let _ = pid(*id).map(|id| kill(id, Signal::SIGKILL));
            }
            found
        });
        ended.extend(found.iter().filter(|id| **id != root));
        for id in &ended {
            // Orphans are now children of this process. The root is waited for by its starter.
            let _ = pid(*id).map(|id| waitpid(id, Some(WaitPidFlag::WNOHANG)));
        }
        if found.is_empty() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

/// Returns the processes of a run: the marked ones, the group of its root, and all their descendants. If the run is `alone`, orphans that left
/// the group also belong to it.
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

/// Returns all processes of the system that have not ended.
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

/// Parses parent and group from a line of /proc: `id (name) state parent group`, where the name may contain any characters. `None` for a
/// process that has ended.
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

/// Returns all processes of the system. Their marks are not visible.
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
            // The run, its child, a grandchild in a session of its own, an orphan that left the group, and a marked process elsewhere.
            process(20, 10, 20),
            process(21, 20, 20),
            process(22, 21, 22),
            process(30, 10, 30),
            process(40, 1, 40),
            process(41, 40, 41),
            // Another child of this process, in its own group; an unrelated process.
            process(50, 10, 10),
            process(60, 1, 60),
        ];
        let mut found = members(&all, 20, 10, &[], true);
        found.sort_unstable();
        assert_eq!(found, [20, 21, 22, 30, 40, 41]);
        // While run 30 exists, the origin of orphan 30 is ambiguous.
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
