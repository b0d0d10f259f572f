//! PNG and JPEG: display values, brought to linear Rec. 709 by what the file says of them.
//!
//! A PNG says it by cICP, else an ICC profile, else sRGB, else gAMA and cHRM; a JPEG by an ICC profile, else by the
//! Exif mark of Adobe RGB. A file that says nothing is sRGB. What a colour space beyond sRGB has out of Rec. 709's
//! reach stays, as negative values.

use std::io::Cursor;

use glam::{DMat3, DVec3, Vec3};
use image::{ImageDecoder, ImageFormat, ImageReader, Limits};
use moxcms::{ColorProfile, DataColorSpace, ProfileText, ToneReprCurve};

use super::color::{self, Primaries};
use super::open_exr::Check;
use super::{Decoded, broken, jpeg};
use crate::picture::linear_of_srgb;
use crate::remark::Remark;

/// Most bytes that a decoder of the `image` crate may take: the largest environment in float32 RGB (1.6 GB) and more.
const MAX_DECODER_BYTES: u64 = 2 << 30;

/// gAMA of sRGB's curve, as files that have it store it.
const SRGB_GAMMA: u32 = 45_455;

/// Luminance in cd/m² that is 1 in a picture of absolute values: diffuse white of ITU-R BT.2408.
const DIFFUSE_WHITE: f64 = 203.0;

/// From a display value, 0 to 1, to a linear one.
type Curve = Box<dyn Fn(f64) -> f64>;

/// What display values mean.
struct Meaning {
    /// For red, green and blue; one for all.
    curves: Vec<Curve>,
    /// From linear values to linear Rec. 709; none where they are that.
    matrix: Option<DMat3>,
    remark: Remark,
}

impl Meaning {
    fn srgb(remark: Remark) -> Self {
        Self { curves: vec![srgb()], matrix: None, remark }
    }

    /// The meaning of values by one curve and one set of primaries.
    fn of(curve: Curve, primaries: Primaries, name: &str) -> Result<Self, String> {
        let matrix = primaries.to_rec709()?;
        Ok(Self {
            curves: vec![curve],
            matrix,
            remark: Remark::detail(format!("its colours are {name}")),
        })
    }
}

fn srgb() -> Curve {
    Box::new(|value| f64::from(linear_of_srgb(value as f32)))
}

fn power(exponent: f64) -> Curve {
    Box::new(move |value| value.powf(exponent))
}

/// Decodes a PNG or JPEG, turned as its Exif data say.
pub(super) fn decode(
    bytes: &[u8],
    format: ImageFormat,
    check: Check<'_>,
) -> Result<Decoded, String> {
    let reader = |bytes| {
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = Limits::default();
        limits.max_alloc = Some(MAX_DECODER_BYTES);
        reader.limits(limits);
        reader.into_decoder().map_err(broken)
    };
    // A header is looked at first: the PNG decoder takes some memory for what it claims.
    if let (ImageFormat::Png, Some(size)) = (format, bytes.get(16..24)) {
        let edge = |at: usize| {
            size[at..at + 4].iter().fold(0, |edge, byte| edge << 8 | usize::from(*byte))
        };
        check(edge(0), edge(4))?;
    }
    let (width, height) = reader(bytes)?.dimensions();
    check(width as usize, height as usize)?;
    let (whole, rough) = match format {
        ImageFormat::Jpeg => jpeg::whole(bytes)?,
        _ => (bytes.into(), None),
    };
    let mut decoder = reader(&whole)?;
    let profile = decoder.icc_profile().map_err(broken)?;
    let exif = decoder.exif_metadata().map_err(broken)?;
    let meaning = match format {
        ImageFormat::Png => of_png(bytes, profile.as_deref())?,
        _ => of_jpeg(profile.as_deref(), exif.as_deref()),
    };
    // Cameras that were held upright store their pictures lying.
    let orientation = decoder.orientation().map_err(broken)?;
    let mut image = image::DynamicImage::from_decoder(decoder).map_err(broken)?;
    image.apply_orientation(orientation);
    let is_clear =
        image.color().has_alpha() && image.to_rgba16().pixels().any(|pixel| pixel.0[3] < u16::MAX);
    let image = image.into_rgb16();
    let tables: Vec<Vec<f32>> = meaning.curves.iter().map(table).collect();
    let linear = |channel: usize, value: u16| tables[channel % tables.len()][usize::from(value)];
    let pixels = image.pixels().map(|pixel| {
        Vec3::from_array(std::array::from_fn(|channel| linear(channel, pixel.0[channel])))
    });
    let (width, height) = (image.width() as usize, image.height() as usize);
    let mut remarks = vec![meaning.remark];
    remarks.extend(rough);
    if is_clear {
        remarks.push(Remark::note("its transparency is left out"));
    }
    let decoded = Decoded::radiance(width, height, pixels.collect());
    Ok(Decoded { is_display: true, remarks, matrix: meaning.matrix, ..decoded })
}

