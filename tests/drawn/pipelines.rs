//! Compiled pipelines from run to run: found, damaged, of another driver, not to be written. The
//! pictures are the same bytes each time, and no damaged file reaches the driver.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Output;

use raindrops::gpu::disk_cache::{KeptDevice, PipelineFile};
use raindrops::gpu::{Instance, PipelineKey, Validation};
use raindrops::remark::Severity;
use raindrops::scene::model::Preset;

use crate::common::{folder, outcome};

/// Renders a small picture by the command, its cache in `cache`; the picture and what was said.
fn render(cache: &Path) -> (Vec<u8>, String) {
    let folder = folder();
    let picture = folder.path().join("a.exr");
    let mut command = crate::common::raindrops();
    command.args(["render", "--size", "32x24", "--drops", "300", "--preset", "fast", "--validate"]);
    if let Ok(device) = std::env::var("RAINDROPS_TEST_DEVICE") {
        command.args(["--device", &device]);
    }
    command.arg("-o").arg(&picture).env("XDG_CACHE_HOME", cache);
    let Output { status, stderr, .. } = outcome(&mut command);
    let said = String::from_utf8(stderr).expect("text");
    assert!(status.success(), "{said}");
    (fs::read(picture).expect("a picture"), said)
}

/// The lines that are of the cache.
fn remarks(said: &str) -> Vec<&str> {
    said.lines().filter(|line| line.contains("pipelines")).collect()
}

/// The one file in a cache.
fn file_in(cache: &Path) -> PathBuf {
    let folder = cache.join("raindrops").read_dir().expect("a folder of ours");
    let mut files: Vec<_> = folder.map(|entry| entry.expect("an entry").path()).collect();
    // Where there are several drivers, their times are kept beside it.
    files.retain(|file| file.to_string_lossy().contains("pipelines-"));
    let [file] = files.as_slice() else { panic!("not one file: {files:?}") };
    file.clone()
}

#[test]
fn cold_warm_and_damaged_give_the_same_picture() {
    let cache = folder();
    let (cold, said) = render(cache.path());
    assert!(remarks(&said).is_empty(), "a first run has nothing to say: {said}");
    let file = file_in(cache.path());
    let kept = fs::read(&file).expect("pipelines");
    let written = fs::metadata(&file).and_then(|data| data.modified()).expect("a time");

    let (warm, said) = render(cache.path());
    assert!(warm == cold && remarks(&said).is_empty(), "{said}");
    // A driver may order its data anew; what is the same is not written.
    if fs::read(&file).expect("pipelines") == kept {
        let now = fs::metadata(&file).and_then(|data| data.modified()).expect("a time");
        assert_eq!(now, written, "the same content was written again");
    }

    let mut flipped = kept.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 0x10;
    for damaged in [&flipped[..], &kept[..kept.len() - 1], &[]] {
        fs::write(&file, damaged).expect("damaged");
        let (picture, said) = render(cache.path());
        assert!(picture == cold, "another picture");
        let [remark] = remarks(&said)[..] else { panic!("not one line: {said}") };
        let name = file.display().to_string();
        assert!(remark.contains(&name) && remark.contains("compiled anew"), "{remark}");
        let mended = fs::read(&file).expect("pipelines");
        assert!(mended.len() == kept.len() && mended[..8] == kept[..8], "not written anew");
    }
}

#[test]
fn a_cache_that_takes_nothing_is_no_error() {
    let folder = folder();
    let not_a_folder = folder.path().join("file");
    fs::write(&not_a_folder, "content").expect("a file");
    let (picture, said) = render(&not_a_folder);
    assert!(!picture.is_empty());
    assert!((1..=2).contains(&remarks(&said).len()), "{said}");
    assert_eq!(fs::read_to_string(&not_a_folder).expect("the file"), "content");
}

const KEY: PipelineKey =
    PipelineKey { vendor: 0x10de, device: 0x2330, driver_version: 7, uuid: [0xa5; 16] };

/// What a driver would give out.
fn data(key: &PipelineKey) -> Vec<u8> {
    let words = [32, 1, key.vendor, key.device].map(u32::to_le_bytes).concat();
    [&words[..], &key.uuid, b"compiled pipelines of this and that kind, no two alike"].concat()
}

/// Writes `data` for `key` and returns the file.
fn write(folder: &Path, key: &PipelineKey, data: &[u8]) -> PathBuf {
    let (file, problem) = PipelineFile::read(folder, key);
    assert!(problem.is_none() && file.data().is_empty());
    assert!(file.write(data).expect("it is written"), "it is not kept");
    file.path().into()
}

/// Puts any data where those for `key` are kept, with the checksum of a sound file: over the driver's version and the data.
fn put(folder: &Path, key: &PipelineKey, data: &[u8]) -> PathBuf {
    let path = PipelineFile::read(folder, key).0.path().to_path_buf();
    let summed = [&key.driver_version.to_le_bytes()[..], data].concat();
    let sum = crc32fast::hash(&summed).to_le_bytes();
    fs::write(&path, [b"drops-1\n", &sum[..], data].concat()).expect("a file");
    path
}

