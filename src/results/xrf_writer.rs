use std::io::{self, Write};

use super::blocks::Blocks;
use super::{Catalogue, Groups, Header, NumberStyle, ResultsTable, ResultsWriter, StepKind};

/// Line end of a text file: LF or CR LF.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum LineEnd {
    /// `\n`.
    #[default]
    Lf,
    /// `\r\n`, as written by versions of ADAMS for Windows before 2017.
    CrLf,
}

impl LineEnd {
    /// Returns the bytes of the line end.
    pub(crate) const fn bytes(self) -> &'static [u8] {
        match self {
            Self::Lf => b"\n",
            Self::CrLf => b"\r\n",
        }
    }
}

/// Details of how an XRF file is spelled.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Style {
    /// Format in which numbers are written.
    pub numbers: NumberStyle,
    /// Line end of all lines.
    pub line_end: LineEnd,
    /// True if the last line has no line end.
    pub open_end: bool,
}

/// Step-by-step writer of an XRF file. Every output step is flushed, so that a killed run leaves only complete steps.
///
/// The layout is the one that existing readers expect, because they parse the file line by line (guide/formats.md 12). Each tag has its own
/// line, attributes have the order of ADAMS, and an empty element ends with ` />`.
#[derive(Debug)]
pub struct XrfWriter<W: Write> {
    output: W,
    style: Style,
    groups: Groups,
    blocks: Blocks,
    text: Vec<u8>,
}

impl<W: Write> XrfWriter<W> {
    /// Writes the header and the map of columns.
    ///
    /// # Errors
    /// Returns an error if the output cannot be written.
    pub fn create(
        output: W,
        header: &Header,
        catalogue: &Catalogue,
        style: Style,
    ) -> io::Result<Self> {
        let mut writer = Self {
            output,
            style,
            groups: Groups::new(catalogue),
            blocks: Blocks::default(),
            text: Vec::new(),
        };
        writer.header(header);
        writer.map(catalogue);
        writer.flush()?;
        Ok(writer)
    }

    /// Writes one output step. If its kind differs from the kind of the step before it, a new Data block is started.
    ///
    /// # Errors
    /// Returns `InvalidInput` if the number of values differs from the number of columns, or if a value is not finite; nothing is written
    /// in this case. Returns another error if the output cannot be written.
    pub fn step(&mut self, kind: StepKind, values: &[f64]) -> io::Result<()> {
        if values.len() != self.groups.len() {
            let message = format!(
                "the step has {} values, but the file has {} columns",
                values.len(),
                self.groups.len()
            );
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        if let Some(at) = values.iter().position(|value| !value.is_finite()) {
            let message = format!("the value of column {} is not finite", at + 1);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, message));
        }
        let before = self.blocks.count();
        if self.blocks.take(kind) {
            if before > 0 {
                self.line("</Data>");
            }
            let (name, id) = (self.blocks.name(), self.blocks.count());
            let line = format!("<Data name=\"{name}\" id=\"{id}\">");
            self.line(&line);
        }
        self.line(&format!("<Step type=\"{}\">", kind.step_type()));
        let (numbers, line_end) = (self.style.numbers, self.style.line_end.bytes());
        self.groups
            .write(&mut self.text, kind, values, numbers, line_end);
        self.line("</Step>");
        self.flush()
    }

    /// Ends the file with the status of the run (such as `Successful`), and returns the output.
    ///
    /// # Errors
    /// Returns an error if the output cannot be written.
    pub fn finish(mut self, run_status: &str) -> io::Result<W> {
        if self.blocks.count() > 0 {
            self.line("</Data>");
        }
        let status = escape(run_status);
        self.line(&format!(
            "<TerminationStatus runTermObject=\"\" runStatus=\"{status}\" />"
        ));
        self.line("</Analysis>");
        self.line("</Results>");
        if self.style.open_end {
            let end = self.text.len() - self.style.line_end.bytes().len();
            self.text.truncate(end);
        }
        self.flush()?;
        Ok(self.output)
    }

    fn line(&mut self, text: &str) {
        self.text.extend_from_slice(text.as_bytes());
        self.text.extend_from_slice(self.style.line_end.bytes());
    }

    /// Writes a Comment element with the given lines, which include their line ends.
    fn comment(&mut self, lines: &str) {
        self.line("<Comment>");
        for line in lines.lines() {
            // Outside of attributes, quotation marks need no escape and are written unchanged.
            self.line(&escape(line).replace("&quot;", "\""));
        }
        self.line("</Comment>");
    }

    fn flush(&mut self) -> io::Result<()> {
        self.output.write_all(&self.text)?;
        self.text.clear();
        self.output.flush()
    }

    fn header(&mut self, h: &Header) {
        self.line("<?xml version=\"1.0\" encoding=\"UTF-8\"?>");
        self.line("<Results xmlns=\"http://www.mscsoftware.com/:xrf10\">");
        self.line("<Bibliography>");
        self.element(
            "File",
            &[
                ("URI", &h.uri),
                ("schema", &h.schema),
                ("version", &h.version),
                ("publicationDate", &h.publication_date),
            ],
        );
        self.element(
            "Corporation",
            &[("author", &h.corporation), ("URI", &h.corporation_uri)],
        );
        self.element("Author", &[("user", &h.user), ("name", &h.user_name)]);
        let (revision, derived) = (escape(&h.revision), escape(&h.derived_from));
        self.line(&format!(
            "<Revision version=\"{revision}\" derivedFrom=\"{derived}\">"
        ));
        self.comment(&h.comment);
        self.line("</Revision>");
        self.line("</Bibliography>");
        // In every real file, two blanks precede `script`.
        self.line(&format!(
            "<Analysis name=\"{}\" executionDate=\"{}\" Solver=\"{}\"  script=\"{}\">",
            escape(&h.analysis),
            escape(&h.execution_date),
            escape(&h.solver),
            escape(&h.script)
        ));
        self.line("<Bibliography>");
        self.element(
            "Environment",
            &[
                ("operatingSystem", &h.operating_system),
                ("hostname", &h.hostname),
            ],
        );
        self.element(
            "Application",
            &[
                ("name", &h.application),
                ("version", &h.application_version),
            ],
        );
        self.line("</Bibliography>");
        let model = [
            ("title", h.title.as_str()),
            ("creationDate", &h.creation_date),
            ("checksum", &h.checksum),
        ];
        if let Some(comment) = &h.model_comment {
            self.line(&format!("<ModelInfo{}>", attributes(&model)));
            self.comment(comment);
            self.line("</ModelInfo>");
        } else {
            self.element("ModelInfo", &model);
        }
        self.element(
            "Units",
            &[
                ("angle", &h.units.angle),
                ("length", &h.units.length),
                ("mass", &h.units.mass),
                ("time", &h.units.time),
            ],
        );
    }

    fn map(&mut self, catalogue: &Catalogue) {
        self.line(&format!("<StepMap name=\"{}\">", escape(&catalogue.name)));
        for entity in &catalogue.entities {
            let id = entity.object_id.map(|id| id.to_string());
            let all = [
                ("name", Some(entity.name.as_str())),
                ("entity", entity.entity.as_deref()),
                ("entType", entity.ent_type.as_deref()),
                ("objectId", id.as_deref()),
                ("comment", entity.comment.as_deref()),
            ];
            self.line(&format!("<Entity{}>", attributes(&present(&all))));
            for component in &entity.components {
                let id = component.id.to_string();
                let all = [
                    ("name", Some(component.name.as_str())),
                    ("unitsValue", component.units.as_deref()),
                    ("plotLabel", component.plot_label.as_deref()),
                    ("id", Some(id.as_str())),
                ];
                self.element("Component", &present(&all));
            }
            self.line("</Entity>");
        }
        self.line("</StepMap>");
    }

    fn element(&mut self, tag: &str, all: &[(&str, &str)]) {
        self.line(&format!("<{tag}{} />", attributes(all)));
    }
}

