use std::io::Write;

use super::{Catalogue, Column, EntityKind, ResultsError, ResultsReader, StepFilter, StepKind};

/// Selected columns of a results file, in the order of their ids.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize)]
pub struct Selection {
    /// The selected columns.
    pub columns: Vec<SelectedColumn>,
}

/// A selected column.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize)]
pub struct SelectedColumn {
    /// Full name of the column, such as `testrig.arm_XFORM.X`. If several columns have the same name, the second and further ones get the
    /// suffix `#2`, `#3`, ...
    pub path: String,
    /// Unit of the column; `None` if the file gives none.
    pub units: Option<String>,
    /// Id of the column: the 1-based position of its value in an output step.
    pub id: usize,
}

impl Selection {
    /// Selects all columns that the catalogue names.
    pub fn all(catalogue: &Catalogue) -> Self {
        Self::new(catalogue, |_| true)
    }

    /// Selects the columns that match any of the patterns. Also returns the patterns that match no column.
    ///
    /// A pattern has the form `ENTITY.COMPONENT`. Case is ignored, `*` matches any text and `?` matches one character.
    ///
    /// The entity may be given by its result set (`arm_XFORM`), its full name (`testrig.arm_XFORM`), its object (`testrig.arm`, or just
    /// `arm`) or its statement (`BUSHING/1`). A pattern that gives only an entity selects all columns of the entity.
    pub fn matching<'p>(catalogue: &Catalogue, patterns: &[&'p str]) -> (Self, Vec<&'p str>) {
        let mut used = vec![false; patterns.len()];
        let selection = Self::new(catalogue, |column| {
            let mut any = false;
            for (pattern, used) in patterns.iter().zip(&mut used) {
                if matches_column(pattern, column) {
                    *used = true;
                    any = true;
                }
            }
            any
        });
        let unused = patterns.iter().zip(used).filter(|(_, used)| !used);
        (selection, unused.map(|(&pattern, _)| pattern).collect())
    }

    fn new(catalogue: &Catalogue, mut wanted: impl FnMut(Column<'_>) -> bool) -> Self {
        let mut seen = std::collections::BTreeMap::new();
        let mut columns = Vec::new();
        for column in catalogue.columns() {
            let mut path = column.path();
            let count = seen.entry(path.to_ascii_lowercase()).or_insert(0_usize);
            *count += 1;
            if *count > 1 {
                path = format!("{path}#{count}");
            }
            if wanted(column) {
                columns.push(SelectedColumn {
                    path,
                    units: column.component.units.clone(),
                    id: column.component.id,
                });
            }
        }
        columns.sort_by_key(|column| column.id);
        Self { columns }
    }

    /// Returns the ids of the selected columns in increasing order.
    pub fn ids(&self) -> Vec<usize> {
        self.columns.iter().map(|column| column.id).collect()
    }

    /// Calls `row` with the kind, the block name and the selected values of each output step that the filter accepts. Returns the number of
    /// these steps.
    ///
    /// # Errors
    /// Returns an error if reading fails or `row` returns an error.
    pub fn rows(
        &self,
        reader: &mut dyn ResultsReader,
        filter: &StepFilter,
        mut row: impl FnMut(StepKind, &str, &[f64]) -> std::io::Result<()>,
    ) -> Result<usize, ResultsError> {
        let time = reader
            .catalogue()
            .columns()
            .find(|column| column.component.name.eq_ignore_ascii_case("TIME"))
            .map(|column| column.component.id);
        let ids = self.ids();
        let (mut values, mut now, mut steps) = (Vec::new(), Vec::new(), 0);
        let mut last: Option<(StepKind, String, Vec<f64>)> = None;
        while let Some(step) = reader.next_step()? {
            now.clear();
            if let Some(time) = time {
                step.pick(&[time], &mut now)?;
            }
            if !filter.takes(step.index, step.kind, now.first().copied()) {
                continue;
            }
            values.clear();
            step.pick(&ids, &mut values)?;
            if filter.last {
                last = Some((step.kind, step.block.to_string(), values.clone()));
                continue;
            }
            row(step.kind, step.block, &values)?;
            steps += 1;
        }
        if let Some((kind, block, values)) = last {
            row(kind, &block, &values)?;
            steps += 1;
        }
        Ok(steps)
    }

    /// Returns the values of the selected columns in all output steps that the filter accepts; each row contains one step.
    ///
    /// # Errors
    /// Returns an error if reading fails.
    pub fn values_of(
        &self,
        reader: &mut dyn ResultsReader,
        filter: &StepFilter,
    ) -> Result<Vec<Vec<f64>>, ResultsError> {
        let mut rows = Vec::new();
        self.rows(reader, filter, |_, _, values| {
            rows.push(values.to_vec());
            Ok(())
        })?;
        Ok(rows)
    }

    /// Writes the remaining output steps of a reader as CSV and returns their number.
    ///
    /// The first line contains the names with units (`arm_XFORM.X [mm]`). Each further line contains the kind of one step and its values,
    /// in the shortest spelling that reads back exactly.
    ///
    /// # Errors
    /// Returns an error if reading or writing fails. All steps before the failure have then been written.
    pub fn write_csv(
        &self,
        reader: &mut dyn ResultsReader,
        output: impl Write,
    ) -> Result<usize, ResultsError> {
        self.write_csv_of(reader, output, &StepFilter::default(), false)
    }

    /// Writes the output steps that the filter accepts as CSV and returns their number.
    ///
    /// If `plain` is true, names have no units and lines contain no kind of step. Other programs can then read every field below the names
    /// as a number.
    ///
    /// # Errors
    /// Returns an error if reading or writing fails. All steps before the failure have then been written.
    pub fn write_csv_of(
        &self,
        reader: &mut dyn ResultsReader,
        output: impl Write,
        filter: &StepFilter,
        plain: bool,
    ) -> Result<usize, ResultsError> {
        let mut csv = csv::Writer::from_writer(output);
        let names = self.columns.iter().map(|column| match &column.units {
            Some(units) if !plain => format!("{} [{units}]", column.path),
            _ => column.path.clone(),
        });
        // I/O errors are passed on unchanged, so that callers can recognise a closed pipe.
        let io = |error: csv::Error| match error.into_kind() {
            csv::ErrorKind::Io(error) => error,
            other => std::io::Error::other(format!("{other:?}")),
        };
        let step = (!plain).then(|| "step".to_string());
        csv.write_record(step.into_iter().chain(names))
            .map_err(io)?;
        let steps = self.rows(reader, filter, |kind, _, values| {
            if !plain {
                csv.write_field(kind.step_type()).map_err(io)?;
            }
            for value in values {
                csv.write_field(value.to_string()).map_err(io)?;
            }
            csv.write_record(None::<&[u8]>).map_err(io)
        })?;
        csv.flush()?;
        Ok(steps)
    }

    /// Writes the remaining output steps of a reader as one JSON object and returns their number.
    ///
    /// `columns` contains path, units and id of each column; `steps` contains kind, block and values of each step. A value that is not
    /// finite is written as `null`.
    ///
    /// # Errors
    /// Returns an error if reading or writing fails; the output is then incomplete.
    pub fn write_json(
        &self,
        reader: &mut dyn ResultsReader,
        output: impl Write,
    ) -> Result<usize, ResultsError> {
        self.write_json_of(reader, output, &StepFilter::default())
    }

    /// Writes the output steps that the filter accepts as one JSON object and returns their number.
    ///
    /// # Errors
    /// Returns an error if reading or writing fails; the output is then incomplete.
    pub fn write_json_of(
        &self,
        reader: &mut dyn ResultsReader,
        mut output: impl Write,
        filter: &StepFilter,
    ) -> Result<usize, ResultsError> {
        #[derive(serde::Serialize)]
        struct Row<'a> {
            kind: &'a str,
            block: &'a str,
            values: &'a [f64],
        }
        let json = std::io::Error::from;
        output.write_all(b"{\"columns\":")?;
        serde_json::to_writer(&mut output, &self.columns).map_err(json)?;
        output.write_all(b",\"steps\":[")?;
        let mut first = true;
        let steps = self.rows(reader, filter, |kind, block, values| {
            output.write_all(if first { b"\n" } else { b",\n" })?;
            first = false;
            let row = Row {
                kind: kind.step_type(),
                block,
                values,
            };
            serde_json::to_writer(&mut output, &row).map_err(json)
        })?;
        output.write_all(b"\n]}\n")?;
        output.flush()?;
        Ok(steps)
    }
}

