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
                "the marks of {name} do not belong to one part in the load cases {}: the best rigid motion leaves a residual of {:.3} {} rms per \
                 coordinate, more than any part deforms",
                labels.join(", "),
                foreign.rms,
                loaded.model.units.length.word
            ),
        );
        if let Some(read) = place {
            diagnostic = diagnostic.label(marks.measured.source.name(), read.place, "");
        }
        diagnostic.help("correct the readings, or leave out these load cases")
    };
    foreign_marks(measurement).into_iter().map(of).collect()
}
