//! Thousands of variants of a deck: what varies, which cases, running them anywhere, one table of answers.
//!
//! Every case is solved cold from the text of its own deck, and its numbers are functions of seed, name and case alone. So the order,
//! the threads and the shards of a run change no bit of the answer. Knows nothing about terminals; who submits shards is the matter of
//! the command.

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
mod plan_keeps;
mod plan_numbers;
mod random;
mod regression;
mod row;
mod runner;
mod shard;
mod summary;
mod table_reader;
mod table_writer;
mod task;
mod variation;

pub use design::Plan;
pub(crate) use engine::SweepError;
pub use engine::{Cases, Places, Progress};
pub(crate) use engine::{run_cases, run_in_memory, run_shard};
pub(crate) use folder::{Manifest, SweepFolder};
pub use kept::{At, Output};
pub use merge::{Columns, merge};
pub use page::page;
pub(crate) use page::six_digits;
pub use plan::SweepPlan;
pub use random::Stream;
pub use row::{Row, Status};
pub(crate) use runner::Runner;
pub(crate) use shard::MOST_SHARDS;
pub(crate) use shard::{Shard, ShardError};
pub(crate) use summary::{OutputSummary, Summary};
pub use table_reader::TableReader;
pub(crate) use table_writer::Layout;
pub use task::Task;
