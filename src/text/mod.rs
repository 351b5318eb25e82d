//! Bytes of a file, places in them, edits of them, and how they get into a file.
//!
//! Knows nothing about ADAMS. Bytes of files are never decoded to be edited: real decks hold Latin-1.

mod code_page;
mod decimals;
mod digest;
mod edit;
mod held;
mod line_ends;
mod printed;
mod real_path;
mod source;
mod span;

pub(crate) use code_page::{CodePage, Encoded};
pub(crate) use decimals::Decimals;
pub(crate) use digest::digest;
pub(crate) use edit::EditConflict;
pub use edit::{Edit, apply_edits};
pub(crate) use held::{patiently, persist};
pub use line_ends::LineEnds;
pub(crate) use printed::{masked, printable};
pub(crate) use real_path::real_path;
pub use source::Source;
pub(crate) use source::{check_size, open_to_read, read_at_most};
pub use span::Span;
