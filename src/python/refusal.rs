//! Conversion of errors to Python exceptions.

use std::io;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use crate::front::{Complaint, Error, ErrorKind};

static INPUT: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static USAGE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
static NO_ANSWER: PyOnceLock<Py<PyType>> = PyOnceLock::new();

/// Creates the Python exception for an error. It holds the text of the error, and the complaints as JSON for the Python layer.
pub(super) fn raised(py: Python<'_>, error: &Error) -> PyErr {
    let text = error.to_string();
    let (lock, name) = match error.kind {
        ErrorKind::Input => (&INPUT, "DeckError"),
        ErrorKind::Usage => (&USAGE, "AddressError"),
        ErrorKind::NoAnswer => (&NO_ANSWER, "SolveError"),
        ErrorKind::File(kind) => return io::Error::new(kind, text).into(),
    };
    let class = match lock.import(py, "admire._errors", name) {
        Ok(class) => class,
        Err(error) => return error,
    };
    match class.call1((text, json(&error.complaints))) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

pub(super) fn json(complaints: &[Complaint]) -> String {
    serde_json::to_string(complaints).expect("complaints hold only names and numbers")
}
