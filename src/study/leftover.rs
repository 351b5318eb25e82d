//! Temporary files left behind by killed processes.

use std::path::Path;
use std::time::Duration;

/// Prefix of the names of temporary files, before the process id.
const PREFIX: &str = ".admire-";
/// Age from which a temporary file counts as abandoned where processes cannot be looked up.
const OLD: Duration = Duration::from_secs(24 * 3600);

/// Returns the prefix of the names of this process' temporary files.
pub fn prefix() -> String {
    format!("{PREFIX}{}-", std::process::id())
}

/// Returns true for the name of a temporary file of any `admire` process.
pub fn is_ours(name: &str) -> bool {
    name.starts_with(PREFIX)
}

/// Removes from a folder the temporary files of processes that have ended.
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

/// Returns true if `/proc` lists the running processes. A Windows drive may contain a folder of this name, too.
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
