//! A device's clock while it works, where the system or the driver tells: Vulkan itself has no word for it.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::bench::DeviceHead;

/// PCI's number of NVIDIA, whose driver tells by a program of its own.
const NVIDIA: u32 = 0x10de;
/// That program.
const SMI: &str = "nvidia-smi";

/// Where kernel drivers tell the clock of a graphics card, below its folder, with the units in a megahertz.
const FILES: [(&str, f64); 3] = [
    // i915.
    ("gt_act_freq_mhz", 1.0),
    // xe.
    ("device/tile0/gt0/freq0/act_freq", 1.0),
    // amdgpu: shader clock, in the first of its monitors.
    ("device/hwmon/*/freq1_input", 1e6),
];

/// Where a device's clock is read.
#[derive(Clone, Debug, PartialEq)]
pub enum Clock {
    /// Files whose mean it is, with the units in a megahertz.
    Files(Vec<PathBuf>, f64),
    /// The processors' lines in `/proc/cpuinfo`.
    CpuInfo(PathBuf),
    /// The driver's own program, which lists devices of this PCI number.
    Program(PathBuf, u32),
    /// Nowhere, and why.
    Unknown(String),
}

impl Clock {
    /// That of a device on this machine.
    pub fn of(device: &DeviceHead) -> Self {
        let root = cfg!(target_os = "linux").then_some(Path::new("/"));
        Self::below(root, device, SMI.as_ref())
    }

    /// Like [`Clock::of`], with the system's files below `root`; none on a system that has no such files.
    fn below(root: Option<&Path>, device: &DeviceHead, program: &Path) -> Self {
        if device.kind == "CPU" {
            let Some(root) = root else { return Self::unread("a processor's") };
            let files = matches(root, "sys/devices/system/cpu/*/cpufreq/scaling_cur_freq");
            if !files.is_empty() {
                return Self::Files(files, 1e3);
            }
            let listed = Self::CpuInfo(root.join("proc/cpuinfo"));
            return match listed.mhz() {
                Some(_) => listed,
                None => Self::Unknown("the system reports no clock of its processors".into()),
            };
        }
        let (Some(vendor), Some(number)) = (device.vendor_id, device.device_id) else {
            return Self::Unknown("the device has no PCI number".into());
        };
        if vendor == NVIDIA {
            let found = Self::Program(program.into(), (number << 16) | vendor);
            return match found.mhz() {
                Some(_) => found,
                None => Self::Unknown(format!(
                    "{} reports no clock of one such device",
                    program.display()
                )),
            };
        }
        let Some(root) = root else { return Self::unread("this device's") };
        let is_it = |card: &PathBuf| {
            let id = |name| number_in(&card.join("device").join(name));
            (id("vendor"), id("device")) == (Some(vendor), Some(number))
        };
        let mut cards = matches(root, "sys/class/drm/*");
        // A card's folder, not those of its connectors (card0-DP-1).
        cards.retain(|card| {
            let name = card.file_name().unwrap_or_default().to_string_lossy();
            name.strip_prefix("card").is_some_and(|rest| rest.parse::<u32>().is_ok())
        });
        cards.retain(is_it);
        match cards.as_slice() {
            [] => Self::Unknown("no kernel driver lists a card of the device's PCI number".into()),
            [card] => {
                let known = FILES.iter().find_map(|(pattern, unit)| {
                    let file = matches(card, pattern).into_iter().next()?;
                    Some(Self::Files(vec![file], *unit))
                });
                known.unwrap_or_else(|| Self::Unknown("its kernel driver reports no clock".into()))
            }
            _ => Self::Unknown("several cards have the device's PCI number".into()),
        }
    }

    fn unread(whose: &str) -> Self {
        Self::Unknown(format!("{whose} clock is read on Linux only"))
    }

