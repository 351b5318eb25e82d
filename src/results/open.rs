use std::io::{Cursor, Read};
use std::path::Path;

use admire_syntax::diagnostic::Checked;
use admire_syntax::text::{Source, check_size, open_to_read};

use super::table_reader::TableReader;
use super::{
    Catalogue, Component, Entity, EntityKind, FormattedResults, GraphicsFile, Header, NumberStyle,
    RequestFile, ResultsError, ResultsReader, ResultsTable, StepKind, XrfReader,
};

/// Size in bytes of the largest file that is read into memory as a whole. Its parsed values need several times this memory.
const LARGEST_WHOLE: u64 = 512 << 20;

/// Reader of a results file, whatever its kind.
pub type AnyResults = Box<dyn ResultsReader>;

/// Opens a results file; its kind is recognised from its content.
///
/// XRF files are read from disk step by step. Request, graphics and formatted results files are small, so each is read as a whole into a
/// table. The returned diagnostics concern only files that are read as a whole; the reader of an XRF file collects its own diagnostics.
///
/// # Errors
/// Returns an error if the file cannot be read or is of none of these kinds. Returns an error if a file that must be read as a whole
/// exceeds 512 MiB.
pub fn open_any(path: &Path) -> Result<Checked<AnyResults>, ResultsError> {
    let name = path.display().to_string();
    let mut file = open_to_read(path)?;
    let mut head = Vec::new();
    file.by_ref().take(64).read_to_end(&mut head)?;
    let begins = head.trim_ascii_start();
    let request = begins.starts_with(b"A.R3");
    let graphics = begins.starts_with(b"A.G8");
    if !request && !graphics && !begins.starts_with(b"FILE TYPE AND SOURCE") {
        let whole: Box<dyn Read> = Box::new(Cursor::new(head).chain(file));
        return Ok(Checked::clean(Box::new(XrfReader::open(name, whole)?)));
    }
    check_size(file.metadata()?.len(), LARGEST_WHOLE)?;
    let room = LARGEST_WHOLE + 1 - head.len() as u64;
    file.take(room).read_to_end(&mut head)?;
    check_size(head.len() as u64, LARGEST_WHOLE)?;
    let source = Source::new(name.as_str(), head);
    let (table, diagnostics) = if request {
        let read = RequestFile::parse(&source);
        (request_table(&read.value)?, read.diagnostics)
    } else if graphics {
        let read = GraphicsFile::parse(&source);
        (graphics_table(&read.value)?, read.diagnostics)
    } else {
        let read = FormattedResults::parse(&source);
        (formatted_table(&read.value)?, read.diagnostics)
    };
    Ok(Checked {
        value: Box::new(TableReader::new(name, table)),
        diagnostics,
    })
}

/// Appends an entity, whose columns are numbered after the existing columns. The columns get no units, because request, graphics and formatted
/// results files name none.
fn add(
    catalogue: &mut Catalogue,
    class: &str,
    name: String,
    object: String,
    id: i64,
    columns: &[&str],
) {
    let before = catalogue.len();
    let components = columns.iter().enumerate().map(|(at, &column)| Component {
        name: column.to_string(),
        units: None,
        plot_label: None,
        id: before + at + 1,
    });
    catalogue.entities.push(Entity {
        name: plain(&name),
        entity: Some(plain(&object)),
        ent_type: Some(class.to_string()),
        object_id: Some(id),
        comment: None,
        components: components.collect(),
    });
}

/// Replaces control characters by blanks, because results files contain no control characters.
fn plain(text: &str) -> String {
    text.replace(char::is_control, " ")
}

fn only_time() -> Catalogue {
    let time = Component {
        name: "TIME".to_string(),
        units: None,
        plot_label: None,
        id: 1,
    };
    Catalogue::new(vec![Entity {
        name: "time".to_string(),
        components: vec![time],
        ..Entity::default()
    }])
}

fn request_table(file: &RequestFile) -> std::io::Result<ResultsTable> {
    let mut catalogue = only_time();
    for request in &file.requests {
        let name = if request.name.is_empty() {
            EntityKind::Request.default_name(request.id)
        } else {
            request.name.clone()
        };
        // The file does not say which quantity a request measures. Its columns 2, 3, 4 contain a vector and its columns 6, 7, 8 a rotation.
        let columns = ["X", "Y", "Z", "R1", "R2", "R3"];
        add(
            &mut catalogue,
            EntityKind::Request.ent_type(),
            name.clone(),
            name,
            request.id,
            &columns,
        );
    }
    let header = Header {
        title: plain(&file.title),
        execution_date: plain(&file.date),
        ..Header::default()
    };
    let steps = file.times.iter().zip(&file.values).map(|(&time, sixes)| {
        let values = std::iter::once(time).chain(sixes.iter().flatten().copied());
        (StepKind::Unlisted, values.collect::<Vec<f64>>())
    });
    table(header, catalogue, steps)
}

