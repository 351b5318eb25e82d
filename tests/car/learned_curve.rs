//! A learned bushing curve: written as a `.bus` file, read back by the solver, and compared with its law in closed form.

use std::path::Path;

use admire_car::{BushingProperty, OddLaw, OddTerm};
use admire_session::{FilePolicy, read_files};
use admire_solver::model::Model;
use admire_solver::system::{Scratch, System};
use admire_syntax::Dataset;
use admire_syntax::text::Source;
use admire_syntax::units::Units;

/// Returns the value of a curve of `law.bus` at a displacement or angle, as the solver evaluates it by Akima's method.
fn value(folder: &Path, block: &str, at: f64) -> f64 {
    let deck = format!(
        "a curve\nUNITS/FORCE=NEWTON, MASS=KILOGRAM, LENGTH=MILLIMETER, TIME=SECOND\nPART/1, GROUND\nMARKER/1, PART=1\n\
         PART/2, MASS=1, CM=2, IP=1,1,1\nMARKER/2, PART=2, QP={at:?}, 0, 0\nSPLINE/1, FILE=law.bus, BLOCK={block}\n\
         SFORCE/1, TRANSLATIONAL, I=2, J=1, ACTIONONLY, FUNCTION=AKISPL(DX(2,1),0,1)\nEND\n"
    );
    let path = folder.join("model.adm").display().to_string();
    let dataset = Dataset::parse(Source::new(path, deck)).value;
    let files = read_files(&dataset, folder, &FilePolicy::new(folder));
    let lowered = Model::lower_with(&dataset, &files.value);
    assert_eq!(lowered.diagnostics, []);
    let system = System::compile(&lowered.value).value;
    let (theta, state) = (system.parameters(), system.state());
    let mut scratch = Scratch::new(&system);
    let Ok(mut here) = system.evaluate(&theta, &state, &mut scratch) else {
        panic!("no value at {at}");
    };
    let (element, _) = system.elements().next().expect("the force");
    let Ok(reading) = here.read_element(element) else {
        panic!("no reading at {at}");
    };
    reading.force.z
}

#[test]
fn a_learned_curve_reads_back_to_its_law() {
    let folder = tempfile::tempdir().unwrap();
    let cubic = OddLaw {
        stiffness: 900.0,
        terms: vec![OddTerm::power(3, 300.0)],
    };
    let mixed = OddLaw {
        stiffness: 400.0,
        terms: vec![OddTerm::power(3, 80.0), OddTerm::power(5, 10.0)],
    };
    let quadratic = OddLaw {
        stiffness: 2.0e5,
        terms: vec![OddTerm::power(2, 3.0e6)],
    };
    let linear = OddLaw {
        stiffness: 1500.0,
        terms: Vec::new(),
    };
    // Force law, block, and range: displacements in mm, angles in radians.
    let all = [
        (&cubic, "FX_CURVE", 2.5),
        (&mixed, "FY_CURVE", 1.75),
        (&linear, "FZ_CURVE", 1.0),
        (&quadratic, "TX_CURVE", 0.15),
    ];
    let mut property = BushingProperty::default();
    for ((law, _, range), axis) in all.iter().zip([0, 1, 2, 3]) {
        property.curves[axis] = Some(law.curve(*range));
    }
    let text = property.text(&Units::default(), "learned by a test");
    std::fs::write(folder.path().join("law.bus"), text).unwrap();
    for (law, block, range) in all {
        let largest = law.force(range).abs();
        let mut worst = 0.0_f64;
        for k in -10..=10_i32 {
            // Between the points of the curve, and at its ends.
            let at = range * f64::from(k) / 10.0 * if k.abs() == 10 { 1.0 } else { 0.987 };
            worst = worst.max((value(folder.path(), block, at) - law.force(at)).abs());
        }
        println!("{block}: {:.1e} of the largest force", worst / largest);
        assert!(worst < 1e-5 * largest, "{block}: {worst} of {largest}");
    }
}
