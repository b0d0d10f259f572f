//! Constants that Rust and GLSL share. Shaders include them as `constants.glsl`, which is made of them here and stands in
//! no file.

use std::fmt::Write as _;

/// A value that a shader can declare.
trait Declared {
    fn declare(&self, name: &str) -> String;
}

impl Declared for u32 {
    fn declare(&self, name: &str) -> String {
        format!("const uint {name} = {self}u;\n")
    }
}

impl<const N: usize> Declared for [[u32; 2]; N] {
    fn declare(&self, name: &str) -> String {
        let each: Vec<_> = self.iter().map(|[x, y]| format!("uvec2({x}, {y})")).collect();
        format!("const uvec2 {name}[{N}] = uvec2[{N}]({});\n", each.join(", "))
    }
}

macro_rules! constants {
    ($($(#[$doc:meta])+ $name:ident: $type:ty = $value:expr;)+) => {
        $($(#[$doc])+ pub const $name: $type = $value;)+

        /// What shaders include as `constants.glsl`.
        pub fn glsl() -> String {
            let mut out = String::from("#ifndef CONSTANTS\n#define CONSTANTS\n");
            $(let _ = write!(out, "{}", $name.declare(stringify!($name)));)+
            out + "#endif\n"
        }
    };
}

constants! {
    /// Tiles that have a bit each in a word of `drawn_tiles.glsl`.
    LISTED_TILES: u32 = 32;
    /// Lists of those tiles.
    LISTS: u32 = 4;
    /// Drops of a cluster: enough that a cluster's test costs little a drop, few enough that clusters at the edge of the
    /// view do not drag in many drops out of it.
    CLUSTER: u32 = 16;
    /// In the place of a drop's index: none, where drops do not fill their last cluster.
    NO_DROP: u32 = u32::MAX;
    /// In scenes of real rain the first index of the drops placed by hand.
    IS_PLACED: u32 = 1 << 31;
    /// Populations of drops in boxes at most: the box around a cluster has two bits for the number of its own.
    MOST_POPULATIONS: u32 = 4;
    /// Stretches of all clusters, of which the workgroups that find those in view take parts in turn.
    STRETCHES: u32 = 64;
    /// Pixels of a tile across. So few a tile that one invocation holds them in registers.
    TILE_ACROSS: u32 = 4;
    /// Pixels of a tile down.
    TILE_DOWN: u32 = 2;
    /// Tiles across of the smallest regions, by which clusters are sorted within their band and tiles are drawn.
    REGION_ACROSS: u32 = 32;
    /// Tiles down of those.
    REGION_DOWN: u32 = 16;
    /// Regions at most.
    MAX_REGIONS: u32 = 256;
    /// Bands of depth at most, in which clusters are taken, farthest first.
    MAX_BANDS: u32 = 16;
    /// Tiles of a drop at most whose blocks one invocation gives out; of others a workgroup does.
    MOST_TILES: u32 = 12;
    /// Dispatches at most among which blocks that are drawn by rays are shared out.
    RAY_PIECES: u32 = 64;
    /// Words of a splat's node; a block has two nodes.
    NODE: u32 = 8;
    /// Entries of a tile's list that a dispatch goes through, or sorts: some 0.3 s on an NVIDIA H200, where a watchdog would wait
    /// for 2.
    MOST_ENTRIES: u32 = 65_536;
    /// Vectors of a tile whose list takes several dispatches.
    SAVED: u32 = 17;
    /// End of a tile's list.
    END: u32 = u32::MAX;
    /// Directions along an edge of the octahedral map. A texel is 3.2° wide on the mean; its corners are up to 3.8° from its middle.
    DIRECTIONS: u32 = 64;
    /// Texels of a direction's larger pictures, 4 + 16 + 64 + 256.
    PYRAMID: u32 = 340;
    /// Texels an edge of the largest, where a frame asks for it.
    LARGEST_EDGE: u32 = 32;
    /// Blocks of a chunk of the paper's drops: each is one subgroup's work, and each sums up the counts of all before it.
    BLOCKS: u32 = 1024;
    /// In place of the picture of one texel of a direction: it has no pictures yet. No radiance is packed so.
    NO_PICTURE: u32 = 0xf800_0000;
    /// Cells of real rain that one workgroup looks into, all of one slab.
    CELLS_GROUP: u32 = 64;
    /// Classes of real rain at most.
    MOST_CLASSES: u32 = 48;
    /// Slabs of a picture at most. At the default cut-off and 60 degrees there are some thousand.
    MOST_SLABS: u32 = 32_768;
    /// Words of a class's law: [`QUANTILES`], then thresholds.
    LAW_WORDS: u32 = 128;
    /// Quantiles of a class's diameter.
    QUANTILES: u32 = 65;
    /// Depths at which a medium's optical depth is tabulated.
    MEDIUM_DEPTHS: u32 = 64;
    /// Angles from 0 to a half turn at which a far drop's light from a source is tabulated: 0.09° apart, a third of the
    /// sun's radius.
    BOW_ANGLES: u32 = 2048;
    /// Elevations, and azimuths over a half turn, at which flattened drops' part of a source's light is tabulated.
    FLAT_SUN_ANGLES: u32 = 24;
    /// Elevations of the camera's direction at which rain has shares of drops of [`FLAT_DIAMETERS`].
    FLAT_ELEVATIONS: u32 = FLAT_SUN_ANGLES;
    /// Diameters of flattened drops whose light is tabulated by direction: words of an entry.
    FLAT_DIAMETERS: u32 = 4;
    /// Angles between a far drop and a source at which its images are tabulated: 0.11° apart at most.
    GLINT_ANGLES: u32 = 2048;
    /// Diameters at which the shape of falling drops is tabulated.
    DIAMETERS: u32 = 41;
    /// How many of them are in a mm.
    DIAMETERS_A_MM: u32 = 8;
    /// The least of them, mm. Smaller drops are spheres, drops over the largest have its shape.
    SMALLEST_MM: u32 = 1;
    /// Pixels along both axes of a block in which drops on a pane are looked for.
    PANE_BLOCK: u32 = 8;
    /// Room for numbers in the cells of a host's pane, for each drop that there may be. Drops that cover no place twice, seen
    /// square on, are in up to 27 cells each on the mean (`passes/pane/drops.rs`).
    PANE_LIST: u32 = 32;
    /// Entries along an edge of the largest table of a drop on a pane.
    PANE_TABLE: u32 = 12;
    /// Most bright sources; each costs every large drop a microsecond on one CPU core. Further ones stay in the
    /// environment that drops see: they are filtered as all of it is.
    MOST_SOURCES: u32 = 8;
    /// Most rays of a pixel of a drop that moves: how many it has is found as they are traced.
    MOST_MOVING_RAYS: u32 = 48;
    /// Most rays of a pixel of a drop out of focus.
    MOST_LENS_RAYS: u32 = 128;
    /// Strided sums by which bright sources are found.
    STRIDES: u32 = 1024;
    /// Largest radiance that an environment stores: half of float16's largest, so that sums of a few fit.
    MAX_STORED: u32 = 32_768;
    /// Pixels of the cells by which streaks and discs are listed: squares, columns, rows, short columns; of drops out of
    /// focus squares and wide squares.
    CELLS_PX: [[u32; 2]; 6] = [[8, 8], [4, 32], [32, 4], [4, 8], [8, 8], [32, 32]];
}
