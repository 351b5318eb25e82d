//! Measurements of this process by the system: processor time and memory.
#![allow(dead_code)] // Each bench uses its own part.

use std::time::Instant;

/// Runs `work` and prints its rate in megabytes per second; `bytes` returns the number of bytes processed.
///
/// The rate is given by the clock and, where the system provides it, by the processor time of all threads. On a busy machine only the
/// latter is meaningful.
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

/// Returns the processor time of all threads during the work, in seconds; clock time if the system provides no processor time.
pub fn seconds(work: impl FnOnce()) -> f64 {
    let (start, busy) = (Instant::now(), processor_seconds());
    work();
    match (busy, processor_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => start.elapsed().as_secs_f64(),
    }
}

/// Returns the processor time of all threads in seconds, with a resolution of a hundredth.
fn processor_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    let mut words = text.rsplit(')').next()?.split_whitespace().skip(11);
    let user: f64 = words.next()?.parse().ok()?;
    let system: f64 = words.next()?.parse().ok()?;
    Some((user + system) / 100.0)
}

/// Returns the peak memory of this process, if the system provides it.
pub fn peak() -> String {
    std::fs::read_to_string("/proc/self/status")
        .ok()
        .and_then(|status| {
            let line = status.lines().find(|line| line.starts_with("VmHWM"))?;
            Some(line.split_once(':')?.1.trim().to_string())
        })
        .unwrap_or_else(|| "not known".to_string())
}
