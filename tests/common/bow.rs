//! Where a rainbow is brightest: Descartes' and Fresnel's formulas and the sun's disc, written out.

/// Refractive index of water, for the bow.
pub const INDEX: f64 = 1.3343;
/// Angular radius of the sun's disc, degrees.
pub const DISC: f64 = 0.27;
/// Degrees of a ring.
pub const RING: f64 = 0.05;

/// Light of a sphere, for each unit of solid angle, by the angle from the point opposite to the sun in rings: once
/// reflected inside, from a sun without extent.
pub fn bow_of_a_point() -> Vec<f64> {
    let mut light = vec![0.0; (60.0 / RING) as usize];
    let steps = 2_000_000;
    for step in 0..steps {
        let square = (f64::from(step) + 0.5) / f64::from(steps);
        let incidence = square.sqrt().asin();
        let refraction = (square.sqrt() / INDEX).asin();
        let (sum, difference) = (incidence + refraction, incidence - refraction);
        let across = (difference.sin() / sum.sin()).powi(2);
        let along = (difference.tan() / sum.tan()).powi(2);
        let reflected = 0.5 * (across + along);
        let angle = (4.0 * refraction - 2.0 * incidence).to_degrees();
        if let Some(ring) = light.get_mut((angle / RING) as usize) {
            *ring += (1.0 - reflected).powi(2) * reflected;
        }
    }
    let solid_angle = |ring: usize| ((ring as f64 + 0.5) * RING).to_radians().sin();
    light.iter().enumerate().map(|(ring, light)| light / solid_angle(ring)).collect()
}

/// The mean over a disc, each of whose strips along the ring sees one angle.
pub fn over_the_disc(light: &[f64]) -> Vec<f64> {
    let reach = (DISC / RING).ceil() as i64;
    let strips: Vec<(i64, f64)> = (-reach..=reach)
        .map(|strip| (strip, (DISC.powi(2) - (strip as f64 * RING).powi(2)).max(0.0).sqrt()))
        .collect();
    let at = |ring: i64| light.get(ring as usize).copied().unwrap_or(0.0);
    (0..light.len() as i64)
        .map(|ring| strips.iter().map(|(strip, length)| length * at(ring + strip)).sum())
        .collect()
}

/// Degrees of the brightest ring, between rings by the parabola through it and its neighbours.
pub fn brightest(rings: &[f64]) -> f64 {
    let top = (1..rings.len() - 1).max_by(|a, b| rings[*a].total_cmp(&rings[*b])).expect("rings");
    let [before, peak, after] = [rings[top - 1], rings[top], rings[top + 1]];
    let offset = 0.5 * (before - after) / (before - 2.0 * peak + after);
    (top as f64 + 0.5 + offset) * RING
}
