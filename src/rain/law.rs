//! How many drops of which size: N(D) = N0 D^μ exp(-ΛD) between two cut-offs, in drops per m³ and mm.
//!
//! In every law the rate that falls is the rate that was asked.
//!
//! - Marshall and Palmer (1948) have μ = 0 and Λ = 4.1 R^-0.21 per mm for a rain rate R in mm/h. With its own
//!   N0 = 8000 their law rains 3 to 18 % more than its label. So N0 follows from the rate; the shape of the law, and with
//!   it the median-volume diameter, is kept.
//! - A gamma law (Ulbrich 1983) has the N0 that Ulbrich found for its μ, and Λ follows from the rate. Or its
//!   median-volume diameter D0 is given: then Λ = (3.67 + μ) / D0, and N0 follows from the rate.
//! - A uniform law has neither μ nor Λ.
//!
//! All moments ∫ N D^k dD are incomplete gamma functions; nothing is integrated numerically.

use std::f64::consts::PI;

use statrs::function::gamma::{gamma_lr, gamma_ur, ln_gamma};

use crate::rain::fall;

/// A law of sizes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// N0 in m⁻³ mm^-(1+μ).
    pub intercept: f64,
    /// μ, over -1.
    pub mu: f64,
    /// Λ in mm⁻¹; 0 for a power law.
    pub slope: f64,
    /// Least diameter, mm.
    pub from: f64,
    /// Largest diameter, mm.
    pub to: f64,
}

/// Λ of Marshall and Palmer in mm⁻¹ for a rate in mm/h.
pub fn marshall_palmer_slope(rate: f64) -> f64 {
    4.1 * rate.powf(-0.21)
}

/// N0 in m⁻³ mm^-(1+μ) that goes with μ in measured rain (Ulbrich 1983).
pub fn ulbrich_intercept(mu: f64) -> f64 {
    6e4 * (3.2 * mu).exp() * 10_f64.powf(-(mu + 1.0))
}

/// Λ in mm⁻¹ of a gamma law whose median-volume diameter, without cut-offs, is `diameter` mm.
pub fn slope_of_median(mu: f64, diameter: f64) -> f64 {
    (3.67 + mu) / diameter
}

/// Λ times the largest diameter under which moments are sums of a few powers. Their closed form is a product of a large
/// number and a small one, which leave float64's range where Λ is nearly 0.
const NEARLY_FLAT: f64 = 0.01;

/// Steps of a search, far more than any takes.
const MOST_STEPS: u32 = 200;

impl Law {
    /// This law with the least Λ with which no more than `rate` mm/h fall in air of `air_density` kg/m³. Λ is 0 if no Λ over 0
    /// rains as much: see [`Law::most_rate`].
    pub fn with_slope_of_rate(self, rate: f64, air_density: f64) -> Self {
        let with = |slope| Self { slope, ..self };
        let (mut low, mut high) = (0.0, 1.0);
        while with(high).rate(air_density) > rate {
            (low, high) = (high, 2.0 * high);
        }
        // The logarithm of the rate is convex over Λ, so that Newton's steps from below do not pass the root; halvings
        // where one leads out of what is left.
        let mut slope = 0.5 * (low + high);
        for _ in 0..MOST_STEPS {
            let law = with(slope);
            let over = (law.rate(air_density) / rate).ln();
            if over > 0.0 {
                low = slope
            } else {
                high = slope
            }
            let newton =
                slope + over * law.flux(3.0, law.from, law.to) / law.flux(4.0, law.from, law.to);
            let next = if low < newton && newton < high { newton } else { 0.5 * (low + high) };
            // What matters is Λ D.
            let is_found = (next - slope).abs() <= 2.0 * f64::EPSILON * (slope + self.to.recip());
            slope = next;
            if is_found {
                break;
            }
        }
        with(slope)
    }

    /// The largest rate in mm/h that the law's N0 and μ allow: that with Λ = 0.
    pub fn most_rate(self, air_density: f64) -> f64 {
        Self { slope: 0.0, ..self }.rate(air_density)
    }

    /// This law with as many drops as make `rate` mm/h fall in air of `air_density` kg/m³.
    pub fn normalised(self, rate: f64, air_density: f64) -> Self {
        let unit = Self { intercept: 1.0, ..self };
        Self { intercept: rate / unit.rate(air_density), ..self }
    }

    /// ∫ N D^k dD over the diameters from `from` to `to` within the cut-offs, in mm^k m⁻³. k > -1 - μ.
    pub fn moment_between(&self, k: f64, from: f64, to: f64) -> f64 {
        let (from, to) = (from.max(self.from), to.min(self.to));
        if from >= to {
            return 0.0;
        }
        self.moment_from(k, from)(to)
    }

