//! Parsing, editing and lowering of real files: nothing is lost, nothing is misread.

mod common;
mod files {
    pub mod adding;
    pub mod bulk;
    pub mod checking;
    pub mod commands;
    pub mod comparing;
    pub mod completion;
    pub mod editing;
    pub mod folder;
    pub mod from_elsewhere;
    pub mod functions;
    pub mod graphics;
    pub mod hostile;
    pub mod left_out;
    pub mod lint;
    pub mod lossless;
    pub mod lowering;
    pub mod marker_points;
    pub mod one_reading;
    pub mod other_units;
    pub mod property;
    pub mod real_decks;
    pub mod results;
    pub mod statements;
}
