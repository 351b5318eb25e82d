use std::path::{Path, PathBuf};

use admire_results::{
    AnyResults, Catalogue, EntityKind, Header, ResultsError, SelectedColumn, Selection, StepFilter,
    StepKind, open_any,
};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::grammar::nearest;

use super::error::{Error, ErrorKind};
use admire_diagnosis::ProgressObserver;

/// Results file of any kind (.res, .req, .gra). Names and units are read when the file is opened. Values are read step by step when they
/// are requested, so that files of any size can be used.
///
/// Example: find the bushing force that a lateral load changes most.
///
/// ```
/// use admire::{Deck, Results, SharedProgress, StepFilter, StepKind};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// # let folder = tempfile::tempdir()?;
/// let file = folder.path().join("lateral.res");
/// let run = Deck::open("corpus/pseudo-mcpherson/model.adm")?.run("corpus/pseudo-mcpherson/lateral.acf")?;
/// run.succeeded()?;
/// run.write(&file, false)?;
///
/// let equilibria = StepFilter { kinds: vec![StepKind::Static], ..StepFilter::default() };
/// let patterns = ["BUSHING/*.F?"];
/// let rows = Results::open(&file)?.select(&patterns, &equilibria, &SharedProgress::default())?;
/// let mut steps = rows.values.chunks(rows.columns.len());
/// let (vertical, lateral) = (steps.next().ok_or("no step")?, steps.next().ok_or("one step")?);
/// let change = |k: &usize| (lateral[*k] - vertical[*k]).abs();
/// let most = (0..rows.columns.len()).max_by(|a, b| change(a).total_cmp(&change(b)));
/// let most = most.ok_or("no bushing")?;
/// println!("{} changes by {:.0} N", rows.columns[most].path, change(&most));
/// // A bushing takes a good part of the 2000 N.
/// assert!(change(&most) > 200.0);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Results {
    path: PathBuf,
    header: Header,
    catalogue: Catalogue,
    columns: Vec<SelectedColumn>,
}

/// Selected columns of a results file, with one row for each step.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Rows {
    /// Columns, in the order of the values in a row.
    pub columns: Vec<SelectedColumn>,
    /// Kind of each step.
    pub kinds: Vec<StepKind>,
    /// All values, row by row.
    pub values: Vec<f64>,
}

impl Results {
    /// Opens a results file and reads its header.
    ///
    /// # Errors
    /// When the file cannot be read or is not a results file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let reader = open(path)?;
        Ok(Self {
            path: path.to_path_buf(),
            header: reader.header().clone(),
            catalogue: reader.catalogue().clone(),
            columns: Selection::all(reader.catalogue()).columns,
        })
    }

    /// Returns the path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the header of the file.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Returns all columns with their units.
    pub fn columns(&self) -> &[SelectedColumn] {
        &self.columns
    }

    /// Reads a column, one value for each step. Examples of names: `KNUCKLE.X`, `KNUCKLE_XFORM.X`, `BUSHING/1.FX`.
    ///
    /// # Errors
    /// When no column has this name, when the name is ambiguous, or when the file cannot be read to its end.
    pub fn column(&self, name: &str, watch: &dyn ProgressObserver) -> Result<Vec<f64>, Error> {
        let columns = vec![one_column(&self.catalogue, name)?];
        let read = self.read(Selection { columns }, &StepFilter::default(), watch)?;
        Ok(read.values)
    }

    /// Reads the columns that match any of the patterns, in the steps that pass a filter. `*` matches any text, and `?` one character. The
    /// name of an entity matches all components of the entity. Without patterns, all columns are read.
    ///
    /// # Errors
    /// When a pattern matches no column, or when the file cannot be read to its end.
    pub fn select(
        &self,
        patterns: &[&str],
        filter: &StepFilter,
        watch: &dyn ProgressObserver,
    ) -> Result<Rows, Error> {
        let selection = if patterns.is_empty() {
            Selection::all(&self.catalogue)
        } else {
            selected(&self.catalogue, patterns)?
        };
        self.read(selection, filter, watch)
    }

    fn read(
        &self,
        selection: Selection,
        filter: &StepFilter,
        watch: &dyn ProgressObserver,
    ) -> Result<Rows, Error> {
        let mut reader = open(&self.path)?;
        let (mut kinds, mut values) = (Vec::new(), Vec::new());
        let read = selection.rows(reader.as_mut(), filter, |kind, _, row| {
            kinds.push(kind);
            values.extend_from_slice(row);
            if watch.goes_on() {
                Ok(())
            } else {
                Err(std::io::ErrorKind::Interrupted.into())
            }
        });
        read.map_err(|error| failed(&self.path, error))?;
        Ok(Rows {
            columns: selection.columns,
            kinds,
            values,
        })
    }
}

pub(super) fn open(path: &Path) -> Result<AnyResults, Error> {
    let opened = open_any(path).map_err(|error| failed(path, error))?;
    Ok(opened.value)
}

fn failed(path: &Path, error: ResultsError) -> Error {
    match error {
        ResultsError::Io(error) => Error::unreadable(path, &error),
        ResultsError::Refused(refused) => Error::plain(ErrorKind::Input, &refused),
    }
}

/// Selects the columns that match patterns; it is an error if a pattern matches no column.
pub(crate) fn selected(catalogue: &Catalogue, patterns: &[&str]) -> Result<Selection, Error> {
    let (selection, unused) = Selection::matching(catalogue, patterns);
    let Some(pattern) = unused.first() else {
        return Ok(selection);
    };
    let mut known: Vec<String> = Vec::new();
    for column in catalogue.columns() {
        let object = column.entity.entity.as_deref().unwrap_or_default();
        let plain = object.rsplit('.').next().unwrap_or(object);
        known.push(column.path());
        known.push(format!("{plain}.{}", column.component.name));
        if let (Some(class), Some(id)) = (&column.entity.ent_type, column.entity.object_id) {
            let keyword = EntityKind::keyword(class);
            known.push(format!("{keyword}/{id}.{}", column.component.name));
        }
    }
    let capitals: Vec<String> = known.iter().map(|path| path.to_uppercase()).collect();
    let near = nearest(pattern, capitals.iter().map(String::as_str))
        .and_then(|near| capitals.iter().position(|path| path == near));
    let message = format!("the results have no column `{pattern}`");
    let mut refused = Diagnostic::error(Code::UndefinedId, message);
    if let Some(at) = near {
        refused = refused.help(format!("did you mean `{}`?", known[at]));
    }
    Err(Error::plain(ErrorKind::Usage, &refused))
}

/// Returns the column with this name; it is an error if there is no such column or more than one.
pub(crate) fn one_column(catalogue: &Catalogue, name: &str) -> Result<SelectedColumn, Error> {
    let mut found = selected(catalogue, &[name])?.columns;
    if found.len() == 1 {
        return Ok(found.remove(0));
    }
    let some: Vec<&str> = found.iter().take(6).map(|c| c.path.as_str()).collect();
    let more = if found.len() > some.len() {
        ", ..."
    } else {
        ""
    };
    let message = format!(
        "`{name}` matches {} columns: {}{more}",
        found.len(),
        some.join(", ")
    );
    let refused = Diagnostic::error(Code::AmbiguousKeyword, message);
    Err(Error::plain(
        ErrorKind::Usage,
        &refused.help("name one of them, or select all of them"),
    ))
}
