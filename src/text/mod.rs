//! Bytes of a file, places in them, and edits of them.
//!
//! Knows nothing about encodings (real decks hold Latin-1 bytes) or about ADAMS.

mod edit;
mod printed;
mod source;
mod span;

pub use edit::{Edit, EditConflict, apply_edits};
pub use printed::{masked, printable};
pub use source::{LineColumn, Source, check_size, read_at_most};
pub use span::Span;
