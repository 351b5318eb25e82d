use admire_syntax::units::Units;

use super::Timestamp;

/// Header of an XRF file. It contains every attribute that occurs in real files, so that a header is written back exactly as it was read.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Header {
    /// Address (`file://...`) at which the file was written.
    pub uri: String,
    /// Name of the file's schema, `xrf`.
    pub schema: String,
    /// Version of the schema.
    pub version: String,
    /// Date and time at which the program started to write the file.
    pub publication_date: String,
    /// Company that made the program.
    pub corporation: String,
    /// Web address of the company that made the program.
    pub corporation_uri: String,
    /// Login name of the user.
    pub user: String,
    /// Full name of the user.
    pub user_name: String,
    /// Revision number of the file.
    pub revision: String,
    /// File from which this revision was derived.
    pub derived_from: String,
    /// Comment on the revision (RESULTS/COMMENT), with the line end of each line; usually empty.
    pub comment: String,
    /// Name of the analysis.
    pub analysis: String,
    /// Date and time of the analysis.
    pub execution_date: String,
    /// Name and version of the solver.
    pub solver: String,
    /// Name of the script that ran the analysis.
    pub script: String,
    /// Operating system of the host computer.
    pub operating_system: String,
    /// Name of the host computer.
    pub hostname: String,
    /// Program that created the model.
    pub application: String,
    /// Version of the program in `application`.
    pub application_version: String,
    /// Title of the model: the first line of the dataset.
    pub title: String,
    /// Date and time at which the model was created.
    pub creation_date: String,
    /// Checksum of the model.
    pub checksum: String,
    /// Comment on the model, with the line end of each line; `None` if the file has no such element.
    pub model_comment: Option<String>,
    /// Units of the result columns.
    pub units: ResultUnits,
}

/// Units in which an XRF file gives its results, as spelled in the file.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct ResultUnits {
    /// Unit of angle, `rad` or `deg`.
    pub angle: String,
    /// Unit of length, for example `mm`.
    pub length: String,
    /// Unit of mass, for example `kg`.
    pub mass: String,
    /// Unit of time, for example `sec`.
    pub time: String,
}

impl From<&Units> for ResultUnits {
    fn from(units: &Units) -> Self {
        Self {
            angle: "rad".to_string(),
            length: units.length.word.to_string(),
            mass: units.mass.word.to_string(),
            time: units.time.word.to_string(),
        }
    }
}

impl Header {
    /// Creates the header for a run of `admire`.
    ///
    /// `path` is the path of the file with the path separators of the operating system, `title` is the title of the model, and `when` is
    /// the time of writing.
    pub fn new(path: &str, title: &str, units: &Units, when: Timestamp) -> Self {
        let unknown = || "-unknown-".to_string();
        let version = env!("CARGO_PKG_VERSION");
        Self {
            uri: format!("file://{path}"),
            schema: "xrf".to_string(),
            version: "2.0.0.0".to_string(),
            publication_date: when.with_offset(),
            corporation: "admire".to_string(),
            corporation_uri: unknown(),
            user: unknown(),
            user_name: "-unknown name-".to_string(),
            revision: "1".to_string(),
            derived_from: unknown(),
            comment: String::new(),
            analysis: "ANALYSIS_01".to_string(),
            execution_date: when.date_time(),
            solver: format!("admire {version}"),
            script: unknown(),
            operating_system: std::env::consts::OS.to_string(),
            hostname: unknown(),
            application: "admire".to_string(),
            application_version: version.to_string(),
            title: title.to_string(),
            creation_date: unknown(),
            checksum: unknown(),
            model_comment: None,
            units: ResultUnits::from(units),
        }
    }
}
