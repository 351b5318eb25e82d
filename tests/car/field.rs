//! Results at a FIELD that Adams/Car writes for a bushing, written back into the subsystem.

use admire_car::{BushingProperty, Subsystem};
use admire_syntax::property::PropertyFile;
use admire_syntax::text::Source;
use admire_syntax::units::Units;

use crate::car_axle::with_field;
use crate::toolkit::{admire, corpus};

/// Factor by which the real top mount is stiffer along its axis.
const FACTOR: f64 = 1.3;
const STIFFER: &str = "element-parameter@ARRAY/903.NUMBERS.3:factor=1.3";

/// Identifies the shipped axle with a FIELD as its top mount. `effect` is planted in the measured axle; `unknown` is a
/// table `[[identify.unknown]]`. Returns the folder.
fn identified(effect: &str, unknown: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let read = |name: &str| std::fs::read_to_string(corpus("pseudo-mcpherson").join(name)).unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    let toml = read("study.toml").replace("[reference]\ndeck = \"reference.adm\"\n", "");
    let deck = with_field(&read("reference.adm"), 3, "axle.bkl_top_mount", None);
    write(
        "study.toml",
        &format!("{toml}\n{unknown}\n[car]\nsubsystem = \"front.sub\"\n"),
    );
    write("model.adm", &deck);
    write("load_cases.csv", &read("load_cases.csv"));
    write("marks_on_parts.csv", &read("marks_on_parts.csv"));
    std::fs::copy(
        corpus("adams-car/front.sub"),
        folder.path().join("front.sub"),
    )
    .unwrap();
    let words = [
        "rig", ".", "--out", "measured", "--sigma", "0.001", "--effect", effect,
    ];
    let (code, _, errors) = admire(folder.path(), &words);
    assert_eq!(code, 0, "{errors}");
    let (code, out, errors) = admire(folder.path(), &["identify", "measured", "--out", "out"]);
    assert_eq!(code, 0, "{out}{errors}");
    folder
}

/// Returns the standard error of the factor, as stated in the list of changes.
fn std_error(folder: &std::path::Path) -> f64 {
    let bytes = std::fs::read(folder.join("out/adams_car/changes.json")).unwrap();
    let list: serde_json::Value = serde_json::from_slice(&bytes).expect("JSON");
    let mut changes = list["changes"].as_array().expect("a list").iter();
    let scale = changes.find(|one| one["factor"] == "fz_scaling_factor");
    scale.expect("the factor")["std_error"]
        .as_f64()
        .expect("a number")
}

fn subsystem(folder: &std::path::Path, name: &str) -> Subsystem {
    let bytes = std::fs::read(folder.join(name)).unwrap();
    let read = Subsystem::parse(Source::new("front.sub", bytes));
    assert_eq!(read.diagnostics, []);
    read.value
}

/// The scale of a curve of the FIELD is the scaling factor of the subsystem.
#[test]
fn the_scale_of_a_field_is_a_scaling_factor() {
    let folder = identified(
        STIFFER,
        "[[identify.unknown]]\nnumbers = [\"ARRAY/903.NUMBERS.3\"]\nform = \"factor\"\n",
    );
    let new = subsystem(folder.path(), "out/adams_car/front.sub");
    let mount = new
        .bushings
        .iter()
        .find(|one| one.usage == "top_mount")
        .expect("the mount");
    let block = &new.file.blocks[mount.block];
    let factor = block
        .parameter("FZ_SCALING_FACTOR")
        .and_then(|p| p.value.number());
    let factor = factor.expect("a factor");
    let error = std_error(folder.path());
    assert!(error < 0.05, "{error}");
    assert!((factor - FACTOR).abs() < 3.5 * error, "{factor} {error}");
    assert!(block.parameter("FX_SCALING_FACTOR").is_none());
    assert_eq!(
        mount.property_file.as_deref(),
        Some("mdids://example/bushings.tbl/top.bus")
    );
}

/// A curve of the FIELD that was identified is a property file, which reads back to the points of the SPLINE.
#[test]
fn the_curve_of_a_field_is_a_property_file() {
    let folder = identified(
        STIFFER,
        "[[identify.unknown]]\nnumbers = [\"SPLINE/903.Y\"]\nform = \"factor\"\ntogether = true\n",
    );
    let new = subsystem(folder.path(), "out/adams_car/front.sub");
    let mount = new
        .bushings
        .iter()
        .find(|one| one.usage == "top_mount")
        .expect("the mount");
    assert_eq!(
        mount.property_file.as_deref(),
        Some("mdids://example/bushings.tbl/top_mount_learned.bus")
    );
    let bytes = std::fs::read(folder.path().join("out/adams_car/top_mount_learned.bus")).unwrap();
    let read = PropertyFile::parse(Source::new("a.bus", bytes));
    assert_eq!(read.diagnostics, []);
    let property = BushingProperty::of(&read.value, &Units::default());
    let curve = property.curves[2].as_ref().expect("FZ_CURVE");
    assert_eq!(curve.x.len(), 33);
    let (_, out, _) = admire(
        folder.path(),
        &["get", "out/identified.adm", "SPLINE/903.Y.33"],
    );
    let last: f64 = out.trim().parse().expect("a number");
    // The shipped mount has 1500 N/mm along its axis, and the last point is at 8 mm.
    let factor = last / (1500.0 * 8.0);
    assert!((factor - FACTOR).abs() < 0.05, "{factor}");
    for (x, y) in curve.x.iter().zip(&curve.y) {
        let law = factor * 1500.0 * x;
        assert!((y - law).abs() <= 1e-9 * law.abs(), "{x}: {y} {law}");
    }
}

/// The offset of a FIELD is an offset of the subsystem, in the units of its file.
#[test]
fn the_offset_of_a_field_is_an_offset_of_the_subsystem() {
    let folder = identified(
        "element-parameter@ARRAY/903.NUMBERS.8:value=0.4",
        "[[identify.unknown]]\nnumbers = [\"ARRAY/903.NUMBERS.8\"]\nform = \"change\"\nsd = 1\n",
    );
    let new = subsystem(folder.path(), "out/adams_car/front.sub");
    let mut mounts = new.bushings.iter();
    let mount = mounts
        .find(|one| one.usage == "top_mount")
        .expect("the mount");
    let block = &new.file.blocks[mount.block];
    let offset = block.parameter("T_OFFSET_Z").and_then(|p| p.value.number());
    let offset = offset.expect("an offset");
    assert!((offset - 0.4).abs() < 0.05, "{offset}");
}
