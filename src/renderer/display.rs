//! The last pass of a picture that is shown: from radiance to display colour, exposed by the picture's own light where the scene
//! asks for that.

use std::sync::Arc;

use ash::vk;

use crate::Result;
use crate::gpu::{
    Device, Image, ImageInfo, Recorder, Timestamps, Use, image_discard, memory_barrier,
};
use crate::passes::tone_map::{DISPLAY, FinalSums, Source, ToneMap};

/// The pass that turns radiance into display colour, and its target.
pub(super) struct Display {
    pub tone_map: ToneMap,
    pub image: Image,
    /// Whether the frame sums up the logarithms that a derived exposure needs.
    pub log_average: bool,
}

impl Display {
    /// The target of a tone map, of so many pixels. `log_average`: whether frames sum up logarithms.
    ///
    /// # Errors
    /// See [`Image::new`].
    pub fn new(
        device: &Arc<Device>,
        tone_map: ToneMap,
        size: [u32; 2],
        log_average: bool,
    ) -> Result<Self> {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT
            | vk::ImageUsageFlags::TRANSFER_SRC
            | vk::ImageUsageFlags::SAMPLED;
        let info = ImageInfo::flat("display", size, DISPLAY, usage);
        Ok(Self { tone_map, image: Image::new(device, &info)?, log_average })
    }

    /// Records the display image of `source`. `sums`: of log luminance, in place of the picture's own.
    pub fn record(
        &self,
        device: &Device,
        commands: Recorder<'_>,
        time: &mut Timestamps,
        source: Source<'_>,
        derives_exposure: bool,
        sums: Option<&FinalSums>,
    ) {
        let tone_map = &self.tone_map;
        if let (true, Some(sums)) = (derives_exposure, sums) {
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::TransferWrite]);
            tone_map.record_sums(device, commands, source, sums);
            memory_barrier(device, commands, &[Use::TransferWrite], &[Use::GraphicsRead]);
        } else if derives_exposure {
            time.time(commands, "log luminance", || {
                tone_map.record_log_luminance(device, commands);
            });
            memory_barrier(device, commands, &[Use::ComputeWrite], &[Use::GraphicsRead]);
        }
        let before = [Use::TransferRead, Use::ColorAttachment];
        image_discard(device, commands, &self.image, &before, Use::ColorAttachment);
        time.time(commands, "tone map", || tone_map.record(device, commands, &self.image));
    }
}
