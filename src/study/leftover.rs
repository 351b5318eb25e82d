//! Temporary files of runs that were killed.

use std::path::Path;
use std::time::Duration;

/// What temporary files are called, before the id of their process.
const PREFIX: &str = ".admire-";
/// Where processes cannot be looked up, a temporary file of this age is nobody's.
const OLD: Duration = Duration::from_secs(24 * 3600);

/// The beginning of the names of this process' temporary files.
pub fn prefix() -> String {
    format!("{PREFIX}{}-", std::process::id())
}

/// True for the name of a temporary file of some process of ours.
pub fn is_ours(name: &str) -> bool {
    name.starts_with(PREFIX)
}

/// Removes temporary files whose process is gone from a folder.
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
            // Whoever is quicker has removed it.
            let _ = std::fs::remove_file(entry.path());
        }
    }
}

/// True where living processes are listed. A disk of Windows may have a folder of this name, too.
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
