//! Drops from files of others: the same drops in every format are the same placed drops and the same picture; files that
//! hold none are refused in a line that says why.

use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use glam::DVec3;
use raindrops::scene::particles::{Particles, drops_of_bytes};
use raindrops::scene::{PlacedDrop, Scene};

use crate::common::picture::square;
use crate::common::{Random, emptied_folder, on_device, raindrops};
use crate::layers::layers;

/// All numbers of a drop, as files hold them: place, radius, velocity, id.
type Row = [f64; 8];
const NAMES: [&str; 8] = ["x", "y", "z", "pscale", "vx", "vy", "vz", "id"];

fn rows() -> Vec<Row> {
    let at = |number: u32, step: f64| (f64::from(number) * step).fract() - 0.5;
    (1..=50)
        .map(|number| {
            let n = f64::from(number);
            let [x, y, z] = [3.0 * at(number, 0.618), 3.0 * at(number, 0.414), -3.0 - n % 4.0];
            [x, y, z, 0.003 * n, at(number, 0.3), -9.0, at(number, 0.7), 7000.0 - n]
        })
        .collect()
}

fn placed(row: &Row) -> PlacedDrop {
    let [x, y, z, radius, vx, vy, vz, id] = *row;
    let velocity = DVec3::new(vx, vy, vz);
    PlacedDrop { velocity, id: Some(id as u32), ..PlacedDrop::sphere(DVec3::new(x, y, z), radius) }
}

fn ply(format: &str, kind: &str, rows: &[Row]) -> Vec<u8> {
    let mut text = format!("ply\nformat {format} 1.0\ncomment by a test\nelement face 1\n");
    text += "property list uchar int vertex_indices\n";
    writeln!(text, "element vertex {}", rows.len()).expect("text");
    for name in NAMES {
        let kind = if name == "id" { "int" } else { kind };
        writeln!(text, "property {kind} {name}").expect("text");
    }
    text += "property uchar red\nend_header\n";
    let mut bytes = text.into_bytes();
    if format == "ascii" {
        bytes.extend(b"3 0 1 2\n");
        for row in rows {
            let values: Vec<String> = row.iter().map(f64::to_string).collect();
            bytes.extend(format!("{} 255\n", values.join(" ")).bytes());
        }
        return bytes;
    }
    let is_big = format == "binary_big_endian";
    let mut put = |mut value: Vec<u8>| {
        if is_big {
            value.reverse();
        }
        bytes.extend(value);
    };
    put(vec![1]);
    put(0_i32.to_le_bytes().to_vec());
    for row in rows {
        for value in &row[..7] {
            put(if kind == "float" {
                (*value as f32).to_le_bytes().to_vec()
            } else {
                value.to_le_bytes().to_vec()
            });
        }
        put((row[7] as i32).to_le_bytes().to_vec());
        put(vec![255]);
    }
    bytes
}

fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
    let head = format!("{{'descr': {descr}, 'fortran_order': False, 'shape': {shape}, }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((head.len() as u16).to_le_bytes());
    bytes.extend(head.bytes());
    bytes.extend(data);
    bytes
}

fn structured(rows: &[Row]) -> Vec<u8> {
    let descr = "[('P', '<f8', (3,)), ('name', '|S3'), ('width', '>f8'), ('v', '<f8', (3,)), ('id', '<u4')]";
    let mut data = Vec::new();
    for [x, y, z, radius, vx, vy, vz, id] in rows {
        [x, y, z].iter().for_each(|value| data.extend(value.to_le_bytes()));
        data.extend(b"abc");
        data.extend((2.0 * radius).to_be_bytes());
        [vx, vy, vz].iter().for_each(|value| data.extend(value.to_le_bytes()));
        data.extend((*id as u32).to_le_bytes());
    }
    npy(descr, &format!("({},)", rows.len()), &data)
}

fn archive(rows: &[Row]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    let flat = |columns: std::ops::Range<usize>| -> Vec<u8> {
        rows.iter()
            .flat_map(|row| row[columns.clone()].to_vec())
            .flat_map(f64::to_le_bytes)
            .collect()
    };
    let count = rows.len();
    let (plain, three) = (format!("({count},)"), format!("({count}, 3)"));
    for (name, columns, shape) in [
        ("position", 0..3, &three),
        ("radius", 3..4, &plain),
        ("velocity", 4..7, &three),
        ("id", 7..8, &plain),
    ] {
        archive
            .start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default())
            .expect("a file");
        archive.write_all(&npy("'<f8'", shape, &flat(columns))).expect("bytes");
    }
    archive.start_file("orient.npy", zip::write::SimpleFileOptions::default()).expect("a file");
    archive.write_all(&npy("'<f4'", "(2, 4)", &[0; 32])).expect("bytes");
    archive.finish().expect("an archive").into_inner()
}