    /// Megahertz now; none where it is not reported.
    pub fn mhz(&self) -> Option<f64> {
        match self {
            Self::Files(files, unit) => mean(files.iter().filter_map(|file| {
                fs::read_to_string(file).ok()?.trim().parse::<f64>().ok().map(|value| value / unit)
            })),
            Self::CpuInfo(file) => {
                let text = fs::read_to_string(file).ok()?;
                let lines = text.lines().filter_map(|line| line.strip_prefix("cpu MHz"));
                mean(lines.filter_map(|line| line.split_once(':')?.1.trim().parse().ok()))
            }
            Self::Program(program, wanted) => {
                let query = "--query-gpu=pci.device_id,clocks.sm";
                let output = Command::new(program)
                    .args([query, "--format=csv,noheader,nounits"])
                    .stdin(Stdio::null())
                    .stderr(Stdio::null())
                    .output()
                    .ok()?;
                let text = String::from_utf8(output.stdout).ok()?;
                let mut found = text.lines().filter_map(|line| {
                    let (id, mhz) = line.split_once(',')?;
                    (hexadecimal(id) == Some(*wanted)).then(|| mhz.trim().parse::<f64>().ok())?
                });
                // With two devices alike nobody knows which one draws.
                found.next().filter(|_| found.next().is_none())
            }
            Self::Unknown(_) => None,
        }
    }

