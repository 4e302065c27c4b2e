//! The extension module `jointid._core`: machines, measurement sets, studies and identifications for the
//! Python package, and the command.
//!
//! Documents cross the border as their JSON text, arrays as NumPy arrays. Names, defaults and docstrings are
//! those of the Python sources.

mod document;
mod error;
mod identification;
mod machine;
mod measurement;
mod settings;
mod study;
mod work;

use pyo3::prelude::*;

/// Tells the Python sources, which read it in the file before they load it, that the extension needs the
/// instructions of x86-64-v3.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[used]
static PROCESSOR: [u8; 27] = *b"jointid-processor:x86-64-v3";

#[pymodule]
mod _core {
    #[pymodule_export]
    use super::document::{effects, friction, page, peaks, run_command, stabilisation, write_files};
    #[pymodule_export]
    use super::identification::Identification;
    #[pymodule_export]
    use super::machine::Machine;
    #[pymodule_export]
    use super::measurement::MeasurementSet;
    #[pymodule_export]
    use super::study::Study;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
