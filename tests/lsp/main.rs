//! The language server: what it holds of a file that is being edited, and what it answers over standard input and output.

mod client;
#[path = "../common/mod.rs"]
mod common;
mod complaints;
mod edits;
mod neovim;
mod real_decks;
mod requests;
mod robust;
