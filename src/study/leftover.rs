//! Removal of temporary files that killed processes have left behind.

use std::path::Path;
use std::time::Duration;

/// Start of the names of temporary files; the id of the process follows.
const PREFIX: &str = ".admire-";
/// Age above which a temporary file counts as abandoned if the system does not list its processes.
const OLD: Duration = Duration::from_secs(24 * 3600);

/// Returns the prefix of the names of this process's temporary files.
pub fn prefix() -> String {
    format!("{PREFIX}{}-", std::process::id())
}

/// Returns true if a file of this name is a temporary file of an `admire` process.
pub fn is_ours(name: &str) -> bool {
    name.starts_with(PREFIX)
}

/// Removes the temporary files of processes that have ended from a folder.
pub fn remove(folder: &Path) {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let Some(rest) = name.to_str().and_then(|name| name.strip_prefix(PREFIX)) else {
            continue;
        };
        let process = rest
            .split_once('-')
            .and_then(|(id, _)| id.parse::<u32>().ok());
        let gone = match process {
            Some(id) if can_look_up() => !Path::new("/proc").join(id.to_string()).exists(),
            _ => entry
                .metadata()
                .and_then(|found| found.modified())
                .is_ok_and(|time| time.elapsed().is_ok_and(|age| age > OLD)),
        };
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if gone && is_file {
            // Another process may have removed the file in the meantime.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// Returns true if `/proc` lists the running processes. On Windows, a folder of this name has another meaning.
fn can_look_up() -> bool {
    cfg!(unix) && Path::new("/proc/self").exists()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_dead_processes_go_and_all_others_stay() {
        let folder = tempfile::tempdir().unwrap();
        // No process has this id.
        let dead = format!("{PREFIX}{}-x", u32::MAX);
        let own = format!("{}x", prefix());
        for name in [dead.as_str(), &own, ".admire-young", "deck.adm"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        remove(folder.path());
        let left = |name: &str| folder.path().join(name).exists();
        assert_eq!(left(&dead), !can_look_up());
        assert!(left(&own) && left(".admire-young") && left("deck.adm"));
    }
}