    /// Where it is read, or why not, in a few words.
    pub fn source(&self) -> String {
        match self {
            Self::Files(files, _) => match files.as_slice() {
                [one] => one.display().to_string(),
                [first, ..] => format!("mean of {} files like {}", files.len(), first.display()),
                [] => "nowhere".into(),
            },
            Self::CpuInfo(file) => {
                format!("cpu MHz of {}; in a virtual machine a constant", file.display())
            }
            Self::Program(program, _) => program.display().to_string(),
            Self::Unknown(why) => format!("unknown: {why}"),
        }
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let all: Vec<f64> = values.collect();
    (!all.is_empty()).then(|| all.iter().sum::<f64>() / all.len() as f64)
}

/// What fits a path in which a part may be `*`, sorted.
fn matches(root: &Path, pattern: &str) -> Vec<PathBuf> {
    let mut found = vec![root.to_path_buf()];
    for part in pattern.split('/') {
        let below = |folder: PathBuf| -> Vec<PathBuf> {
            if part != "*" {
                return vec![folder.join(part)];
            }
            let entries = fs::read_dir(&folder).into_iter().flatten().flatten();
            entries.map(|entry| entry.path()).collect()
        };
        found = found.into_iter().flat_map(below).filter(|path| path.exists()).collect();
    }
    found.sort();
    found
}

/// `0x1002` to its number.
fn hexadecimal(text: &str) -> Option<u32> {
    u32::from_str_radix(text.trim().strip_prefix("0x")?, 16).ok()
}

fn number_in(file: &Path) -> Option<u32> {
    hexadecimal(&fs::read_to_string(file).ok()?)
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt as _;

    fn device(kind: &str, ids: Option<(u32, u32)>) -> DeviceHead {
        DeviceHead {
            name: "D".into(),
            driver: "V".into(),
            driver_info: "1".into(),
            api_version: "1.3.0".into(),
            kind: kind.into(),
            vendor_id: ids.map(|ids| ids.0),
            device_id: ids.map(|ids| ids.1),
            driver_uuid: None,
            pipeline_cache_uuid: None,
        }
    }

    /// A folder with files of the given texts.
    fn system(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().expect("a folder");
        for (name, text) in files {
            let path = root.path().join(name);
            fs::create_dir_all(path.parent().expect("a folder")).expect("made");
            crate::files::write_whole(&path, text.as_bytes()).expect("written");
        }
        root
    }

    const AMD: [(&str, &str); 4] = [
        ("sys/class/drm/card0/device/vendor", "0x1002\n"),
        ("sys/class/drm/card0/device/device", "0x744c\n"),
        ("sys/class/drm/card0/device/hwmon/hwmon3/freq1_input", "2450000000\n"),
        ("sys/class/drm/card0-DP-1/status", "connected\n"),
    ];

    #[test]
    fn each_driver_tells_in_its_own_place() {
        let of = |files: &[(&str, &str)], kind: &str, ids: (u32, u32)| {
            let root = system(files);
            Clock::below(Some(root.path()), &device(kind, Some(ids)), "nowhere".as_ref()).mhz()
        };
        assert_eq!(of(&AMD, "discrete GPU", (0x1002, 0x744c)), Some(2450.0));
        assert_eq!(of(&AMD, "discrete GPU", (0x1002, 0x744d)), None, "another card's");
        let intel = [
            ("sys/class/drm/card1/device/vendor", "0x8086"),
            ("sys/class/drm/card1/device/device", "0x4680"),
            ("sys/class/drm/card1/gt_act_freq_mhz", "1450\n"),
        ];
        assert_eq!(of(&intel, "integrated GPU", (0x8086, 0x4680)), Some(1450.0));
        let cores = [
            ("sys/devices/system/cpu/cpu0/cpufreq/scaling_cur_freq", "2000000\n"),
            ("sys/devices/system/cpu/cpu1/cpufreq/scaling_cur_freq", "3000000\n"),
            ("proc/cpuinfo", "cpu MHz : 1.0\n"),
        ];
        assert_eq!(of(&cores, "CPU", (0x10005, 0)), Some(2500.0));
        let virtual_machine =
            [("proc/cpuinfo", "cpu MHz\t\t: 2400.5\nflags\t: x\ncpu MHz\t\t: 2400.5\n")];
        assert_eq!(of(&virtual_machine, "CPU", (0x10005, 0)), Some(2400.5));
    }

    #[test]
    fn the_drivers_own_program_is_asked_for_one_device() {
        let root = system(&[]);
        let program = root.path().join("smi");
        let ask = |lines: &str| {
            let text = format!("#!/bin/sh\nprintf '{lines}'\n");
            crate::files::write_whole(&program, text.as_bytes()).expect("a program");
            fs::set_permissions(&program, fs::Permissions::from_mode(0o755)).expect("its mode");
            let nvidia = device("discrete GPU", Some((0x10de, 0x2330)));
            let found = Clock::below(Some(root.path()), &nvidia, &program);
            assert_eq!(found, Clock::below(None, &nvidia, &program), "where there are no files");
            found
        };
        assert_eq!(ask(r"0x250310DE, 300\n0x233010DE, 1980\n").mhz(), Some(1980.0));
        let two = ask(r"0x233010DE, 300\n0x233010DE, 1980\n");
        assert!(matches!(two, Clock::Unknown(_)), "which of the two draws is not known");
    }

    #[test]
    fn what_is_not_told_is_said() {
        let why = |files: &[(&str, &str)], device: DeviceHead| {
            Clock::below(Some(system(files).path()), &device, "nowhere".as_ref()).source()
        };
        let gpu = |ids| device("discrete GPU", ids);
        assert!(why(&[], gpu(None)).starts_with("unknown: the device has no PCI number"));
        assert!(why(&[], gpu(Some((0x1002, 1)))).contains("no kernel driver lists"));
        assert!(why(&AMD[..2], gpu(Some((0x1002, 0x744c)))).contains("reports no clock"));
        assert!(why(&[], gpu(Some((0x10de, 1)))).contains("nowhere reports no clock"));
        assert!(why(&[], device("CPU", None)).contains("no clock of its processors"));
        // Elsewhere than on Linux the same names would be files of somebody else.
        for other in [device("CPU", None), gpu(Some((0x1002, 0x744c)))] {
            let found = Clock::below(None, &other, "nowhere".as_ref());
            assert!(found.source().contains("read on Linux only"), "{}", found.source());
        }
    }
}
