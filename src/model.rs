//! The named models: every approximation goes by a name that a scene or a command line can choose.
//!
//! What each computes, costs and gets wrong stands in `docs/method.md`.

use clap::ValueEnum;
use serde::{Deserialize, Serialize};

/// Declares an enum of models whose names are the same in scene files, on the command line and in
/// result files.
macro_rules! models {
    ($(#[$meta:meta])* $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $text:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize, ValueEnum)]
        pub enum $name {
            $($(#[$variant_meta])* #[serde(rename = $text)] #[value(name = $text)] $variant,)+
        }

        impl $name {
            /// The name in scenes, commands and results.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $text,)+ }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.pad(self.name())
            }
        }
    };
}

models! {
    /// A choice of one model on every axis.
    Preset {
        /// The method as published in 2011, done well.
        Paper = "paper",
        /// Least time at no more error: prefiltered pictures, exact outlines and order, by compute.
        Fast = "fast",
        /// Truest on the GPU: rays through every pixel, the closed form, exact order.
        Exact = "exact",
    }
}

models! {
    /// How the light leaving a point of a drop is found.
    Optics {
        /// The paper's hierarchical mask: directions, reflectance and coverage from a ray-traced
        /// table at float16.
        Mask = "mask",
        /// The same at float32.
        MaskF32 = "mask-f32",
        /// The prefiltered picture of a far drop by view direction; larger drops by closed form.
        Appearance = "appearance",
        /// The closed form along rays through each pixel.
        ClosedForm = "closed-form",
    }
}

models! {
    /// Where the drops' positions come from.
    Simulation {
        /// Exact integers from a hash, for any time: nothing is stored from frame to frame.
        Integer = "integer",
        /// The paper's: float32 positions kept in a buffer and moved every frame; drifts.
        Stored = "stored",
    }
}

models! {
    /// What a drop is drawn as.
    Primitive {
        /// A point with `gl_PointSize`; drops over the device's point size as quads.
        Point = "point",
        /// Its pixels, composited tile by tile in a compute pass.
        Tile = "tile",
    }
}

models! {
    /// In which order drops are composited.
    Order {
        /// As they come, resolved by the depth test (the paper's).
        Unsorted = "unsorted",
        /// Exactly front to back, by distance and index.
        Sorted = "sorted",
    }
}

models! {
    /// How radiance becomes display colour.
    Operator {
        /// The global photographic operator of Reinhard et al. 2002.
        Photographic = "photographic",
        /// None: radiance above 1 clips.
        None = "none",
    }
}
