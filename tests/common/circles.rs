//! Dependencies between source files of a crate, and the circles among them.

use std::collections::{BTreeMap, BTreeSet};

type Path = Vec<String>;

/// Returns the circular dependencies between files, each sorted by name. `files` holds paths below `src` and texts.
///
/// Code after `#[cfg(test)]` and re-exports of a `mod.rs` do not count.
pub fn circles(files: &[(String, String)]) -> Vec<Vec<String>> {
    let modules: BTreeMap<Path, (&str, String)> = files
        .iter()
        .map(|(path, text)| (module_of(path), (path.as_str(), code_of(text))))
        .collect();
    let mut handed: BTreeMap<(Path, String), Path> = BTreeMap::new();
    let mut named: BTreeMap<&Path, Vec<Path>> = BTreeMap::new();
    for (module, (path, code)) in &modules {
        for (public, use_path) in paths(code) {
            let Some(whole) = absolute(module, &use_path, &modules) else {
                continue;
            };
            if public && let Some(name) = use_path.last() {
                handed.insert((module.clone(), name.clone()), whole.clone());
            }
            if !(public && path.ends_with("mod.rs")) {
                named.entry(module).or_default().push(whole);
            }
        }
    }
    let resolve = |path: &Path| {
        let mut path = path.clone();
        for _ in 0..6 {
            let length = (0..=path.len())
                .rev()
                .find(|n| modules.contains_key(&path[..*n]))?;
            let (module, rest) = (path[..length].to_vec(), &path[length..]);
            match rest
                .first()
                .and_then(|name| handed.get(&(module.clone(), name.clone())))
            {
                Some(target) if *target != path => {
                    let mut next = target.clone();
                    next.extend_from_slice(&rest[1..]);
                    path = next;
                }
                _ => return Some(module),
            }
        }
        None
    };
    let mut reached: BTreeMap<&Path, BTreeSet<Path>> = BTreeMap::new();
    for (module, uses) in &named {
        let own: BTreeSet<Path> = uses
            .iter()
            .filter_map(&resolve)
            .filter(|to| to != *module)
            .collect();
        reached.insert(module, own);
    }
    // Transitive closure: all modules reachable over any number of files.
    loop {
        let mut grown = false;
        for module in modules.keys() {
            let further: BTreeSet<Path> = reached
                .get(module)
                .into_iter()
                .flatten()
                .filter_map(|to| reached.get(to))
                .flatten()
                .cloned()
                .collect();
            let own = reached.entry(module).or_default();
            let before = own.len();
            own.extend(further);
            grown |= own.len() > before;
        }
        if !grown {
            break;
        }
    }
    let circle = |module: &Path| -> Vec<String> {
        let both =
            |other: &&Path| reached[module].contains(*other) && reached[*other].contains(module);
        modules
            .keys()
            .filter(both)
            .map(|other| modules[other].0.to_string())
            .collect()
    };
    let found: BTreeSet<Vec<String>> = modules
        .keys()
        .filter(|module| reached[*module].contains(*module))
        .map(circle)
        .collect();
    found.into_iter().collect()
}

/// Returns the module path of a file: `a/b.rs` and `a/b/mod.rs` are a::b.
fn module_of(path: &str) -> Path {
    let mut parts: Path = path
        .trim_end_matches(".rs")
        .split('/')
        .map(str::to_string)
        .collect();
    if parts.last().is_some_and(|last| last == "mod") {
        parts.pop();
    }
    parts
}

/// Returns the code without comments and without the test module.
fn code_of(text: &str) -> String {
    let code = text.split("\nmod tests {").next().unwrap_or_default();
    let lines = code
        .lines()
        .map(|line| line.split("//").next().unwrap_or_default());
    lines.collect::<Vec<_>>().join("\n")
}

/// Returns all paths that begin with `crate`, `self` or `super` or follow `use`; the flag is true for a re-export.
fn paths(code: &str) -> Vec<(bool, Path)> {
    let (mut out, mut rest) = (Vec::new(), String::new());
    let mut lines = code.lines();
    while let Some(line) = lines.next() {
        let trimmed = line.trim_start();
        let public = trimmed.starts_with("pub");
        let after = match trimmed.split_once("use ") {
            Some((before, after))
                if before.is_empty() || (public && !before.contains(['=', '{'])) =>
            {
                after
            }
            _ => {
                rest.push_str(line);
                rest.push('\n');
                continue;
            }
        };
        let mut tree = after.to_string();
        while !tree.contains(';') {
            let Some(next) = lines.next() else { break };
            tree.push_str(next);
        }
        expand(
            &[],
            tree.split(';').next().unwrap_or_default(),
            &mut |path| out.push((public, path)),
        );
    }
    for start in ["crate::", "self::", "super::"] {
        for (at, _) in rest.match_indices(start) {
            if rest[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == ':') {
                continue;
            }
            let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
            let text: String = rest[at..].chars().take_while(|c| is_path(*c)).collect();
            let parts = text.split("::").filter(|part| !part.is_empty());
            out.push((false, parts.map(str::to_string).collect()));
        }
    }
    out
}

/// Expands a tree of `use` into single paths.
fn expand(prefix: &[String], tree: &str, put: &mut dyn FnMut(Path)) {
    let (head, group) = match tree.split_once('{') {
        Some((head, rest)) => (head, rest.rsplit_once('}').map(|(inside, _)| inside)),
        None => (tree.split(" as ").next().unwrap_or_default(), None),
    };
    let mut path = prefix.to_vec();
    let parts = head
        .split("::")
        .map(str::trim)
        .filter(|part| !part.is_empty());
    path.extend(parts.map(str::to_string));
    let Some(group) = group else {
        return put(path);
    };
    let (mut depth, mut start) = (0_usize, 0);
    for (at, c) in group.char_indices().chain([(group.len(), ',')]) {
        match c {
            '{' => depth += 1,
            '}' => depth = depth.saturating_sub(1),
            ',' if depth == 0 => {
                let part = group[start..at].trim();
                if !part.is_empty() {
                    expand(&path, part, put);
                }
                start = at + 1;
            }
            _ => {}
        }
    }
}

/// Converts a path to one from the root of the crate; `None` for a path of another crate.
fn absolute(module: &Path, path: &Path, modules: &BTreeMap<Path, (&str, String)>) -> Option<Path> {
    let mut base = module.clone();
    let mut rest = path.as_slice();
    match rest.first()?.as_str() {
        "crate" => {
            base.clear();
            rest = &rest[1..];
        }
        "self" => rest = &rest[1..],
        "super" => {
            while rest.first().is_some_and(|part| part == "super") {
                base.pop();
                rest = &rest[1..];
            }
        }
        first => {
            base.push(first.to_string());
            if !modules.contains_key(&base) {
                return None;
            }
            rest = &rest[1..];
        }
    }
    base.extend_from_slice(rest);
    Some(base)
}
