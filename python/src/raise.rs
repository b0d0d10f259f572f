//! The library's errors and remarks as Python's exceptions and warnings: the classes are those of `raindrops/_errors.py`.

use pyo3::prelude::*;
use raindrops::Error;
use raindrops::remark::{Remark, Severity};

const MODULE: &str = "raindrops._errors";

/// The exception `class` of the package, with a message.
pub fn exception(py: Python<'_>, class: &str, message: &str) -> PyErr {
    let made = py.import(MODULE).and_then(|module| module.getattr(class)?.call1((message,)));
    made.map_or_else(|error| error, PyErr::from_value)
}

/// A result of the library as one of Python.
pub trait Raise<T> {
    /// The error as an exception.
    fn raise(self, py: Python<'_>) -> PyResult<T>;
}

impl<T> Raise<T> for raindrops::Result<T> {
    fn raise(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|error| {
            let (class, hint) = match &error {
                Error::NoLoader(_) | Error::NoDevice | Error::NoCard { .. } => (
                    "NoDeviceError",
                    "; on Debian and Ubuntu apt install libvulkan1 mesa-vulkan-drivers brings a driver that needs no GPU",
                ),
                Error::DeviceNotFound { .. } => ("DeviceError", ""),
                Error::DeviceLacks { .. } => {
                    ("DeviceError", "; device= chooses, raindrops.devices() lists them")
                }
                Error::Scene { .. } => ("SceneError", ""),
                Error::File { .. } | Error::Environment { .. } => ("FileError", ""),
                Error::Vulkan { .. } | Error::Memory { .. } | Error::Limit { .. } => ("DeviceError", ""),
                _ => ("Error", ""),
            };
            exception(py, class, &format!("{error}{hint}"))
        })
    }
}

/// Gives remarks as warnings; one that is made an error is that.
pub fn tell(py: Python<'_>, of: &str, remarks: &[Remark]) -> PyResult<()> {
    let lines: Vec<(&str, String)> = remarks
        .iter()
        .map(|remark| {
            let severity = match remark.severity {
                Severity::Detail => "detail",
                Severity::Note => "note",
                Severity::Warning => "warning",
            };
            let before = if of.is_empty() { String::new() } else { format!("{of}: ") };
            (severity, format!("{before}{}", remark.text))
        })
        .collect();
    if lines.is_empty() {
        return Ok(());
    }
    py.import(MODULE)?.getattr("tell")?.call1((lines,)).map(|_| ())
}
