//! From the colours of a file to linear Rec. 709: primaries, a white point, and the curve of display values.
//!
//! A white point that is not D65 is adapted by Bradford's cones (as ICC does it), so that a file's white is the program's.

use glam::{DMat3, DVec2, DVec3, Vec3};

/// Chromaticities (CIE 1931 x, y) of three primaries and of their white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Primaries {
    pub red: DVec2,
    pub green: DVec2,
    pub blue: DVec2,
    pub white: DVec2,
}

const D65: DVec2 = DVec2::new(0.3127, 0.3290);
const D60: DVec2 = DVec2::new(0.321_68, 0.337_67);

/// White of the profile connection space of ICC, as XYZ.
const D50_XYZ: DVec3 = DVec3::new(0.9642, 1.0, 0.8249);

/// Chromaticities that differ by less are the same: files round them to three or four digits.
const SAME: f64 = 6e-4;

const fn primaries(red: [f64; 2], green: [f64; 2], blue: [f64; 2], white: DVec2) -> Primaries {
    Primaries {
        red: DVec2::from_array(red),
        green: DVec2::from_array(green),
        blue: DVec2::from_array(blue),
        white,
    }
}

pub(super) const REC709: Primaries = primaries([0.64, 0.33], [0.30, 0.60], [0.15, 0.06], D65);
pub(super) const ADOBE_RGB: Primaries = primaries([0.64, 0.33], [0.21, 0.71], [0.15, 0.06], D65);
pub(super) const P3_D65: Primaries = primaries([0.68, 0.32], [0.265, 0.69], [0.15, 0.06], D65);
pub(super) const REC2020: Primaries = primaries([0.708, 0.292], [0.17, 0.797], [0.131, 0.046], D65);
pub(super) const ACES_AP0: Primaries =
    primaries([0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], D60);
pub(super) const ACES_AP1: Primaries =
    primaries([0.713, 0.293], [0.165, 0.83], [0.128, 0.044], D60);
/// The tristimulus values themselves.
pub(super) const XYZ: Primaries =
    primaries([1.0, 0.0], [0.0, 1.0], [0.0, 0.0], DVec2::new(1.0 / 3.0, 1.0 / 3.0));

impl Primaries {
    /// From eight numbers in the usual order.
    pub fn from_array([rx, ry, gx, gy, bx, by, wx, wy]: [f64; 8]) -> Self {
        primaries([rx, ry], [gx, gy], [bx, by], DVec2::new(wx, wy))
    }

    fn is(&self, other: &Self) -> bool {
        let pairs = [
            (self.red, other.red),
            (self.green, other.green),
            (self.blue, other.blue),
            (self.white, other.white),
        ];
        pairs.iter().all(|(a, b)| (*a - *b).abs().max_element() < SAME)
    }

    /// The matrix from linear values of these primaries to linear Rec. 709; none if they are those of Rec. 709.
    ///
    /// # Errors
    /// The primaries span no colours.
    pub fn to_rec709(self) -> Result<Option<DMat3>, String> {
        if self.is(&REC709) {
            return Ok(None);
        }
        // Tristimulus values are what they are, whatever white goes with them.
        if self.is(&XYZ) {
            return Ok(Some(REC709.to_xyz()?.inverse()));
        }
        let adapted = adaptation(xyz_of(self.white), xyz_of(D65));
        let matrix = REC709.to_xyz()?.inverse() * adapted * self.to_xyz()?;
        if matrix.is_finite() { Ok(Some(matrix)) } else { Err(self.no_colors()) }
    }

    /// The matrix to XYZ by which (1, 1, 1) is the white of luminance 1.
    fn to_xyz(self) -> Result<DMat3, String> {
        let [red, green, blue] = [self.red, self.green, self.blue]
            .map(|place| DVec3::new(place.x, place.y, 1.0 - place.x - place.y));
        let matrix = DMat3::from_cols(red, green, blue);
        if matrix.determinant().abs() < 1e-9 || self.white.y.abs() < 1e-9 || !matrix.is_finite() {
            return Err(self.no_colors());
        }
        let amounts = matrix.inverse() * xyz_of(self.white);
        Ok(matrix * DMat3::from_diagonal(amounts))
    }

    fn no_colors(&self) -> String {
        let Self { red, green, blue, white } = self;
        format!(
            "has primaries that span no colours: red {red}, green {green}, blue {blue}, white {white}"
        )
    }
}

/// XYZ of a chromaticity, luminance 1.
fn xyz_of(place: DVec2) -> DVec3 {
    DVec3::new(place.x / place.y, 1.0, (1.0 - place.x - place.y) / place.y)
}

/// Bradford's adaptation of XYZ from one white to another.
fn adaptation(from: DVec3, to: DVec3) -> DMat3 {
    let cones = DMat3::from_cols(
        DVec3::new(0.8951, -0.7502, 0.0389),
        DVec3::new(0.2664, 1.7135, -0.0685),
        DVec3::new(-0.1614, 0.0367, 1.0296),
    );
    cones.inverse() * DMat3::from_diagonal((cones * to) / (cones * from)) * cones
}

/// The matrix to linear Rec. 709 from colorants of an ICC profile: XYZ adapted to D50, a column each.
pub(super) fn from_d50(colorants: DMat3) -> Result<DMat3, String> {
    Ok(REC709.to_xyz()?.inverse() * adaptation(D50_XYZ, xyz_of(D65)) * colorants)
}

/// Applies a matrix to every pixel, in float64.
pub(super) fn convert(pixels: &mut [Vec3], matrix: DMat3) {
    for pixel in pixels {
        *pixel = (matrix * pixel.as_dvec3()).as_vec3();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Matrices as published: BT.2087 (Rec. 2020), ACES' own with D60 adapted by CAT02 or Bradford to 4 digits (Bradford).
    #[test]
    fn matrices_are_those_of_the_standards() {
        let rec2020 =
            [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
        let ap1 =
            [[1.7050, -0.6218, -0.0833], [-0.1302, 1.1408, -0.0106], [-0.0240, -0.1290, 1.1529]];
        for (primaries, rows) in [(REC2020, rec2020), (ACES_AP1, ap1)] {
            let matrix = primaries.to_rec709().expect("colours").expect("another space");
            for (row, expected) in rows.iter().enumerate() {
                let off = matrix.row(row) - DVec3::from_array(*expected);
                assert!(off.abs().max_element() < 3e-4, "{primaries:?} row {row}: off by {off}");
            }
        }
    }

    #[test]
    fn white_stays_white_and_rec_709_stays_itself() {
        assert_eq!(REC709.to_rec709(), Ok(None));
        for primaries in [ADOBE_RGB, P3_D65, REC2020, ACES_AP0, ACES_AP1] {
            let matrix = primaries.to_rec709().expect("colours").expect("another space");
            let white = matrix * DVec3::ONE;
            assert!((white - DVec3::ONE).abs().max_element() < 1e-9, "{primaries:?}: {white}");
        }
        let flat = Primaries { blue: REC709.green, ..REC709 };
        assert!(flat.to_rec709().is_err());
    }
}
