//! The house plan, held by machine: floors, file sizes, and generated code that is fresh.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

#[path = "common/circles.rs"]
mod circles;
mod common;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Every Rust file of the project's own folders, with its path from the root.
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

/// The floor table of the crate documentation: module and floor.
fn floors() -> BTreeMap<String, usize> {
    let text = fs::read_to_string(root().join("src/lib.rs")).expect("src/lib.rs");
    text.lines()
        .filter_map(|line| line.strip_prefix("//! | "))
        .filter_map(|row| {
            let mut cells = row.split(" | ");
            let floor = cells.next()?.trim().parse().ok()?;
            Some((cells.next()?.trim().to_string(), floor))
        })
        .collect()
}

/// The top-level modules a piece of code names as `crate::x` or `crate::{x, y::z}`.
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

/// The code of a file without its comment lines.
fn without_comments(text: &str) -> String {
    text.lines()
        .filter(|line| !line.trim_start().starts_with("//"))
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn imports_point_down() {
    let floors = floors();
    assert!(floors.len() > 10, "the floor table of src/lib.rs is gone");
    let mut wrong = Vec::new();
    for (path, text) in rust_files() {
        let Some(inside) = path.strip_prefix("src/") else {
            continue;
        };
        let module = inside.split(['/', '.']).next().expect("a first piece");
        if ["lib", "bin", "build"].contains(&module) {
            continue;
        }
        let Some(floor) = floors.get(module) else {
            wrong.push(format!("{path}: `{module}` is not in the floor table"));
            continue;
        };
        for used in crate_modules(&without_comments(&text)) {
            match floors.get(&used) {
                _ if used == module => {}
                None => wrong.push(format!("{path}: `crate::{used}` is not in the floor table")),
                Some(other) if other < floor => {}
                Some(other) => wrong.push(format!(
                    "{path}: `{module}` (floor {floor}) uses `{used}` (floor {other})"
                )),
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_floor_table_lists_what_there_is() {
    let listed: BTreeSet<String> = floors().into_keys().collect();
    let mut there = BTreeSet::new();
    for entry in fs::read_dir(root().join("src")).expect("src") {
        let path: PathBuf = entry.expect("readable entry").path();
        let name = path
            .file_stem()
            .expect("a name")
            .to_string_lossy()
            .to_string();
        if !["lib", "bin", "build"].contains(&name.as_str()) {
            there.insert(name);
        }
    }
    assert_eq!(there, listed);
}

/// Programs see the front, the types it answers with, and the guide; rooms are for this crate, its tests and benches.
#[test]
fn rooms_are_not_documented() {
    let text = fs::read_to_string(root().join("src/lib.rs")).expect("src/lib.rs");
    let lines: Vec<&str> = text.lines().collect();
    let documented: Vec<_> = lines
        .windows(2)
        .filter(|pair| pair[0] != "#[doc(hidden)]")
        .filter_map(|pair| pair[1].strip_prefix("pub mod ")?.strip_suffix(';'))
        .collect();
    assert_eq!(documented, ["guide"]);
    assert!(lines.contains(&"#![warn(unreachable_pub)]"));
}

/// Files in such circles at most.
const MOST_IN_CIRCLES: usize = 6;

/// Circles that may stand, by one file of each, and why. A circle that is gone must leave this list.
const ALLOWED: [(&str, &str); 2] = [
    (
        "function/build.rs",
        "a function calls functions: the grammar of expressions is recursive",
    ),
    (
        "lsp/document.rs",
        "a document checks an excerpt of itself after an edit",
    ),
];

#[test]
fn no_circles_of_files_but_those_named() {
    let files: Vec<(String, String)> = rust_files()
        .into_iter()
        .filter_map(|(path, text)| Some((path.strip_prefix("src/")?.to_string(), text)))
        .filter(|(path, _)| !path.starts_with("bin/") && path != "lib.rs" && path != "build.rs")
        .collect();
    let found = circles::circles(&files);
    let is_allowed =
        |circle: &&Vec<String>| ALLOWED.iter().any(|(of, _)| circle.iter().any(|f| f == of));
    let new: Vec<_> = found.iter().filter(|circle| !is_allowed(circle)).collect();
    assert!(new.is_empty(), "new circles of files: {new:#?}");
    let gone: Vec<_> = ALLOWED
        .iter()
        .filter(|(of, _)| !found.iter().flatten().any(|file| file == of))
        .collect();
    assert!(gone.is_empty(), "no circle any more: {gone:?}");
    // No circle grows.
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
            "src/grammar/generated.rs" => continue,
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

/// Sines, exponentials and powers of equilibria and fits come from a crate, not from the C library of the system: one deck has one
/// answer everywhere.
#[test]
fn solutions_do_not_depend_on_the_c_library() {
    let folders = [
        "mechanics",
        "element",
        "constraint",
        "function",
        "system",
        "linear",
        "statics",
        "session",
        "identify",
        "tolerance",
        "uncertainty",
        "rig",
        "motion",
        "kc",
        "discrepancy",
        "report",
        "model",
        "syntax",
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
        fs::read_to_string(root().join("src/grammar/generated.rs")).expect("generated.rs");
    assert!(
        committed == grammar::emit(&grammar),
        "src/grammar/generated.rs is stale: cargo run -p grammar"
    );
    let page =
        fs::read_to_string(root().join("src/guide/coverage.md")).expect("src/guide/coverage.md");
    assert!(
        grammar::with_coverage(&page, &grammar).as_ref() == Some(&page),
        "the coverage table of the guide is stale: cargo run -p grammar"
    );
}

/// The compiler refuses `unsafe` in both packages, and no file asks it to look away; what calls Python may.
#[test]
fn nothing_is_unsafe() {
    let workspace = fs::read_to_string(root().join("Cargo.toml")).expect("Cargo.toml");
    assert!(workspace.contains("\nunsafe_code = \"deny\"\n"));
    for manifest in ["Cargo.toml", "grammar/Cargo.toml"] {
        let text = fs::read_to_string(root().join(manifest)).expect("a manifest");
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
