//! Compiles `glsl/*.{comp,vert,frag}` to SPIR-V and writes `shaders.rs`, one constant a shader; and what the shaders share
//! with Rust, `sets.rs` and `structures.rs`. Warnings are errors; whatever a shader includes from `glsl/include` is tracked.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use glsl::Glsl;
use interface::Interface;

#[path = "src/gpu/glsl.rs"]
mod glsl;
#[path = "build/interface.rs"]
mod interface;

fn main() {
    if let Err(error) = build() {
        // `Debug` would show a compiler's message in one line.
        eprintln!("{error}");
        std::process::exit(1);
    }
}

fn build() -> Result<(), Box<dyn std::error::Error>> {
    let out = PathBuf::from(env::var("OUT_DIR")?);
    println!("cargo:rerun-if-changed=glsl");
    println!("cargo:rerun-if-changed=glsl/include");
    // First the folder within the repository: sources without one may lie in somebody else's.
    let git = std::process::Command::new("git")
        .args(["rev-parse", "--show-prefix", "--short=12", "HEAD"])
        .output();
    let told = git.ok().filter(|out| out.status.success()).map_or(Vec::new(), |out| out.stdout);
    let told = String::from_utf8_lossy(&told);
    let commit = told.strip_prefix('\n').map_or("unknown", str::trim);
    println!("cargo:rustc-env=RAINDROPS_COMMIT={commit}");
    if Path::new(".git/logs/HEAD").exists() {
        println!("cargo:rerun-if-changed=.git/logs/HEAD");
    }

    let compiler = Glsl::new(Path::new("glsl"))?;
    let variants = interface::variants(Path::new("glsl"))?;
    let (mut constants, mut all) = (String::new(), String::new());
    for variant in &variants {
        let (name, define, constant) = (&variant.file, variant.define, variant.constant());
        let words = compiler.compile(name, define)?;
        writeln!(
            constants,
            "/// `glsl/{name}`, compiled.\n\
             pub const {constant}: &Shader = \
             // SAFETY: the compiler's.\n\
             &unsafe {{ Shader::new(\"{name}\", {define:?}, &{words:?}) }};"
        )?;
        write!(all, "{constant}, ")?;
    }
    writeln!(constants, "/// Every shader.\npub const ALL: &[&Shader] = &[{all}];")?;
    fs::write(out.join("shaders.rs"), constants)?;
    let interface = Interface::read(&compiler, &variants)?;
    fs::write(out.join("sets.rs"), interface.sets())?;
    fs::write(out.join("structures.rs"), interface.structures()?)?;
    Ok(())
}
