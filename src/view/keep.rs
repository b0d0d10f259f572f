//! Screenshots and scene files of what one sees, under the next free number.

use std::path::PathBuf;

use crate::picture::write_png;
use crate::scene::Scene;
use crate::{Error, Result};

/// The folder that they go to.
#[derive(Debug)]
pub struct Keep {
    folder: PathBuf,
}

impl Keep {
    /// Keeps files in `folder`.
    pub fn new(folder: PathBuf) -> Self {
        Self { folder }
    }

    /// `raindrops-0001.png` or the first number after it that is free.
    fn next(&self, extension: &str) -> Result<PathBuf> {
        let path = |number: u32| self.folder.join(format!("raindrops-{number:04}.{extension}"));
        let free = (1..=9999).map(path).find(|path| !path.exists());
        free.ok_or_else(|| Error::write(&self.folder, "all numbers to 9999 are taken"))
    }

    /// Keeps a picture: sRGB, three bytes a pixel.
    pub fn picture(&self, srgb: &[u8], (width, height): (u32, u32)) -> Result<PathBuf> {
        let path = self.next("png")?;
        write_png(&path, width, height, srgb)?;
        Ok(path)
    }

    /// Keeps a scene.
    pub fn scene(&self, scene: &Scene) -> Result<PathBuf> {
        let path = self.next("toml")?;
        scene.save(&path)?;
        Ok(path)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::scene::model::{Optics, Preset};
    use crate::scene::{ModelChoice, PlacedDrop};

    #[test]
    fn a_scene_is_read_back_as_it_was() -> Result<()> {
        let folder = tempfile::tempdir().map_err(|error| Error::write(Path::new("tmp"), error))?;
        let keep = Keep::new(folder.path().into());
        let drop = PlacedDrop::sphere(glam::DVec3::new(0.1, 1e-9, -3e20), 1.0 / 3.0);
        let model = ModelChoice {
            preset: Preset::Fast,
            optics: Some(Optics::ClosedForm),
            samples: Some(7),
            ..ModelChoice::default()
        };
        let scenes = [
            Scene::default(),
            Scene { rain: None, drops: vec![drop; 2], ..Scene::default() },
            Scene { drops: vec![drop], time: -0.1 - 1e-12, model, ..Scene::default() },
        ];
        for (number, scene) in scenes.iter().enumerate() {
            let path = keep.scene(scene)?;
            assert_eq!(path, folder.path().join(format!("raindrops-{:04}.toml", number + 1)));
            assert_eq!(&Scene::load(&path)?, scene);
        }
        // What it names, wherever the file lies.
        let mut scene = Scene::default();
        scene.environment.file = Some("sky.exr".into());
        scene.background.color = Some("plate.exr".into());
        scene.background.depth = Some("depth.exr".into());
        let read = Scene::load(&keep.scene(&scene)?)?;
        let here = |name: &str| std::path::absolute(name).ok();
        assert_eq!(read.environment.file, here("sky.exr"));
        assert_eq!(read.background.color, here("plate.exr"));
        assert_eq!(read.background.depth, here("depth.exr"));
        Ok(())
    }
}
