//! The named models: every approximation goes by a name that a scene or a command line can choose.
//!
//! What each computes, costs and gets wrong stands in `docs/method.md`.

use serde::{Deserialize, Serialize};

/// Declares an enum of models whose names are the same in scene files, on the command line and in
/// result files.
macro_rules! models {
    ($(#[$meta:meta])* $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $text:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
        #[cfg_attr(any(feature = "cli", feature = "view"), derive(clap::ValueEnum))]
        pub enum $name {
            $($(#[$variant_meta])* #[serde(rename = $text)]
            #[cfg_attr(any(feature = "cli", feature = "view"), value(name = $text))]
            $variant,)+
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
        /// What the scene requires: within the error that is accepted, or within a frame's time and never less true than `fast`.
        Auto = "auto",
        /// `paper`, but only the drops in view are drawn: the same pictures without a vertex for each of the others.
        PaperCompact = "paper-compact",
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
        /// The same at 16-bit signed normalised integers.
        MaskSnorm16 = "mask-snorm16",
        /// A mask whose every level is the drop seen from infinity (Rousseau et al. 2006).
        SingleMask = "single-mask",
        /// A table of deviation and reflectance over the impact parameter alone.
        Radial = "radial",
        /// The closed form along rays through each pixel: no table at all.
        ClosedForm = "closed-form",
        /// The mean colour of a far drop by view direction.
        Far = "far",
        /// The prefiltered picture of a far drop by view direction; larger drops by closed form.
        Appearance = "appearance",
    }
}

impl Optics {
    /// Whether directions come from the paper's mask, in whatever storage.
    pub fn is_mask(self) -> bool {
        matches!(self, Self::Mask | Self::MaskF32 | Self::MaskSnorm16 | Self::SingleMask)
    }

    /// Whether a drop's light is integrated before the frame, so that a pixel looks it up once.
    pub fn is_prefiltered(self) -> bool {
        matches!(self, Self::Far | Self::Appearance)
    }
}

models! {
    /// What becomes of the light of those internal reflections that are not followed.
    Weights {
        /// The last order that is followed carries it: no energy is lost, but it leaves in a wrong
        /// direction. With none followed these are the paper's weights, F and 1-F.
        Conserving = "conserving",
        /// It is left out: F and (1-F)² F^k, as physics has them.
        Physical = "physical",
    }
}

models! {
    /// Reflectance of the water's surface.
    Fresnel {
        /// The exact formula for unpolarised light.
        Exact = "exact",
        /// Schlick's approximation (1994); off by up to 0.06, near 84°.
        Schlick = "schlick",
    }
}

models! {
    /// The light that a drop reflects on its outside.
    Reflection {
        /// Shown.
        On = "on",
        /// Left out; nothing stands in.
        Off = "off",
    }
}

models! {
    /// At which level of its prefilter the environment is read.
    Lookup {
        /// That of the footprint of a pixel's, or a sample's, ray.
        Footprint = "footprint",
        /// Always the finest.
        Finest = "finest",
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
        /// Four vertices of a strip an instance.
        Quad = "quad",
        /// Its pixels, composited tile by tile in a compute pass.
        Tile = "tile",
    }
}

models! {
    /// In which order drops are composited.
    Order {
        /// As they come, blended and resolved by the depth test (the paper's).
        Unsorted = "unsorted",
        /// As they come, into four samples a pixel of which alpha says how many a drop takes; the
        /// depth test resolves the order sample by sample.
        AlphaToCoverage = "alpha-to-coverage",
        /// Exactly front to back, by distance and index.
        Sorted = "sorted",
    }
}

models! {
    /// The law of the sizes of real rain's drops.
    Sizes {
        /// Marshall and Palmer 1948: exponential.
        MarshallPalmer = "marshall-palmer",
        /// Ulbrich 1983: a power times an exponential.
        Gamma = "gamma",
        /// As many of every diameter.
        Uniform = "uniform",
    }
}

models! {
    /// The shape of real rain's drops.
    DropShape {
        /// Flattened by the air, by their size.
        Equilibrium = "equilibrium",
        /// Spheres.
        Sphere = "sphere",
    }
}

models! {
    /// In what shape drops are drawn that are no spheres.
    ShapeModel {
        /// As spheres of their volume.
        Sphere = "sphere",
        /// A sphere's picture on the outline of a spheroid.
        Stretched = "stretched",
        /// Spheroids, each ray traced from surface to surface.
        Spheroid = "spheroid",
        /// As the scene has them: two half spheroids of the equilibrium shape, spheroids by `axis_ratio`, both traced.
        Equilibrium = "equilibrium",
    }
}

models! {
    /// What becomes of drops of real rain whose radius is under the cut-off in pixels.
    FarRain {
        /// All are drawn, one by one.
        Drops = "drops",
        /// They are a medium that takes out and puts in the light that they would.
        Medium = "medium",
        /// They are left out: the picture is too clear and too dark.
        None = "none",
    }
}

models! {
    /// How drops are shown that move while the shutter is open.
    Motion {
        /// Where they are when it opens.
        Instant = "instant",
        /// Their outline's mean over the exposure, in closed form; small and faint ones of one colour.
        Streak = "streak",
        /// Rays that have a time each, for every drop.
        Sampled = "sampled",
    }
}

models! {
    /// How drops out of focus are shown.
    Lens {
        /// As through a pinhole: sharp.
        Pinhole = "pinhole",
        /// Their outline spread over the disc that a point becomes, in closed form; small and faint ones of one colour.
        Disc = "disc",
        /// Rays that have a place on the lens each.
        Sampled = "sampled",
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
