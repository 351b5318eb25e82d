//! Runs many cases of one reader on all processors and keeps the smallest failing input for each failure.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, Once};
use std::time::{Duration, Instant};

use admire_syntax::diagnostic::Diagnostic;
use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;

use crate::mutation::mutated;
use crate::readers::reader;

/// Time limit of a case, generous enough for a busy machine. A case of a few thousand bytes that takes longer is a failure.
const SLOW: Duration = Duration::from_secs(20);
/// Time after which a running case aborts the program, so that a hang becomes a failure and not an endless test.
const HUNG: Duration = Duration::from_secs(180);
/// Maximum number of runs spent on shrinking one failing input.
const SHRINKING: usize = 400;

thread_local! {
    /// Location and message of the last panic in the current case of this thread; `None` outside a case.
    static LAST: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Installs a panic hook that records panics inside a case and prints all others as usual.
fn note_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let usual = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            let noted = LAST.with_borrow_mut(|last| {
                last.as_mut().map(|last| {
                    let place = info.location().map(ToString::to_string);
                    let payload = info.payload();
                    let text = payload.downcast_ref::<String>().map(String::as_str);
                    let text = text.or_else(|| payload.downcast_ref::<&str>().copied());
                    let message = text.unwrap_or_default();
                    *last = format!("{}: {message}", place.unwrap_or_default());
                })
            });
            if noted.is_none() {
                usual(info);
            }
        }));
    });
}

/// Returns the reason why a reader fails on an input, or `None` if it succeeds.
fn failure(target: impl Fn(&[u8]), bytes: &[u8]) -> Option<String> {
    LAST.set(Some(String::new()));
    let start = Instant::now();
    let ended = catch_unwind(AssertUnwindSafe(|| target(bytes)));
    let why = LAST.take().unwrap_or_default();
    match ended {
        Err(payload) if why.is_empty() => {
            // A panic on a helper thread leaves no record on this thread.
            let text = payload.downcast_ref::<String>().cloned();
            Some(text.unwrap_or_else(|| "a panic on another thread".to_string()))
        }
        Err(_) => Some(why),
        Ok(()) if start.elapsed() > SLOW => Some(format!("took {:?}", start.elapsed())),
        Ok(()) => None,
    }
}

/// Returns the source location of a failure. Failures at the same location count as the same.
fn place(why: &str) -> &str {
    why.split(": ").next().unwrap_or_default()
}

/// Returns a smaller input with the same failure, by removing pieces of decreasing length.
fn shrunk(target: impl Fn(&[u8]), bytes: &[u8], why: &str) -> Vec<u8> {
    let mut best = bytes.to_vec();
    let (mut piece, mut runs) = (best.len() / 2, 0);
    while piece > 0 && !why.starts_with("took") {
        let mut at = 0;
        while at < best.len() {
            let mut fewer = best.clone();
            fewer.drain(at..(at + piece).min(best.len()));
            runs += 1;
            if runs > SHRINKING {
                return best;
            }
            if failure(&target, &fewer).is_some_and(|other| place(&other) == place(why)) {
                best = fewer;
            } else {
                at += piece;
            }
        }
        piece /= 2;
    }
    best
}

/// Saves a failing input and returns its path.
fn kept(name: &str, bytes: &[u8]) -> PathBuf {
    let mut sum = 0xcbf2_9ce4_8422_2325_u64;
    for byte in bytes {
        sum = (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    }
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{sum:016x}"));
    std::fs::write(&path, bytes).expect("a place for failing inputs");
    path
}

fn variable(name: &str) -> Option<u64> {
    std::env::var(name).ok()?.parse().ok()
}

/// Background thread that aborts the program if a case hangs.
struct Watch {
    running: Arc<Mutex<BTreeMap<u64, (Instant, Vec<u8>)>>>,
    over: Arc<AtomicBool>,
}

impl Watch {
    fn new(name: &'static str) -> Self {
        let watch = Self {
            running: Arc::default(),
            over: Arc::default(),
        };
        let (running, over) = (watch.running.clone(), watch.over.clone());
        std::thread::spawn(move || {
            while !over.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(200));
                let running = running.lock().expect("no panic while it is held");
                for (case, (start, bytes)) in &*running {
                    if start.elapsed() > HUNG {
                        let path = kept(name, bytes);
                        eprintln!("{name}: case {case} hangs: {}", path.display());
                        std::process::abort();
                    }
                }
            }
        });
        watch
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        self.over.store(true, Ordering::Relaxed);
    }
}

