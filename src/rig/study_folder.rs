//! Study folder that a virtual rig writes: the files of the original study with new readings. The folder contains no trace of the planted
//! effects.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::readings::Readings;
use super::rig_options::RigOptions;
use admire_study::{Measurement, Study, section, written};

/// Standard deviation that the new study declares for exact readings, in the deck's length unit. A standard deviation of zero is not allowed.
const EXACT: f64 = 1e-4;

/// Returns the files of the new study folder, as pairs of relative path and contents.
pub(super) fn files(
    study: &Study,
    measured: &Measurement,
    read: &Readings,
    options: &RigOptions,
) -> Vec<(PathBuf, Vec<u8>)> {
    let relative = |name: &str| {
        let path = Path::new(name);
        path.strip_prefix(&study.folder)
            .unwrap_or(path)
            .to_path_buf()
    };
    let mut files = vec![
        (relative(study.deck.name()), study.deck.bytes().to_vec()),
        (
            relative(study.loads.source.name()),
            study.loads.source.bytes().to_vec(),
        ),
    ];
    let mut toml = String::from_utf8_lossy(study.source.bytes()).into_owned();
    if let Some(marks) = &study.marks {
        let mut listed = String::from("part,mark,x,y,z\n");
        for (part, places) in measured.parts.iter().zip(&read.listed) {
            for (mark, p) in part.marks.iter().zip(places) {
                let _ = writeln!(
                    listed,
                    "{},{},{:.9},{:.9},{:.9}",
                    part.name, mark.label, p.x, p.y, p.z
                );
            }
        }
        let mut seen = String::from("case,part,mark,x,y,z\n");
        for (case, places) in measured.cases.iter().zip(&read.marks) {
            for (part, places) in measured.parts.iter().zip(places) {
                for (mark, x) in part.marks.iter().zip(places) {
                    let _ = writeln!(
                        seen,
                        "{},{},{},{:.9},{:.9},{:.9}",
                        case.label, part.name, mark.label, x.x, x.y, x.z
                    );
                }
            }
        }
        let exact_list = measured.sigma_on_parts == 0.0 || options.sigma == Some(0.0);
        if let Some(size) = options.sigma_on_parts {
            toml = section::with_number(&toml, "marks", "sigma_on_parts", size);
        }
        let listed = if exact_list {
            marks.on_parts.source.bytes().to_vec()
        } else {
            listed.into_bytes()
        };
        files.push((relative(marks.on_parts.source.name()), listed));
        files.push((relative(marks.measured.source.name()), seen.into_bytes()));
        if options.sigma.is_some() || options.scatter.declared != 1.0 {
            // Exact readings need a nonzero standard deviation as well.
            let sigma = if measured.sigma == 0.0 {
                EXACT
            } else {
                measured.sigma
            };
            let declared = sigma * options.scatter.declared;
            toml = section::with_number(&toml, "marks", "sigma", declared);
        }
    }
    if let Some((_, table)) = &study.wheel {
        let mut seen = String::from("case,x,y,z,camber_deg,steer_deg\n");
        for (case, wheel) in measured.cases.iter().zip(&read.wheel) {
            if let Some(wheel) = wheel {
                let p = wheel.position;
                let _ = writeln!(
                    seen,
                    "{},{:.9},{:.9},{:.9},{:.9},{:.9}",
                    case.label, p.x, p.y, p.z, wheel.camber_deg, wheel.steer_deg
                );
            }
        }
        let name = table.as_ref().map(|table| relative(table.source.name()));
        if name.is_none() {
            toml = toml.replacen("[wheel]", "[wheel]\nmeasured = \"wheel.csv\"", 1);
        }
        files.push((
            name.unwrap_or_else(|| PathBuf::from("wheel.csv")),
            seen.into_bytes(),
        ));
    }
    let of_readings = study.readings.as_ref().map_or(0, |(_, own)| own.len());
    if let Some((table, _)) = &study.readings {
        let text = channels(measured, read, 0..of_readings, &[]);
        files.push((relative(table.source.name()), text.into_bytes()));
    }
    if let Some((_, table)) = &study.kc {
        let name = relative(table.source.name());
        // Loads and curves may share one file.
        let both = name == relative(study.loads.source.name());
        let loads: Vec<&str> = study.columns.iter().map(|(n, _)| n.text.as_str()).collect();
        let loads = if both { loads.as_slice() } else { &[] };
        let text = channels(measured, read, of_readings..measured.channels.len(), loads);
        files.retain(|(other, _)| *other != name);
        files.push((name, text.into_bytes()));
    }
    if let Some(table) = &study.kc_summary {
        let text = written(table, measured, &read.channels);
        files.push((relative(table.source.name()), text.into_bytes()));
    }
    if let Some(car) = &study.car {
        let subsystem = car.subsystem.file.source();
        files.push((relative(subsystem.name()), subsystem.bytes().to_vec()));
    }
    files.push((
        PathBuf::from("study.toml"),
        without_section(&toml, "reference").into_bytes(),
    ));
    files
}

/// Formats a CSV file with one row for each case. The columns are the given loads, then the channels in `range` in the units of their columns.
fn channels(
    measured: &Measurement,
    read: &Readings,
    range: std::ops::Range<usize>,
    loads: &[&str],
) -> String {
    let mut out = String::from("case");
    for name in loads {
        let _ = write!(out, ",{name}");
    }
    let range: Vec<usize> = range
        .filter(|k| measured.channels[*k].is_read_by_case())
        .collect();
    for channel in range.iter().map(|k| &measured.channels[*k]) {
        let _ = write!(out, ",{}", channel.column.0);
    }
    out.push('\n');
    // A channel without any readings in the original study is written for all cases. For any other channel, only the cells with a reading in
    // the original study are written.
    let all: Vec<bool> = (0..measured.channels.len())
        .map(|k| measured.cases.iter().all(|case| case.channels[k].is_none()))
        .collect();
    for (at, (case, values)) in measured.cases.iter().zip(&read.channels).enumerate() {
        out += &case.label;
        for load in &case.loads[..loads.len()] {
            let _ = write!(out, ",{load}");
        }
        for &k in &range {
            let channel = &measured.channels[k];
            let counts = channel.relative_to.is_none() || channel.reference(at).is_some();
            if counts && (all[k] || case.channels[k].is_some()) {
                let _ = write!(out, ",{:.9e}", values[k] / channel.column.1);
            } else {
                out.push(',');
            }
        }
        out.push('\n');
    }
    out
}

/// Returns the TOML text without one section. It is used to remove `[reference]`, which does not describe the ground truth of the new study.
fn without_section(toml: &str, name: &str) -> String {
    let header = format!("[{name}]");
    let mut keep = true;
    let mut out = String::with_capacity(toml.len());
    for line in toml.split_inclusive('\n') {
        let start = line.trim_start();
        if start.starts_with('[') {
            keep = !start.starts_with(&header);
        }
        if keep {
            out += line;
        }
    }
    out
}
