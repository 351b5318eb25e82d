//! Text of a mapping: the whole TOML file.

use super::column_text::{FILL_IN, filled, quoted};
use super::mapping::Mapping;
use super::named_test::NamedTest;
use super::open_point::{OpenPoint, missing_of};
use admire_kc::{Side, TestKind};

impl Mapping {
    /// Returns the mapping as a commented TOML file. Open points are written as `?`, with the possible words in a comment.
    pub fn text(&self, open: &[OpenPoint]) -> String {
        let mut text = String::from(
            "# What the columns of this laboratory's tables hold: `admire import-kc` reads it, `admire guide kc` explains it.\n",
        );
        let own = &self.file;
        let mut lines = Vec::new();
        if let Some(sheet) = &own.sheet {
            lines.push(format!("sheet = {}", quoted(sheet)));
        }
        match own.header[..] {
            [] => {}
            [line] => lines.push(format!("header = {line}")),
            _ => lines.push(format!("header = {:?}", own.header)),
        }
        if let Some(units) = own.units {
            lines.push(format!("units = {units}"));
        }
        let mark = |byte: u8| quoted(&char::from(byte).to_string());
        if let Some(delimiter) = own.delimiter {
            lines.push(format!("delimiter = {}", mark(delimiter)));
        }
        if let Some(decimal) = own.decimal {
            lines.push(format!("decimal = {}", mark(decimal)));
        }
        if let Some(test) = own.test {
            lines.push(format!("test = {}", quoted(test.name())));
        } else if open.contains(&OpenPoint::NoTest) {
            let words = TestKind::ALL.map(TestKind::name).join(", ");
            lines.push(format!("{}test = {}", filled(&words), quoted(FILL_IN)));
        }
        if let Some(side) = own.side {
            lines.push(format!("side = {}", quoted(side.word())));
        }
        if own.every > 1 {
            lines.push(format!("every = {}", own.every));
        }
        if !lines.is_empty() {
            text += &format!("\n[file]\n{}\n", lines.join("\n"));
        }
        let mut columns = Vec::new();
        for (at, column) in self.columns.iter().enumerate() {
            columns.push(column.line(&missing_of(open, at)));
        }
        text += &format!("\n[columns]\n{}\n", columns.join("\n"));
        let known = |(word, kind): &(String, NamedTest)| {
            format!("{} = {}", quoted(word), quoted(kind.word()))
        };
        let mut lines: Vec<String> = self.tests.iter().map(known).collect();
        lines.extend(open.iter().filter_map(OpenPoint::test_line));
        if !lines.is_empty() {
            text += &format!("\n[tests]\n{}\n", lines.join("\n"));
        }
        let known =
            |(word, side): &(String, Side)| format!("{} = {}", quoted(word), quoted(side.word()));
        let mut lines: Vec<String> = self.sides.iter().map(known).collect();
        lines.extend(open.iter().filter_map(OpenPoint::side_line));
        if !lines.is_empty() {
            text += &format!("\n[sides]\n{}\n", lines.join("\n"));
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::text::Source;

    #[test]
    fn a_written_mapping_is_read_again() {
        let text = "[file]\nheader = [2, 3]\nunits = 4\ndecimal = \",\"\ndelimiter = \"|\"\ntest = \"roll\"\nside = \"left\"\nevery = 5\nsheet = \"A\"\n[columns]\n\"Say \\\"toe\\\"\" = { is = \"toe_angle\", unit = \"mm\", positive = \"out\", over_mm = 406.4, side = \"right\" }\n\"F\" = { load = \"Fy\", load_sign = \"-\", unit = \"kN\" }\n[tests]\n\"Hub\" = \"bounce\"\n[sides]\nVL = \"left\"\n";
        let read = |text: &str| Mapping::read(&Source::new("m", text)).value.unwrap();
        let mapping = read(text);
        assert_eq!(
            mapping.tests,
            [("Hub".to_string(), NamedTest::Test(TestKind::Bounce))]
        );
        assert_eq!(mapping.sides, [("VL".to_string(), Side::Left)]);
        let mut again = read(&mapping.text(&[]));
        for (own, before) in again.columns.iter_mut().zip(&mapping.columns) {
            own.span = before.span;
        }
        assert_eq!(again, mapping);
    }
}
