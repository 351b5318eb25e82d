//! Python package: classes and functions over the front of the library, and the commands of the wheel.
//!
//! This module only passes values on and computes nothing. The Python layer (`src/python/admire`) provides names, types and documentation.
//! The module is compiled only with the feature `python`, which maturin enables.
#![allow(unsafe_code)] // The macros of PyO3 expand to unsafe code.
#![allow(missing_docs)] // The Python layer documents its interface.
#![allow(clippy::used_underscore_binding, clippy::elidable_lifetime_names)] // The macros of PyO3 trigger these lints, too.

mod block;
mod commands;
mod deck;
mod refusal;
mod results;
mod run;
mod study;
mod sweep;
mod tools;
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
    module.add_function(wrap_pyfunction!(commands::run_admire, module)?)?;
    module.add_function(wrap_pyfunction!(commands::run_mdi, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::sweep, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::merge_shards, module)?)?;
    module.add_function(wrap_pyfunction!(sweep::program_of_sweep, module)?)?;
    module.add_function(wrap_pyfunction!(tools::compare_results, module)?)?;
    module.add_function(wrap_pyfunction!(tools::virtual_rig_run, module)?)?;
    module.add_function(wrap_pyfunction!(tools::study_files, module)?)?;
    module.add_function(wrap_pyfunction!(tools::trust, module)?)?;
    Ok(())
}
