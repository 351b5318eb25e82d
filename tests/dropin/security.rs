use crate::run::{Results, SLIDER, folder, mdi, mdi_with};

#[test]
fn a_command_file_writes_only_in_the_folders_of_its_run() {
    let outside = folder(&[]);
    let target = outside.path().join("x");
    let acf = format!(
        "\nfile/model=slider, output_prefix=\"{}\"\nSIM/STAT\n",
        target.display()
    );
    let inside = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
    let ran = mdi(inside.path(), &["ru-s", "run"]);
    assert_eq!(ran.code, 2, "{}", ran.stdout);
    assert!(ran.stdout.contains("[write-outside]"), "{}", ran.stdout);
    assert_eq!(std::fs::read_dir(outside.path()).unwrap().count(), 0);

    let allowed = outside.path().display().to_string();
    let ran = mdi_with(
        inside.path(),
        &["ru-s", "run"],
        "",
        &[("ADMIRE_ALLOW_PATH", &allowed)],
    );
    assert_eq!(ran.code, 0, "{}", ran.stdout);
    assert_eq!(Results::read(outside.path(), "x.res").steps.len(), 1);
}

#[test]
fn saving_overwrites_no_other_file() {
    let acf = "\nfile/model=slider\nSIM/STAT\nSAVE/FILE=notes.txt\nSAVE/FILE=../escaped.sav\n";
    let folder = folder(&[
        ("slider.adm", SLIDER),
        ("run.acf", acf),
        ("notes.txt", "mine"),
    ]);
    let ran = mdi(folder.path(), &["ru-s", "run"]);
    assert!(ran.stdout.contains("no saved state"), "{}", ran.stdout);
    assert!(ran.stdout.contains("[write-outside]"), "{}", ran.stdout);
    assert_eq!(
        std::fs::read(folder.path().join("notes.txt")).unwrap(),
        b"mine"
    );
}

#[test]
fn absurd_sizes_are_refused_at_once() {
    for command in [
        "SIMULATE/STATICS, END=1, STEPS=2000000000",
        "SIMULATE/STATICS, END=1, DTOUT=1E-300",
        "FILE/COMMAND=run",
    ] {
        let acf =
            format!("\nfile/model=slider\nDEACTIVATE/JOINT, RANGE=2, 4000000000\n{command}\n");
        let folder = folder(&[("slider.adm", SLIDER), ("run.acf", &acf)]);
        let start = std::time::Instant::now();
        let ran = mdi(folder.path(), &["ru-s", "run"]);
        assert!(start.elapsed().as_secs() < 20, "{command}");
        assert_ne!(ran.code, 0, "{command}: {}", ran.stdout);
        assert!(ran.stdout.contains("---- START: ERROR ----"), "{command}");
    }
}
