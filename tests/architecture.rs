//! Architecture rules beyond the compiler: layers inside crates, circular dependencies, file sizes, and up-to-date generated code.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

#[path = "common/circles.rs"]
mod circles;
mod common;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns all Rust files in the project's own folders, as pairs of path (from the root) and text.
fn rust_files() -> Vec<(String, String)> {
    let mut found = Vec::new();
    for folder in ["src", "tests", "grammar/src"] {
        for path in common::files_below(&root().join(folder), "rs") {
            let shown = path
                .strip_prefix(root())
                .expect("below the root")
                .to_string_lossy()
                .replace('\\', "/");
            found.push((shown, fs::read_to_string(&path).expect("readable file")));
        }
    }
    found
}

/// Returns the names of all crates: folders below `src` with their own manifest, and `""` for the top-level package.
fn crates() -> Vec<String> {
    let mut found: Vec<String> = fs::read_dir(root().join("src"))
        .expect("src")
        .map(|entry| entry.expect("readable entry").path())
        .filter(|path| path.join("Cargo.toml").exists())
        .map(|path| {
            path.file_name()
                .expect("a name")
                .to_string_lossy()
                .to_string()
        })
        .collect();
    found.sort();
    assert!(found.len() > 10, "the crates are gone: {found:?}");
    found
}

/// Returns the crate of a file below `src` and the path inside it; the top-level package is the crate with an empty name.
fn inside<'a>(crates: &[String], path: &'a str) -> Option<(String, &'a str)> {
    let below = path.strip_prefix("src/")?;
    let own = below
        .split_once('/')
        .filter(|(first, _)| crates.iter().any(|c| c == first));
    Some(own.map_or((String::new(), below), |(name, rest)| {
        (name.to_string(), rest)
    }))
}

/// Layers of each crate that has several, from the bottom up, as folder names; `""` is the rest of the crate.
const ROOMS: [(&str, &[&str]); 6] = [
    ("syntax", &["text", "units", "diagnostic", "grammar", ""]),
    (
        "solver",
        &[
            "mechanics",
            "linear",
            "model",
            "function",
            "element",
            "constraint",
            "system",
            "statics",
            "motion",
        ],
    ),
    ("session", &["", "check", "backend"]),
    ("identify", &["settings", "priors", "tolerance", ""]),
    ("sweep", &["", "uncertainty"]),
    ("", &["front", "cli", "python"]),
];

/// Returns the top-level modules that a piece of code names as `crate::x` or `crate::{x, y::z}`.
fn crate_modules(code: &str) -> BTreeSet<String> {
    let word = |text: &str| -> String {
        text.chars()
            .take_while(|c| c.is_alphanumeric() || *c == '_')
            .collect()
    };
    let mut found = BTreeSet::new();
    for (at, _) in code.match_indices("crate::") {
        if code[..at].ends_with(|c: char| c == '$' || c == '_' || c.is_alphanumeric()) {
            continue;
        }
        let rest = &code[at + "crate::".len()..];
        let Some(group) = rest.strip_prefix('{') else {
            found.insert(word(rest));
            continue;
        };
        let (mut depth, mut fresh) = (0_usize, true);
        for (i, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' if depth == 0 => break,
                '}' => depth -= 1,
                ',' if depth == 0 => fresh = true,
                c if fresh && !c.is_whitespace() => {
                    found.insert(word(&group[i..]));
                    fresh = false;
                }
                _ => {}
            }
        }
    }
    found
}

/// Returns the text of a file without its comment lines.
fn without_comments(text: &str) -> String {
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n")
}