/// A curve at every value of 16 bits.
fn table(curve: &Curve) -> Vec<f32> {
    (0..=u16::MAX).map(|value| curve(f64::from(value) / f64::from(u16::MAX)) as f32).collect()
}

/// What a PNG says.
fn of_png(bytes: &[u8], profile: Option<&[u8]>) -> Result<Meaning, String> {
    let decoder = png::Decoder::new(Cursor::new(bytes));
    let reader = decoder.read_info().map_err(broken)?;
    let info = reader.info();
    if let Some(points) = info.coding_independent_code_points {
        return Ok(of_code_points(points.color_primaries, points.transfer_function));
    }
    if let Some(profile) = profile {
        return Ok(of_profile(profile));
    }
    if info.srgb.is_some() {
        return Ok(Meaning::srgb(Remark::detail("its colours are sRGB")));
    }
    let stated = info.chrm_chunk.map(|stated| {
        let each = [stated.red, stated.green, stated.blue, stated.white];
        let numbers = each.map(|(x, y)| [x, y].map(|part| f64::from(part.into_scaled()) / 1e5));
        Primaries::from_array(std::array::from_fn(|n| numbers[n / 2][n % 2]))
    });
    let primaries = stated.unwrap_or(color::REC709);
    let is_rec709 = primaries.to_rec709()?.is_none();
    match info.gama_chunk.map(png::ScaledFloat::into_scaled) {
        None if is_rec709 => Ok(Meaning::srgb(Remark::detail("its colours are taken for sRGB"))),
        None => Meaning::of(srgb(), primaries, "sRGB's curve with primaries of its own (cHRM)"),
        Some(gamma) if is_rec709 && gamma.abs_diff(SRGB_GAMMA) < 10 => {
            Ok(Meaning::srgb(Remark::detail("its colours are sRGB (gAMA)")))
        }
        Some(0) => Err(broken("its gAMA is 0")),
        Some(gamma) => {
            let exponent = 1e5 / f64::from(gamma);
            Meaning::of(power(exponent), primaries, &format!("of the power {exponent:.3} (gAMA)"))
        }
    }
}

/// What a JPEG says.
fn of_jpeg(profile: Option<&[u8]>, exif: Option<&[u8]>) -> Meaning {
    if let Some(profile) = profile {
        return of_profile(profile);
    }
    // Cameras store Adobe RGB without a profile: an interoperability index of R03 (DCF 2.0).
    let index = exif.and_then(|exif| {
        let read = exif::Reader::new().read_raw(exif.to_vec()).ok()?;
        let field = read.get_field(exif::Tag::InteroperabilityIndex, exif::In::PRIMARY)?;
        Some(field.display_value().to_string())
    });
    if index.is_some_and(|index| index.contains("R03")) {
        // Its power is 2 + 51/256.
        let adobe = Meaning::of(power(563.0 / 256.0), color::ADOBE_RGB, "Adobe RGB (Exif)");
        if let Ok(adobe) = adobe {
            return adobe;
        }
    }
    Meaning::srgb(Remark::detail("its colours are taken for sRGB"))
}

