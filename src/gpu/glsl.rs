//! GLSL to SPIR-V, by the same options when the program is built (`build.rs`) and when its shaders
//! are reloaded. Warnings are errors.

use std::fs;
use std::path::{Path, PathBuf};

use shaderc::{CompileOptions, Compiler, EnvVersion, OptimizationLevel, ShaderKind, TargetEnv};

// Compiled with this file wherever that is: in the library, in `build.rs` and in tests.
#[allow(dead_code, reason = "what is needed of it here is its text")]
#[path = "../abi/constants.rs"]
mod constants;

/// Compiles the shaders of a folder, which may include what is in its `include/`.
pub struct Glsl {
    compiler: Compiler,
    folder: PathBuf,
}

impl Glsl {
    /// A compiler for the shaders of `folder`.
    ///
    /// # Errors
    /// What the compiler says if it cannot start.
    pub fn new(folder: &Path) -> Result<Self, String> {
        let compiler = Compiler::new().map_err(|error| error.to_string())?;
        Ok(Self { compiler, folder: folder.into() })
    }

    /// SPIR-V of file `name`, with macro `define` defined if there is one.
    ///
    /// # Errors
    /// If `name` is no shader by its extension, or cannot be read; else what the compiler says,
    /// to which warnings are errors.
    pub fn compile(&self, name: &str, define: Option<&str>) -> Result<Vec<u32>, String> {
        self.compile_at(OptimizationLevel::Performance, name, define)
    }

    /// Like [`Glsl::compile`], but without optimisation: the result keeps the names of what it declares.
    ///
    /// # Errors
    /// See [`Glsl::compile`].
    #[allow(dead_code, reason = "for `build.rs` and `tests/house/abi.rs`")]
    pub fn compile_with_names(&self, name: &str, define: Option<&str>) -> Result<Vec<u32>, String> {
        self.compile_at(OptimizationLevel::Zero, name, define)
    }

    fn compile_at(
        &self,
        level: OptimizationLevel,
        name: &str,
        define: Option<&str>,
    ) -> Result<Vec<u32>, String> {
        self.compile_text(level, name, &read(&self.folder.join(name))?, define)
    }

    /// SPIR-V of the text of a shader, of the kind that `name` has by its extension.
    ///
    /// # Errors
    /// See [`Glsl::compile`].
    pub fn compile_text(
        &self,
        level: OptimizationLevel,
        name: &str,
        source: &str,
        define: Option<&str>,
    ) -> Result<Vec<u32>, String> {
        let path = self.folder.join(name);
        let kind = kind(&path).ok_or_else(|| format!("{name} is no .comp, .vert or .frag"))?;
        let mut options = CompileOptions::new().map_err(|error| error.to_string())?;
        options.set_target_env(TargetEnv::Vulkan, EnvVersion::Vulkan1_3 as u32);
        options.set_optimization_level(level);
        options.set_warnings_as_errors();
        options.set_include_callback(|name, _, _, _| {
            let path = self.folder.join("include").join(name);
            let content = match name {
                "constants.glsl" => constants::glsl(),
                _ => read(&path)?,
            };
            let resolved_name = path.to_string_lossy().into_owned();
            Ok(shaderc::ResolvedInclude { resolved_name, content })
        });
        if let Some(define) = define {
            options.add_macro_definition(define, None);
        }
        let shown = path.to_string_lossy();
        let compiled =
            self.compiler.compile_into_spirv(source, kind, &shown, "main", Some(&options));
        compiled.map(|spirv| spirv.as_binary().to_vec()).map_err(|error| error.to_string())
    }
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}

/// What a file is by its extension; none if it is no shader.
pub fn kind(path: &Path) -> Option<ShaderKind> {
    match path.extension()?.to_str()? {
        "comp" => Some(ShaderKind::Compute),
        "vert" => Some(ShaderKind::Vertex),
        "frag" => Some(ShaderKind::Fragment),
        _ => None,
    }
}
