//! The window's own pictures: the rain's under the overlay, presented or kept as a screenshot.

use std::sync::Arc;

use ash::vk;
use egui::TexturesDelta;
use egui::epaint::ClippedPrimitive;

use crate::Result;
use crate::gpu::{
    Buffer, Commands, Device, Image, ImageInfo, Recorder, Surface, Swapchain, Timestamps, Use,
    copy_to_buffer, image_barrier, image_discard, memory_barrier,
};
use crate::passes::overlay::Overlay;
use crate::passes::present::Present;

/// Frames that may be under way at once.
const FRAMES: usize = 2;

/// Commands of a frame under way, and what they took.
struct Frame {
    commands: Commands,
    timestamps: Timestamps,
}

/// What a window needs once its format is known.
struct Passes {
    present: Present,
    overlay: Overlay,
}

/// egui's triangles and the size of a point in pixels.
#[derive(Default)]
pub struct Shapes {
    /// What to draw, in order.
    pub primitives: Vec<ClippedPrimitive>,
    /// Pixels a point.
    pub points_px: f32,
}

/// The window's surface, its swapchain and the passes that draw into it.
pub struct Screen {
    frames: Vec<Frame>,
    next: usize,
    passes: Option<Passes>,
    swapchain: Option<Swapchain>,
    /// Changes of the font atlas that are not on the device yet.
    textures: TexturesDelta,
    /// Whether frames wait for the screen.
    vsync: bool,
    /// GPU milliseconds of the window's own passes in the last finished frame.
    pub passes_ms: Vec<(&'static str, f64)>,
    surface: Arc<Surface>,
    device: Arc<Device>,
}

impl Screen {
    /// The screen of a surface; its swapchain is made when first drawn to.
    ///
    /// # Errors
    /// [`crate::Error::Window`] if the device cannot present to it.
    pub fn new(device: &Arc<Device>, surface: Surface, vsync: bool) -> Result<Self> {
        surface.check(device)?;
        let frame = |_| -> Result<Frame> {
            let commands = Commands::new(device, "window")?;
            Ok(Frame { commands, timestamps: Timestamps::new(device)? })
        };
        Ok(Self {
            frames: (0..FRAMES).map(frame).collect::<Result<_>>()?,
            next: 0,
            passes: None,
            swapchain: None,
            textures: TexturesDelta::default(),
            vsync,
            passes_ms: Vec::new(),
            surface: Arc::new(surface),
            device: device.clone(),
        })
    }

    /// Whether frames wait for the screen.
    pub fn vsync(&self) -> bool {
        self.vsync
    }

    /// Lets frames wait for the screen, or not.
    pub fn set_vsync(&mut self, vsync: bool) -> Result<()> {
        if self.vsync != vsync {
            self.vsync = vsync;
            let size = self.size();
            self.resize(size)?;
        }
        Ok(())
    }

    /// Width and height of what is shown; 0 before the first frame and while minimised.
    pub fn size(&self) -> (u32, u32) {
        self.swapchain.as_ref().map_or((0, 0), |swapchain| swapchain.size)
    }

    fn resize(&mut self, size: (u32, u32)) -> Result<()> {
        let old = self.swapchain.take();
        self.swapchain =
            Swapchain::new(&self.device, &self.surface, size, self.vsync, FRAMES, old)?;
        Ok(())
    }

    /// Shows `pictures` from now on: one, or two to compare.
    pub fn show(&mut self, pictures: &[&Image]) -> Result<()> {
        if let Some(passes) = &mut self.passes {
            passes.present.show(pictures)?;
        }
        Ok(())
    }

