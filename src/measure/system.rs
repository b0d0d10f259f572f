//! What the operating system tells of the machine and of this process. Linux tells it in files, other systems through the
//! crate `sysinfo`. What a system does not tell is absent.

#[cfg(feature = "cli")]
pub(super) use of::resident_bytes;
pub(super) use of::{load, processor, release};

/// Between a processor's name and its family.
#[cfg(any(feature = "cli", target_os = "linux"))]
pub(super) const FAMILY: &str = " (family ";

/// A name, or that there is none.
fn named(name: &str) -> String {
    let name = name.trim();
    if name.is_empty() { "unknown".into() } else { name.into() }
}

#[cfg(target_os = "linux")]
mod of {
    use super::{FAMILY, named};

    fn file(path: &str) -> String {
        std::fs::read_to_string(path).unwrap_or_default()
    }

    /// The processor's name, with family and model where the system tells them.
    pub fn processor() -> String {
        processor_in(&file("/proc/cpuinfo"))
    }

    /// The system's name and version.
    pub fn release() -> Option<String> {
        let text = file("/etc/os-release");
        let name = text.lines().find_map(|line| line.strip_prefix("PRETTY_NAME="))?;
        Some(name.trim_matches('"').to_string())
    }

    /// Load average of the last minute.
    pub fn load() -> Option<f64> {
        file("/proc/loadavg").split(' ').next()?.parse().ok()
    }

    /// Memory of this process that is in the machine's memory.
    #[cfg(feature = "cli")]
    pub fn resident_bytes() -> Option<u64> {
        let text = file("/proc/self/status");
        let line = text.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
        let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
        Some(1024 * kib)
    }

    /// Family and model stand with the name: machines that are lent often give several kinds of processors one name.
    fn processor_in(cpuinfo: &str) -> String {
        let value = |key: &str| {
            let lines = cpuinfo.lines().filter_map(|line| line.split_once(':'));
            let mut found = lines.filter(|(name, _)| name.trim() == key);
            found.next().map(|(_, value)| value.trim())
        };
        let name = named(value("model name").unwrap_or_default());
        match value("cpu family").zip(value("model")) {
            Some((family, model)) => format!("{name}{FAMILY}{family}, model {model})"),
            None => name,
        }
    }

    #[cfg(test)]
    mod tests {
        use super::processor_in;

        #[test]
        fn processors_of_one_name_are_told_apart() {
            let of = |family: u32| {
                processor_in(&format!(
                    "processor\t: 0\ncpu family\t: {family}\nmodel\t\t: 1\nmodel name\t: AMD EPYC\n\nprocessor\t: 1\nmodel\t\t: 9\n"
                ))
            };
            assert_eq!((of(25), of(26) != of(25)), ("AMD EPYC (family 25, model 1)".into(), true));
            assert_eq!(processor_in("processor : 0\nBogoMIPS : 50\n"), "unknown");
        }
    }
}

#[cfg(not(target_os = "linux"))]
mod of {
    use sysinfo::{CpuRefreshKind, System};

    use super::named;

    /// The processor's name.
    pub fn processor() -> String {
        let mut system = System::new();
        system.refresh_cpu_specifics(CpuRefreshKind::nothing());
        named(system.cpus().first().map_or("", |cpu| cpu.brand()))
    }

    /// The system's name and version.
    pub fn release() -> Option<String> {
        System::long_os_version()
    }

    /// Load average of the last minute. Windows has none; `sysinfo` imitates it from a thread of its own.
    pub fn load() -> Option<f64> {
        (!cfg!(windows)).then(|| System::load_average().one)
    }

    /// Memory of this process that is in the machine's memory.
    #[cfg(feature = "cli")]
    pub fn resident_bytes() -> Option<u64> {
        use sysinfo::{ProcessRefreshKind, ProcessesToUpdate};
        let own = sysinfo::get_current_pid().ok()?;
        let mut system = System::new();
        let memory = ProcessRefreshKind::nothing().with_memory();
        system.refresh_processes_specifics(ProcessesToUpdate::Some(&[own]), true, memory);
        Some(system.process(own)?.memory())
    }
}
