//! What can go wrong, said in one line that names the thing, the place and the mend.

use std::fmt;
use std::path::{Path, PathBuf};

use ash::vk;

use crate::thousands::{thousands, thousands_of};

/// The result of everything in this library that can fail.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What can go wrong. Each message is one line, also where `main` returns it.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The machine has no Vulkan loader.
    #[error("no Vulkan loader: {0}")]
    NoLoader(String),

    /// The loader knows no device.
    #[error("no Vulkan device: install a driver, or check VK_DRIVER_FILES")]
    NoDevice,

    /// A driver is there, and finds no device.
    #[error(
        "no Vulkan device: {call} failed ({result}): no driver finds a device of its kind; install another driver, or check \
         VK_DRIVER_FILES"
    )]
    NoCard {
        /// The Vulkan command.
        call: &'static str,
        /// What it returned.
        result: vk::Result,
    },

    /// No device goes by the name or index that was asked for.
    #[error("no Vulkan device matches '{wanted}'; there are: {found}")]
    DeviceNotFound {
        /// What was asked for.
        wanted: String,
        /// The devices that exist.
        found: String,
    },

    /// The device lacks what the renderer needs.
    #[error("{device} lacks {missing}: update its driver, or take another device")]
    DeviceLacks {
        /// The device's name.
        device: String,
        /// Every missing feature, by its Vulkan name.
        missing: String,
    },

    /// A Vulkan call failed.
    #[error("{call} failed for {object}: {result}")]
    Vulkan {
        /// The Vulkan command.
        call: &'static str,
        /// What it was called for.
        object: String,
        /// What it returned.
        result: vk::Result,
    },

    /// Device memory could not be had.
    #[error("no memory on the device for {object} ({} MiB): {reason}", thousands_of(*mebibytes, 1))]
    Memory {
        /// What the memory was for.
        object: String,
        /// How much was asked for.
        mebibytes: f64,
        /// What the allocator said.
        reason: String,
    },

    /// The scene asks for more than the device's limits allow.
    #[error("{what} is {}, but {device} takes {} at most", thousands(*wanted), thousands(*limit))]
    Limit {
        /// The quantity.
        what: &'static str,
        /// Its value in the scene.
        wanted: u64,
        /// The device's limit.
        limit: u64,
        /// The device's name.
        device: String,
    },

    /// There is no display, or no window on it that Vulkan could draw in.
    #[error("cannot open a window: {0}")]
    Window(String),

    /// A scene file or a value given on the command line is wrong.
    #[error("{place}: {problem}")]
    Scene {
        /// File and line, or the option.
        place: String,
        /// What is wrong, and what would be right.
        problem: String,
    },

    /// An environment image cannot be used.
    #[error("environment {}: {problem}", path.display())]
    Environment {
        /// The image file.
        path: PathBuf,
        /// What is wrong, and what would be right.
        problem: String,
    },

    /// A file could not be read or written.
    #[error("cannot {doing} {}: {reason}", path.display())]
    File {
        /// `read` or `write`.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system or the codec said.
        reason: String,
    },

    /// A plot that could not be drawn.
    #[cfg(feature = "cli")]
    #[error("cannot plot: {0}")]
    Plot(String),

    /// The validation layers complained, or are not there.
    #[error("Vulkan validation: {0}")]
    Validation(String),
}

#[cfg(feature = "cli")]
/// Why a plot was not drawn. The plotting backend's errors borrow from it; words do not.
pub(crate) struct PlotFailed(String);

#[cfg(feature = "cli")]
impl<E: std::error::Error> From<E> for PlotFailed {
    fn from(error: E) -> Self {
        Self(error.to_string())
    }
}

#[cfg(feature = "cli")]
impl From<PlotFailed> for Error {
    fn from(PlotFailed(reason): PlotFailed) -> Self {
        Self::Plot(reason)
    }
}

/// The message: that is what a program says whose `main` ends with an error.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Error {
    /// Whether the device, or a window's surface, is lost: nothing made from it is of use any more, but
    /// another may be had.
    pub fn is_lost(&self) -> bool {
        use vk::Result as R;
        matches!(
            self,
            Self::Vulkan { result: R::ERROR_DEVICE_LOST | R::ERROR_SURFACE_LOST_KHR, .. }
        )
    }

    /// Something wrong with a scene, or with what goes with one.
    pub(crate) fn scene(place: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::Scene { place: place.into(), problem: problem.into() }
    }

    /// A file that could not be read.
    pub fn read(path: &Path, reason: impl ToString) -> Self {
        Self::File { doing: "read", path: path.into(), reason: reason.to_string() }
    }

    /// A file that could not be read, for a problem in words that follow its name, such as "is cut off".
    pub(crate) fn unread(path: &Path, problem: &str) -> Self {
        let reason = problem.strip_prefix("cannot be read: ");
        Self::read(path, reason.map_or_else(|| format!("it {problem}"), Into::into))
    }

    /// A file that could not be written.
    pub fn write(path: &Path, reason: impl ToString) -> Self {
        Self::File { doing: "write", path: path.into(), reason: reason.to_string() }
    }
}
