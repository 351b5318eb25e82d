//! Identification on the two reference axles: the paper's loop and the direct solution.

mod bad_data;
mod command;
#[path = "../common/mod.rs"]
mod common;
#[allow(
    dead_code,
    non_snake_case,
    reason = "the tests of the solver use the rest"
)]
#[path = "../solver/deck.rs"]
mod deck;
mod direct;
mod free_motions;
mod global;
mod kc_curves;
mod kc_experiment;
mod kc_summary;
mod options;
mod regression;
mod repeats;
mod reproduce;
mod sensors;
mod setup;
mod stated_unknowns;
mod study_folder;
mod threads;
mod verdict;
mod virtual_rig;
