//! A scene in a folder: its text, what stands beside it, and the light that it asks for.

use std::io::Cursor;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use half::f16;
use raindrops::environment::Environment;
use raindrops::files::write_whole;
use raindrops::picture::layers::Layers;
use raindrops::scene::Scene;

use super::scene::{Beside, Made, PHOTOGRAPHS, frame};

/// A scene that was read, ready to be drawn.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The text of the file.
    pub text: String,
    /// Where the file is; those that it names are beside it.
    pub file: PathBuf,
    /// The scene as the file has it, with the paths of its files.
    pub parsed: Scene,
    /// Its first frame.
    pub scene: Scene,
    pub environment: Environment,
}

/// Writes a scene as `scene.toml` with its files.
pub fn write(made: &Made, folder: &Path) -> anyhow::Result<()> {
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    for (name, beside) in &made.files {
        let path = folder.join(name);
        match beside {
            Beside::Sky(sky, random) => sky.picture(&mut random.clone()).write_exr(&path)?,
            Beside::Radiance(picture) => picture.write_exr(&path)?,
            Beside::Depth([width, height], depth) if name.ends_with(".png") => {
                write_whole(&path, &png(*width, *height, depth)?)?;
            }
            Beside::Depth([width, height], depth) => {
                let empty = Layers::empty(*width, *height);
                Layers { depth: depth.clone(), color: vec![[f16::ZERO; 4]; 0], ..empty }
                    .write_depth(&path)?;
            }
        }
    }
    write_whole(&folder.join("scene.toml"), made.text.as_bytes())?;
    Ok(())
}

/// Whole numbers of 16 bits; what is deeper than they hold is as deep as they hold.
fn png(width: u32, height: u32, depth: &[f32]) -> anyhow::Result<Vec<u8>> {
    let stored = depth.iter().map(|z| z.round().clamp(1.0, 65_535.0) as u16).collect();
    let image = image::ImageBuffer::<image::Luma<u16>, Vec<u16>>::from_raw(width, height, stored);
    let mut bytes = Cursor::new(Vec::new());
    image
        .context("a depth of the picture's size")?
        .write_to(&mut bytes, image::ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

/// Reads a scene file; photographs are in another folder.
pub fn read(file: &Path, photographs: &Path) -> anyhow::Result<Loaded> {
    let text = std::fs::read_to_string(file).with_context(|| file.display().to_string())?;
    let parsed = parsed(&text, file, photographs)?;
    let environment = Environment::open(&parsed.environment).with_context(|| {
        "scripts/setup.sh fetches photographs, --photographs names their folder".to_string()
    })?;
    Ok(Loaded { text, file: file.into(), scene: frame(&parsed), parsed, environment })
}

impl Loaded {
    /// Another text in place of the file's, with the same files beside it.
    pub fn with_text(&self, text: &str, photographs: &Path) -> anyhow::Result<Self> {
        let parsed = parsed(text, &self.file, photographs)?;
        let environment = match parsed.environment == self.parsed.environment {
            true => self.environment.clone(),
            false => Environment::open(&parsed.environment)?,
        };
        let (text, file) = (text.to_string(), self.file.clone());
        Ok(Self { text, file, scene: frame(&parsed), parsed, environment })
    }
}

/// The scene of a text, with the paths of its files.
fn parsed(text: &str, file: &Path, photographs: &Path) -> raindrops::Result<Scene> {
    let mut scene = Scene::parse(text, &file.display().to_string())?;
    let named =
        [&mut scene.environment.file, &mut scene.background.color, &mut scene.background.depth];
    for named in named.into_iter().flatten() {
        *named = match named.strip_prefix(PHOTOGRAPHS) {
            Ok(name) => photographs.join(name),
            Err(_) => file.with_file_name(&*named),
        };
    }
    Ok(scene)
}
