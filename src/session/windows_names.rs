//! The rules Windows has for file names: how a name is spelled there and elsewhere, and which names are no files.
//!
//! Text only, so that they are the same on every system; see "Naming Files, Paths, and Namespaces" of the Windows documentation.

/// A name as Windows has it: no quotes around it, `\` between folders, no dots and blanks at the end of a folder or file.
pub(super) fn of_windows(written: &str) -> String {
    undotted(&unquoted(written).replace('/', r"\"))
}

/// A name as Unix has it: no quotes around it, `/` between folders, no drive letter. A share (`\\server\share`) stays a path that is
/// not here.
pub(super) fn of_unix(written: &str) -> String {
    let slashed = unquoted(written).replace('\\', "/");
    without_drive(slashed.strip_prefix("//?/").unwrap_or(&slashed)).to_string()
}

/// The name without the dots and blanks that Windows drops at the end of each of its parts.
pub(super) fn undotted(name: &str) -> String {
    // `\\?\` says that the rest is meant as it stands.
    if name.starts_with(r"\\?\") {
        return name.to_string();
    }
    name.split_inclusive(['/', '\\'])
        .flat_map(|part| {
            let bare = part.trim_end_matches(['/', '\\']);
            let kept = match bare.trim_end() {
                "." => ".",
                ".." => "..",
                _ => bare.trim_end_matches(['.', ' ']),
            };
            [kept, &part[bare.len()..]]
        })
        .collect()
}

/// Fails for names that Windows takes for something else than a file of that name: devices (`NUL`, `AUX.adm`), and what is written
/// behind a colon. Elsewhere every name is one.
///
/// # Errors
/// Why it names no file.
pub fn check_name(name: &str) -> Result<(), String> {
    match no_file(name) {
        Some(why) if cfg!(windows) => Err(why),
        _ => Ok(()),
    }
}

/// Why Windows has no file of this name.
fn no_file(name: &str) -> Option<String> {
    let slashed = unquoted(name).replace('\\', "/");
    if slashed.starts_with("//./") {
        return Some(r"what begins with `\\.\` is a device of Windows".to_string());
    }
    let path = slashed.strip_prefix("//?/").unwrap_or(&slashed);
    for part in without_drive(path).split('/') {
        let base = part.split(['.', ':']).next().unwrap_or_default();
        if is_device(base.trim_end()) {
            return Some(format!("`{}` is a device of Windows", base.trim_end()));
        }
        if part.contains(':') {
            return Some(
                "on Windows a colon may stand only behind the letter of a drive".to_string(),
            );
        }
    }
    None
}

/// `CON`, `COM1` and so on; a superscript digit counts as a digit.
fn is_device(base: &str) -> bool {
    let upper = base.to_uppercase();
    if ["CON", "PRN", "AUX", "NUL", "CONIN$", "CONOUT$"].contains(&upper.as_str()) {
        return true;
    }
    let port = |word| {
        let digit = upper.strip_prefix(word)?;
        let mut digits = digit.chars();
        let one = digits.next()?;
        Some(digits.next().is_none() && (one.is_ascii_digit() || "¹²³".contains(one)))
    };
    port("COM").or_else(|| port("LPT")) == Some(true)
}

/// Without blanks, quotes and zero bytes.
fn unquoted(written: &str) -> String {
    written
        .trim()
        .trim_matches(|c| c == '"' || c == '\'')
        .trim()
        .replace('\0', "")
}

fn without_drive(slashed: &str) -> &str {
    match slashed.as_bytes() {
        [letter, b':', ..] if letter.is_ascii_alphabetic() => &slashed[2..],
        _ => slashed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_spelled_as_each_system_has_them() {
        for (written, windows, unix) in [
            (r"C:\runs\model", r"C:\runs\model", "/runs/model"),
            (
                r"C:/runs\model.adm",
                r"C:\runs\model.adm",
                "/runs/model.adm",
            ),
            (
                r#" "d:\my runs\a b.adm" "#,
                r"d:\my runs\a b.adm",
                "/my runs/a b.adm",
            ),
            (r"..\model", r"..\model", "../model"),
            ("./sub/../model", r".\sub\..\model", "./sub/../model"),
            (r"C:model", "C:model", "model"),
            (
                r"\\server\share\model",
                r"\\server\share\model",
                "//server/share/model",
            ),
            (r"\\?\C:\runs\model", r"\\?\C:\runs\model", "/runs/model"),
            // Dots and blanks at the end do not count on Windows; elsewhere they are part of the name.
            (r"runs. \model..", r"runs\model", "runs. /model.."),
            (r"\\?\C:\model.", r"\\?\C:\model.", "/model."),
            ("", "", ""),
        ] {
            assert_eq!(of_windows(written), windows, "{written}");
            assert_eq!(of_unix(written), unix, "{written}");
        }
    }

    #[test]
    fn devices_are_no_files_and_what_looks_like_one_is() {
        for name in [
            "NUL",
            "con",
            "AUX.adm",
            r"C:\runs\aux.adm",
            "prn .txt",
            "nul.tar.gz",
            "com1",
            "LPT9.res",
            "COM²",
            "CONOUT$",
            r"\\.\COM12",
            r"\\?\C:\NUL",
            "out:1",
            r"C:\runs\a:b",
            "\"NUL\"",
        ] {
            assert!(no_file(name).is_some(), "{name}");
        }
        for name in [
            "model.adm",
            r"C:\runs\model",
            "C:model",
            "console.adm",
            "auxiliary",
            "com",
            "COM10",
            "LPT",
            "null",
            "my.con",
            r"\\server\share\a",
            r"\\?\C:\a",
            "",
        ] {
            assert_eq!(no_file(name), None, "{name}");
        }
    }
}
