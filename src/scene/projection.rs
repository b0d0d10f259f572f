//! Between directions and pixels, the principal point included, as in `glsl/include/projection.glsl`.

use glam::{DMat3, DVec2, DVec3};

/// By how many pixels drops that are drawn may lie beyond an edge of the window within the whole picture: they are
/// entered by tiles of 4 x 2 pixels, one more around those of the window, and their smoothed edge reaches half a pixel
/// beyond their outline.
const MARGIN: f64 = 12.0;

/// A camera and the part of a picture that is drawn, resolved: an orthonormal frame, the scale of the image plane, and
/// where the view axis meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the eye is, in scene units.
    pub position: DVec3,
    /// Unit vector to the right of the picture.
    pub right: DVec3,
    /// Unit vector to the top of the picture.
    pub up: DVec3,
    /// Unit vector towards the viewer, against the view direction.
    pub back: DVec3,
    /// Width and height of the whole picture in pixels.
    pub whole: [u32; 2],
    /// Column and row in the whole picture of the first pixel that is drawn.
    pub origin: [u32; 2],
    /// Width of what is drawn in pixels.
    pub width: u32,
    /// Height of what is drawn in pixels.
    pub height: u32,
    /// Where the view axis meets the image plane, in pixels from the upper left corner of what is drawn; of a part
    /// of a picture often outside of it.
    pub principal: DVec2,
    /// Distance of the image plane in pixels: half the whole's height times cot(fov/2). A length of 1 at
    /// depth 1 covers this many pixels.
    pub focal_px: f64,
}

impl View {
    /// Columns right, up, back: view space to world space.
    pub fn to_world(&self) -> DMat3 {
        DMat3::from_cols(self.right, self.up, self.back)
    }

    /// Unit direction in world space of the ray through image point (x, y), in pixels from the
    /// upper left corner of what is drawn; the middle of the first pixel is (0.5, 0.5).
    pub fn ray(&self, x: f64, y: f64) -> DVec3 {
        let plane = DVec2::new(x, y) - self.principal;
        (plane.x * self.right - plane.y * self.up - self.focal_px * self.back).normalize()
    }

    /// Such rays through the corners of a rectangle, from its upper left one around.
    pub fn corners(&self, [left, upper, right, lower]: [f64; 4]) -> [DVec3; 4] {
        [(left, upper), (right, upper), (right, lower), (left, lower)].map(|(x, y)| self.ray(x, y))
    }

    /// Image point in pixels of a direction in world space, and whether it is in front of the camera.
    pub fn point(&self, direction: DVec3) -> (DVec2, bool) {
        let scale = self.focal_px / -direction.dot(self.back);
        let plane = DVec2::new(direction.dot(self.right), -direction.dot(self.up));
        (self.principal + scale * plane, scale > 0.0)
    }

    /// Column and row of the pixel that a direction in world space falls into; `None` beside what is
    /// drawn and behind the camera.
    pub fn pixel(&self, direction: DVec3) -> Option<(u32, u32)> {
        let (DVec2 { x, y }, is_before) = self.point(direction);
        let is_seen = is_before
            && (0.0..f64::from(self.width)).contains(&x)
            && (0.0..f64::from(self.height)).contains(&y);
        is_seen.then_some((x as u32, y as u32))
    }

    /// Number of a pixel of what is drawn in the whole picture, row by row (modulo 2^32).
    pub fn number_in_whole(&self, x: u32, y: u32) -> u32 {
        let row = (y + self.origin[1]).wrapping_mul(self.whole[0]);
        row.wrapping_add(x + self.origin[0])
    }

    /// Tangents of the angles from the view axis to the left, upper, right and lower edge, outwards; where the whole
    /// picture goes on beyond an edge, a few pixels more.
    pub fn tan_edges(&self) -> [f64; 4] {
        let size = DVec2::new(self.width.into(), self.height.into());
        let goes_on = |is_inside: bool| if is_inside { MARGIN } else { 0.0 };
        let [left, top] = self.origin;
        let [width, height] = self.whole;
        [
            self.principal.x + goes_on(left > 0),
            self.principal.y + goes_on(top > 0),
            size.x - self.principal.x + goes_on(left + self.width < width),
            size.y - self.principal.y + goes_on(top + self.height < height),
        ]
        .map(|edge| edge / self.focal_px)
    }
}