/// Checks the layers inside crates; between crates the compiler enforces them.
#[test]
fn imports_point_down_inside_of_crates() {
    let crates = crates();
    let mut wrong = Vec::new();
    for (path, text) in rust_files() {
        let Some((own, rest)) = inside(&crates, &path) else {
            continue;
        };
        let Some((_, rooms)) = ROOMS.iter().find(|(of, _)| *of == own) else {
            continue;
        };
        let first = rest.split(['/', '.']).next().expect("a first piece");
        if ["lib", "bin", "build"].contains(&first) {
            continue;
        }
        let floor = |module: &str| {
            let named = rooms.iter().position(|room| *room == module);
            named.or_else(|| rooms.iter().position(|room| room.is_empty()))
        };
        let Some(mine) = floor(first) else {
            wrong.push(format!("{path}: `{first}` is no room of `{own}`"));
            continue;
        };
        for used in crate_modules(&without_comments(&text)) {
            if floor(&used).is_some_and(|other| other > mine) {
                wrong.push(format!(
                    "{path}: `{first}` uses `{used}`, which is above it"
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Returns the crates in the table of the front page, `| crate | what it owns |`, which lists them from the bottom up.
fn table() -> Vec<String> {
    let text = fs::read_to_string(root().join("src/lib.rs")).expect("src/lib.rs");
    let rows = text
        .lines()
        .filter_map(|line| line.strip_prefix("//! | `admire-"));
    rows.filter_map(|row| Some(row.split_once('`')?.0.to_string()))
        .collect()
}

#[test]
fn the_table_of_the_first_page_lists_the_crates_from_the_bottom_up() {
    let table = table();
    let mut sorted = table.clone();
    sorted.sort();
    assert_eq!(sorted, crates());
    for (at, name) in table.iter().enumerate() {
        let manifest =
            fs::read_to_string(root().join(format!("src/{name}/Cargo.toml"))).expect("a manifest");
        let used = manifest
            .lines()
            .filter_map(|line| line.strip_prefix("admire-")?.split_once('.'));
        for (other, _) in used {
            let place = table.iter().position(|own| own == other);
            assert!(
                place.is_some_and(|place| place < at),
                "`{name}` uses `{other}`, which is above it"
            );
        }
    }
}

#[test]
fn every_crate_says_what_it_is_for() {
    for name in crates() {
        let text = fs::read_to_string(root().join(format!("src/{name}/lib.rs"))).expect("lib.rs");
        let docs = text
            .lines()
            .take_while(|line| line.starts_with("//!"))
            .count();
        assert!(docs >= 3, "src/{name}/lib.rs says little of itself");
        assert!(
            text.contains("\n#![warn(unreachable_pub)]\n"),
            "src/{name}/lib.rs"
        );
    }
}

/// Checks that only the public interface and its types are documented; modules used only by tests and programs are hidden.
#[test]
fn the_first_page_documents_the_front() {
    let text = fs::read_to_string(root().join("src/lib.rs")).expect("src/lib.rs");
    let lines: Vec<&str> = text.lines().collect();
    let documented: Vec<_> = lines
        .windows(2)
        .filter(|pair| pair[0] != "#[doc(hidden)]")
        .filter_map(|pair| pair[1].strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    assert_eq!(documented, Vec::<&str>::new());
    assert!(lines.contains(&"#![warn(unreachable_pub)]"));
}

/// Maximum total number of files in circular dependencies.
const MOST_IN_CIRCLES: usize = 6;

/// Allowed circular dependencies, each by one of its files, with the reason. A circle that no longer exists must leave this list.
const ALLOWED: [(&str, &str); 2] = [
    (
        "solver/function/build.rs",
        "a function calls functions: the grammar of expressions is recursive",
    ),
    (
        "lsp/document.rs",
        "a document checks an excerpt of itself after an edit",
    ),
];

#[test]
fn no_circles_of_files_but_those_named() {
    let crates = crates();
    let mut files: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for (path, text) in rust_files() {
        let Some((own, rest)) = inside(&crates, &path) else {
            continue;
        };
        if rest.starts_with("bin/") || rest == "build.rs" {
            continue;
        }
        // The first file of a crate re-exports the items of its modules, like a `mod.rs`.
        let rest = if rest == "lib.rs" { "mod.rs" } else { rest };
        files.entry(own).or_default().push((rest.to_string(), text));
    }
    let mut found: Vec<Vec<String>> = Vec::new();
    for (own, files) in &files {
        let circles = circles::circles(files).into_iter();
        let full = |file: &String| format!("{own}/{file}").trim_start_matches('/').to_string();
        found.extend(circles.map(|circle| circle.iter().map(full).collect()));
    }
    let is_allowed =
        |circle: &&Vec<String>| ALLOWED.iter().any(|(of, _)| circle.iter().any(|f| f == of));
    let new: Vec<_> = found.iter().filter(|circle| !is_allowed(circle)).collect();
    assert!(new.is_empty(), "new circles of files: {new:#?}");
    let gone: Vec<_> = ALLOWED
        .iter()
        .filter(|(of, _)| !found.iter().flatten().any(|file| file == of))
        .collect();
    assert!(gone.is_empty(), "no circle any more: {gone:?}");
    // No circle may grow.
    let files_in_circles: usize = found.iter().map(Vec::len).sum();
    assert!(
        files_in_circles <= MOST_IN_CIRCLES,
        "{files_in_circles} {found:#?}"
    );
}

#[test]
fn circles_are_found() {
    let file = |path: &str, text: &str| (path.to_string(), text.to_string());
    let files = [
        file(
            "a/mod.rs",
            "mod x;\nmod y;\nmod z;\npub use x::{X, Other as Renamed};",
        ),
        file("a/x.rs", "use super::y::{self, Y};"),
        file("a/y.rs", "use super::X;\nuse std::fmt;"),
        file(
            "a/z.rs",
            "fn f() -> crate::a::y::Y { todo() }\n// use super::z;",
        ),
        file(
            "b.rs",
            "use crate::a::X;\n#[cfg(test)]\nmod tests {\n use crate::c::C;\n}",
        ),
        file("c.rs", "use crate::b::B;"),
    ];
    assert_eq!(circles::circles(&files), [["a/x.rs", "a/y.rs"]]);
}

#[test]
fn files_are_short() {
    let mut long = Vec::new();
    for (path, text) in rust_files() {
        let lines = text.lines().count();
        let limit = match path.as_str() {
            "src/syntax/grammar/generated.rs" => continue,
            path if path.starts_with("src/bin/") => 29,
            _ => 600,
        };
        if lines > limit {
            long.push(format!("{path}: {lines} lines, the limit is {limit}"));
        }
    }
    assert!(long.is_empty(), "{}", long.join("\n"));
}

#[test]
fn nothing_is_left_unfinished() {
    let mut wrong = Vec::new();
    for (path, text) in rust_files() {
        // A file named `tests.rs` is compiled for tests only.
        if !path.starts_with("src/") || path.ends_with("/tests.rs") {
            continue;
        }
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for word in [
            ".unwrap()",
            "todo!(",
            "unimplemented!(",
            "dbg!(",
            "Result<_, String>",
        ] {
            if without_comments(code).contains(word) {
                wrong.push(format!("{path}: `{word}`"));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Checks that solvers and fits take sines, exponentials and powers from a crate and not from the system's C library.
///
/// A deck then has the same solution on every system.
#[test]
fn solutions_do_not_depend_on_the_c_library() {
    let folders = [
        "syntax",
        "solver",
        "session",
        "study",
        "rig",
        "kc",
        "tune",
        "identify",
        "diagnosis",
        "design",
        "report",
        "sweep/uncertainty",
    ];
    let functions = [
        "sin", "cos", "tan", "sin_cos", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh",
        "exp", "exp2", "exp_m1", "ln", "ln_1p", "log", "log2", "log10", "powf", "hypot", "cbrt",
    ];
    let mut wrong = Vec::new();
    for (path, text) in rust_files() {
        let below = |folder: &&str| path.starts_with(&format!("src/{folder}/"));
        if !folders.iter().any(below) || path.contains("/tests") || path.ends_with("/golden.rs") {
            continue;
        }
        let code = without_comments(text.split("#[cfg(test)]").next().unwrap_or_default());
        for function in functions {
            if code.contains(&format!(".{function}("))
                || code.contains(&format!("f64::{function})"))
            {
                wrong.push(format!("{path}: `{function}`"));
            }
        }
    }
    assert!(wrong.is_empty(), "libm:: instead: {}", wrong.join("\n"));
}

#[test]
fn the_generated_tables_are_fresh() {
    let grammar = grammar::read(&root().join("grammar")).unwrap_or_else(|e| panic!("{e}"));
    let committed =
        fs::read_to_string(root().join("src/syntax/grammar/generated.rs")).expect("generated.rs");
    assert!(
        committed == grammar::emit(&grammar),
        "src/syntax/grammar/generated.rs is stale: cargo run -p grammar"
    );
    let page =
        fs::read_to_string(root().join("src/guide/coverage.md")).expect("src/guide/coverage.md");
    assert!(
        grammar::with_coverage(&page, &grammar).as_ref() == Some(&page),
        "the coverage table of the guide is stale: cargo run -p grammar"
    );
    let colours = "src/lsp/vscode/syntaxes/adams.tmLanguage.json";
    assert!(
        fs::read_to_string(root().join(colours)).expect(colours) == grammar::textmate(&grammar),
        "{colours} is stale: cargo run -p grammar"
    );
}

/// Checks that all packages inherit the ban on `unsafe` and that no file overrides it; the crate that calls Python is exempt.
#[test]
fn nothing_is_unsafe() {
    let workspace = fs::read_to_string(root().join("Cargo.toml")).expect("Cargo.toml");
    assert!(workspace.contains("\nunsafe_code = \"deny\"\n"));
    let own = crates()
        .into_iter()
        .map(|name| format!("src/{name}/Cargo.toml"));
    let packages = ["Cargo.toml", "grammar/Cargo.toml"].map(str::to_string);
    for manifest in own.chain(packages) {
        let text = fs::read_to_string(root().join(&manifest)).expect("a manifest");
        assert!(
            text.contains("\n[lints]\nworkspace = true\n"),
            "{manifest} has lints of its own"
        );
    }
    let asks: Vec<_> = rust_files()
        .into_iter()
        .filter(|(path, text)| !path.starts_with("src/python") && text.contains("unsafe_code"))
        .map(|(path, _)| path)
        .filter(|path| path != "tests/architecture.rs")
        .collect();
    assert_eq!(asks, Vec::<String>::new());
}

#[test]
fn crate_modules_are_found_in_every_spelling() {
    let code = "use crate::text::{Edit, Span}; use crate::{units, model::Part}; fn f(x: crate::syntax::Address) {}";
    let found: Vec<_> = crate_modules(code).into_iter().collect();
    assert_eq!(found, ["model", "syntax", "text", "units"]);
}
