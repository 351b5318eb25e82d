//! The drop-in solver as seen by callers: a process with a command line, files and an exit code.

#[path = "../common/mod.rs"]
mod common;

mod bad_motions;
#[path = "../common/car_deck.rs"]
mod car_deck;
mod commands;
mod crank;
mod edges;
mod entities;
mod errors;
#[cfg_attr(windows, allow(dead_code, unused_imports))] // Some of it needs a shell of Unix.
mod external;
mod faults;
mod friction;
mod governor;
mod kills;
mod known_motions;
mod launch;
mod level_arm;
mod massless;
mod measured;
#[allow(non_snake_case, reason = "rotation matrices and inertias")]
mod mechanisms;
mod message;
mod motion;
mod output_files;
mod parsers;
#[allow(non_snake_case, reason = "rotation matrices, forces and torques")]
mod random_models;
mod redefinitions;
mod reference;
mod rolling;
mod run;
mod run_files;
mod saving;
mod security;
mod sensors;
mod shims;
#[cfg_attr(windows, allow(dead_code, unused_imports))] // Some of it needs a shell of Unix.
mod solving;
#[path = "../common/squeezer.rs"]
mod squeezer;
mod starting;
mod status;
#[cfg_attr(windows, allow(dead_code, unused_imports))] // Some of it needs a shell of Unix.
mod study_solver;
mod task;
mod together;
mod toolkit;
mod variables;
#[cfg(windows)]
mod windows;
