//! The drop-in solver as callers see it: a process with a command line, files and an exit code.

#[path = "../common/mod.rs"]
mod common;

mod commands;
mod errors;
mod launch;
mod reference;
mod run;
mod security;
mod shims;
mod toolkit;
