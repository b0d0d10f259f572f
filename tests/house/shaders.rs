//! What holds for the sources of all shaders, without a device: includes compile alone, `main`s are short.

use std::fs;
use std::path::PathBuf;

use shaderc::OptimizationLevel;

use crate::glsl::{self, Glsl};

/// Lines of a `main` at most, its first and last included.
const LONGEST_MAIN: usize = 50;
/// Macros that choose between what an include declares.
const MACROS: [&str; 2] = ["CELLS", "PICTURE_TEXELS"];

/// The sources: of this tree, or those that `tests/house/mutants.rs` has put a fault in.
fn folder() -> PathBuf {
    let own = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("glsl");
    std::env::var_os("RAINDROPS_TEST_GLSL").map_or(own, PathBuf::from)
}

/// Names and texts of the files of `glsl/`, or of a folder in it.
fn sources(within: &str) -> Vec<(String, String)> {
    let files = fs::read_dir(folder().join(within)).expect("a folder");
    let files = files.map(|file| file.expect("a file").path()).filter(|path| path.is_file());
    let text = |path: &PathBuf| fs::read_to_string(path).expect("text");
    let name = |path: &PathBuf| path.file_name().expect("a name").to_string_lossy().into_owned();
    files.map(|path| (name(&path), text(&path))).collect()
}

#[test]
fn each_include_compiles_alone() {
    let compiler = Glsl::new(&folder()).expect("a compiler");
    for (name, text) in sources("include") {
        // A drop's fragment has inputs that no other stage has.
        let of_fragment = name == "drop_fragment.glsl" || text.contains("\"drop_fragment.glsl\"");
        let main = if text.contains("void main()") { "" } else { "void main() {}" };
        let source = format!(
            "#version 460\n\
             #extension GL_GOOGLE_include_directive : require\n\
             #extension GL_KHR_shader_subgroup_arithmetic : require\n\
             #extension GL_KHR_shader_subgroup_ballot : require\n\
             #include \"{name}\"\n\
             #include \"{name}\"\n\
             {main}\n"
        );
        let shader = if of_fragment { "alone.frag" } else { "alone.comp" };
        let macros = MACROS.into_iter().filter(|name| text.contains(name)).map(Some);
        for define in macros.chain([None]) {
            let compiled = compiler.compile_text(OptimizationLevel::Zero, shader, &source, define);
            if let Err(problem) = compiled {
                panic!("{name} {}: {problem}", define.unwrap_or_default());
            }
        }
    }
}

#[test]
fn no_main_is_long() {
    for (name, text) in sources("").into_iter().chain(sources("include")) {
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            if !line.starts_with("void main()") || line.ends_with('}') {
                continue;
            }
            let length = 2 + lines.by_ref().take_while(|line| *line != "}").count();
            assert!(length <= LONGEST_MAIN, "{name}: main has {length} lines");
        }
    }
}

#[test]
fn numbers_of_bindings_and_kinds_of_populations_are_chosen_in_one_place() {
    let all = || {
        let shaders =
            sources("").into_iter().filter(|(name, _)| glsl::kind(name.as_ref()).is_some());
        shaders.chain(sources("include"))
    };
    let word = |text: &str, wanted: &str| {
        text.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == wanted)
    };
    let by_macro = all().find(|(_, text)| {
        text.lines().any(|line| line.starts_with("#define") && line.contains("_BINDING"))
    });
    assert_eq!(by_macro.map(|(name, _)| name), None, "a macro gives a binding's number");
    let cells = all().filter(|(_, text)| word(text, "CELLS")).map(|(name, _)| name);
    assert_eq!(cells.collect::<Vec<_>>(), ["population.glsl"]);
}