/// Writes the seeds and the dictionary of a reader to files below a folder, for a coverage-guided fuzzer.
fn given_away(folder: &Path, name: &str, seeds: &[Vec<u8>], words: &[String]) {
    let place = folder.join(name).join("seeds");
    std::fs::create_dir_all(&place).expect("a folder for seeds");
    for (at, seed) in seeds.iter().enumerate() {
        std::fs::write(place.join(at.to_string()), seed).expect("a seed");
    }
    let quoted = words.iter().map(|word| {
        let escaped = word.bytes().map(|byte| match byte {
            b'"' | b'\\' => format!("\\{}", char::from(byte)),
            b' '..=b'~' => char::from(byte).to_string(),
            _ => format!("\\x{byte:02x}"),
        });
        format!("\"{}\"\n", escaped.collect::<String>())
    });
    let dictionary = quoted.collect::<String>();
    std::fs::write(folder.join(name).join("words"), dictionary).expect("a dictionary");
}

/// Runs a reader on every seed and then on `cases` mutations of the seeds; `FUZZ_CASES` overrides the number. The reader panics if a
/// property is violated. If `FUZZ_SEEDS` names a folder, the seeds and words are written to it instead.
pub fn fuzz(name: &'static str, cases: u64, seeds: &[Vec<u8>], words: &[String]) {
    let target = reader(name);
    if let Some(folder) = std::env::var_os("FUZZ_SEEDS") {
        return given_away(Path::new(&folder), name, seeds, words);
    }
    note_panics();
    let cases = variable("FUZZ_CASES").unwrap_or(cases);
    let from = variable("FUZZ_FROM").unwrap_or(0);
    let begin = Instant::now();
    let watch = Watch::new(name);
    let failures: Mutex<BTreeMap<String, (usize, Vec<u8>, String)>> = Mutex::default();
    let run = |case: u64, bytes: Vec<u8>| {
        let running = || watch.running.lock().expect("no panic while it is held");
        running().insert(case, (Instant::now(), bytes.clone()));
        let failed = failure(target, &bytes);
        running().remove(&case);
        if let Some(why) = failed {
            let mut failures = failures.lock().expect("no panic while it is held");
            let found = failures
                .entry(place(&why).to_string())
                .or_insert_with(|| (0, bytes.clone(), why.clone()));
            found.0 += 1;
            if bytes.len() < found.1.len() {
                *found = (found.0, bytes, why);
            }
        }
    };
    (0..seeds.len()).into_par_iter().for_each(|at| {
        run(u64::MAX - at as u64, seeds[at].clone());
    });
    (from..from + cases).into_par_iter().for_each(|case| {
        let mut random = Pcg64::seed_from_u64(case);
        run(case, mutated(seeds, words, &mut random));
    });
    let failures = failures.into_inner().expect("no panic while it is held");
    println!(
        "{name}: {} seeds, {cases} mutations, {} failures, {:.1} s",
        seeds.len(),
        failures.len(),
        begin.elapsed().as_secs_f64()
    );
    let mut told = Vec::new();
    for (count, bytes, why) in failures.values() {
        let path = kept(name, &shrunk(target, bytes, why));
        told.push(format!("{count} times, input {}: {why}", path.display()));
    }
    assert!(told.is_empty(), "{name}:\n{}", told.join("\n"));
}

/// Checks that the labels of diagnostics about `file` lie inside its bytes.
pub fn assert_inside(diagnostics: &[Diagnostic], file: &str, bytes: &[u8]) {
    for diagnostic in diagnostics {
        for label in &diagnostic.labels {
            let span = label.span;
            let inside = span.start() <= span.end() && span.end() <= bytes.len();
            assert!(
                inside || &*label.file != file,
                "{span:?} of {}: {diagnostic:?}",
                bytes.len()
            );
        }
    }
}
