//! Compiles `glsl/*.{comp,vert,frag}` to SPIR-V and writes `shaders.rs`, one constant a shader.
//! Warnings are errors; whatever a shader includes from `glsl/include` is tracked.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::{env, fs};

use shaderc::{CompileOptions, Compiler, EnvVersion, OptimizationLevel, ShaderKind, TargetEnv};

/// Shaders that are compiled a second time: file, suffix of the constant, macro that is defined.
const VARIANTS: [(&str, &str, &str); 5] = [
    ("drops.frag", "_CLOSED_FORM", "BY_CLOSED_FORM"),
    ("drops.frag", "_RADIAL", "DEVIATION_TABLE"),
    ("drops.frag", "_PICTURE", "BY_PICTURE"),
    ("log_luminance.comp", "_BUFFER", "RADIANCE_IN_BUFFER"),
    ("tone_map.frag", "_BUFFER", "RADIANCE_IN_BUFFER"),
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

    let compiler = Compiler::new()?;
    let mut options = CompileOptions::new()?;
    options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_3 as u32);
    options.set_optimization_level(OptimizationLevel::Performance);
    options.set_warnings_as_errors();
    options.set_include_callback(|name, _, _, _| {
        let path = format!("glsl/include/{name}");
        println!("cargo:rerun-if-changed={path}");
        let content = fs::read_to_string(&path).map_err(|error| format!("{path}: {error}"))?;
        Ok(shaderc::ResolvedInclude { resolved_name: path, content })
    });

    let mut files: Vec<PathBuf> =
        fs::read_dir("glsl")?.map(|entry| entry.map(|e| e.path())).collect::<Result<_, _>>()?;
    files.sort();
    let mut constants = String::new();
    for path in files {
        let Some(kind) = shader_kind(&path) else { continue };
        let name =
            path.file_name().and_then(|name| name.to_str()).ok_or("file name is not UTF-8")?;
        println!("cargo:rerun-if-changed=glsl/{name}");
        let source = fs::read_to_string(&path)?;
        let constant = name.replace('.', "_").to_uppercase();
        let variants = VARIANTS.iter().filter(|(file, ..)| *file == name);
        let variants = variants.map(|(_, suffix, define)| (*suffix, Some(*define)));
        for (suffix, define) in std::iter::once(("", None)).chain(variants) {
            let mut options = options.clone();
            if let Some(define) = define {
                options.add_macro_definition(define, None);
            }
            let path = path.to_string_lossy();
            let binary =
                compiler.compile_into_spirv(&source, kind, &path, "main", Some(&options))?;
            let words = binary.as_binary();
            writeln!(
                constants,
                "/// `glsl/{name}`, compiled.\n\
                 pub const {constant}{suffix}: &Shader = \
                 &Shader {{ name: \"{name}\", words: &{words:?} }};"
            )?;
        }
    }
    fs::write(out.join("shaders.rs"), constants)?;
    Ok(())
}

fn shader_kind(path: &Path) -> Option<ShaderKind> {
    match path.extension()?.to_str()? {
        "comp" => Some(ShaderKind::Compute),
        "vert" => Some(ShaderKind::Vertex),
        "frag" => Some(ShaderKind::Fragment),
        _ => None,
    }
}
