//! What is done in another way on a GPU than on a CPU driver, for its speed alone: both ways draw the same picture.
//!
//! A CPU driver runs the invocations of a dispatch in vectors of four to sixteen, one vector after the other on each
//! core: it wants few and long ones. A GPU runs tens of thousands beside each other, and waits for memory in each:
//! it wants many and short ones.

/// For which of the two the passes are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Machine {
    /// A driver that runs shaders on the host's processor.
    Cpu,
    /// Any other.
    Gpu,
}

impl Machine {
    /// Sums of log luminance before the last few, none where those are made of all at once (`passes::tone_map`).
    pub fn log_sums_between(self) -> Option<u32> {
        match self {
            Self::Cpu => None,
            Self::Gpu => Some(4096),
        }
    }

    /// Whether a workgroup each puts the lists of tiles in order whose drops did not come so (`glsl/order_lists.comp`), not an
    /// invocation each: on a CPU all would wait at each barrier for the work of the others.
    pub fn sorts_by_workgroups(self) -> bool {
        self == Self::Gpu
    }

    /// Whether shaders are laid out for a GPU, where they have the choice (`FOR_GPU`):
    /// - Four words that lie together are stored at once. A CPU driver stores word by word: of a splat's four links those in use.
    /// - The streaks that an invocation walks over are bounded: a watchdog would reset the device. llvmpipe ends loops itself.
    /// - A pass of a loop takes one splat, not two, for fewer registers. A CPU driver writes back all pixels after each pass.
    pub fn is_gpu(self) -> bool {
        self == Self::Gpu
    }

    /// Invocations of a workgroup that draws the images of bright sources in large drops, 64 of them or one
    /// (`glsl/glints.comp`). A vector of a CPU takes as long as the one invocation that has an image to solve for, so each
    /// takes several drops, and solves for those alone that need it.
    pub fn glint_lanes(self) -> u32 {
        match self {
            Self::Cpu => 8,
            Self::Gpu => 64,
        }
    }
}
