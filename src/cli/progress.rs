//! Progress of a command: stage, count, rate and remaining time. On a terminal, it appears after half a second. Without a terminal, one
//! line is printed per minute.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use admire_diagnosis::ProgressObserver;

use super::format::Format;
use super::interrupt;
use super::shell::Shell;

/// Delay before progress is shown on a terminal.
const PATIENCE: Duration = Duration::from_millis(500);
/// Interval between progress lines without a terminal.
const MINUTE: Duration = Duration::from_secs(60);
/// Interval between updates of the display.
const TICK: Duration = Duration::from_millis(120);

/// Number of finished items, with an upper bound and a name.
#[derive(Clone, Copy, Debug)]
pub(super) struct Count {
    /// Number of items finished so far.
    pub done: usize,
    /// Upper bound of the total number of items, if known.
    pub of: Option<usize>,
    /// Name of the counted items, in the plural.
    pub what: &'static str,
}

/// Smallest number of finished items for an estimate of the remaining time.
const SETTLED: usize = 2;
/// Smallest share of finished items for an estimate of the remaining time.
const SETTLED_SHARE: f64 = 0.02;

/// Displayed state of a command: the stage, a detail, and the finished items.
#[derive(Clone, Debug, Default)]
struct State {
    stage: String,
    detail: String,
    count: Option<Count>,
}

/// Progress display. On a terminal it is one line, which disappears when this value is dropped. Without a terminal, one line is printed per
/// minute.
pub(super) struct Progress {
    state: Arc<Mutex<State>>,
    ended: Arc<AtomicBool>,
    painter: Option<JoinHandle<()>>,
    /// True if each stage is printed as a line, for verbose output without a terminal.
    lines: bool,
}

impl Progress {
    /// Starts the display. `look` is called at every tick, even if nothing is shown, and returns the current stage and count.
    pub(crate) fn new(
        stage: &str,
        shell: &Shell,
        look: impl Fn() -> Option<(&'static str, Count)> + Send + 'static,
    ) -> Self {
        let state = Arc::new(Mutex::new(State::default()));
        let ended = Arc::new(AtomicBool::new(false));
        let shown = (Arc::clone(&state), Arc::clone(&ended));
        let terminal = shell.shows_progress();
        let speaks = shell.format == Format::Text && !shell.is_quiet();
        let lines = shell.is_verbose() && !terminal;
        let painter = std::thread::spawn(move || {
            if terminal {
                paint(&shown.0, &shown.1, &look);
            } else {
                report(&shown.0, &shown.1, &look, (lines, speaks));
            }
        });
        let progress = Self {
            state,
            ended,
            painter: Some(painter),
            lines,
        };
        progress.stage(stage);
        progress
    }
}

impl ProgressObserver for Progress {
    fn stage(&self, stage: &str) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.stage == stage {
            return;
        }
        *state = State {
            stage: stage.to_string(),
            ..State::default()
        };
        if self.lines {
            eprintln!("{stage}");
        }
    }

    fn detail(&self, detail: String) {
        if self.lines {
            eprintln!("  {detail}");
        }
        self.state
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .detail = detail;
    }

    fn count(&self, done: usize, most: Option<usize>, what: &'static str) {
        self.state
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .count = Some(Count {
            done,
            of: most,
            what,
        });
    }

    fn goes_on(&self) -> bool {
        !interrupt::asked()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(painter) = self.painter.take() {
            painter.thread().unpark();
            // A painter thread that has panicked needs no cleanup.
            let _ = painter.join();
        }
    }
}

