//! Export of the rig as decks and command files that run on any ADAMS.

use std::collections::BTreeSet;

use super::bench::Bench;
use super::bench_error::BenchError;
use super::rig::Variant;
use super::sweep::KcRun;
use super::test_kind::TestKind;
use admire_syntax::Address;

/// Returns the rig's files as (name, contents): one dataset for each [`Variant`] of the deck, and one command file for each test.
///
/// For each sample, a command file sets the loads and heights and runs a static equilibrium. On a mirrored axle, only the wheel in the deck
/// is driven. A steering test gets no file if it drives a parameter of the deck, such as a marker's position, because no command can change
/// a parameter.
///
/// # Errors
/// As [`Bench::variant`].
pub fn deck_files(
    bench: &mut Bench<'_>,
    run: &KcRun,
) -> Result<Vec<(String, Vec<u8>)>, BenchError> {
    let mut files = Vec::new();
    let mut written = BTreeSet::new();
    let drive = bench
        .config
        .steering_drive
        .as_ref()
        .and_then(|at| Address::parse(&at.text, bench.dataset()).ok());
    for test in &run.tests {
        let by_number = drive.as_ref().is_some_and(|at| at.argument.is_some());
        if test.kind == TestKind::Steering && by_number {
            continue;
        }
        let variant = Variant::of_test(test.kind, &test.settings);
        let rigged = &bench.variant(variant)?.rigged;
        let deck = variant.name();
        if written.insert(variant) {
            files.push((format!("{deck}.adm"), rigged.dataset.bytes().to_vec()));
        }
        let name = test.kind.name();
        let mut text = format!("{deck}\n{name}\n");
        for sample in &test.samples {
            text += &format!(
                "! {} {} {}\n",
                test.kind.variable(),
                sample.value,
                sample.branch.word()
            );
            let inputs = &sample.inputs;
            for wheel in &rigged.wheels {
                let k = wheel.side.index();
                let mut set = |kind: &str, id: u32, value: f64| {
                    text += &format!("{kind}/{id}, FUNCTION = {value:?}\n");
                };
                for (id, value) in wheel.loads.into_iter().zip(inputs.loads[k]) {
                    set("VARIABLE", id, value);
                }
                let at = [inputs.vertical_at_patch, inputs.plane_at_patch];
                for (id, at) in wheel.patch.into_iter().zip(at) {
                    set("VARIABLE", id, f64::from(u8::from(at)));
                }
                if let Some(id) = wheel.motion {
                    set("MOTION", id, inputs.height[k]);
                }
            }
            if let (
                Some(value),
                Some(Address {
                    kind,
                    id: Some(id),
                    argument: None,
                    ..
                }),
            ) = (inputs.steer, &drive)
            {
                text += &format!("{kind}/{id}, FUNCTION = {value:?}\n");
            }
            text += "SIMULATE/STATIC\n";
        }
        text += "STOP\n";
        files.push((format!("{name}.acf"), text.into_bytes()));
    }
    Ok(files)
}
