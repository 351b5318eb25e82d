#![cfg(unix)]

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use super::{Bench, NUMBERS, bits, said, shown};

#[test]
fn a_sweep_that_is_killed_again_and_again_loses_and_doubles_nothing() {
    let bench = Bench::cases(1500);
    assert!(bench.sweep("whole", &[]).status.success());
    let (plan, out) = (bench.path("sweep.toml"), bench.path("killed"));
    let mut pause = 20;
    let mut kills = 0;
    for _ in 0..12 {
        let mut child = Command::new(env!("CARGO_BIN_EXE_admire"))
            .args(["sweep", shown(&plan), "--out", shown(&out)])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("admire starts");
        std::thread::sleep(Duration::from_millis(pause));
        // The moments of the kill are spread over start, work and the writing of the result.
        pause = 20 + pause * 7 % 331;
        kills += usize::from(child.try_wait().expect("a child").is_none());
        let _ = child.kill();
        let _ = child.wait();
    }
    assert!(kills > 2, "{kills} runs were killed");
    let last = bench.sweep("killed", &[]);
    assert!(last.status.success(), "{}", said(&last));
    let (whole, killed) = (bench.rows("whole", NUMBERS), bench.rows("killed", NUMBERS));
    assert_eq!(killed.len(), 1500);
    assert!(whole.iter().map(bits).eq(killed.iter().map(bits)));
}

/// Checks the remains of a run that was killed while it wrote the summary: a temporary file of a process that no longer exists.
#[test]
fn a_sweep_killed_while_it_writes_its_answer_goes_on() {
    let bench = Bench::cases(10);
    assert!(bench.sweep("out", &[]).status.success());
    let out = bench.path("out");
    let left = out.join(format!(".admire-{}-aBcDeF", u32::MAX));
    std::fs::rename(out.join("summary.json"), &left).expect("renamed");
    let again = bench.sweep("out", &[]);
    assert!(again.status.success(), "{}", said(&again));
    assert!(out.join("summary.json").exists());
    assert_eq!(left.exists(), !Path::new("/proc/self").exists());
}

/// Returns the peak memory, in bytes, of a sweep with this number of cases.
#[cfg(target_os = "linux")]
fn most_memory(cases: usize) -> u64 {
    let bench = Bench::cases(cases);
    let (plan, out) = (bench.path("sweep.toml"), bench.path("out"));
    let mut child = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(["sweep", shown(&plan), "--out", shown(&out), "--jobs", "2"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("admire starts");
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0;
    let start = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kilobytes = line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok());
        most = most.max(1024 * kilobytes.unwrap_or(0));
        assert!(start.elapsed() < Duration::from_secs(600));
        std::thread::sleep(Duration::from_millis(5));
    }
    most
}

#[cfg(target_os = "linux")]
#[test]
fn memory_does_not_grow_with_the_cases() {
    // 200 bytes per case correspond to 20 MB for 100,000 cases.
    let (few, many) = (most_memory(200), most_memory(5000));
    let room = 200 * 4800 + (6 << 20);
    assert!(
        many < few + room,
        "{few} bytes for 200 cases, {many} for 5000"
    );
}
