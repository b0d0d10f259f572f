//! Medians and percentiles of samples.

/// The `fraction` quantile (0 to 1) of samples in any order, linear between neighbours (type 7 of
/// Hyndman and Fan 1996, what numpy does); NaN of none.
pub fn quantile(samples: &[f64], fraction: f64) -> f64 {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = fraction.clamp(0.0, 1.0) * last as f64;
    let (low, high) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    low + (high - low) * place.fract()
}

/// The median; NaN of none.
pub fn median(samples: &[f64]) -> f64 {
    quantile(samples, 0.5)
}

#[cfg(test)]
mod tests {
    use super::{median, quantile};

    #[test]
    fn quantiles_as_numpy_has_them() {
        let samples = [7.0, 1.0, 3.0, 10.0];
        assert_eq!(median(&samples), 5.0);
        assert_eq!(quantile(&samples, 0.0), 1.0);
        assert_eq!(quantile(&samples, 1.0), 10.0);
        assert!((quantile(&samples, 0.1) - 1.6).abs() < 1e-12);
        assert!(median(&[]).is_nan());
    }
}
