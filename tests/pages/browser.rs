use std::path::{Path, PathBuf};
use std::process::Command;

use crate::common::skipped;

/// Report of a page about itself, after it was loaded and its controls were used.
#[derive(serde::Deserialize, Debug)]
pub struct Seen {
    /// Errors of scripts and of the console.
    pub errors: Vec<String>,
    /// Width of the window, and width of its content.
    pub window: f64,
    pub content: f64,
    /// For each chart or map, whether it has a size and a drawing.
    pub pictures: Vec<bool>,
    /// For each three-dimensional view, the number of drawn pixels, and the controls that change them.
    pub scenes: Vec<SceneSeen>,
    /// For each chart, its response to the pointer.
    pub charts: Vec<ChartSeen>,
    /// Addresses outside of the page.
    pub outside: Vec<String>,
}

/// Response of a chart to the pointer.
#[derive(serde::Deserialize, Debug)]
pub struct ChartSeen {
    /// Whether a point shows its value.
    pub value: bool,
    /// Whether a dragged frame zooms.
    pub zoomed: bool,
}

/// Controls that changed the picture of a view.
#[derive(serde::Deserialize, Debug)]
pub struct SceneSeen {
    /// Pixels that are not empty.
    pub drawn: usize,
    /// Whether an arrow key turned it.
    pub key: bool,
    /// Whether a drag turned it.
    pub drag: bool,
    /// Whether the slider of displacements moved it; absent without one.
    pub slider: Option<bool>,
    /// Whether the next step or case moved it; absent without one.
    pub step: Option<bool>,
    /// For each named view: left, right, top and bottom of the drawing as fractions of the canvas, and the horizontal position of its upper
    /// third.
    pub views: std::collections::BTreeMap<String, [f64; 5]>,
}

/// Returns the browser; prints a notice and returns `None` if there is none.
pub fn chromium() -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&path)
        .flat_map(|folder| {
            ["chromium", "chromium-browser", "google-chrome"].map(|name| folder.join(name))
        })
        .find(|program| program.is_file());
    if found.is_none() {
        assert!(
            std::env::var_os("ADMIRE_REQUIRE_CHROMIUM").is_none(),
            "Chromium is required and not installed"
        );
        skipped("Chromium is not installed");
    }
    found
}

const BEFORE: &str = "<script>window.seenErrors=[];\
addEventListener('error',e=>seenErrors.push(String(e.message)));\
addEventListener('unhandledrejection',e=>seenErrors.push(String(e.reason)));\
for(const k of ['error','warn'])console[k]=(...a)=>seenErrors.push(a.join(' '));</script>";

/// Script that runs in the page: it uses every control of every view and records the results.
const PROBE: &str = include_str!("probe.js");

/// Opens a page in a window of this width, and uses its controls.
///
/// The page is in a frame, because the browser's own windows have a minimum width.
pub fn open(chromium: &Path, page: &Path, width: u32, dark: bool) -> Seen {
    let text = std::fs::read_to_string(page).expect("readable page");
    let text = text.replacen("<head>", &format!("<head>{BEFORE}"), 1);
    let text = text.replacen("</body>", &format!("<script>{PROBE}</script></body>"), 1);
    let text = text.replace('&', "&amp;").replace('"', "&quot;");
    let outer = format!(
        "<!DOCTYPE html><meta charset=\"utf-8\"><body><iframe width=\"{width}\" height=\"900\" srcdoc=\"{text}\"></iframe>"
    );
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = folder.path().join("page.html");
    std::fs::write(&file, outer).expect("writable page");
    let mut command = Command::new(chromium);
    command
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-dev-shm-usage",
            "--disable-quic",
            "--no-first-run",
        ])
        .args([
            "--disable-background-networking",
            "--disable-component-update",
            "--disable-sync",
        ])
        .args([
            "--window-size=1400,1000",
            "--virtual-time-budget=20000",
            "--dump-dom",
        ])
        .arg(format!(
            "--user-data-dir={}",
            folder.path().join("profile").display()
        ));
    if dark {
        command.arg("--blink-settings=preferredColorScheme=0");
    }
    let out = command
        .arg(format!("file://{}", file.display()))
        .output()
        .expect("Chromium starts");
    let dom = String::from_utf8_lossy(&out.stdout);
    let seen = dom
        .split("<pre id=\"seen\">")
        .nth(1)
        .and_then(|rest| rest.split("</pre>").next())
        .unwrap_or_else(|| {
            panic!(
                "the page did not answer: {}",
                String::from_utf8_lossy(&out.stderr)
            )
        });
    let seen = seen
        .replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&amp;", "&");
    serde_json::from_str(&seen).unwrap_or_else(|error| panic!("{error}: {seen}"))
}

/// Checks the requirements on every page, in a wide and in a narrow window, light and dark.
pub fn sound(chromium: &Path, page: &Path) -> Seen {
    let mut widest = None;
    for (width, dark) in [(1200, false), (400, true)] {
        let seen = open(chromium, page, width, dark);
        let name = page.display();
        assert!(
            seen.errors.is_empty(),
            "{name} at {width}: {:?}",
            seen.errors
        );
        assert!(
            seen.outside.is_empty(),
            "{name} refers to {:?}",
            seen.outside
        );
        assert!(
            seen.content <= seen.window && seen.window <= f64::from(width),
            "{name} at {width}: {} wide",
            seen.content
        );
        assert!(
            seen.pictures.iter().all(|drawn| *drawn),
            "{name} at {width}: {:?}",
            seen.pictures
        );
        for chart in &seen.charts {
            assert!(chart.value && chart.zoomed, "{name} at {width}: {chart:?}");
        }
        for scene in &seen.scenes {
            assert!(scene.drawn > 300, "{name} at {width}: {scene:?}");
            assert!(scene.key && scene.drag, "{name} at {width}: {scene:?}");
        }
        widest.get_or_insert(seen);
    }
    widest.expect("two windows were opened")
}
