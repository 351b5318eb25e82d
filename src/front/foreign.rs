use admire_identify::LoadedStudy;
use admire_study::{ForeignMarks, foreign_marks};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Returns an error for each part with marks (measured points) that cannot be on this part, because no rigid motion fits them. The error
/// names the load cases concerned.
pub(crate) fn foreign_parts(loaded: &LoadedStudy) -> Vec<Diagnostic> {
    let measurement = &loaded.measurement;
    let Some(marks) = &loaded.study.marks else {
        return Vec::new();
    };
    let of = |foreign: ForeignMarks| {
        let name = &measurement.parts[foreign.part].name;
        let labels: Vec<&str> = foreign
            .cases
            .iter()
            .map(|&case| measurement.cases[case].label.as_str())
            .collect();
        let first = &measurement.cases[foreign.cases[0]].marks;
        let place = first.iter().find(|read| read.part == foreign.part);
        let mut diagnostic = Diagnostic::error(
            Code::InconsistentMarks,
            format!(
                "the marks of {name} in cases {} do not belong to one part: the best rigid motion leaves {:.3} rms, and no part deforms so much",
                labels.join(", "),
                foreign.rms
            ),
        );
        if let Some(read) = place {
            diagnostic = diagnostic.label(marks.measured.source.name(), read.place, "");
        }
        diagnostic.help("correct the readings, or leave these cases out; then diagnose again")
    };
    foreign_marks(measurement).into_iter().map(of).collect()
}
