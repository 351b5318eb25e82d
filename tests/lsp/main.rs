//! The language server: its document of an edited file, and its answers over standard input and output.

mod client;
#[path = "../common/mod.rs"]
mod common;
mod complaints;
mod edits;
mod neovim;
mod real_decks;
mod requests;
mod robust;