    /// Draws the pictures and the overlay in a window of `size` pixels. False if nothing could be
    /// shown: the window is minimised, or changes its size at this moment.
    pub fn draw(&mut self, size: (u32, u32), pictures: &[&Image], shapes: &Shapes) -> Result<bool> {
        let is_stale = self.swapchain.as_ref().is_none_or(|s| s.is_stale() || s.size != size);
        if is_stale {
            self.resize(size)?;
        }
        let Some(swapchain) = &mut self.swapchain else { return Ok(false) };
        if self.passes.is_none() {
            self.passes = Some(Passes {
                present: Present::new(&self.device, swapchain.format, pictures)?,
                overlay: Overlay::new(&self.device, swapchain.format, FRAMES)?,
            });
        }
        let Some(passes) = &mut self.passes else { return Ok(false) };
        passes.overlay.update_atlas(&std::mem::take(&mut self.textures))?;

        let number = self.next;
        self.next = (self.next + 1) % FRAMES;
        let frame = &mut self.frames[number];
        let commands = frame.commands.begin()?;
        if frame.timestamps.is_used() {
            self.passes_ms = frame.timestamps.read_ms()?;
        }
        frame.timestamps.reset();
        let Some(acquired) = swapchain.acquire(number)? else {
            // Recording was begun; what is empty may be submitted.
            frame.commands.submit()?;
            return Ok(false);
        };
        let target = swapchain.image(acquired);
        let attachment = Use::ColorAttachment;
        // The swapchain's semaphore is waited for at this stage.
        image_discard(&self.device, commands, target, &[attachment], attachment);
        let time = &mut frame.timestamps;
        record(&self.device, commands, time, passes, number, target, pictures, Some(shapes))?;
        image_barrier(&self.device, commands, target, attachment, Use::Present);
        swapchain.present(acquired, &mut frame.commands)?;
        Ok(true)
    }

    /// Takes what egui changed in its font atlas, which it tells only once.
    pub fn take_textures(&mut self, textures: TexturesDelta) {
        self.textures.append(textures);
    }

    /// What the window shows, with or without the overlay: sRGB, three bytes a pixel, row by row
    /// from the top, of [`Screen::size`]. None before the first frame.
    pub fn read(
        &mut self,
        pictures: &[&Image],
        shapes: Option<&Shapes>,
    ) -> Result<Option<Vec<u8>>> {
        let (width, height) = self.size();
        let (Some(swapchain), Some(passes)) = (&self.swapchain, &mut self.passes) else {
            return Ok(None);
        };
        // What was laid out for this picture may need letters that are not on the device yet.
        passes.overlay.update_atlas(&std::mem::take(&mut self.textures))?;
        let format = swapchain.format;
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let info = ImageInfo::flat("screenshot", [width, height], format, usage);
        let image = Image::new(&self.device, &info)?;
        let count = width as usize * height as usize;
        let staging = Buffer::readback(&self.device, "screenshot", 4 * count as u64)?;

        // The overlay's buffers of this frame, and its commands, must not be in use.
        self.device.wait_idle()?;
        let frame = &mut self.frames[0];
        let commands = frame.commands.begin()?;
        frame.timestamps.reset();
        let device = &*self.device;
        let attachment = Use::ColorAttachment;
        image_discard(device, commands, &image, &[Use::Nothing], attachment);
        record(device, commands, &mut frame.timestamps, passes, 0, &image, pictures, shapes)?;
        image_barrier(device, commands, &image, attachment, Use::TransferRead);
        copy_to_buffer(device, commands, (&image, 0), (&staging, 0));
        memory_barrier(device, commands, &[Use::TransferWrite], &[Use::HostRead]);
        frame.commands.submit()?;
        frame.commands.wait()?;
        let pixels: Vec<[u8; 4]> = staging.read(count);
        let is_bgr = format == vk::Format::B8G8R8A8_SRGB;
        let rgb = |[a, b, c, _]: [u8; 4]| if is_bgr { [c, b, a] } else { [a, b, c] };
        Ok(Some(pixels.into_iter().flat_map(rgb).collect()))
    }
}

/// The frame: the finished pictures, and over them the overlay. `target` is a colour attachment.
#[expect(clippy::too_many_arguments, reason = "borrowed from both sides of `Screen`")]
fn record(
    device: &Device,
    commands: Recorder<'_>,
    time: &mut Timestamps,
    passes: &mut Passes,
    frame: usize,
    target: &Image,
    pictures: &[&Image],
    shapes: Option<&Shapes>,
) -> Result<()> {
    let (drawn, sampled) = (Use::ColorAttachment, Use::GraphicsRead);
    for picture in pictures {
        image_barrier(device, commands, picture, drawn, sampled);
    }
    time.time(commands, "present", || passes.present.record(device, commands, target));
    for picture in pictures {
        image_barrier(device, commands, picture, sampled, drawn);
    }
    let mut recorded = Ok(());
    if let Some(Shapes { primitives, points_px, .. }) = shapes {
        image_barrier(device, commands, target, drawn, drawn);
        let overlay = &mut passes.overlay;
        time.time(commands, "overlay", || {
            recorded = overlay.record(commands, frame, target, primitives, *points_px);
        });
    }
    recorded
}

impl Drop for Screen {
    fn drop(&mut self) {
        // Frames under way use what is about to be freed; a lost device has none.
        let _ = self.device.wait_idle();
    }
}
