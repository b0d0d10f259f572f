//! The shape of a falling drop by its size: the axis ratio, the equilibrium shape, and its fit by two half
//! spheroids. A drop is a figure of revolution about the vertical; its top is round, its base is flat.
//!
//! Diameters are those of the sphere of equal volume, in millimetres. Lengths are over the radius of that
//! sphere. Heights count upwards from the origin of the equilibrium series, which is within 0.015 radii of
//! the centre of mass. Above [`LARGEST`] the shape stays that of [`LARGEST`]: the sources end there.

/// The largest diameter for which the shape is known, mm.
pub const LARGEST: f64 = 6.0;

/// Under this diameter the equilibrium shape is a sphere, mm: its radius is within 0.003 of one.
pub const SMALLEST_FLATTENED: f64 = 1.0;

/// Height over width of a drop: Beard and Chuang 1987. The polynomial exceeds 1 below 0.453 mm, where a
/// drop is a sphere.
pub fn axis_ratio(diameter: f64) -> f64 {
    let d = diameter.clamp(0.0, LARGEST);
    (1.0048 + d * (5.7e-4 + d * (-2.628e-2 + d * (3.682e-3 - d * 1.677e-4)))).min(1.0)
}

/// Radius of the equilibrium shape at `angle` radians from the upward vertical: Chuang and Beard 1990,
/// r(θ) = 1 + Σ c_n cos nθ.
pub fn equilibrium_radius(diameter: f64, angle: f64) -> f64 {
    if diameter < SMALLEST_FLATTENED {
        return 1.0;
    }
    let coefficients = between(&SERIES, diameter);
    let sum: f64 =
        coefficients.iter().zip(0..).map(|(c, n)| c * (f64::from(n) * angle).cos()).sum();
    1.0 + 1e-4 * sum
}

/// Two half spheroids of one width that stand for the equilibrium shape: within 0.0073 of its radius, and
/// within 0.5 % of its volume. The surface is smooth at the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Halves {
    /// Height of the plane that parts the halves.
    pub joint: f64,
    /// Half the width of both.
    pub equatorial: f64,
    /// Height of the upper half over the joint.
    pub top: f64,
    /// Depth of the lower half under the joint.
    pub bottom: f64,
}

impl Halves {
    /// The fit for a diameter; a sphere below [`SMALLEST_FLATTENED`].
    pub fn of_diameter(diameter: f64) -> Self {
        let [joint, equatorial, top, bottom] = if diameter < SMALLEST_FLATTENED {
            [0.0, 1.0, 1.0, 1.0]
        } else {
            between(&HALVES, diameter)
        };
        Self { joint, equatorial, top, bottom }
    }

    /// Area of the outline over that of the sphere, seen along a direction whose sine of elevation is given.
    ///
    /// Each half's outline is half an ellipse: the surface is vertical at the joint all around.
    pub fn outline_area(&self, sine: f64) -> f64 {
        let cosine = (1.0 - sine * sine).max(0.0).sqrt();
        let height = |half: f64| (half * cosine).hypot(self.equatorial * sine);
        0.5 * self.equatorial * (height(self.top) + height(self.bottom))
    }

    /// Radius of a sphere about the centre that holds it.
    pub fn reach(&self) -> f64 {
        self.equatorial.max(self.top).max(self.bottom) + self.joint.abs()
    }

    /// Volume over that of the sphere.
    pub fn volume(&self) -> f64 {
        0.5 * self.equatorial * self.equatorial * (self.top + self.bottom)
    }
}

/// A row of a table, linear in the diameter between rows, constant outside of them.
fn between<const N: usize>(table: &[(f64, [f64; N])], diameter: f64) -> [f64; N] {
    let next = table.partition_point(|(row, _)| *row <= diameter).clamp(1, table.len() - 1);
    let ((from, low), (to, high)) = (table[next - 1], table[next]);
    let share = ((diameter - from) / (to - from)).clamp(0.0, 1.0);
    std::array::from_fn(|i| low[i] + share * (high[i] - low[i]))
}

/// Diameter in mm; c_0 … c_10 of the equilibrium series in 10⁻⁴.
#[rustfmt::skip]
const SERIES: [(f64, [f64; 11]); 11] = [
    (1.0, [-28.0, 30.0, -83.0, 22.0, -3.0, -2.0, 1.0, 0.0, 0.0, 0.0, 0.0]),
    (1.5, [-72.0, 70.0, -210.0, 57.0, -6.0, -7.0, 3.0, 0.0, -1.0, 0.0, 1.0]),
    (2.0, [-134.0, 118.0, -385.0, 100.0, -5.0, -17.0, 6.0, 1.0, -3.0, 1.0, 1.0]),
    (2.5, [-211.0, 180.0, -592.0, 147.0, 4.0, -32.0, 10.0, 3.0, -5.0, 1.0, 2.0]),
    (3.0, [-297.0, 247.0, -816.0, 188.0, 24.0, -52.0, 13.0, 8.0, -8.0, 1.0, 4.0]),
    (3.5, [-388.0, 309.0, -1042.0, 221.0, 53.0, -75.0, 15.0, 15.0, -12.0, 0.0, 7.0]),
    (4.0, [-481.0, 359.0, -1263.0, 244.0, 91.0, -99.0, 15.0, 25.0, -16.0, -2.0, 10.0]),
    (4.5, [-573.0, 401.0, -1474.0, 255.0, 137.0, -121.0, 11.0, 36.0, -19.0, -6.0, 13.0]),
    (5.0, [-665.0, 435.0, -1674.0, 258.0, 187.0, -141.0, 4.0, 48.0, -21.0, -11.0, 17.0]),
    (5.5, [-755.0, 465.0, -1863.0, 251.0, 242.0, -157.0, -7.0, 61.0, -21.0, -17.0, 21.0]),
    (6.0, [-843.0, 472.0, -2040.0, 240.0, 299.0, -168.0, -21.0, 73.0, -20.0, -25.0, 24.0]),
];

/// Diameter in mm; joint, half width, height of the top, depth of the bottom of the two half spheroids
/// that err least from the series in the radius.
const HALVES: [(f64, [f64; 4]); 9] = [
    (1.0, [-0.0085, 1.0053, 1.0026, 0.9756]),
    (1.5, [-0.0228, 1.0135, 1.0073, 0.9379]),
    (2.0, [-0.0415, 1.0252, 1.0117, 0.8883]),
    (2.5, [-0.0620, 1.0392, 1.0154, 0.8319]),
    (3.0, [-0.0805, 1.0552, 1.0150, 0.7759]),
    (3.5, [-0.0970, 1.0719, 1.0111, 0.7235]),
    (4.0, [-0.1110, 1.0890, 1.0035, 0.6765]),
    (5.0, [-0.1275, 1.1231, 0.9760, 0.6029]),
    (6.0, [-0.1319, 1.1564, 0.9367, 0.5524]),
];
