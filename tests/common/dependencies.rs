//! What `.ci/deny.toml` says of the dependencies, held without cargo-deny: licences, doubles, bans and sources.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// The dependencies of the project on the systems that the settings name, as cargo resolves them: packages by their ids, and what
/// each needs.
struct Tree {
    packages: BTreeMap<String, Value>,
    needs: BTreeMap<String, Vec<String>>,
    members: Vec<String>,
}

impl Tree {
    fn read(root: &Path, settings: &toml::Table) -> Self {
        let targets = settings["graph"]["targets"].as_array().expect("targets");
        let read = |more: &[&str]| {
            let mut cargo = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".into()));
            cargo.current_dir(root).args(["metadata", "--locked"]);
            cargo.args(["--format-version", "1", "--all-features"]);
            for target in targets {
                cargo.args(["--filter-platform", target.as_str().expect("a target")]);
            }
            cargo.args(more).output().expect("cargo")
        };
        // What only another system needs is perhaps not here yet.
        let mut output = read(&["--offline"]);
        if !output.status.success() {
            output = read(&[]);
        }
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "cargo metadata: {said}");
        let all: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let list = |value: &Value| value.as_array().expect("a list").clone();
        let packages = list(&all["packages"]).into_iter();
        let needs = list(&all["resolve"]["nodes"]).into_iter().map(|node| {
            let deps = list(&node["deps"]).into_iter();
            (words(&node["id"]), deps.map(|d| words(&d["pkg"])).collect())
        });
        Self {
            packages: packages.map(|p| (words(&p["id"]), p)).collect(),
            needs: needs.collect(),
            members: list(&all["workspace_members"]).iter().map(words).collect(),
        }
    }

    /// Everything that these need, and they themselves.
    fn below(&self, mut left: Vec<String>) -> BTreeSet<String> {
        let mut found = BTreeSet::new();
        while let Some(id) = left.pop() {
            if found.insert(id.clone()) {
                left.extend(self.needs.get(&id).into_iter().flatten().cloned());
            }
        }
        found
    }
}

fn words(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_string()
}

/// Whether a licence in the words of SPDX can be met by the allowed ones.
fn is_met(licence: &str, allowed: &BTreeSet<&str>) -> bool {
    let spaced = licence
        .replace('/', " OR ")
        .replace('(', " ( ")
        .replace(')', " ) ");
    let words: Vec<&str> = spaced.split_whitespace().collect();
    let mut at = 0;
    let met = either(&words, &mut at, allowed);
    assert_eq!(at, words.len(), "{licence}");
    met
}

fn either(words: &[&str], at: &mut usize, allowed: &BTreeSet<&str>) -> bool {
    let mut met = both(words, at, allowed);
    while words.get(*at) == Some(&"OR") {
        *at += 1;
        met |= both(words, at, allowed);
    }
    met
}

fn both(words: &[&str], at: &mut usize, allowed: &BTreeSet<&str>) -> bool {
    let mut met = single(words, at, allowed);
    while words.get(*at) == Some(&"AND") {
        *at += 1;
        met &= single(words, at, allowed);
    }
    met
}

fn single(words: &[&str], at: &mut usize, allowed: &BTreeSet<&str>) -> bool {
    let word = words[*at];
    *at += 1;
    if word == "(" {
        let met = either(words, at, allowed);
        *at += 1;
        return met;
    }
    if words.get(*at) != Some(&"WITH") {
        return allowed.contains(word);
    }
    *at += 2;
    let whole = words[*at - 3..*at].join(" ");
    allowed.contains(whole.as_str())
}

/// True if `name@1.2` of the settings means this version.
fn means(pattern: &str, name: &str, version: &str) -> bool {
    let (wanted, part) = pattern.split_once('@').unwrap_or((pattern, ""));
    let rest = version.strip_prefix(part);
    wanted == name
        && rest.is_some_and(|rest| part.is_empty() || rest.is_empty() || rest.starts_with('.'))
}

#[test]
fn dependencies_are_what_the_settings_allow() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join(".ci/deny.toml")).expect(".ci/deny.toml");
    let settings: toml::Table = text.parse().expect("TOML");
    let tree = Tree::read(root, &settings);
    let used = tree.below(tree.members.clone());
    assert!(used.len() > 100, "{} packages", used.len());
    let listed = |room: &str, key: &str| -> Vec<String> {
        let all = settings[room][key].as_array().expect("a list");
        let word = |v: &toml::Value| {
            v.as_str()
                .or_else(|| v.get("crate")?.as_str())
                .map(String::from)
        };
        all.iter().map(|v| word(v).expect("a word")).collect()
    };
    let allowed = listed("licenses", "allow");
    let allowed: BTreeSet<&str> = allowed.iter().map(String::as_str).collect();
    let (banned, registries) = (listed("bans", "deny"), listed("sources", "allow-registry"));
    let (skipped, trees) = (listed("bans", "skip"), listed("bans", "skip-tree"));
    let is = |id: &String, pattern: &String| {
        let package = &tree.packages[id];
        means(
            pattern,
            &words(&package["name"]),
            &words(&package["version"]),
        )
    };
    // Everything below a tree that is skipped.
    let tops = used.iter().filter(|id| trees.iter().any(|t| is(id, t)));
    let tops: Vec<String> = tops.cloned().collect();
    assert_eq!(
        tops.len(),
        trees.len(),
        "a tree that nothing needs is skipped"
    );
    let below = tree.below(tops);
    let idle = |skip: &&String| !used.iter().any(|id| is(id, skip));
    let idle: Vec<&String> = skipped.iter().filter(idle).collect();
    assert!(idle.is_empty(), "nothing needs {idle:?}");
    let mut wrong = Vec::new();
    let mut versions: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for id in &used {
        let package = &tree.packages[id];
        let (name, version) = (words(&package["name"]), words(&package["version"]));
        let licence = words(&package["license"]);
        if !is_met(&licence, &allowed) {
            wrong.push(format!("{name} {version}: `{licence}`"));
        }
        if banned.iter().any(|ban| means(ban, &name, &version)) {
            wrong.push(format!("{name} is banned"));
        }
        let source = package["source"].as_str();
        let known = |source: &str| registries.iter().any(|r| source == format!("registry+{r}"));
        if !source.is_none_or(known) {
            wrong.push(format!("{name} comes from {source:?}"));
        }
        if !below.contains(id) && !skipped.iter().any(|skip| is(id, skip)) {
            versions.entry(name).or_default().insert(version);
        }
    }
    let doubled = versions.iter().filter(|(_, versions)| versions.len() > 1);
    wrong.extend(doubled.map(|(name, versions)| format!("{name} in {versions:?}")));
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn licences_are_read_as_spdx_writes_them() {
    let allowed = BTreeSet::from(["MIT", "Zlib", "Apache-2.0 WITH LLVM-exception"]);
    for (licence, met) in [
        ("MIT OR GPL-3.0", true),
        ("GPL-3.0/MIT", true),
        ("MIT AND GPL-3.0", false),
        ("(GPL-3.0 OR MIT) AND Zlib", true),
        ("Apache-2.0", false),
        ("Apache-2.0 WITH LLVM-exception", true),
        ("GPL-3.0 OR (MIT AND (Zlib OR BSD-3-Clause))", true),
    ] {
        assert_eq!(is_met(licence, &allowed), met, "{licence}");
    }
    assert!(means("syn@1", "syn", "1.0.5") && !means("syn@1", "syn", "10.0.0"));
}