/// What an ICC profile says, if it is one of a matrix and curves; else sRGB, with a warning.
fn of_profile(bytes: &[u8]) -> Meaning {
    let not_applied = |name: &str, why: &str| {
        Meaning::srgb(Remark::warning(format!(
            "its ICC profile '{name}' is not applied: {why}; its colours are taken for sRGB"
        )))
    };
    let Ok(profile) = ColorProfile::new_from_slice(bytes) else {
        return not_applied("without a name", "it is broken");
    };
    let name = name_of(&profile);
    let curves = [&profile.red_trc, &profile.green_trc, &profile.blue_trc];
    let (curves, colorants): (Vec<_>, _) = match profile.color_space {
        DataColorSpace::Rgb => (curves.into_iter().flatten().collect(), colorants(&profile)),
        DataColorSpace::Gray => (profile.gray_trc.iter().collect(), None),
        other => {
            return not_applied(
                &name,
                &format!("its colours are {other:?}, and the picture is RGB here"),
            );
        }
    };
    let is_rgb = profile.color_space == DataColorSpace::Rgb;
    if curves.len() != if is_rgb { 3 } else { 1 } || is_rgb && colorants.is_none() {
        return not_applied(&name, "it is a table, not a matrix and curves");
    }
    let curves: Option<Vec<Curve>> = curves.into_iter().map(curve_of).collect();
    let Some(curves) = curves else { return not_applied(&name, "a curve of it is broken") };
    let matrix = match colorants.map(color::from_d50).transpose() {
        Ok(matrix) => matrix,
        Err(problem) => return not_applied(&name, &problem),
    };
    let remark = Remark::detail(format!("its ICC profile '{name}' is applied"));
    if is_srgb(&curves, matrix) {
        Meaning::srgb(remark)
    } else {
        Meaning { curves, matrix, remark }
    }
}

/// Whether a profile says sRGB, but for its rounding.
fn is_srgb(curves: &[Curve], matrix: Option<DMat3>) -> bool {
    let far = |value: f64| {
        let linear = srgb()(value);
        curves.iter().any(|curve| (curve(value) - linear).abs() > 5e-4)
    };
    let columns =
        matrix.unwrap_or_default().to_cols_array().into_iter().zip(DMat3::IDENTITY.to_cols_array());
    columns.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 2e-3
        && !(0..=255).any(|n| far(f64::from(n) / 255.0))
}

fn curve_of(curve: &ToneReprCurve) -> Option<Curve> {
    let evaluator = curve.make_linear_evaluator().ok()?;
    Some(Box::new(move |value| f64::from(evaluator.evaluate_value(value as f32))))
}

/// XYZ of the primaries, a column each; none where the profile has none.
fn colorants(profile: &ColorProfile) -> Option<DMat3> {
    let column = |c: moxcms::Xyzd| DVec3::new(c.x, c.y, c.z);
    let matrix = DMat3::from_cols(
        column(profile.red_colorant),
        column(profile.green_colorant),
        column(profile.blue_colorant),
    );
    (matrix.determinant().abs() > 1e-9).then_some(matrix)
}

fn name_of(profile: &ColorProfile) -> String {
    let name = match &profile.description {
        Some(ProfileText::PlainString(text)) => text.clone(),
        Some(ProfileText::Localizable(all)) => {
            all.first().map(|one| one.value.clone()).unwrap_or_default()
        }
        Some(ProfileText::Description(text)) => text.ascii_string.clone(),
        None => String::new(),
    };
    let name: String = name.chars().filter(|letter| !letter.is_control()).collect();
    if name.trim().is_empty() { "without a name".into() } else { name.trim().into() }
}

