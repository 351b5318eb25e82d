//! Rules of Windows for file names: conversion to the form of Windows or Unix, and names that are devices and not files.
//!
//! The functions work only on text, so they give the same results on every operating system. The rules are in "Naming Files, Paths, and
//! Namespaces" in the documentation of Windows.

/// Converts a name to the form of Windows: without quotes, with `\` between folders, and without trailing dots and blanks in names.
pub(super) fn of_windows(written: &str) -> String {
    undotted(&unquoted(written).replace('/', r"\"))
}

/// Converts a name to the form of Unix: without quotes, with `/` between folders, and without a drive letter. The path of a network share
/// (`\\server\share`) stays a path that does not exist locally.
pub(super) fn of_unix(written: &str) -> String {
    let slashed = unquoted(written).replace('\\', "/");
    without_drive(slashed.strip_prefix("//?/").unwrap_or(&slashed)).to_string()
}

/// Returns the name without the trailing dots and blanks that Windows drops from each component of a path.
pub(super) fn undotted(name: &str) -> String {
    // Windows takes the text after `\\?\` literally.
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

/// Checks that Windows treats a name as the name of a file. Devices (`NUL`, `AUX.adm`) and names with a colon are not allowed. On other
/// systems, every name is accepted.
///
/// # Errors
/// Returns the reason why the name is not the name of a file.
pub fn check_name(name: &str) -> Result<(), String> {
    match no_file(name) {
        Some(why) if cfg!(windows) => Err(why),
        _ => Ok(()),
    }
}

/// Returns the reason why a name is not the name of a file on Windows, or `None` if it is.
fn no_file(name: &str) -> Option<String> {
    let slashed = unquoted(name).replace('\\', "/");
    if slashed.starts_with("//./") {
        return Some(r"a path that begins with `\\.\` is a Windows device".to_string());
    }
    let path = slashed.strip_prefix("//?/").unwrap_or(&slashed);
    for part in without_drive(path).split('/') {
        let base = part.split(['.', ':']).next().unwrap_or_default();
        if is_device(base.trim_end()) {
            return Some(format!("`{}` is a Windows device", base.trim_end()));
        }
        if part.contains(':') {
            return Some("on Windows a colon may appear only after the drive letter".to_string());
        }
    }
    None
}

/// Returns true for names of devices such as `CON` or `COM1`. A superscript digit counts as a digit.
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

/// Removes zero bytes, and blanks and quotes around a name.
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
            // Windows ignores trailing dots and blanks; on other systems they are part of the name.
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