    /// [`Law::moment_between`] of diameters from `from` on to any, both within the cut-offs.
    fn moment_from(&self, k: f64, from: f64) -> impl Fn(f64) -> f64 {
        let s = k + self.mu + 1.0;
        let a = self.slope * from;
        // The incomplete function that is small here is taken: its difference cancels least.
        let takes_upper = a > s;
        let first = match takes_upper {
            true => gamma_ur(s, a),
            false if a > 0.0 => gamma_lr(s, a),
            false => 0.0,
        };
        let all = self.intercept * (ln_gamma(s) - s * self.slope.ln()).exp();
        move |to| {
            let b = self.slope * to;
            if b < NEARLY_FLAT {
                return self.intercept * self.nearly_flat(s, from, to);
            }
            all * if takes_upper { first - gamma_ur(s, b) } else { gamma_lr(s, b) - first }
        }
    }

    /// ∫ D^(s-1) exp(-ΛD) dD where ΛD is small: the exponential as a sum of powers.
    fn nearly_flat(&self, s: f64, from: f64, to: f64) -> f64 {
        let (mut sum, mut factor) = (0.0, 1.0);
        for n in 0..MOST_STEPS {
            let power = s + f64::from(n);
            let term = factor * (to.powf(power) - from.powf(power)) / power;
            sum += term;
            if term.abs() <= f64::EPSILON * sum.abs() {
                break;
            }
            factor *= -self.slope / f64::from(n + 1);
        }
        sum
    }

    /// ∫ N D^k dD between the cut-offs.
    pub fn moment(&self, k: f64) -> f64 {
        self.moment_between(k, self.from, self.to)
    }

    /// Drops a cubic metre.
    pub fn number(&self) -> f64 {
        self.moment(0.0)
    }

    /// Mean diameter, mm.
    pub fn mean_diameter(&self) -> f64 {
        self.moment(1.0) / self.number()
    }

    /// The diameter in mm under which half of the water is.
    pub fn median_volume_diameter(&self) -> f64 {
        self.quantile(3.0, 0.5)
    }

    /// Water in g/m³.
    pub fn water(&self) -> f64 {
        PI / 6.0 * 1e-3 * self.moment(3.0)
    }

    /// Share of light that a metre of the rain takes out of a ray: the drops' outlines, without the half that
    /// diffraction puts into a lobe narrower than a pixel.
    pub fn extinction(&self) -> f64 {
        extinction(self.moment(2.0))
    }

    /// Rain that falls through a level plane in still air, mm/h.
    pub fn rate(&self, air_density: f64) -> f64 {
        6.0 * PI * 1e-4 * self.water_flux(self.from, self.to) * fall::density_factor(air_density)
    }

    /// ∫ N D³ v dD over some diameters in the speed table's air, mm³ m⁻³ m/s.
    pub fn water_flux(&self, from: f64, to: f64) -> f64 {
        self.flux(3.0, from, to)
    }

    /// ∫ N D^k v dD over some diameters in the speed table's air.
    fn flux(&self, k: f64, from: f64, to: f64) -> f64 {
        let (from, to) = (from.max(self.from), to.min(self.to));
        fall::pieces(from, to)
            .map(|piece| {
                piece.at_zero * self.moment_between(k, piece.from, piece.to)
                    + piece.slope * self.moment_between(k + 1.0, piece.from, piece.to)
            })
            .sum()
    }

    /// The diameter in mm under which the share `u` of ∫ N D^k dD is. k = 0: a drop's diameter for a uniform
    /// random number.
    pub fn quantile(&self, k: f64, u: f64) -> f64 {
        self.quantile_between(k, u, self.from, self.to)
    }

    /// The quantile among the drops between two diameters alone.
    pub fn quantile_between(&self, k: f64, u: f64, from: f64, to: f64) -> f64 {
        let moment = self.moment_from(k, from);
        let wanted = u * moment(to);
        let (mut low, mut high) = (from, to);
        let mut diameter = from + u * (to - from);
        // Newton's steps, and halvings where one leads out of what is left. They end within rounding: after so small a step of
        // Newton's what is left is its square.
        loop {
            let over = moment(diameter) - wanted;
            if over < 0.0 {
                low = diameter
            } else {
                high = diameter
            }
            let newton = diameter - over / self.density(k, diameter);
            let (next, least) = match low < newton && newton < high {
                true => (newton, 1e-9),
                false => (0.5 * (low + high), 2.0 * f64::EPSILON),
            };
            if (next - diameter).abs() <= least * diameter {
                return next;
            }
            diameter = next;
        }
    }

    /// N D^k, in mm^k m⁻³ mm⁻¹.
    fn density(&self, k: f64, diameter: f64) -> f64 {
        self.intercept * diameter.powf(k + self.mu) * (-self.slope * diameter).exp()
    }
}

/// Extinction a metre of drops with ∫ N D² dD of `m2` mm² m⁻³.
pub fn extinction(m2: f64) -> f64 {
    0.25 * PI * 1e-6 * m2
}
