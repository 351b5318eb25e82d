//! The Python package: classes and functions over the front of the library.
//!
//! Computes nothing itself. The layer in Python (`src/python/admire`) gives names, types and documents; this module hands values over.
//! Compiled only with the feature `python`, which maturin turns on.
#![allow(unsafe_code)] // The macros of PyO3 expand to it.
#![allow(missing_docs)] // The layer in Python documents what it offers.
#![allow(clippy::used_underscore_binding, clippy::elidable_lifetime_names)] // Of the macros, too.

mod block;
mod deck;
mod refusal;
mod results;
mod run;
mod study;
mod sweep;
mod work;

use pyo3::prelude::*;

#[pymodule]
fn _admire(module: &Bound<'_, PyModule>) -> PyResult<()> {
    work::loaded();
    module.add("__version__", admire_report::VERSION)?;
    module.add_class::<block::Block>()?;
    module.add_class::<deck::Deck>()?;
    module.add_class::<run::Run>()?;
    module.add_class::<results::Results>()?;
    module.add_class::<study::Study>()?;
    module.add_function(wrap_pyfunction!(sweep::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::merge_shards, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::program_of_sweep, module)?)?;
    Ok(())
}
