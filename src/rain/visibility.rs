//! How far single drops can be seen: their size and streak in pixels, how many are larger than a cut-off in
//! pixels, and how much a pixel flickers by those that are smaller.
//!
//! `focal_px` is the distance of the image plane in pixels ([`crate::scene::camera::View::focal_px`]).
//! Lengths are in metres, diameters in millimetres, times in seconds. A drop's depth is measured along the
//! view axis.

use std::f64::consts::PI;

use crate::rain::fall;
use crate::rain::law::Law;
use crate::scene::projection::View;

/// A drop's radius in pixels.
pub fn radius_px(focal_px: f64, diameter: f64, depth: f64) -> f64 {
    focal_px * 1e-3 * diameter / (2.0 * depth)
}

/// Depth at which a drop's radius is `radius_px`.
pub fn depth_of_radius(focal_px: f64, diameter: f64, radius_px: f64) -> f64 {
    focal_px * 1e-3 * diameter / (2.0 * radius_px)
}

/// Length of a drop's streak in pixels, moving at `speed` across the line of sight.
pub fn streak_px(focal_px: f64, speed: f64, shutter: f64, depth: f64) -> f64 {
    focal_px * speed * shutter / depth
}

/// What a picture shows of the rain: the frustum of its pixels, and where the rain ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// Distance of the image plane in pixels.
    pub focal_px: f64,
    /// Pixels across.
    pub width: f64,
    /// Pixels down.
    pub height: f64,
    /// Distance from the camera to the rain's end; may be infinite.
    pub extent: f64,
}

impl Frustum {
    /// The frustum of the whole picture, of which a view may be a part.
    pub fn of(view: &View, extent: f64) -> Self {
        let [width, height] = view.whole.map(f64::from);
        Self { focal_px: view.focal_px, width, height, extent }
    }
}

/// Points along each edge of the picture at which the rain's end is taken. It is a sphere around the camera,
/// a frustum ends in a plane: the midpoint rule errs by 10⁻⁴ of the count where both matter.
const POINTS: u32 = 64;

impl Frustum {
    /// Number of drops in view whose radius is over `radius_px` pixels.
    ///
    /// Without an end of the rain it is κ (f/2ρ)³ M3 with κ = W H / 3f²: the inverse cube of the radius.
    pub fn drops_above(&self, law: &Law, radius_px: f64) -> f64 {
        let cone = self.width * self.height / (3.0 * self.focal_px * self.focal_px);
        let near = |end: f64| {
            // Drops over this diameter are above the radius as far as the rain goes.
            let all = 2e3 * radius_px * end / self.focal_px;
            let deep = match law.moment_between(3.0, law.from, all) {
                // The depth of a drop without radius is infinite.
                0.0 => 0.0,
                m3 => depth_of_radius(self.focal_px, 1.0, radius_px).powi(3) * m3,
            };
            let far = law.moment_between(0.0, all, law.to);
            cone * (deep + if far > 0.0 { end.powi(3) * far } else { 0.0 })
        };
        let reach = depth_of_radius(self.focal_px, law.to, radius_px);
        let corner = (0.5 * self.width).hypot(0.5 * self.height) / self.focal_px;
        if self.extent >= reach * corner.hypot(1.0) {
            return near(f64::INFINITY);
        }
        let offset = |point: u32, edge: f64| {
            ((f64::from(point) + 0.5) / f64::from(POINTS) - 0.5) * edge / self.focal_px
        };
        let points = (0..POINTS * POINTS).map(|point| {
            let (x, y) = (offset(point % POINTS, self.width), offset(point / POINTS, self.height));
            near(self.extent / (1.0 + x * x + y * y).sqrt())
        });
        points.sum::<f64>() / f64::from(POINTS * POINTS)
    }

    /// Standard deviation of a pixel's opacity on the axis by the drops under `radius_px` pixels (up to 1),
    /// taken as Poisson. `shutter` 0: an instant.
    ///
    /// A drop at depth z adds (π r²)² g(ℓ) (1 - √π r/3)² to the variance: g for its streak over the pixels,
    /// the last factor for its own width and height. A streak of more than a pixel hides the height. The light
    /// behind all rain carries the contrast, hence e^-τ.
    pub fn noise(&self, law: &Law, air_density: f64, radius_px: f64, shutter: f64) -> f64 {
        let nearest = |diameter| depth_of_radius(self.focal_px, diameter, radius_px);
        self.noise_beyond(law, air_density, nearest, shutter)
    }

    /// [`Frustum::noise`] by the drops that are farther than a depth, which may depend on their diameter.
    pub fn noise_beyond(
        &self,
        law: &Law,
        air_density: f64,
        nearest: impl Fn(f64) -> f64,
        shutter: f64,
    ) -> f64 {
        let factor = fall::density_factor(air_density);
        let end = self.extent.recip();
        let of_diameter = |diameter: f64| {
            let speed = factor * fall::terminal_speed(diameter, fall::TABLE_AIR_DENSITY);
            let start = nearest(diameter).recip();
            if start <= end {
                return 0.0;
            }
            // Over the inverse depth the integrand is smooth but where the streak is one pixel long.
            let kink = (self.focal_px * speed * shutter).recip().clamp(end, start);
            let at = |inverse: f64| {
                let radius = radius_px(self.focal_px, diameter, 1.0) * inverse;
                let streak = self.focal_px * speed * shutter * inverse;
                let size = PI.sqrt() * radius / 3.0;
                variance_share(size, streak)
            };
            diameter.powi(4) * (simpson(at, end, kink) + simpson(at, kink, start))
        };
        // Over equal shares of the fourth moment, so that no size is missed.
        let m4 = law.moment(4.0);
        let shares = 256;
        let sum: f64 = (0..shares)
            .map(|i| law.quantile(4.0, (f64::from(i) + 0.5) / f64::from(shares)))
            .map(|diameter| of_diameter(diameter) / diameter.powi(4))
            .sum();
        let mean = sum / f64::from(shares);
        let variance = PI * PI / 16.0 * self.focal_px.powi(2) * 1e-12 * m4 * mean;
        variance.sqrt() * (-law.extinction() * self.extent).exp()
    }
}

/// Share of (π r²)² by which a drop adds to a pixel's variance: `size` is √π r/3. A streak of more than a pixel
/// hides the height.
pub(super) fn variance_share(size: f64, streak_px: f64) -> f64 {
    streak_share(streak_px) * (1.0 - size) * (1.0 - size / streak_px.max(1.0))
}

/// g(ℓ): what is left of a sub-pixel drop's variance when a streak of ℓ pixels spreads it.
pub fn streak_share(streak_px: f64) -> f64 {
    if streak_px <= 1.0 {
        1.0 - streak_px / 3.0
    } else {
        streak_px.recip() - 1.0 / (3.0 * streak_px * streak_px)
    }
}

/// ∫ f dx by Simpson's rule over 16 intervals; f is smooth here.
fn simpson(f: impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let intervals = 16;
    let step = (to - from) / f64::from(intervals);
    let weight = |i| if i == 0 || i == intervals { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
    let sum: f64 = (0..=intervals).map(|i| weight(i) * f(from + f64::from(i) * step)).sum();
    sum * step / 3.0
}
