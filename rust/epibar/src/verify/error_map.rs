//! Where in the images `F` is known how well.
//!
//! A point of A has an epipolar line in B, and the seven parameters' covariance carries over to the distance between a
//! point of that line and the true line: `σ² = jᵀ C j` with `j` the derivative of the distance. Its mean is that of a folded
//! normal, `σ √(2/π)`, and a map holds its average over the part of the line that B shows. What the covariance does not
//! know, and the number [`Calibration::expected_error`](crate::Calibration::expected_error) holds as well, is
//! added in the same way: same factor, same systematic part. Beyond the motion that part is what it becomes there, where it is more
//! ([`covariance_alike`](super::covariance::covariance_alike)).

use nalgebra::{Matrix3, Vector3};

use super::covariance::{expected_distance, expected_error};
use super::over_image::{along, cell_centres, larger_median};
use super::thresholds::larger;
use crate::frontier::volume::Correspondence;
use crate::geometry::seven_parameters::{Information, SevenParameters, Step};
use crate::image::ImageSize;

/// Cells of a map.
pub const ROWS: usize = 24;
/// From left to right.
pub const COLUMNS: usize = 32;

/// What is known of the error of a geometry.
#[derive(Debug, Clone)]
pub struct Uncertainty {
    /// The geometry.
    pub at: SevenParameters,
    /// Covariance of its parameters.
    pub covariance: Information,
    /// Covariance of its parameters from what outlines are off alike.
    pub alike: Information,
    /// Error over the images that the covariance does not know, pixels; it adds as independent.
    pub systematic: f64,
}

/// Expected error over an image, in cells of equal size.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ErrorMap {
    /// Cells from top to bottom.
    pub rows: usize,
    /// Cells from left to right.
    pub columns: usize,
    /// Pixels, row after row; NaN where the other image shows nothing of the epipolar line.
    pub values: Vec<f64>,
}

impl Uncertainty {
    /// Expected error over correspondences, pixels.
    pub fn over(&self, correspondences: &[Correspondence]) -> f64 {
        expected_error(&self.at, &self.covariance, correspondences).hypot(self.systematic)
    }

    /// Expected error of points of A, in B, and of points of B, in A.
    pub fn maps(&self) -> [ErrorMap; 2] {
        let (matrix, derivatives, [a, b]) = (self.at.unscaled(), self.at.derivatives(), self.at.sizes());
        let transposed = derivatives.map(|d| d.transpose());
        [self.map(&matrix, &derivatives, a, b), self.map(&matrix.transpose(), &transposed, b, a)]
    }

    /// The error that the covariances alone expect in half of either image, the larger of the two, pixels; NaN where either
    /// is not known.
    pub fn beyond_motion(&self) -> f64 {
        let known = Self { systematic: 0.0, ..self.clone() };
        larger_median(known.maps().map(|map| map.values))
    }

    fn map(
        &self,
        matrix: &Matrix3<f64>,
        derivatives: &[Matrix3<f64>; 7],
        from: ImageSize,
        to: ImageSize,
    ) -> ErrorMap {
        let values = cell_centres(from, ROWS, COLUMNS)
            .map(|point| self.along_line(matrix, derivatives, &point, to))
            .collect();
        ErrorMap { rows: ROWS, columns: COLUMNS, values }
    }

    /// Mean over the visible part of the epipolar line of a point; NaN where there is none.
    fn along_line(
        &self,
        matrix: &Matrix3<f64>,
        derivatives: &[Matrix3<f64>; 7],
        point: &Vector3<f64>,
        to: ImageSize,
    ) -> f64 {
        let line = matrix * point;
        let Some(seen) = along(&line, to) else { return f64::NAN };
        let scale = 1.0 / line.x.hypot(line.y);
        let change = derivatives.map(|d| d * point * scale);
        let sum: f64 = seen
            .iter()
            .map(|[x, y]| {
                let row = Step::from_fn(|k, _| change[k].dot(&Vector3::new(*x, *y, 1.0)));
                let alike = expected_distance(&self.alike, &row);
                expected_distance(&self.covariance, &row).hypot(larger(self.systematic, alike))
            })
            .sum();
        sum / seen.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Fundamental;
    use crate::image::Line;
    use crate::random::{Generator, generator};
    use rand::RngExt;

    /// About normal: the sum of twelve uniform numbers.
    fn normal(random: &mut Generator) -> f64 {
        (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0
    }

    #[test]
    fn a_map_is_what_perturbed_geometries_show() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(800, 450).unwrap()];
        let matrix = Matrix3::new(1e-6, -3e-6, 2e-3, 5e-6, 2e-6, -9e-3, -4e-3, 6e-3, 1.0);
        let f = Fundamental::from_matrix(&matrix, sizes[0], sizes[1]).unwrap();
        let at = SevenParameters::new(&f, sizes).unwrap();
        let mut random = generator(3, 0);
        let root = Information::from_fn(|_, _| 4e-4 * normal(&mut random));
        let steps: Vec<Step> = (0..2000).map(|_| root * Step::from_fn(|_, _| normal(&mut random))).collect();
        let of =
            |covariance, alike, systematic| Uncertainty { at: at.clone(), covariance, alike, systematic };
        let (covariance, none) = (root * root.transpose(), Information::zeros());
        let maps = of(covariance, none, 0.0).maps();
        let with_systematic = of(covariance, none, 3.0).maps();
        // Of what is systematic the larger counts.
        assert_eq!(of(none, covariance, 0.0).maps()[0].values[400], maps[0].values[400]);
        assert_eq!(of(none, covariance * 1e-8, 3.0).maps()[0].values[400], 3.0);

        let mut compared = 0;
        for (side, (from, to)) in [(sizes[0], sizes[1]), (sizes[1], sizes[0])].into_iter().enumerate() {
            for (row, column) in [(2, 3), (12, 16), (20, 9), (7, 30)] {
                let (x, y) = (
                    (column as f64 + 0.5) * from.width as f64 / 32.0 - 0.5,
                    (row as f64 + 0.5) * from.height as f64 / 24.0 - 0.5,
                );
                let line_of = |matrix: &Matrix3<f64>| {
                    let point = Vector3::new(x, y, 1.0);
                    let line = if side == 0 { matrix * point } else { matrix.tr_mul(&point) };
                    Line::from_homogeneous(&line).unwrap()
                };
                let value = maps[side].values[row * 32 + column];
                let Some(segment) = line_of(f.matrix()).clip(to) else {
                    assert!(value.is_nan());
                    continue;
                };
                let mut sum = 0.0;
                for step in &steps {
                    let line = line_of(&at.stepped(step).unscaled());
                    for k in 0..50 {
                        let t = (f64::from(k) + 0.5) / 50.0;
                        let x = segment.x0 + t * (segment.x1 - segment.x0);
                        let y = segment.y0 + t * (segment.y1 - segment.y0);
                        sum += line.signed_distance(x, y).abs();
                    }
                }
                let expected = sum / (50 * steps.len()) as f64;
                assert!((value / expected - 1.0).abs() < 0.1, "{side} {row} {column}: {value} {expected}");
                let more = with_systematic[side].values[row * 32 + column];
                assert!(more > 3.0 && more < value + 3.0, "{more}");
                compared += 1;
            }
        }
        assert!(compared >= 4, "{compared}");
    }
}
