//! Text as other programs write it: results, expectations and scenes with a byte-order mark, or in UTF-16, as `>` of
//! Windows PowerShell makes them.

use std::fs;
use std::path::Path;

use raindrops::scene::Scene;

use super::{error_line, keep};
use crate::common::stand_in::Bench;

type Encode = fn(&str) -> Vec<u8>;

const ENCODINGS: [(&str, Encode); 3] = [
    ("UTF-8 with a mark", |text| [b"\xef\xbb\xbf", text.as_bytes()].concat()),
    ("UTF-16, little", |text| {
        let units = text.encode_utf16().flat_map(|unit| [unit as u8, (unit >> 8) as u8]);
        [0xff, 0xfe].into_iter().chain(units).collect()
    }),
    ("UTF-16, big", |text| {
        let units = text.encode_utf16().flat_map(|unit| [(unit >> 8) as u8, unit as u8]);
        [0xfe, 0xff].into_iter().chain(units).collect()
    }),
];

/// Writes a file again in another encoding.
fn encode(path: &Path, encode: Encode) {
    let text = fs::read_to_string(path).expect("UTF-8");
    fs::write(path, encode(&text.replace('\n', "\r\n"))).expect("a file");
}

#[test]
fn results_and_expectations_of_any_encoding_are_read() {
    let bench = Bench::new();
    keep(&bench, "plain.json", &[]);
    let ran = |arguments: &[&str]| {
        let output = bench.command(arguments).output().expect("it starts");
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("UTF-8")
    };
    let expected = ran(&["verdict", "plain.json", "plain.json"]);
    for (name, of) in ENCODINGS {
        keep(&bench, "a.json", &[]);
        encode(&bench.path().join("a.json"), of);
        assert_eq!(ran(&["verdict", "a.json", "a.json"]), expected.replace("plain", "a"), "{name}");
        ran(&["report", "a.json", "-o", "page.html"]);
        // A verdict is read again, by expectations in the same encoding.
        ran(&["verdict", "a.json", "a.json", "--json", "v.json"]);
        let expect = "# µ\n[[device]]\nmatch = \"D\"\nratio = 1.5\n";
        fs::write(bench.path().join("e.toml"), expect).expect("a file");
        for file in ["v.json", "e.toml"] {
            encode(&bench.path().join(file), of);
        }
        ran(&["verdict", "v.json", "--expect", "e.toml"]);
        ran(&["report", "v.json", "-o", "page.html"]);
    }
    // What is neither is refused, by its name.
    keep(&bench, "a.json", &[]);
    let text = fs::read_to_string(bench.path().join("a.json")).expect("text");
    let unmarked = text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<_>>();
    let latin = text.replace("sky", "\u{fffd}").into_bytes();
    let latin: Vec<u8> = latin.into_iter().filter(|byte| ![0xbf, 0xbd].contains(byte)).collect();
    for bytes in [unmarked, latin] {
        fs::write(bench.path().join("a.json"), bytes).expect("a file");
        let output =
            bench.command(&["verdict", "a.json", "plain.json"]).output().expect("it starts");
        let line = error_line(&output, 2);
        assert!(line.contains("cannot read a.json: it is neither UTF-8 nor UTF-16"), "{line}");
    }
}

#[test]
fn scenes_of_any_encoding_are_read() {
    let bench = Bench::new();
    let path = bench.path().join("scene.toml");
    let text = "# µ 雨\nseed = 5\n[rain]\nrate = 3.0\n";
    for (name, of) in ENCODINGS {
        fs::write(&path, text).expect("a file");
        encode(&path, of);
        let scene = Scene::load(&path).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(scene, Scene::parse(text, "scene.toml").expect("a scene"), "{name}");
        // A mistake has its line.
        fs::write(&path, format!("{text}rat = 1\n")).expect("a file");
        encode(&path, of);
        let told = Scene::load(&path).expect_err(name).to_string();
        assert!(told.contains("scene.toml:5: "), "{told}");
    }
    fs::write(&path, b"# \xb5\n").expect("a file");
    let told = Scene::load(&path).expect_err("Latin-1").to_string();
    assert!(told.contains("scene.toml: it is neither UTF-8") && told.contains("byte 3"), "{told}");
}