/// Nothing is taken from a file, and a line says why.
fn is_refused(folder: &Path, key: &PipelineKey, why: &str) {
    let (file, problem) = PipelineFile::read(folder, key);
    assert!(file.data().is_empty(), "{why}: it was taken");
    let problem = problem.unwrap_or_else(|| panic!("{why}: not a word"));
    assert_eq!(problem.severity, Severity::Note);
    assert!(problem.text.contains(why) && !problem.text.contains('\n'), "{problem}");
}

#[test]
fn every_damage_is_found() {
    let folder = folder();
    let path = write(folder.path(), &KEY, &data(&KEY));
    let whole = fs::read(&path).expect("the file");
    assert_eq!(PipelineFile::read(folder.path(), &KEY).0.data(), data(&KEY), "the control");
    let mut random = crate::common::Random(3);
    for at in 0..whole.len() {
        for mask in [1 << (at % 8), 0xff, 1 + (random.bits() % 255) as u8] {
            let mut damaged = whole.clone();
            damaged[at] ^= mask;
            fs::write(&path, damaged).expect("damaged");
            is_refused(folder.path(), &KEY, "damaged");
        }
        fs::write(&path, &whole[..at]).expect("cut off");
        is_refused(folder.path(), &KEY, "damaged");
    }
    fs::write(&path, [&whole[..], b"\0"].concat()).expect("more");
    is_refused(folder.path(), &KEY, "damaged");
    let file = fs::File::create(&path).expect("a file");
    file.set_len(1 << 40).expect("a terabyte of nothing");
    is_refused(folder.path(), &KEY, "over 64 MiB");
    fs::remove_file(&path).expect("removed");
    fs::create_dir(&path).expect("a folder in its place");
    is_refused(folder.path(), &KEY, "not a regular file");
}

/// With a sound checksum: the data itself is another driver's, or its header claims what is not so.
#[test]
fn data_of_another_driver_is_refused() {
    let others = [
        PipelineKey { vendor: 1, ..KEY },
        PipelineKey { device: 1, ..KEY },
        PipelineKey { uuid: [0; 16], ..KEY },
    ];
    let mut bad: Vec<Vec<u8>> = others.iter().map(data).collect();
    for (at, word) in [(0, u32::MAX), (0, 31), (4, 2)] {
        let mut data = data(&KEY);
        data[at..at + 4].copy_from_slice(&u32::to_le_bytes(word));
        bad.push(data);
    }
    for bad in bad {
        let folder = folder();
        let path = put(folder.path(), &KEY, &bad);
        is_refused(folder.path(), &KEY, "another device or driver");
        // It is not written again either: the next run would have to refuse it, too.
        let (file, _) = PipelineFile::read(folder.path(), &KEY);
        assert!(!file.write(&bad).expect("it can be removed") && !path.exists());
        assert!(file.write(&data(&KEY)).expect("it is written"));
        assert_eq!(PipelineFile::read(folder.path(), &KEY).0.data(), data(&KEY));
    }
    // Each version of a driver has a file of its own; one under another's name is refused.
    let folder = folder();
    let newer = PipelineKey { driver_version: 8, ..KEY };
    let path = write(folder.path(), &KEY, &data(&KEY));
    let (file, problem) = PipelineFile::read(folder.path(), &newer);
    assert!(problem.is_none() && file.data().is_empty() && file.path() != path);
    fs::rename(path, file.path()).expect("renamed");
    is_refused(folder.path(), &newer, "damaged, or of another version");
}

/// Some drivers give out fewer bytes than the header that Vulkan defines (lavapipe of Mesa 26: 20). They are not kept; those that
/// an earlier version of the program kept go without a note.
#[test]
fn data_without_a_header_are_not_kept() {
    for length in [0, 1, 20, 31] {
        let short = &data(&KEY)[..length];
        let folder = folder();
        let (file, problem) = PipelineFile::read(folder.path(), &KEY);
        assert!(problem.is_none() && !file.write(short).expect("nothing to write"), "{length}");
        assert_eq!(folder.path().read_dir().expect("a folder").count(), 0, "{length}");

        let path = put(folder.path(), &KEY, short);
        let (file, problem) = PipelineFile::read(folder.path(), &KEY);
        let problem = problem.expect("a remark");
        assert_eq!(problem.severity, Severity::Detail, "{length}: {problem}");
        assert!(file.data().is_empty() && problem.text.contains("compiled anew"), "{problem}");
        assert!(!file.write(short).expect("it is removed") && !path.exists(), "{length}");
    }
}

/// By the library: pipelines of both frames, kept and found under validation; what the driver gives
/// is what its own check accepts.
#[test]
fn kept_pipelines_are_found_under_validation() {
    let _alone = crate::common::layer::alone();
    let cache = folder();
    let instance = Instance::new(Validation::On).expect("Vulkan and its validation layer");
    let mut pictures = Vec::new();
    for run in 0..2 {
        let report = crate::common::chosen(&instance);
        let key = report.pipeline_key;
        let path = Some(cache.path().to_path_buf());
        let device =
            KeptDevice::open(&instance, report, path, |line| panic!("{line}")).expect("a device");
        assert_eq!(device.bytes_found() > 0, run == 1);
        pictures.push(
            [Preset::Paper, Preset::Fast]
                .map(|preset| crate::common::frame(&device, preset, (32, 24))),
        );
        assert!(key.heads(&device.pipelines().expect("pipelines")), "not as Vulkan has it");
    }
    assert!(pictures[0] == pictures[1], "kept pipelines draw another picture");
    instance.expect_silence().expect("silence");
}