fn graphics_table(file: &GraphicsFile) -> std::io::Result<ResultsTable> {
    let mut catalogue = only_time();
    for part in &file.parts {
        let object = EntityKind::Part.default_name(*part);
        let columns = ["X", "Y", "Z", "PSI", "THETA", "PHI"];
        let name = format!("{object}_XFORM");
        add(
            &mut catalogue,
            EntityKind::Part.ent_type(),
            name,
            object,
            *part,
            &columns,
        );
    }
    for force in &file.forces {
        let name = format!("GRAPHICS_{force}");
        let columns = ["FX", "FY", "FZ", "TX", "TY", "TZ"];
        add(
            &mut catalogue,
            "Graphics",
            name.clone(),
            name,
            *force,
            &columns,
        );
    }
    let header = Header {
        title: plain(&file.title),
        execution_date: plain(&file.date),
        ..Header::default()
    };
    let steps = file.times.iter().enumerate().map(|(frame, &time)| {
        let sixes = file.poses[frame].iter().chain(&file.loads[frame]);
        let values = std::iter::once(time).chain(sixes.flatten().copied());
        (file.kinds[frame], values.collect::<Vec<f64>>())
    });
    table(header, catalogue, steps)
}

fn formatted_table(file: &FormattedResults) -> std::io::Result<ResultsTable> {
    let mut catalogue = only_time();
    for part in &file.parts {
        let object = match &part.name {
            Some(full) => super::numbering::without_model(full),
            None => EntityKind::Part.default_name(part.id),
        };
        let last = object.rsplit('.').next().unwrap_or(&object);
        let name = format!("{last}_XFORM");
        let columns = ["X", "Y", "Z", "PSI", "THETA", "PHI"];
        add(
            &mut catalogue,
            EntityKind::Part.ent_type(),
            name,
            object,
            part.id,
            &columns,
        );
    }
    let header = Header {
        title: plain(&file.title),
        ..Header::default()
    };
    let steps = file.steps.iter().map(|step| {
        let kind = match step.kind.to_ascii_uppercase().as_str() {
            "STATIC" => StepKind::Static,
            "QUASI-STATIC" | "QUASISTATIC" => StepKind::QuasiStatic,
            "KINEMATIC" => StepKind::Kinematic,
            "DYNAMIC" => StepKind::Dynamic,
            _ => StepKind::Unlisted,
        };
        let values = std::iter::once(step.time).chain(step.displacements.iter().flatten().copied());
        (kind, values.collect::<Vec<f64>>())
    });
    table(header, catalogue, steps)
}

fn table(
    header: Header,
    catalogue: Catalogue,
    steps: impl Iterator<Item = (StepKind, Vec<f64>)>,
) -> std::io::Result<ResultsTable> {
    let mut table = ResultsTable::new(header, catalogue, NumberStyle::default());
    for (kind, values) in steps {
        table.push(kind, &values)?;
    }
    Ok(table)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Selection;

    #[test]
    fn request_files_are_shown_like_any_other() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.req");
        let text = " A.R3    2020-01-01 00:00:00               0         0  3D\nt\n    1     MMKGS_N_RACA 1.0E+03\n\
                    toe angle\n         5\n 0.5\n 1 2 3 4 5 6\n";
        std::fs::write(&path, text).unwrap();
        let mut opened = open_any(&path).unwrap();
        assert!(opened.diagnostics.is_empty());
        let (selection, unused) =
            Selection::matching(opened.value.catalogue(), &["toe*.r1", "time"]);
        assert!(unused.is_empty());
        let mut csv = Vec::new();
        selection
            .write_csv(opened.value.as_mut(), &mut csv)
            .unwrap();
        assert_eq!(
            String::from_utf8(csv).unwrap(),
            "step,time.TIME,toe angle.R1\nunlisted,0.5,4\n"
        );
        assert!(open_any(&folder.path().join("none")).is_err());
    }
}
