//! The static solver against independent equilibria, closed forms and its own invariances.

#[path = "../common/mod.rs"]
mod common;
mod deck;
mod derivatives;
mod elements;
mod reference;
mod robust;
mod speed;
