//! A real editor: headless Neovim with its built-in client. The test is skipped without Neovim.

use std::path::Path;
use std::process::Command;

use serde_json::Value;

use crate::common::skipped;

const DECK: &str = "t\nPART/1, GROUND\nMARKER/1, PART=1\nPART/2, MASS=1,CM=20\nMARKER/20,PART=2\nJOINT/1, SPHERICAL, J=1, I=20\nEND\n";

/// Returns the settings for Neovim from the guide.
fn of_the_guide() -> &'static str {
    let page = include_str!("../../src/guide/editors.md");
    let (_, rest) = page.split_once("```lua\n").expect("settings");
    rest.split_once("```").expect("their end").0
}

#[test]
fn neovim_shows_complaints_and_applies_edits() {
    if Command::new("nvim").arg("--version").output().is_err() {
        skipped("nvim is not here");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let deck = folder.path().join("deck.adm");
    std::fs::write(&deck, DECK).expect("writable");
    std::fs::write(
        folder.path().join("run.ACF"),
        "deck\nrun\nSIMULATE/STATICS\nSTOP\n",
    )
    .expect("writable");
    let settings = folder.path().join("init.lua");
    std::fs::write(&settings, of_the_guide()).expect("writable");
    let own = std::env::var_os("PATH").unwrap_or_default();
    let built = Path::new(env!("CARGO_BIN_EXE_admire")).parent();
    let folders = built.map(Path::to_path_buf).into_iter();
    let path = std::env::join_paths(folders.chain(std::env::split_paths(&own))).expect("folders");
    let out = Command::new("nvim")
        .args(["--headless", "-i", "NONE", "-n", "-u"])
        .arg(&settings)
        .args([
            "-c",
            concat!(
                "luafile ",
                env!("CARGO_MANIFEST_DIR"),
                "/tests/lsp/neovim.lua"
            ),
        ])
        .env("PATH", path)
        .env("DECK", &deck)
        .env("XDG_STATE_HOME", folder.path())
        .env("XDG_CACHE_HOME", folder.path())
        .output()
        .expect("it runs");
    let text = String::from_utf8_lossy(&out.stdout);
    let seen: Value = text
        .find('{')
        .and_then(|at| serde_json::from_str(&text[at..]).ok())
        .unwrap_or_else(|| panic!("{text}\n{}", String::from_utf8_lossy(&out.stderr)));
    for what in ["started", "complained", "mended", "stopped"] {
        assert_eq!(seen[what], true, "{what}: {seen:#}");
    }
    assert_eq!(seen["attached"], true, "{seen:#}");
    assert_eq!(seen["codes"], serde_json::json!(["undefined-id"]));
    assert_eq!(seen["place"], serde_json::json!([5, 27]));
    assert!(
        seen["hover"]
            .as_str()
            .is_some_and(|text| text.contains("Position in ground: 0, 0, 0")),
        "{seen:#}"
    );
    assert_eq!(seen["renamed"], DECK.replace("20", "25").trim_end());
    assert_eq!(
        seen["laid"],
        "t\nPART/1, GROUND\nMARKER/1, PART=1\nPART/2, MASS=1, CM=25\nMARKER/25, PART=2\nJOINT/1, SPHERICAL, J=1, I=25\nEND"
    );
    assert_eq!(seen["items"], serde_json::json!(["1", "2"]));
    assert_eq!(seen["symbols"], 7, "{seen:#}");
}
