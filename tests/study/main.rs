//! The way from a deck to a diagnosed study: setting up, questions, refusals and explanations.

mod ending;
mod explaining;
mod messages;
mod new_study;
mod planning;
mod run;
mod slips;
mod terminal;
mod tutorial;
