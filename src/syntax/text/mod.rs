//! Bytes of files, spans and edits of these bytes, and functions that read and write files.
//!
//! The module is independent of ADAMS. Bytes are edited without decoding, because real decks contain Latin-1 characters.

mod code_page;
mod decimals;
mod edit;
mod held;
mod line_ends;
mod printed;
mod real_path;
mod source;
mod span;

pub use code_page::CodePage;
pub use code_page::Encoded;
pub use decimals::Decimals;
pub use edit::EditConflict;
pub use edit::{Edit, apply_edits};
pub use held::patiently;
pub use line_ends::LineEnds;
pub use printed::masked;
pub use printed::printable;
pub use real_path::real_path;
pub use source::Source;
pub use source::check_size;
pub use source::open_to_read;
pub use source::read_at_most;
pub use span::Span;
