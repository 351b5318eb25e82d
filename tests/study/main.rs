//! From a deck to a diagnosed study, as a person goes: what is begun, asked, refused and explained on the way.

mod ending;
mod explaining;
mod messages;
mod new_study;
mod planning;
mod run;
mod slips;
mod terminal;
mod tutorial;
