use std::process::Command;

use crate::run::{Results, SLIDER, folder};

#[test]
fn installed_shims_run_under_every_name() {
    let tools = folder(&[]);
    let bin = tools.path().join("bin");
    let installed = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(["install-shims", "--names", "mdi,adams2024_1"])
        .arg(&bin)
        .output()
        .unwrap();
    assert!(installed.status.success(), "{installed:?}");
    let batch = std::fs::read_to_string(bin.join("mdi.bat")).unwrap();
    assert!(
        batch.starts_with("@echo off\r\n\"") && batch.contains("\" %*\r\nexit /b %ERRORLEVEL%\r\n")
    );

    if cfg!(unix) {
        let run = folder(&[
            ("slider.adm", SLIDER),
            ("run.acf", "\nfile/model=slider\nSIM/STAT\nSTOP\n"),
        ]);
        for name in ["mdi", "adams2024_1"] {
            let _ = std::fs::remove_file(run.path().join("slider.res"));
            // Started by name through a shell and the PATH, as by MATLAB's system().
            let status = Command::new("sh")
                .args(["-c", &format!("{name} ru-standard run > log.txt")])
                .current_dir(run.path())
                .env("PATH", format!("{}:/usr/bin:/bin", bin.display()))
                .status()
                .unwrap();
            assert!(status.success(), "{name}");
            assert_eq!(
                Results::read(run.path(), "slider.res").steps.len(),
                1,
                "{name}"
            );
        }
    }

    // A foreign file is replaced only with an explicit option.
    let name = if cfg!(windows) { "mdi.bat" } else { "mdi" };
    std::fs::write(bin.join(name), "mine").unwrap();
    let refused = Command::new(env!("CARGO_BIN_EXE_admire"))
        .args(["install-shims", "--names", "mdi"])
        .arg(&bin)
        .output()
        .unwrap();
    assert_eq!(refused.status.code(), Some(2));
    assert_eq!(std::fs::read(bin.join(name)).unwrap(), b"mine");
}

/// Checks that the folder of the programs is a single word for the shell, whatever its name contains.
#[cfg(unix)]
#[test]
fn no_name_becomes_a_command_of_the_shell() {
    let place = folder(&[]);
    let tools = place
        .path()
        .join("it's\n`touch pwned`$(touch pwned); touch pwned\n\"&");
    std::fs::create_dir(&tools).unwrap();
    for program in [env!("CARGO_BIN_EXE_admire"), env!("CARGO_BIN_EXE_mdi")] {
        let name = std::path::Path::new(program).file_name().unwrap();
        std::fs::copy(program, tools.join(name)).unwrap();
    }
    let installed = Command::new(tools.join("admire"))
        .args(["install-shims", "bin", "--names", "mdi"])
        .current_dir(place.path())
        .output()
        .unwrap();
    assert!(installed.status.success(), "{installed:?}");
    std::fs::write(place.path().join("slider.adm"), SLIDER).unwrap();
    let acf = "\nfile/model=slider\nSIM/STAT\nSTOP\n";
    std::fs::write(place.path().join("run.acf"), acf).unwrap();
    let ran = Command::new(place.path().join("bin/mdi"))
        .args(["ru-standard", "run"])
        .current_dir(place.path())
        .output()
        .unwrap();
    assert!(ran.status.success(), "{ran:?}");
    assert_eq!(Results::read(place.path(), "slider.res").steps.len(), 1);
    assert!(!place.path().join("pwned").exists());
}
