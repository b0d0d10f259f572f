//! What a device promises of how shaders run, beyond what Vulkan does. It is declared in every shader
//! (`specialize.rs`), so that the driver must keep it.
//!
//! Vulkan lets a driver round float32 operations as it likes, and run invocations that a branch has parted apart from each
//! other from then on. Which drops are in view is told alike by all drivers only if they round alike; and a subgroup's
//! invocations take places from a counter together (`glsl/include/together.glsl`). Denormals are left to the driver: no
//! length or light that matters is so small.

use std::ffi::CStr;

use ash::vk;

/// See [`Reconvergence::Promised`].
pub(super) const MAXIMAL_RECONVERGENCE: &CStr = c"VK_KHR_shader_maximal_reconvergence";
/// Validation layers before this version take the extension's SPIR-V for a mistake.
pub(super) const LAYER_KNOWS_IT: u32 = vk::make_api_version(0, 1, 3, 280);

/// Whether a subgroup's invocations come together again after a branch that only some of them took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reconvergence {
    /// The device has `VK_KHR_shader_maximal_reconvergence`, and it is enabled.
    Promised,
    /// Nothing promises it, but a driver that runs shaders on the host's processor has them in one vector.
    InOneVector,
    /// Nothing promises it: shaders do without.
    #[default]
    Open,
}

/// What a device promises.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Promises {
    /// Results in float32 are the nearest ones (`shaderRoundingModeRTEFloat32`).
    pub rounds_to_nearest: bool,
    /// Whether the invocations of a subgroup come together again after a branch.
    pub reconvergence: Reconvergence,
    /// Invocations that leave a loop at its end, while others of their vector go on, lose what they have read last: a defect of
    /// SwiftShader (docs/upstream.md). There such loops have a way out at their beginning, too, which none takes.
    pub loses_left: bool,
}

impl Promises {
    /// What a device with these properties promises. A driver that cannot round 32 bits by a rule of their own promises nothing.
    pub(super) fn of(
        floats: &vk::PhysicalDeviceFloatControlsProperties<'_>,
        has_extension: bool,
        is_cpu: bool,
        driver: vk::DriverId,
    ) -> Self {
        let is_apart =
            floats.rounding_mode_independence != vk::ShaderFloatControlsIndependence::NONE;
        Self {
            rounds_to_nearest: is_apart && floats.shader_rounding_mode_rte_float32 == vk::TRUE,
            reconvergence: match (has_extension, is_cpu) {
                (true, _) => Reconvergence::Promised,
                (false, true) => Reconvergence::InOneVector,
                (false, false) => Reconvergence::Open,
            },
            loses_left: driver == vk::DriverId::GOOGLE_SWIFTSHADER,
        }
    }

    /// What `raindrops devices` says of them, in two parts.
    pub fn words(&self) -> [&'static str; 2] {
        let rounding = match self.rounds_to_nearest {
            true => "rounded to the nearest, which the driver promises",
            false => "rounded as the driver does, which promises nothing",
        };
        let reconvergence = match self.reconvergence {
            Reconvergence::Promised => {
                "together after a branch, by VK_KHR_shader_maximal_reconvergence"
            }
            Reconvergence::InOneVector => "together after a branch, as they are one vector",
            Reconvergence::Open => "perhaps apart after a branch: shaders go without one",
        };
        [rounding, reconvergence]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_declared_that_a_device_does_not_promise() {
        use vk::ShaderFloatControlsIndependence as Independence;
        let of = |rounds: bool, independence, has_extension, is_cpu| {
            let floats = vk::PhysicalDeviceFloatControlsProperties::default()
                .shader_rounding_mode_rte_float32(rounds)
                .rounding_mode_independence(independence);
            Promises::of(&floats, has_extension, is_cpu, vk::DriverId::MESA_LLVMPIPE)
        };
        assert!(of(true, Independence::ALL, false, false).rounds_to_nearest);
        assert!(of(true, Independence::TYPE_32_ONLY, false, false).rounds_to_nearest);
        assert!(!of(true, Independence::NONE, false, false).rounds_to_nearest);
        assert!(!of(false, Independence::ALL, false, false).rounds_to_nearest);
        let reconvergence = |has, is_cpu| of(true, Independence::ALL, has, is_cpu).reconvergence;
        assert_eq!(reconvergence(true, true), Reconvergence::Promised);
        assert_eq!(reconvergence(false, true), Reconvergence::InOneVector);
        assert_eq!(reconvergence(false, false), Reconvergence::Open);
    }
}