fn matches_column(pattern: &str, column: Column<'_>) -> bool {
    let set = &column.entity.name;
    let component = &column.component.name;
    let full = column.path();
    let full_set = full.strip_suffix(component.as_str()).unwrap_or(&full);
    let full_set = full_set.strip_suffix('.').unwrap_or(full_set);
    let object = column.entity.entity.as_deref().unwrap_or(set);
    // The name of the object without the models that contain it, for patterns such as `arm.X`.
    let plain = object.rsplit('.').next().unwrap_or(object);
    let statement = match (&column.entity.ent_type, column.entity.object_id) {
        (Some(class), Some(id)) => format!("{}/{id}", EntityKind::keyword(class)),
        _ => String::new(),
    };
    [set, full_set, object, plain, &statement]
        .iter()
        .any(|name| glob(pattern, name) || glob(pattern, &format!("{name}.{component}")))
}

/// Returns true if `text` matches `pattern`, where `*` matches any text and `?` one character; case is ignored.
///
/// The algorithm is not recursive, and its time for each `*` is linear in the length of the text.
fn glob(pattern: &str, text: &str) -> bool {
    let fold = |text: &str| {
        text.chars()
            .map(|c| c.to_ascii_lowercase())
            .collect::<Vec<_>>()
    };
    let (pattern, text) = (fold(pattern), fold(text));
    let (mut p, mut t) = (0, 0);
    let mut star = None;
    while t < text.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, t));
                p += 1;
            }
            Some(&c) if c == '?' || c == text[t] => {
                p += 1;
                t += 1;
            }
            _ => match star {
                Some((at, from)) => {
                    star = Some((at, from + 1));
                    p = at + 1;
                    t = from + 1;
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|&c| c == '*')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_stand_for_text() {
        assert!(glob("part_2_xform.*", "PART_2_XFORM.PSI"));
        assert!(glob("*.F?", "JOINT_1.FX"));
        assert!(!glob("*.F?", "JOINT_1.FXX"));
        assert!(glob("a*b*c", "aXbXbXc"));
        assert!(!glob("a*b", "aXc"));
        assert!(!glob("", "a"));
        assert!(glob("**", ""));
        let hostile = "*a".repeat(50);
        assert!(!glob(&hostile, &"b".repeat(2000)));
    }
}
