//! Bytes of a file, places in them, and edits of them.
//!
//! Knows nothing about encodings (real decks hold Latin-1 bytes), about ADAMS, or about where the bytes came from.

mod edit;
mod source;
mod span;

pub use edit::{Edit, EditConflict, apply_edits};
pub use source::{LineColumn, Source};
pub use span::Span;
