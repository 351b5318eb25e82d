//! Bytes of a file, places in them, edits of them, and how they get into a file.
//!
//! Knows nothing about ADAMS. Bytes of files are never decoded to be edited: real decks hold Latin-1.

mod code_page;
mod digest;
mod edit;
mod held;
mod line_ends;
mod printed;
mod real_path;
mod source;
mod span;

pub use code_page::{CodePage, Encoded};
pub use digest::digest;
pub use edit::{Edit, EditConflict, apply_edits};
pub use held::{patiently, persist};
pub use line_ends::LineEnds;
pub use printed::{masked, printable};
pub use real_path::real_path;
pub use source::{LineColumn, Source, check_size, read_at_most};
pub use span::Span;
