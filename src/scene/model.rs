//! The named models: every approximation goes by a name that a scene or a command line can choose; and what a scene has
//! chosen.
//!
//! What each computes, costs and gets wrong stands in `docs/method.md`.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::scene::real_rain::RealRain;

/// Declares an enum of models whose names are the same in scene files, on the command line and in
/// result files.
macro_rules! models {
    ($(#[$meta:meta])* $name:ident { $($(#[$variant_meta:meta])* $variant:ident = $text:literal,)+ }) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize, schemars::JsonSchema)]
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
        /// The paper's mask at float32.
        MaskF32 = "mask-f32",
        /// The paper's mask at 16-bit signed normalised integers.
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

    /// Whether a drop's light is integrated before it is drawn, so that a pixel looks it up once.
    pub fn is_prefiltered(self) -> bool {
        matches!(self, Self::Far | Self::Appearance)
    }

    /// Whether drops can be entered into tiles.
    pub fn is_on_tiles(self) -> bool {
        matches!(self, Self::ClosedForm | Self::Appearance)
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
        /// Drawn as they come, blended and resolved by the depth test (the paper's).
        Unsorted = "unsorted",
        /// Drawn as they come, into four samples a pixel of which alpha says how many a drop takes; the depth test
        /// resolves the order sample by sample.
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
        /// Equally many drops of every diameter.
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
        /// Spheres of their volume.
        Sphere = "sphere",
        /// A sphere's picture on the outline of a spheroid.
        Stretched = "stretched",
        /// Spheroids, each ray traced from surface to surface.
        Spheroid = "spheroid",
        /// The scene's shapes: two half spheroids of the equilibrium shape, spheroids by `axis_ratio`, both traced.
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
        /// `medium`, with the noise that single drops make.
        Grain = "grain",
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
        /// A pinhole: drops are sharp.
        Pinhole = "pinhole",
        /// Their outline spread over the disc that a point becomes, in closed form; small and faint ones of one colour.
        Disc = "disc",
        /// Rays that have a place on the lens each.
        Sampled = "sampled",
    }
}

models! {
    /// How a pane of glass and the drops on it are drawn.
    PaneModel {
        /// Rays through each pixel that a drop touches, followed through up to eight reflections within it.
        Exact = "exact",
        /// Rays as in `exact`, but what does not leave a drop where it meets the surface first is dark.
        FirstExit = "first-exit",
        /// Drops out of focus by what is seen of them from the middle of the lens: a picture each, spread over the lens's disc; from
        /// twice their radius on by one colour.
        Picture = "picture",
        /// Drops out of focus by one colour each, spread over the lens's disc.
        Color = "colour",
        /// Left out, glass and drops: the rain as without a pane.
        None = "none",
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

/// A preset and what overrides it. Only TOML is made of it, which leaves out what is not there.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ModelChoice {
    /// Chooses on every axis what no other key does.
    pub preset: Preset,
    /// The RMS error of sRGB values, from 0 to 1, that preset `auto` may make. A grey level is 1/255 = 0.0039.
    #[schemars(extend(
        "exclusiveMinimum" = 0,
        "maximum" = 1,
        "x-default" = "the least that `budget_ms` or a frame of 1/60 s affords"
    ))]
    pub error: Option<f64>,
    /// What a frame by preset `auto` may take on the device at hand.
    #[schemars(extend("exclusiveMinimum" = 0, "x-unit" = "ms"))]
    pub budget_ms: Option<f64>,
    /// How the light leaving a point of a drop is found.
    #[schemars(extend("x-default" = "by preset"))]
    pub optics: Option<Optics>,
    /// What a drop is drawn as.
    #[schemars(extend("x-default" = "by preset and optics"))]
    pub primitive: Option<Primitive>,
    /// In which order drops are composited: tiles are always `sorted`, points and quads never.
    #[schemars(extend("x-default" = "`sorted` for tiles, else `unsorted`"))]
    pub order: Option<Order>,
    /// Where the drops' places come from.
    #[schemars(extend("x-default" = "`integer`"))]
    pub simulation: Option<Simulation>,
    /// Edge of the mask's finest level, a power of two.
    #[schemars(range(min = 1, max = 4096), extend("x-unit" = "texels"))]
    pub mask_size: u32,
    /// Places in a pixel that a drop's light is the mean of; on tiles rays.
    #[schemars(range(min = 1, max = 256), extend("x-default" = "by preset"))]
    pub samples: Option<u32>,
    /// Most reflections inside a drop that are followed; the paper's mask follows none.
    #[schemars(range(min = 0, max = 8), extend("x-default" = "by preset"))]
    pub internal_reflections: Option<u32>,
    /// What becomes of the light of the reflections that are not followed.
    #[schemars(extend(
        "x-default" = "`conserving`; `physical` where `closed-form` rays are traced through drops that are no spheres"
    ))]
    pub weights: Option<Weights>,
    /// Reflectance of the water's surface.
    #[schemars(extend("x-default" = "`exact`"))]
    pub fresnel: Option<Fresnel>,
    /// The light that a drop reflects on its outside.
    #[schemars(extend("x-default" = "`on`; `auto` may choose off"))]
    pub reflection: Option<Reflection>,
    /// At which level of its prefilter the environment is read.
    #[schemars(extend("x-default" = "`footprint`"))]
    pub lookup: Option<Lookup>,
    /// What becomes of the drops of real rain under the cut-off; `drops` needs a finite `rain.extent`.
    #[schemars(extend(
        "x-default" = "`grain` where its noise is over `error` (a grey level if there is none), else `medium`"
    ))]
    pub far_rain: Option<FarRain>,
    /// Radius under which a drop of real rain is not drawn one by one. It follows from the environment's contrast, is 0.053
    /// at most without `error` and an exposure of 1/250 s or longer, and rises where more than 4 million drops would be
    /// drawn. One that is given, and `far_rain = "drops"`, rise where more than 8 million would be.
    #[schemars(range(min = 0.001, max = 1), extend(
        "x-unit" = "px",
        "x-default" = "where a drop at rest changes no pixel by more than `error` (a grey level if there is none)"
    ))]
    pub cutoff_px: Option<f64>,
    /// Radius under which optics `appearance` draws a few drops of real rain that stand for all, each as large as one of this
    /// radius: mean, variance and correlation of the picture stay, single drops do not. None is drawn under 0.354 of it.
    #[schemars(range(min = 0.001, max = 1), extend(
        "x-unit" = "px",
        "x-default" = "0.15 or, if that is less, where a streak changes no pixel by more than `error` (a grey level if there \
                       is none); no drop is thinned without streaks, with an exposure under 1/250 s, or if `far_rain` or \
                       `cutoff_px` is given"
    ))]
    pub thinned_px: Option<f64>,
    /// Radius under which optics `appearance` on tiles gives a drop two colours instead of a picture.
    #[schemars(range(min = 0.4, max = 1.5), extend(
        "x-unit" = "px",
        "x-default" = "0.7, 1 or 1.5: the first over which fewer than 2,000 drops are expected, else 1.5"
    ))]
    pub splat_px: Option<f32>,
    /// How drops are drawn that move while the shutter is open.
    #[schemars(extend("x-default" = "by the optics: `streak` for `appearance`, `sampled` for `closed-form`"))]
    pub motion: Option<Motion>,
    /// How drops out of focus are drawn.
    #[schemars(extend("x-default" = "by the optics: `disc` for `appearance`, `sampled` for `closed-form`"))]
    pub lens: Option<Lens>,
    /// In what shape drops are drawn that are no spheres.
    #[schemars(extend(
        "x-default" = "`equilibrium`; with optics `appearance` and an exposure of 1/250 s or longer `stretched`, unless \
                       the scene has `[film]` or a placed drop that is no sphere"
    ))]
    pub shape: Option<ShapeModel>,
    /// How a pane of glass and the drops on it are drawn.
    #[schemars(extend("x-default" = "`exact` for optics `closed-form`, else `picture`"))]
    pub pane: Option<PaneModel>,
}

