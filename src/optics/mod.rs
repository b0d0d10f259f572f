//! One drop in float64: the physics, told once.
//!
//! - `interface.rs`: what a flat piece of the surface does to a ray.
//! - `sphere.rs`: a sphere of water, or a bubble in water, in closed form.
//! - `spheroid.rs`: drops that the air flattens, traced from surface to surface.
//! - `cap.rs`: a drop on a pane.
//! - `mask.rs`: the geometry of the paper's mask.

mod cap;
mod interface;
mod mask;
mod sphere;
mod spheroid;

pub use cap::{Cap, FirstExit};
pub use interface::{Interface, fresnel, schlick};
pub use mask::{level_distance, level_half_angle, mask_intersection};
pub use sphere::Intersection;
pub use spheroid::{Exit, Shape, Walk, semi_axes};

/// Refractive index of water at 589 nm over that of air, as the paper has it.
pub const WATER: f64 = 1.33;

/// Refractive indices of water over air at 20 °C at the dominant wavelengths of the sRGB primaries
/// (611, 549 and 464 nm): IAPWS R9-97 over Ciddor's air.
pub const WATER_RGB: [f64; 3] = [1.332_33, 1.334_35, 1.338_35];