fn comma(rows: &[Row], delimiter: &str, names: [&str; 8]) -> Vec<u8> {
    let mut text = format!("note{delimiter}{}\n", names.join(delimiter));
    for row in rows {
        let values: Vec<String> = row.iter().map(f64::to_string).collect();
        writeln!(text, "\"a, b\"{delimiter}{}", values.join(delimiter)).expect("text");
    }
    text.into_bytes()
}

fn scene() -> Scene {
    let mut scene = square(64);
    scene.camera.shutter = 0.01;
    scene
}

#[test]
fn the_same_drops_in_every_format_are_the_same_to_the_byte() {
    let folder = emptied_folder("particles/formats");
    let rows = rows();
    let expected: Vec<PlacedDrop> = rows.iter().map(placed).collect();
    let houdini = ["P[0]", "P[1]", "P[2]", "pscale", "v[0]", "v[1]", "v[2]", "id"];
    let files = [
        ("ascii.ply", ply("ascii", "double", &rows)),
        ("little.ply", ply("binary_little_endian", "double", &rows)),
        ("big.ply", ply("binary_big_endian", "double", &rows)),
        ("all.npy", structured(&rows)),
        ("all.npz", archive(&rows)),
        ("all.csv", comma(&rows, ",", NAMES)),
        ("houdini.csv", comma(&rows, ";", houdini)),
    ];
    let mut scenes = Vec::new();
    for (name, bytes) in &files {
        fs::write(folder.join(name), bytes).expect("a file");
        let mut scene = Scene { particles: Some(Particles::of(folder.join(name))), ..scene() };
        scene.read_particles().expect(name);
        assert!(scene.placed().eq(&expected), "{name}");
        scenes.push((*name, scene));
    }
    // What float32 keeps of them.
    let single = drops_of_bytes(&ply("binary_big_endian", "float", &rows)).expect("drops");
    assert!(single.iter().zip(&expected).all(|(a, b)| a.center.as_vec3() == b.center.as_vec3()));
    on_device(|device| {
        let drawn = |scene: &Scene| layers(device, scene, &Scene { time: 0.01, ..scene.clone() });
        let by_hand = drawn(&Scene { drops: expected.clone(), ..scene() });
        assert!(by_hand.id.iter().any(|id| (6950..7000).contains(id)));
        for (name, scene) in [&scenes[1], &scenes[4]] {
            assert!(drawn(scene) == by_hand, "{name}");
        }
    });
}

