//! Shaders with a fault, compiled into a folder from which tests take them (`RAINDROPS_TEST_GLSL`).

use std::collections::BTreeSet;
use std::fs;
use std::ops::Range;
use std::path::Path;

use raindrops::gpu::shaders;

use crate::glsl;
use crate::mutants::write;

/// Files of the folder `glsl` in which a file's text ends up: itself, and those that include it.
fn with_text_of(tree: &Path, file: &Path) -> BTreeSet<String> {
    let sources: Vec<(String, String)> = ["glsl", "glsl/include"]
        .into_iter()
        .flat_map(|folder| fs::read_dir(tree.join(folder)).expect("shaders"))
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.is_file())
        .map(|path| (name_of(&path), fs::read_to_string(&path).expect("a shader")))
        .collect();
    let mut found = BTreeSet::from([name_of(file)]);
    loop {
        let before = found.len();
        for (name, source) in &sources {
            if found.iter().any(|of| source.contains(&format!("#include \"{of}\""))) {
                found.insert(name.clone());
            }
        }
        if found.len() == before {
            return found;
        }
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().expect("a file").to_string_lossy().into_owned()
}

/// How many of the shaders in which a fault ends up it changes, and how many no longer compile.
pub struct Compiled {
    pub changed: usize,
    pub broken: usize,
}

/// The tree's shaders with another text in a place of a file, as sources and those that it changes compiled, in `folder`. A
/// shader that does not compile stays as it was.
pub fn compile(
    tree: &Path,
    folder: &Path,
    file: &Path,
    place: Range<usize>,
    put: &str,
) -> Compiled {
    let _ = fs::remove_dir_all(folder);
    for part in ["glsl", "glsl/include"] {
        for entry in fs::read_dir(tree.join(part)).expect("shaders") {
            let path = entry.expect("an entry").path();
            if path.is_file() {
                let name = path.strip_prefix(tree).expect("below the tree");
                let mut source = fs::read_to_string(&path).expect("a shader");
                if name == file {
                    source.replace_range(place.clone(), put);
                }
                write(
                    &folder.join(name.strip_prefix("glsl").expect("a shader")),
                    source.as_bytes(),
                );
            }
        }
    }
    let compiler = glsl::Glsl::new(folder).expect("shaderc");
    let mut compiled = Compiled { changed: 0, broken: 0 };
    let with_text = with_text_of(tree, file);
    for shader in shaders::ALL.iter().filter(|shader| with_text.contains(shader.name)) {
        match compiler.compile(shader.name, shader.define) {
            Ok(words) if words == shader.words() => {}
            Ok(words) => {
                let file = crate::common::shader_file(shader.name, shader.define);
                let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
                fs::write(folder.join(file), bytes).expect("SPIR-V");
                compiled.changed += 1;
            }
            Err(_) => compiled.broken += 1,
        }
    }
    compiled
}