fn present<'a>(all: &[(&'a str, Option<&'a str>)]) -> Vec<(&'a str, &'a str)> {
    all.iter()
        .filter_map(|&(name, value)| value.map(|value| (name, value)))
        .collect()
}

fn attributes(all: &[(&str, &str)]) -> String {
    all.iter().fold(String::new(), |text, (name, value)| {
        text + " " + name + "=\"" + &escape(value) + "\""
    })
}

impl<W: Write> ResultsWriter for XrfWriter<W> {
    fn step(&mut self, kind: StepKind, values: &[f64]) -> io::Result<()> {
        self.step(kind, values)
    }

    fn finish(self: Box<Self>, status: &str) -> io::Result<Option<ResultsTable>> {
        (*self).finish(status).map(|_| None)
    }
}

impl ResultsTable {
    /// Writes the table as an XRF file with the given header. Apart from the header, the bytes are the same as in the file that a run would
    /// write.
    ///
    /// # Errors
    /// Returns an error if the output cannot be written.
    pub fn write_as(&self, header: &Header, output: impl Write) -> io::Result<()> {
        let style = Style {
            numbers: self.numbers,
            ..Style::default()
        };
        let mut writer = XrfWriter::create(output, header, &self.catalogue, style)?;
        let width = self.catalogue.len().max(1);
        for (kind, values) in self.kinds.iter().zip(self.values.chunks(width)) {
            writer.step(*kind, values)?;
        }
        writer.finish(&self.status)?;
        Ok(())
    }
}

/// Escapes text for XML. Special characters become character references; control characters, which XML does not allow, become blanks.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{EntityKind, Numbering, Stored, Timestamp};
    use admire_syntax::units::Units;

    #[test]
    fn blocks_follow_the_kinds_of_steps() {
        let units = Units::default();
        let mut numbering = Numbering::new(units, Stored::default());
        numbering.object(EntityKind::Bushing, Some(".m.b<1>"), 7, 0);
        numbering.object(EntityKind::Part, None, 2, 0);
        let catalogue = numbering.finish();
        assert_eq!(catalogue.len(), 1 + 18 + 9);
        let header = Header::new("/run/ex.res", "ex", &units, Timestamp::from_unix(0));
        let mut writer =
            XrfWriter::create(Vec::new(), &header, &catalogue, Style::default()).unwrap();
        let mut values = vec![0.0; 28];
        writer.step(StepKind::Input, &values).unwrap();
        values[1] = -1.5;
        writer.step(StepKind::QuasiStatic, &values).unwrap();
        values[0] = 1.0;
        writer.step(StepKind::QuasiStatic, &values).unwrap();
        assert!(writer.step(StepKind::Static, &values[1..]).is_err());
        values[3] = f64::NAN;
        assert!(writer.step(StepKind::Static, &values).is_err());
        let text = String::from_utf8(writer.finish("Successful").unwrap()).unwrap();
        insta::assert_snapshot!(text.split_once("<ModelInfo").unwrap().1);
    }
}
