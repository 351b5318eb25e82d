//! What the system tells of this process: processor time and memory.
#![allow(dead_code)] // Each bench uses its own part.

use std::time::Instant;

/// Runs the work, asks for the size of what it worked on, and prints the rate by the clock, and by the processor time of all threads where the system tells: on a busy
/// machine only the second says something of the program.
pub fn rate<T>(what: &str, bytes: impl FnOnce() -> usize, work: impl FnOnce() -> T) -> T {
    let (start, busy) = (Instant::now(), processor_seconds());
    let result = work();
    let (seconds, after) = (start.elapsed().as_secs_f64(), processor_seconds());
    let megabytes = bytes() as f64 / 1e6;
    print!(
        "{what:<26} {megabytes:.0} MB: {:>6.0} MB/s",
        megabytes / seconds
    );
    if let (Some(before), Some(after)) = (busy, after) {
        print!(
            ", {:>6.0} MB per second of processor",
            megabytes / (after - before).max(0.01)
        );
    }
    println!();
    result
}

/// Processor seconds of all threads that the work took; seconds by the clock where the system does not tell.
pub fn seconds(work: impl FnOnce()) -> f64 {
    let (start, busy) = (Instant::now(), processor_seconds());
    work();
    match (busy, processor_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => start.elapsed().as_secs_f64(),
    }
}

/// Of all threads, in hundredths of seconds.
fn processor_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut words = text.rsplit(')').next()?.split_whitespace().skip(11);
    let user: f64 = words.next()?.parse().ok()?;
    let system: f64 = words.next()?.parse().ok()?;
    Some((user + system) / 100.0)
}

/// The most memory this process ever had, where the system tells.
pub fn peak() -> String {
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|status| {
            let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
            Some(line.split_once(':')?.1.trim().to_string())
        })
        .unwrap_or_else(|| "not known".to_string())
}
