//! The machine that a benchmark ran on.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

#[cfg(feature = "cli")]
use super::system::FAMILY;
use super::{others, system};
use crate::thousands::counted;

/// Environment variables that decide which driver runs, with which layers, or how fast a driver on the CPU is.
pub const VARIABLES: [&str; 14] = [
    "VK_DRIVER_FILES",
    "VK_ICD_FILENAMES",
    "VK_ADD_DRIVER_FILES",
    "VK_LOADER_DRIVERS_SELECT",
    "VK_LOADER_DRIVERS_DISABLE",
    "VK_LOADER_LAYERS_ENABLE",
    "VK_INSTANCE_LAYERS",
    "MESA_VK_DEVICE_SELECT",
    "LP_NUM_THREADS",
    "LP_NATIVE_VECTOR_WIDTH",
    "LP_DEBUG",
    "LP_PERF",
    "GALLIVM_DEBUG",
    "GALLIVM_PERF",
];

/// CPU, cores, system, load and variables.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Host {
    /// Processor, as the system names it.
    pub cpu: String,
    /// Logical cores that this process may use.
    pub cores: usize,
    /// Operating system and architecture.
    pub os: String,
    /// Load average of the last minute when the benchmark began; absent where the system has none.
    pub load: Option<f64>,
    /// What other programs took of all processors' time while the benchmark ran, 0 to 1, the most of any round; absent
    /// where the system does not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub others: Option<f64>,
    /// Environment variables that are set and that decide on the driver or its speed.
    #[serde(default, skip_serializing_if = "IndexMap::is_empty")]
    pub variables: IndexMap<String, String>,
}

impl Host {
    /// This machine, now.
    pub fn now() -> Self {
        let release = system::release().unwrap_or(std::env::consts::OS.into());
        Self {
            cpu: system::processor(),
            cores: std::thread::available_parallelism().map_or(1, Into::into),
            os: format!("{release} {}", std::env::consts::ARCH),
            load: system::load(),
            others: None,
            variables: VARIABLES
                .iter()
                .filter_map(|name| Some((name.to_string(), std::env::var_os(name)?)))
                .map(|(name, value)| (name, value.to_string_lossy().into_owned()))
                .collect(),
        }
    }

    /// Whether both have one processor, as far as is known: results of older programs have its name without [`FAMILY`].
    #[cfg(feature = "cli")]
    pub(crate) fn has_processor_of(&self, other: &Self) -> bool {
        match (self.cpu.split_once(FAMILY), other.cpu.split_once(FAMILY)) {
            (Some((name, _)), None) => name == other.cpu,
            (None, Some((name, _))) => name == self.cpu,
            _ => self.cpu == other.cpu,
        }
    }

    /// Its variables as a shell sets them, each after a comma; nothing where none is set.
    #[cfg(feature = "cli")]
    pub(crate) fn settings(&self) -> String {
        self.variables.iter().map(|(name, value)| format!(", {name}={value}")).collect()
    }

    /// What makes times doubtful that are measured from now on, in a line; none if nothing does.
    pub fn doubt(&self) -> Option<String> {
        let load = self.load.filter(|load| *load > self.cores as f64)?;
        Some(format!(
            "the load of {load} exceeds the {}: something else runs, or did a minute ago; times may be too long",
            counted(self.cores as u64, "core")
        ))
    }

    /// What made times doubtful while they were measured, in a line; none if nothing did.
    pub fn others_doubt(&self) -> Option<String> {
        self.others.and_then(others::doubt)
    }
}

#[cfg(test)]
mod tests {
    use super::Host;

    #[cfg(feature = "cli")]
    #[test]
    fn a_name_without_a_family_is_any_of_them() {
        let of = |cpu: &str| Host { cpu: cpu.into(), ..Host::now() };
        let [old, zen_3, zen_4] =
            ["C", "C (family 25, model 1)", "C (family 25, model 17)"].map(of);
        assert!(old.has_processor_of(&zen_3) && zen_3.has_processor_of(&old));
        assert!(zen_3.has_processor_of(&zen_3) && !zen_3.has_processor_of(&zen_4));
        assert!(!old.has_processor_of(&of("D (family 25, model 1)")));
    }

    #[test]
    fn more_work_than_cores_makes_times_doubtful() {
        let of = |load| {
            let variables = Default::default();
            let (cpu, os) = ("C".into(), "O".into());
            Host { cpu, cores: 2, os, load, others: None, variables }.doubt()
        };
        assert!(of(Some(2.1)).is_some_and(|doubt| doubt.contains("2.1 exceeds the 2 cores")));
        assert_eq!((of(Some(2.0)), of(None)), (None, None));
    }
}
