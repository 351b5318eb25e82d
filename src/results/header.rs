use admire_syntax::units::Units;

use super::Timestamp;

/// What an XRF file says of itself before its results. Every attribute of real files is here, so that writing a header
/// that was read gives the same bytes.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct Header {
    /// Where the file was written, `file://...`.
    pub uri: String,
    /// Schema, `xrf`.
    pub schema: String,
    /// Version of the schema.
    pub version: String,
    /// When the file was begun.
    pub publication_date: String,
    /// Who makes the program.
    pub corporation: String,
    /// Where to find them.
    pub corporation_uri: String,
    /// Log-in name.
    pub user: String,
    /// Full name.
    pub user_name: String,
    /// Revision of the file.
    pub revision: String,
    /// What the revision comes from.
    pub derived_from: String,
    /// Lines of the revision's comment (RESULTS/COMMENT), each with its line end; usually empty.
    pub comment: String,
    /// Name of the analysis.
    pub analysis: String,
    /// When the analysis ran.
    pub execution_date: String,
    /// The solver.
    pub solver: String,
    /// The script that ran it.
    pub script: String,
    /// Operating system.
    pub operating_system: String,
    /// Host.
    pub hostname: String,
    /// Program that made the model.
    pub application: String,
    /// Its version.
    pub application_version: String,
    /// Title of the model: the first line of the dataset.
    pub title: String,
    /// When the model was made.
    pub creation_date: String,
    /// Checksum of the model.
    pub checksum: String,
    /// Lines of the model's comment, each with its line end; `None` if the file has no such element.
    pub model_comment: Option<String>,
    /// Units of the results.
    pub units: ResultUnits,
}

/// Units of results as the file spells them.
#[derive(Clone, PartialEq, Eq, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct ResultUnits {
    /// `rad` or `deg`.
    pub angle: String,
    /// For example `mm`.
    pub length: String,
    /// For example `kg`.
    pub mass: String,
    /// For example `sec`.
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
    /// The header of a run of ours: `path` of the file (forward or backward slashes as the system has them), `title` of the
    /// model, its units, and when it is written.
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
