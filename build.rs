//! Compiles `glsl/*.{comp,vert,frag}` to SPIR-V and writes `shaders.rs`, one constant a shader.
//! Warnings are errors; whatever a shader includes from `glsl/include` is tracked.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use glsl::Glsl;

#[path = "src/gpu/glsl.rs"]
mod glsl;

/// Shaders that are compiled a second time: file, suffix of the constant, macro that is defined.
const VARIANTS: &[(&str, &str, &str)] = &[
    ("blocks.comp", "_TEXELS", "TEXELS"),
    ("bin_starts.comp", "_CELLS", "CELLS"),
    ("sort_clusters.comp", "_CELLS", "CELLS"),
    ("gather.comp", "_CELLS", "CELLS"),
    ("sky.comp", "_CELLS", "CELLS"),
    ("sky.comp", "_BEFORE", "BEFORE"),
    ("sky.comp", "_CELLS_BEFORE", "CELLS_BEFORE"),
    ("large.comp", "_CELLS", "CELLS"),
    ("composite.comp", "_DISORDERED", "DISORDERED"),
    ("composite.comp", "_TEXELS", "TEXELS"),
    ("layers.comp", "_CELLS", "OF_CELLS"),
    ("layers.comp", "_TEXELS", "BY_TEXELS"),
    ("layers.comp", "_CELLS_TEXELS", "OF_CELLS_BY_TEXELS"),
    ("drops.frag", "_CLOSED_FORM", "BY_CLOSED_FORM"),
    ("drops.frag", "_RADIAL", "DEVIATION_TABLE"),
    ("drops.frag", "_PICTURE", "BY_PICTURE"),
    ("drops.frag", "_STAGE", "STAGE"),
    ("output.frag", "_BUFFER", "RADIANCE_IN_BUFFER"),
    ("output.frag", "_TEXELS", "RADIANCE_IN_TEXELS"),
    ("renew_map.comp", "_CUBE", "CUBE"),
    ("tone_map.frag", "_BUFFER", "RADIANCE_IN_BUFFER"),
    ("tone_map.frag", "_TEXELS", "RADIANCE_IN_TEXELS"),
];

fn main() {
    if let Err(error) = build() {
        // As text: a compiler's message has lines.
        eprintln!("{error}");
        std::process::exit(1);
    }
}

fn build() -> Result<(), Box<dyn std::error::Error>> {
    let out = PathBuf::from(env::var("OUT_DIR")?);
    println!("cargo:rerun-if-changed=glsl");
    println!("cargo:rerun-if-changed=glsl/include");
    let commit =
        std::process::Command::new("git").args(["rev-parse", "--short=12", "HEAD"]).output();
    let commit = commit.ok().filter(|out| out.status.success());
    let commit = commit
        .map_or("unknown".into(), |out| String::from_utf8_lossy(&out.stdout).trim().to_string());
    println!("cargo:rustc-env=RAINDROPS_COMMIT={commit}");
    if Path::new(".git/logs/HEAD").exists() {
        println!("cargo:rerun-if-changed=.git/logs/HEAD");
    }

    let compiler = Glsl::new(Path::new("glsl"))?;
    let mut files: Vec<PathBuf> =
        fs::read_dir("glsl")?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
    files.sort();
    let (mut constants, mut all) = (String::new(), String::new());
    for path in files {
        if glsl::kind(&path).is_none() {
            continue;
        }
        let name =
            path.file_name().and_then(|name| name.to_str()).ok_or("file name is not UTF-8")?;
        let constant = name.replace('.', "_").to_uppercase();
        let variants = VARIANTS.iter().filter(|(file, ..)| *file == name);
        let variants = variants.map(|(_, suffix, define)| (*suffix, Some(*define)));
        for (suffix, define) in std::iter::once(("", None)).chain(variants) {
            let words = compiler.compile(name, define)?;
            writeln!(
                constants,
                "/// `glsl/{name}`, compiled.\n\
                 pub const {constant}{suffix}: &Shader = \
                 // SAFETY: the compiler's.\n\
                 &unsafe {{ Shader::new(\"{name}\", {define:?}, &{words:?}) }};"
            )?;
            write!(all, "{constant}{suffix}, ")?;
        }
    }
    writeln!(constants, "/// Every shader.\npub const ALL: &[&Shader] = &[{all}];")?;
    fs::write(out.join("shaders.rs"), constants)?;
    Ok(())
}
