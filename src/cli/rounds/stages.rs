//! The stages of the paper's frame, drawn by one process and held against another's: `render --stages FILE`, which
//! `bench --a … --b …` runs where two pictures differ.
//!
//! The file is no result: a line of text, four numbers of 32 bits (columns, rows, drops, stages), then float32 as
//! they were drawn, all of this machine's byte order. Both sides run on it.

use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, ensure};
use glam::Vec3;

use crate::environment::Environment;
use crate::files::write_whole;
use crate::gpu::Device;
use crate::measure::drivers::{Apart, apart};
use crate::picture::Picture;
use crate::plan::{Output, plan};
use crate::renderer::Renderer;
use crate::renderer::stages::Stages;
use crate::scene::model::Preset;
use crate::scene::{ModelChoice, Scene};

const HEAD: &[u8] = b"raindrops-stages/1\n";

/// The paper's frame of a scene as far as each stage, and its picture; none of a scene without drops that have
/// numbers.
pub fn paper_stages(
    device: &Arc<Device>,
    scene: &Scene,
    environment: &Environment,
) -> crate::Result<Option<(Stages, Picture)>> {
    if scene.drop_count() == 0 {
        return Ok(None);
    }
    let mut scene = scene.clone();
    scene.model = ModelChoice {
        preset: Preset::Paper,
        mask_size: scene.model.mask_size,
        ..Default::default()
    };
    let plan = plan(&scene, environment, Output::Radiance)?;
    let mut renderer = Renderer::new(device, &scene, environment, &plan)?;
    renderer.draw(&scene)?;
    let picture = renderer.read_radiance()?;
    Ok(Some((Stages::draw(device, &scene, environment, &plan)?, picture)))
}

/// Writes stages for another process.
pub fn write(path: &Path, stages: &Stages, picture: &Picture) -> crate::Result<()> {
    let numbers = [picture.width, picture.height, stages.drops.len() as u32, 3];
    let mut bytes =
        [HEAD, bytemuck::cast_slice(&numbers), bytemuck::cast_slice(&stages.drops)].concat();
    stages.pictures.iter().for_each(|of| bytes.extend_from_slice(bytemuck::cast_slice(of)));
    bytes.extend_from_slice(bytemuck::cast_slice(&picture.pixels));
    write_whole(path, &bytes)
}

/// Reads what [`write`] wrote.
fn read(path: &Path) -> anyhow::Result<(Stages, Picture)> {
    let bytes = std::fs::read(path).context("no stages were written")?;
    let rest = bytes.strip_prefix(HEAD).context("they are no stages")?;
    let (head, rest) = rest.split_at_checked(16).context("they end in the middle")?;
    let [width, height, drops, 3] = bytemuck::pod_collect_to_vec::<u8, u32>(head)[..] else {
        anyhow::bail!("they are no stages");
    };
    let (pixels, drops) = (width as usize * height as usize, drops as usize);
    ensure!(rest.len() == 16 * drops + (3 * 16 + 12) * pixels, "they end in the middle");
    let (of_drops, mut rest) = rest.split_at(16 * drops);
    let mut next = || {
        let (of_stage, others) = rest.split_at(16 * pixels);
        rest = others;
        bytemuck::pod_collect_to_vec(of_stage)
    };
    let pictures = [next(), next(), next()];
    let stages = Stages { drops: bytemuck::pod_collect_to_vec(of_drops), pictures };
    let pixels: Vec<Vec3> = bytemuck::pod_collect_to_vec(rest);
    Ok((stages, Picture { width, height, pixels }))
}

/// How far two processes' stages are apart, in the order of the frame.
pub fn between(a: &Path, b: &Path) -> anyhow::Result<Vec<Apart>> {
    let (a, b) = (read(a)?, read(b)?);
    let size = |of: &(Stages, Picture)| (of.1.width, of.1.height, of.0.drops.len());
    ensure!(size(&a) == size(&b), "they are of different sizes");
    Ok(apart((&a.0, &a.1), (&b.0, &b.1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_come_back_as_they_were() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a");
        let numbers = |from: u32| (0..6).map(|n| [from as f32 + n as f32 / 7.0; 4]).collect();
        let stages = Stages { drops: vec![[0.5; 4]; 9], pictures: [1, 2, 3].map(numbers) };
        let picture = Picture { width: 3, height: 2, pixels: vec![Vec3::new(1.0, 2.0, 3.0); 6] };
        write(&path, &stages, &picture).expect("written");
        let (read_stages, read_picture) = read(&path).expect("stages");
        assert_eq!((read_stages.drops, read_stages.pictures), (stages.drops, stages.pictures));
        assert_eq!(read_picture.pixels, picture.pixels);
        assert!(between(&path, &path).expect("stages").iter().all(|stage| !stage.strays()));
        let bytes = std::fs::read(&path).expect("a file");
        for cut in [0, 5, 20, bytes.len() - 1] {
            write_whole(&path, &bytes[..cut]).expect("written");
            assert!(read(&path).is_err(), "{cut}");
        }
    }
}
