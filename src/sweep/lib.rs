//! Sweeps over thousands of variants of a deck: the varied parameters, the cases, their runs, and one table of results.
//!
//! A [`SweepPlan`] defines the variation, and [`Cases`] is the interface of the cases to be run. A [`Row`] is the result of one case, and
//! [`merge`](fn@merge) joins the tables of shards. Every case is solved from scratch from the text of its own deck, and its random numbers
//! depend only on seed, parameter name and case number. Thus the order, the threads and the shards of a run change no bit of the results.
//! [`uncertainty`] repeats identifications with the same engine, for bootstrap and posterior sampling. This crate is independent of
//! terminals, and does not submit jobs to a cluster; the command `admire sweep` does.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod answer_path;
mod answers;
mod checksum;
mod complaints;
mod correlation;
mod design;
mod distribution;
mod engine;
mod folder;
mod indices;
mod journal;
mod kept;
mod merge;
mod morris;
pub mod normal;
mod page;
mod plan;
mod plan_file;
mod plan_numbers;
mod plan_outputs;
mod random;
mod regression;
mod row;
mod runner;
mod shard;
mod summary;
mod table_reader;
mod table_writer;
mod task;
pub mod uncertainty;
mod variation;

pub use design::Plan;
pub(crate) use engine::SweepError;
pub use engine::run_shard;
pub use engine::{Cases, Places, Progress};
pub(crate) use engine::{run_cases, run_in_memory};
pub use folder::Manifest;
pub use folder::SweepFolder;
pub use kept::{Output, Reduction};
pub use merge::{Columns, merge};
pub use page::page;
pub use page::six_digits;
pub use plan::SweepPlan;
pub use random::Stream;
pub use row::{Row, Status};
pub use runner::Runner;
pub use shard::MOST_SHARDS;
pub use shard::Shard;
pub use shard::ShardError;
pub use summary::OutputSummary;
pub use summary::Summary;
pub use table_reader::TableReader;
pub(crate) use table_writer::Layout;
pub use task::Task;