#[test]
fn what_is_no_file_of_drops_is_refused_in_a_line() {
    let some = |change: &dyn Fn(&mut Row)| {
        let mut rows = rows();
        change(&mut rows[4]);
        comma(&rows, ",", NAMES)
    };
    let header = |text: &str| format!("ply\nformat {text}end_header\n").into_bytes();
    let xyz = "property float x\nproperty float y\nproperty float z\n";
    let mixed = {
        let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        for (name, shape, size) in [("P", "(2, 3)", 24), ("pscale", "(3,)", 12)] {
            archive
                .start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default())
                .expect("a file");
            archive.write_all(&npy("'<f4'", shape, &vec![0; size])).expect("bytes");
        }
        archive.finish().expect("an archive").into_inner()
    };
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        ("nothing", Vec::new(), "no PLY, NPY, NPZ or CSV"),
        ("a picture", vec![0x89, b'P', b'N', b'G', 0xff, 0, 1], "no PLY, NPY, NPZ or CSV"),
        ("no names", b"1,2,3\n4,5,6\n".to_vec(), "names no columns of particles"),
        ("no places", b"id,pscale\n1,2\n".to_vec(), "no positions (x y z, P, position)"),
        ("half a velocity", b"x,y,z,vx,vy\n1,2,3,4,5\n".to_vec(), "a part of v alone"),
        ("a word", b"x,y,z\n1,2,three\n".to_vec(), "line 2: z = 'three' is no number"),
        ("a short line", b"x,y,z\n1,2\n".to_vec(), "line: 2"),
        (
            "a row that is no number",
            header(&format!("ascii 1.0\nelement vertex 2\n{xyz}"))
                .into_iter()
                .chain(*b"1 2 3\nnan 0 1\n")
                .collect(),
            "line 9: 'nan 0 1' is no row of finite numbers",
        ),
        ("NaN", some(&|row| row[1] = f64::NAN), "particle 5: its position is"),
        ("a velocity", some(&|row| row[5] = f64::INFINITY), "particle 5: its velocity is"),
        (
            "no size",
            some(&|row| row[3] = 0.0),
            "particle 5: its radius is 0, not finite and over 0",
        ),
        ("less", some(&|row| row[3] = -1.0), "particle 5: its radius is -1"),
        ("twice", some(&|row| row[7] = 6999.0), "particle 5: another one has its id, 6999"),
        ("half", some(&|row| row[7] = 0.5), "particle 5: id 0.5 is no whole number"),
        (
            "far",
            some(&|row| row[7] = 5e9),
            "particle 5: id 5000000000 is no whole number from 0 to",
        ),
        ("many in text", header(&format!("ascii 1.0\nelement vertex 1000000000\n{xyz}")), "vertex"),
        (
            "many in binary",
            header(&format!("binary_little_endian 1.0\nelement vertex 1000000000\n{xyz}")),
            "expected 1000000000, got 0",
        ),
        (
            "many of nothing",
            header(&format!(
                "binary_little_endian 1.0\nelement none 1000000000\nelement vertex 1\n{xyz}"
            )),
            "expected 1, got 0",
        ),
        (
            "a list",
            header(&format!(
                "ascii 1.0\nelement vertex 1\n{xyz}property list uchar float pscale\n"
            )),
            "the property pscale of its element vertex is a list",
        ),
        (
            "no element",
            header("ascii 1.0\nelement face 0\nproperty int a\n"),
            "none of its elements has positions",
        ),
        (
            "many numbers",
            npy("'<f4'", "(1000000000, 3)", &[0; 12]),
            "claims 1,000,000,000 particles",
        ),
        (
            "fewer",
            npy("'<f4'", "(60000000, 3)", &[0; 12]),
            "claims 720,000,000 bytes, and 12 follow",
        ),
        ("beyond", npy("'<f4'", "(4294967296, 4294967296, 3)", &[0; 12]), "its "),
        ("four", npy("'<f4'", "(1, 4)", &[0; 16]), "its shape is [1, 4], neither"),
        (
            "words",
            npy("[('x', '|S3'), ('y', '<f4'), ('z', '<f4')]", "(1,)", &[0; 11]),
            "is no number",
        ),
        ("a short one", b"\x93NUMPY\x01\x00".to_vec(), "fill whole buffer"),
        (
            "a long header",
            b"\x93NUMPY\x02\x00\xff\xff\xff\xff{}".to_vec(),
            "its header claims 4,294,967,295 bytes",
        ),
        ("mixed", mixed, "not as many of each"),
        ("no archive", b"PK\x03\x04and so on".to_vec(), ""),
    ];
    for (name, bytes, expected) in cases {
        let said = drops_of_bytes(&bytes).expect_err(name);
        assert!(said.contains(expected) && !said.contains('\n'), "{name}: {said}");
    }
    let said = |scene: &str| Scene::parse(scene, "s.toml").expect_err("refused").to_string();
    for (keys, expected) in [
        ("scale = 2.0", "particles: give a file"),
        ("file = \"a.ply\"\nscale = 0.0", "scale = 0 is not finite and over 0"),
        ("file = \"a.ply\"\nradius = -1.0", "radius = -1"),
        ("file = \"a.ply\"\nfps = nan", "fps = NaN"),
        ("file = \"a.ply\"\nfpss = 1.0", "did you mean `fps`"),
    ] {
        let said = said(&format!("[particles]\n{keys}"));
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn an_id_of_0_is_a_drop_too() {
    let drops = drops_of_bytes(b"x,y,z,id\n1,2,3,0\n1,2,4,1\n").expect("drops");
    assert_eq!(drops.iter().map(|drop| drop.id).collect::<Vec<_>>(), [Some(u32::MAX), Some(1)]);
}

/// Damaged files of each format are tried; none may panic.
#[test]
fn mutants_are_read_or_refused_in_a_line() {
    let (rows, mut random) = (&rows()[..4], Random(7));
    for (name, bytes) in [
        ("ascii", ply("ascii", "float", rows)),
        ("big", ply("binary_big_endian", "float", rows)),
        ("npy", structured(rows)),
        ("npz", archive(rows)),
        ("csv", comma(rows, ",", NAMES)),
    ] {
        let mut counts = [0; 2];
        for _ in 0..400 {
            let mut bytes = bytes.clone();
            for _ in 0..1 + random.bits() % 3 {
                if bytes.is_empty() {
                    break;
                }
                let at = random.bits() as usize % bytes.len();
                match random.bits() % 4 {
                    0 => bytes[at] ^= 1 << (random.bits() % 8),
                    1 => bytes[at] = b"0129-(' ,\n\0\xff"[random.bits() as usize % 12],
                    2 => drop(bytes.remove(at)),
                    _ => bytes.truncate(at.max(1)),
                }
            }
            let found = drops_of_bytes(&bytes);
            counts[usize::from(found.is_ok())] += 1;
            if let Err(said) = found {
                assert!(!said.is_empty() && !said.contains('\n'), "{name}: {said}");
            }
        }
        println!("{name}: {} read, {} refused", counts[1], counts[0]);
        assert!(counts.iter().all(|count| *count > 20), "{name}: {counts:?}");
    }
}

fn write_frame(folder: &Path, number: u32, rows: &str) {
    fs::write(folder.join(format!("s.{number:03}.csv")), rows).expect("a file");
}

#[test]
fn a_sequence_has_a_file_a_frame_and_moves_between_them() {
    let folder = emptied_folder("particles/sequence");
    write_frame(&folder, 5, "x,y,z,id\n0,0,-4,1\n1,0,-4,2\n");
    write_frame(&folder, 6, "x,y,z,id\n0,1,-4,1\n9,9,-4,3\n");
    write_frame(&folder, 7, "x,y,z,id,vx,vy,vz\n0,5,-4,1,2,0,0\n");
    let file: PathBuf = folder.join("s.%03d.csv");
    let mut particles = Particles::of(file);
    (particles.radius, particles.scale, particles.fps, particles.first) = (Some(0.5), 2.0, 10.0, 5);
    let mut scene = Scene { particles: Some(particles), rain: None, ..Scene::default() };
    let mut at = |time: f64| {
        scene.time = time;
        scene.read_particles().map(|()| {
            let drops = scene.placed().map(|drop| (drop.center_at(time), drop.velocity));
            drops.collect::<Vec<_>>()
        })
    };
    let near = |found: &[(DVec3, DVec3)], expected: &[([f64; 3], [f64; 3])]| {
        assert_eq!(found.len(), expected.len());
        for ((center, velocity), (place, moves)) in found.iter().zip(expected) {
            assert!(center.distance(DVec3::from_array(*place)) < 1e-9, "{center}");
            assert!(velocity.distance(DVec3::from_array(*moves)) < 1e-9, "{velocity}");
        }
    };
    // By ids: to the next frame, ten a second, lengths twice the file's. One without a next stands.
    near(
        &at(0.0).expect("drops"),
        &[([0.0, 0.0, -8.0], [0.0, 20.0, 0.0]), ([2.0, 0.0, -8.0], [0.0; 3])],
    );
    near(
        &at(0.05).expect("drops"),
        &[([0.0, 1.0, -8.0], [0.0, 20.0, 0.0]), ([2.0, 0.0, -8.0], [0.0; 3])],
    );
    near(
        &at(0.15).expect("drops"),
        &[([0.0, 6.0, -8.0], [0.0, 80.0, 0.0]), ([18.0, 18.0, -8.0], [0.0; 3])],
    );
    near(&at(0.25).expect("drops"), &[([0.2, 10.0, -8.0], [4.0, 0.0, 0.0])]);
    let said = at(0.3).expect_err("no such frame").to_string();
    assert!(said.contains("s.008.csv is not there: frame 8 of the sequence"), "{said}");
    let said = at(-0.05).expect_err("no such frame").to_string();
    assert!(said.contains("s.004.csv"), "{said}");
    // Without a next frame: from where the last one had them.
    fs::remove_file(folder.join("s.007.csv")).expect("removed");
    near(
        &at(0.1).expect("drops"),
        &[([0.0, 2.0, -8.0], [0.0, 20.0, 0.0]), ([18.0, 18.0, -8.0], [0.0; 3])],
    );
}

/// Nothing is written for a film whose sequence ends early.
#[test]
fn a_film_beyond_its_sequence_is_refused_before_it_begins() {
    let folder = emptied_folder("particles/film");
    write_frame(&folder, 1, "x,y,z\n0,0,-4\n");
    write_frame(&folder, 2, "x,y,z\n0,0.1,-4\n");
    let scene = "[particles]\nfile = \"s.%03d.csv\"\nradius = 0.2\n[film]\nfps = 24\n[image]\nwidth = 16\nheight = 16\n\
                 [environment]\nradiance = [1, 1, 1]\n[model]\npreset = \"fast\"\n";
    fs::write(folder.join("s.toml"), scene).expect("a scene");
    let render = |frames: &str| {
        let mut command = raindrops();
        command
            .current_dir(&folder)
            .args(["render", "s.toml", "--layers", "-o", "f.exr", "--frames", frames]);
        command.output().expect("run")
    };
    let output = render("3");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success() && said.contains("s.003.csv is not there: frame 3"), "{said}");
    let written = |name: &str| folder.join(name).exists();
    assert!(!written("f-0000.exr"));
    assert!(render("2").status.success());
    assert!(written("f-0000.exr") && written("f-0001.exr"));
    let [first, second] = ["f-0000.exr", "f-0001.exr"].map(|name| fs::read(folder.join(name)).ok());
    assert!(first != second, "the second frame has the first one's drops");
}
