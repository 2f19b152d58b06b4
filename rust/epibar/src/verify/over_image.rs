//! Places all over an image, and along the epipolar line of each.

use nalgebra::Vector3;

use super::thresholds::larger;
use crate::geometry::{Fundamental, symmetric_epipolar_distance};
use crate::image::{Homogeneous, ImageSize, Line};

/// Points along an epipolar line.
const ALONG: usize = 9;
/// Cells in which two geometries are compared.
const ROWS: usize = 9;
const COLUMNS: usize = 12;
/// A larger distance counts as this, pixels of a 640×480 image: beside an epipole it is any.
const MOST: f64 = 100.0;

/// Centres of the cells that an image is divided into, row after row, pixels.
pub fn cell_centres(size: ImageSize, rows: usize, columns: usize) -> impl Iterator<Item = Homogeneous> {
    // The image of a pixel reaches half a pixel beyond its centre.
    let centre =
        |k: usize, cells: usize, pixels: usize| (k as f64 + 0.5) * pixels as f64 / cells as f64 - 0.5;
    (0..rows * columns).map(move |cell| {
        Vector3::new(
            centre(cell % columns, columns, size.width),
            centre(cell / columns, rows, size.height),
            1.0,
        )
    })
}

/// Points along the part of a line that an image shows, pixels; `None` where it shows none of it.
pub fn along(line: &Homogeneous, size: ImageSize) -> Option<[[f64; 2]; ALONG]> {
    let segment = Line::from_homogeneous(line)?.clip(size)?;
    Some(std::array::from_fn(|k| {
        let t = (k as f64 + 0.5) / ALONG as f64;
        [segment.x0 + t * (segment.x1 - segment.x0), segment.y0 + t * (segment.y1 - segment.y0)]
    }))
}

/// How far apart two geometries are over the images, those beyond the motion included: the median over an image of the mean symmetric
/// epipolar distance along the line of a place under the first, pixels, of the image in which it is larger. NaN where either
/// shows no line.
pub fn image_distance(f: &Fundamental, other: &Fundamental, [a, b]: [ImageSize; 2]) -> f64 {
    larger_median([means(f, other, a, b), means(&f.transposed(), &other.transposed(), b, a)])
}

/// The median over an image of what is known of its places, of the image in which it is larger; NaN where nothing is known of either.
pub fn larger_median(of_images: [Vec<f64>; 2]) -> f64 {
    let [a, b] = of_images.map(|mut values| {
        values.retain(|v| v.is_finite());
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
    });
    larger(a, b)
}

fn means(f: &Fundamental, other: &Fundamental, from: ImageSize, to: ImageSize) -> Vec<f64> {
    let most = MOST * ImageSize::pixel_scale([from, to]);
    cell_centres(from, ROWS, COLUMNS)
        .filter_map(|x| {
            let points = along(&f.line_in_b(&x), to)?;
            let distance = |b| symmetric_epipolar_distance(other, [x.x, x.y], b).min(most);
            Some(points.into_iter().map(distance).sum::<f64>() / ALONG as f64)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix3;

    #[test]
    fn a_geometry_moved_by_five_pixels_is_as_far_away() {
        let size = ImageSize::new(640, 480).unwrap();
        // Lines of equal height: B's image moved down by five pixels.
        let moved = |by: f64| {
            let f = Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 1.0, by);
            Fundamental::from_matrix(&f, size, size).unwrap()
        };
        assert!((image_distance(&moved(0.0), &moved(5.0), [size; 2]) - 5.0).abs() < 1e-9);
        assert_eq!(image_distance(&moved(0.0), &moved(500.0), [size; 2]), MOST);
        // In an image of eight times the size the same is as many times as far.
        let large = ImageSize::new(5120, 3840).unwrap();
        assert!((image_distance(&moved(0.0), &moved(240.0), [large; 2]) - 240.0).abs() < 1e-9);
        assert!((image_distance(&moved(0.0), &moved(3000.0), [large; 2]) - 8.0 * MOST).abs() < 1e-9);
        // None of the lines is in the other image.
        assert!(image_distance(&moved(2000.0), &moved(0.0), [size; 2]).is_nan());
    }
}
