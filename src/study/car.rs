//! Section `[car]` of `study.toml`: the subsystem of Adams/Car that contains the axle of the deck.

use admire_car::Subsystem;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::text::Source;

use super::section::{Section, SpannedText};

/// Contents of section `[car]`.
#[derive(Clone, Debug)]
pub struct CarSettings {
    /// Subsystem file of Adams/Car: key `subsystem`.
    pub subsystem: Subsystem,
    /// Place of the section in `study.toml`.
    pub section: SpannedText,
    /// Markers of the deck with the names of their hardpoints: table `hardpoints`.
    pub hardpoints: Vec<(SpannedText, SpannedText)>,
    /// Bushings of the deck with their names in Adams/Car: table `bushings`.
    pub bushings: Vec<(SpannedText, SpannedText)>,
}

impl CarSettings {
    /// Reads the section. `source` is the text of the subsystem file, whose diagnostics are added to `out`.
    pub(crate) fn read(
        section: &mut Section<'_>,
        source: Option<Source>,
        out: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let span = section.span();
        let hardpoints = section.section("hardpoints", out).all_texts(out);
        let bushings = section.section("bushings", out).all_texts(out);
        let read = Subsystem::parse(source?);
        out.extend(read.diagnostics);
        Some(Self {
            subsystem: read.value,
            section: SpannedText {
                text: "car".to_string(),
                span,
            },
            hardpoints,
            bushings,
        })
    }
}