/// Code points of ITU-T H.273, as cICP has them.
fn of_code_points(primaries: u8, transfer: u8) -> Meaning {
    let space = match primaries {
        1 => Some(color::REC709),
        9 => Some(color::REC2020),
        10 => Some(color::XYZ),
        12 => Some(color::P3_D65),
        _ => None,
    };
    let curve: Option<Curve> = match transfer {
        1 | 6 | 14 | 15 => Some(Box::new(inverse_bt709)),
        4 => Some(power(2.2)),
        5 => Some(power(2.8)),
        8 => Some(power(1.0)),
        13 => Some(srgb()),
        16 => Some(Box::new(|value| pq(value) / DIFFUSE_WHITE)),
        18 => Some(Box::new(|value| inverse_hlg(value) / inverse_hlg(0.75))),
        _ => None,
    };
    let name = format!("cICP {primaries}, {transfer}");
    let meaning = space.zip(curve).and_then(|(space, curve)| Meaning::of(curve, space, &name).ok());
    meaning.unwrap_or_else(|| {
        Meaning::srgb(Remark::warning(format!(
            "its colours ({name} of H.273) are not known here; they are taken for sRGB"
        )))
    })
}

/// ITU-R BT.709: light of a camera's signal.
fn inverse_bt709(value: f64) -> f64 {
    if value < 0.081 { value / 4.5 } else { ((value + 0.099) / 1.099).powf(1.0 / 0.45) }
}

/// SMPTE ST 2084: luminance in cd/m².
fn pq(value: f64) -> f64 {
    let (m1, m2) = (2610.0 / 16_384.0, 2523.0 / 4096.0 * 128.0);
    let (c1, c2, c3) = (3424.0 / 4096.0, 2413.0 / 4096.0 * 32.0, 2392.0 / 4096.0 * 32.0);
    let root = value.powf(1.0 / m2);
    10_000.0 * ((root - c1).max(0.0) / (c2 - c3 * root)).powf(1.0 / m1)
}

/// ITU-R BT.2100, HLG: light of the scene, 0 to 1. A signal of 3/4 is diffuse white (BT.2408).
fn inverse_hlg(value: f64) -> f64 {
    let (a, b, c) = (0.178_832_77, 0.284_668_92, 0.559_910_73);
    if value <= 0.5 { value * value / 3.0 } else { (((value - c) / a).exp() + b) / 12.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values that the standards state: PQ has 203 cd/m² at 58.1 %, HLG 3/12 of the light at half of the signal.
    #[test]
    fn transfer_curves_are_those_of_the_standards() {
        assert!((pq(0.5807) - 203.0).abs() < 0.3, "{}", pq(0.5807));
        assert!((pq(1.0) - 10_000.0).abs() < 1e-6);
        assert!((inverse_hlg(0.5) - 1.0 / 12.0).abs() < 1e-9);
        assert!((inverse_hlg(1.0) - 1.0).abs() < 1e-6, "{}", inverse_hlg(1.0));
        // 4.5 L at the foot, and its knee at L = 0.018.
        assert!((inverse_bt709(0.081) - 0.018).abs() < 1e-4);
        assert!((inverse_bt709(1.0) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn unknown_code_points_are_a_warning() {
        let meaning = of_code_points(22, 17);
        assert_eq!(meaning.remark.severity, crate::remark::Severity::Warning);
        assert!(meaning.remark.text.contains("cICP 22, 17"));
        // 709 and sRGB are known, and need no matrix.
        let meaning = of_code_points(1, 13);
        assert!(
            meaning.matrix.is_none() && meaning.remark.severity < crate::remark::Severity::Note
        );
    }

    #[test]
    fn a_profile_that_is_not_one_is_a_warning_with_its_name() {
        let meaning = of_profile(b"no profile");
        assert!(meaning.remark.text.contains("'without a name' is not applied: it is broken"));
        let mut table = ColorProfile::new_display_p3();
        table.red_trc = None;
        let bytes = table.encode().expect("bytes");
        let said = of_profile(&bytes).remark.text;
        assert!(said.contains("Display P3") && said.contains("it is a table"), "{said}");
        // sRGB's own is no change at all.
        let srgb = ColorProfile::new_srgb().encode().expect("bytes");
        let meaning = of_profile(&srgb);
        assert!(meaning.matrix.is_none() && meaning.curves.len() == 1, "{}", meaning.remark);
    }
}
