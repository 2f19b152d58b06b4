//! Fundamental matrices from point matches, for hypotheses where points are only about right.

use nalgebra::{SMatrix, SVector, Vector3};

use super::fundamental::{Fundamental, normaliser};
use super::least_matrix::least_matrix;
use crate::image::ImageSize;

/// The normalised eight-point algorithm (Hartley 1997) over eight or more matches, pixels.
///
/// Normalised by the images' sizes rather than the points' spread. `None` with fewer than eight matches or where they
/// leave the matrix without a value.
pub fn eight_point(matches: &[([f64; 2], [f64; 2])], sizes: [ImageSize; 2]) -> Option<Fundamental> {
    if matches.len() < 8 {
        return None;
    }
    let (ta, tb) = (normaliser(sizes[0]), normaliser(sizes[1]));
    let mut normal = SMatrix::<f64, 9, 9>::zeros();
    for (a, b) in matches {
        let (a, b) = (ta * Vector3::new(a[0], a[1], 1.0), tb * Vector3::new(b[0], b[1], 1.0));
        let equation = SVector::<f64, 9>::from_fn(|k, _| b[k / 3] * a[k % 3]);
        normal.ger(1.0, &equation, &equation, 1.0);
    }
    let normalised = least_matrix(&normal)?;
    Fundamental::from_matrix(&(tb.transpose() * normalised * ta), sizes[0], sizes[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::symmetric_epipolar_distance;

    #[test]
    fn recovers_the_geometry_of_exact_matches() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        // Two cameras: the second turned by 0.3 rad about y and moved.
        let (sin, cos) = 0.3f64.sin_cos();
        let matches: Vec<_> = (0..20)
            .map(|k| {
                let t = f64::from(k);
                let p = [(1.7 * t).sin() * 2.0, (2.9 * t).cos() * 1.5, 7.0 + (0.8 * t).sin() * 2.0];
                let q = [cos * p[0] + sin * p[2] - 2.0, p[1] + 0.2, -sin * p[0] + cos * p[2] + 0.5];
                let a = [320.0 + 600.0 * p[0] / p[2], 240.0 + 600.0 * p[1] / p[2]];
                let b = [400.0 + 500.0 * q[0] / q[2], 225.0 + 500.0 * q[1] / q[2]];
                (a, b)
            })
            .collect();
        let f = eight_point(&matches, sizes).unwrap();
        for (a, b) in &matches {
            assert!(symmetric_epipolar_distance(&f, *a, *b) < 1e-6);
        }
        assert!(eight_point(&matches[..7], sizes).is_none());
    }
}
