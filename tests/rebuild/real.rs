//! Results of a real Adams/Car axle, read from the folder of reference data.

use std::path::Path;

use admire_rebuild::{Role, rebuild};

use crate::common::missing;

/// Checks a file with 101 equilibria under lateral loads. Masses are round numbers in the axle's own files, and the test rig has a wheel of 20
/// kg. The deck itself is not available.
#[test]
fn a_real_axle_repeats_its_results() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../shared/real-decks/kinbench-kc/NRAC_G023_Lat_static_load.res");
    if !path.exists() {
        missing(&path.display().to_string());
        return;
    }
    let answer = rebuild(&[&path], &[]);
    let rebuilt = answer.value.expect("a deck");
    let repeated = rebuilt.repeat.largest(0..101);
    assert!(
        repeated.is_some_and(|apart| apart < 1e-3),
        "{repeated:?} {:?}",
        rebuilt.repeat.error
    );
    let (record, mechanism) = (&rebuilt.record, &rebuilt.mechanism);
    let named = |part: &str| {
        let all = record
            .bodies
            .iter()
            .position(|body| body.name.ends_with(part));
        mechanism.bodies[all.expect(part)].mass
    };
    for (part, mass) in [
        ("whl_wheel", 20.0),
        ("whr_wheel", 20.0),
        ("gel_spindle", 1.1),
    ] {
        assert!(
            (named(part) - mass).abs() < 1e-4 * mass,
            "{part} {}",
            named(part)
        );
    }
    // The lower bushings of the struts are linear, with 1000 N/mm along all axes.
    for member in &mechanism.members {
        let name = &record.elements[member.connection.element].name;
        if let Role::Bushing { law, .. } = &member.role
            && name.contains("strut_lower")
        {
            for axis in &law.force {
                let admire_rebuild::AxisLaw::Linear { stiffness, .. } = axis else {
                    panic!("{name}: {axis:?}")
                };
                assert!((stiffness - 1000.0).abs() < 1e-3, "{name} {stiffness}");
            }
        }
    }
}