/// Prints a line per minute if `speaks` is true, and a line for each new stage that `look` returns if `stages` is true.
fn report(
    state: &Mutex<State>,
    ended: &AtomicBool,
    look: &dyn Fn() -> Option<(&'static str, Count)>,
    (stages, speaks): (bool, bool),
) {
    let (began, mut last, mut minutes) = (Instant::now(), "", 1);
    while !ended.load(Ordering::Relaxed) {
        let now = present(state, look);
        if let (true, Some((stage, _))) = (stages, look())
            && !stage.is_empty()
            && stage != last
        {
            eprintln!("{stage}");
            last = stage;
        }
        if speaks && began.elapsed() >= MINUTE * minutes {
            eprintln!("{}", line(&now, began.elapsed()));
            minutes += 1;
        }
        std::thread::park_timeout(TICK);
    }
}

/// Returns the displayed state: the state set by the command, overridden by the result of `look`.
fn present(state: &Mutex<State>, look: &dyn Fn() -> Option<(&'static str, Count)>) -> State {
    let mut now = state.lock().unwrap_or_else(PoisonError::into_inner).clone();
    if let Some((stage, count)) = look() {
        now.stage = stage.to_string();
        now.count = Some(count);
    }
    now
}

/// Paints the progress line until the command has ended.
fn paint(
    state: &Mutex<State>,
    ended: &AtomicBool,
    look: &dyn Fn() -> Option<(&'static str, Count)>,
) {
    let began = Instant::now();
    let style = ProgressStyle::with_template("{spinner} {msg}").expect("the template is valid");
    let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::hidden()).with_style(style);
    let mut visible = false;
    while !ended.load(Ordering::Relaxed) {
        if !visible && began.elapsed() >= PATIENCE {
            bar.set_draw_target(ProgressDrawTarget::stderr());
            visible = true;
        }
        bar.set_message(line(&present(state, look), began.elapsed()));
        bar.tick();
        std::thread::park_timeout(TICK);
    }
    bar.finish_and_clear();
}

/// Formats the progress line.
///
/// If the total is known: `cases: 812 of 3000 cases (27 %) · 61/s · at most 36 s more · 13 s`.
/// If the total is unknown: `search: 812 sweeps · 61/s · 13 s`.
fn line(state: &State, elapsed: Duration) -> String {
    let mut pieces = Vec::new();
    if !state.detail.is_empty() {
        pieces.push(state.detail.clone());
    }
    let seconds = elapsed.as_secs_f64();
    if let Some(Count { done, of, what }) = state.count.filter(|count| count.done > 0) {
        let rate = done as f64 / seconds.max(1e-3);
        pieces.push(match of {
            Some(most) => {
                let share = 100.0 * done as f64 / most.max(1) as f64;
                format!("{done} of {most} {what} ({share:.0} %)")
            }
            None => format!("{done} {what}"),
        });
        let digits = usize::from(rate < 10.0);
        pieces.push(format!("{rate:.digits$}/s"));
        let settled = |most: &usize| done >= SETTLED && done as f64 >= SETTLED_SHARE * *most as f64;
        if let Some(left) = of.filter(settled) {
            let left = span(left.saturating_sub(done) as f64 / rate);
            pieces.push(format!("at most {left} more"));
        }
    }
    pieces.push(span(seconds));
    format!("{}: {}", state.stage, pieces.join(" · "))
}

/// Formats a duration, such as `40 s` or `12 min`.
fn span(seconds: f64) -> String {
    if seconds < 120.0 {
        format!("{seconds:.0} s")
    } else {
        format!("{:.0} min", seconds / 60.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_tells_stage_count_rate_and_what_is_left() {
        let state = State {
            stage: "search".to_string(),
            detail: String::new(),
            count: Some(Count {
                done: 600,
                of: Some(3000),
                what: "runs",
            }),
        };
        assert_eq!(
            line(&state, Duration::from_secs(10)),
            "search: 600 of 3000 runs (20 %) · 60/s · at most 40 s more · 10 s"
        );
        // With slow items, a rate is shown from the second item on.
        let state = State {
            count: Some(Count {
                done: 4,
                of: Some(13),
                what: "cases",
            }),
            ..state
        };
        assert_eq!(
            line(&state, Duration::from_secs(8)),
            "search: 4 of 13 cases (31 %) · 0.5/s · at most 18 s more · 8 s"
        );
        // If the total is unknown, no remaining time is shown.
        let search = State {
            count: Some(Count {
                done: 60,
                of: None,
                what: "sweeps",
            }),
            ..state
        };
        assert_eq!(
            line(&search, Duration::from_secs(10)),
            "search: 60 sweeps · 6.0/s · 10 s"
        );
        assert_eq!(
            line(
                &State {
                    stage: "fit".to_string(),
                    ..State::default()
                },
                Duration::from_secs(2)
            ),
            "fit: 2 s"
        );
    }
}
