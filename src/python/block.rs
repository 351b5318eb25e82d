use pyo3::prelude::*;
use pyo3::types::PyDict;

/// Read-only numbers that NumPy uses without copying them: `numpy.asarray` of an object with `__array_interface__` refers to the same
/// memory and keeps the object alive.
#[pyclass(frozen, module = "admire._admire")]
pub(super) struct Block {
    values: Vec<f64>,
    rows: usize,
    columns: usize,
}

impl Block {
    /// Creates a block from values stored row by row.
    pub(crate) fn new(values: Vec<f64>, columns: usize) -> Self {
        Self {
            rows: values.len().checked_div(columns).unwrap_or(0),
            values,
            columns,
        }
    }
}

#[pymethods]
impl Block {
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        interface(py, &self.values, (self.rows, self.columns))
    }
}

/// Returns the dictionary of the array interface protocol, version 3. It states the shape, the number type, and the address as read-only.
pub(super) fn interface<'py>(
    py: Python<'py>,
    values: &[f64],
    shape: (usize, usize),
) -> PyResult<Bound<'py, PyDict>> {
    let asked = PyDict::new(py);
    asked.set_item("version", 3)?;
    asked.set_item("shape", shape)?;
    let order = if cfg!(target_endian = "big") {
        ">f8"
    } else {
        "<f8"
    };
    asked.set_item("typestr", order)?;
    asked.set_item("data", (values.as_ptr().addr(), true))?;
    Ok(asked)
}
