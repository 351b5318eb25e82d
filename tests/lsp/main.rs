//! The language server: what it holds of a file that is being edited, and what it answers over standard input and output.

mod client;
mod complaints;
mod edits;
mod neovim;
mod requests;
mod robust;
