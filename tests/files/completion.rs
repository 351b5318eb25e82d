//! Tests of bash completion with the script printed by `admire completions bash`.

use std::path::Path;
use std::process::Command;

use crate::common::shared;

/// Returns the completions that bash offers for the last word, or `None` if bash is not available.
fn offered(words: &[&str]) -> Option<Vec<String>> {
    let program = Path::new(env!("CARGO_BIN_EXE_admire"));
    let mut paths = vec![program.parent()?.to_path_buf()];
    paths.extend(std::env::split_paths(&std::env::var_os("PATH")?));
    let last = words.len() - 1;
    let script = format!(
        "source <(admire completions bash) || exit 9\nCOMP_WORDS=(\"$@\")\nCOMP_CWORD={last}\nCOMP_TYPE=9\n\
         _clap_complete_admire admire \"${{COMP_WORDS[{last}]}}\" x\nprintf '%s\\n' \"${{COMPREPLY[@]}}\""
    );
    let output = Command::new("bash")
        .args(["--norc", "-c", &script, "bash"])
        .args(words)
        .env("PATH", std::env::join_paths(paths).ok()?)
        .output()
        .ok()?;
    assert!(output.status.success(), "{output:?}");
    let text = String::from_utf8(output.stdout).expect("UTF-8");
    Some(text.lines().map(|line| line.trim().to_string()).collect())
}

#[test]
fn addresses_columns_and_words_are_completed() {
    let Some(deck) = shared("real-decks/quarter-car/Controls_Plant.adm") else {
        return;
    };
    let deck = deck.to_str().expect("UTF-8");
    let results = shared("real-decks/photocaber/adams1.res").expect("beside the deck");
    let results = results.to_str().expect("UTF-8");
    for (words, wanted) in [
        (&["admire", "get", deck, "JOINT/"][..], "JOINT/2"),
        (&["admire", "set", deck, "PART/2.M"], "PART/2.MASS"),
        (&["admire", "get", deck, "bod_road.IP."], "bod_road.IP.3"),
        (&["admire", "renumber", deck, "MARKER/5"], "MARKER/51"),
        (
            &["admire", "results", results, "--get", "p0"],
            "p0-2_XFORM.X",
        ),
        (&["admire", "explain", "BUSH"], "BUSHING"),
        (&["admire", "summ"], "summary"),
    ] {
        let Some(offered) = offered(words) else {
            return;
        };
        assert!(
            offered.iter().any(|one| one == wanted),
            "{words:?}: {offered:?}"
        );
    }
}