impl ModelChoice {
    /// Takes another preset in place of its own. An accepted error and a budget are `auto`'s, and go with it.
    pub fn take_preset(&mut self, preset: Preset) {
        self.preset = preset;
        self.error = self.error.filter(|_| preset == Preset::Auto);
        self.budget_ms = self.budget_ms.filter(|_| preset == Preset::Auto);
    }

    pub(super) fn validate_far_rain(
        &self,
        rain: Option<&RealRain>,
    ) -> std::result::Result<(), String> {
        let Some(rain) = rain else {
            let given = [
                ("far_rain", self.far_rain.is_some()),
                ("cutoff_px", self.cutoff_px.is_some()),
                ("thinned_px", self.thinned_px.is_some()),
            ];
            return match given.iter().find(|(_, is_given)| *is_given) {
                Some((key, _)) => Err(format!("model: {key} is for real rain; give rain.rate")),
                None => Ok(()),
            };
        };
        let is_whole = matches!(self.far_rain, Some(FarRain::Drops | FarRain::None));
        if let (true, Some(_), Some(far)) = (is_whole, self.thinned_px, self.far_rain) {
            return Err(format!(
                "model: thinned_px leaves a part of the rain to the medium, and far_rain = \"{far}\" has none; \
                 leave one of them out"
            ));
        }
        if self.far_rain == Some(FarRain::Drops) && self.cutoff_px.is_some() {
            return Err("model: far_rain = \"drops\" draws every drop; leave out cutoff_px".into());
        }
        if self.far_rain == Some(FarRain::Drops) && rain.extent.is_infinite() {
            return Err(
                "model: far_rain = \"drops\" needs an end of the rain; give rain.extent".into()
            );
        }
        Ok(())
    }

    /// The keys of models that are given, not left to the preset.
    pub(crate) fn overrides(&self) -> Vec<String> {
        const OTHERS: [&str; 4] = ["preset", "error", "budget_ms", "mask_size"];
        // Names and numbers always have a form in TOML; what is not given has none.
        let given = toml::Table::try_from(self).unwrap_or_default();
        given.into_iter().map(|(key, _)| key).filter(|key| !OTHERS.contains(&&**key)).collect()
    }
}

impl Default for ModelChoice {
    fn default() -> Self {
        Self {
            preset: Preset::Auto,
            error: None,
            budget_ms: None,
            optics: None,
            primitive: None,
            order: None,
            simulation: None,
            mask_size: 1024,
            samples: None,
            internal_reflections: None,
            weights: None,
            fresnel: None,
            reflection: None,
            lookup: None,
            far_rain: None,
            cutoff_px: None,
            thinned_px: None,
            splat_px: None,
            motion: None,
            lens: None,
            shape: None,
            pane: None,
        }
    }
}
