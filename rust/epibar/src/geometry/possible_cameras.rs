//! How far a fundamental matrix is from that of any two cameras that somebody may have.
//!
//! Of seven parameters five are the pose of two cameras, and two are left for focal lengths; so no focal lengths need to fit. Where none do, with the principal points and the
//! shape of pixels that are known, or with square pixels and principal points in the middle, it is not the geometry of two such cameras: the images are cropped or stretched, the
//! lens bends strongly, or one camera's silhouettes lack the same part of everybody, which looks like a world that is stretched before one camera only.

use nalgebra::{Matrix3, Vector2};

use super::cameras::CameraMatrices;
use super::fundamental::Fundamental;
use crate::image::ImageSize;

/// Focal lengths, in widths of the image: a view of 110 degrees, and one of 10.
const FOCAL_LENGTHS: [f64; 2] = [0.35, 6.0];
/// Of each camera so many are tried, evenly in their logarithms.
const TRIED: usize = 24;
/// So many of the best are improved, until a step is smaller than this share of a focal length.
const IMPROVED: usize = 3;
const FINEST: f64 = 1e-4;

/// The least of [`CameraMatrices::deviation`] over focal lengths of both cameras: 0 where some fit. Of cameras that are known only the focal lengths are not believed.
pub fn least_deviation(f: &Fundamental, sizes: [ImageSize; 2], known: Option<&CameraMatrices>) -> f64 {
    let [least, most] = FOCAL_LENGTHS.map(f64::ln);
    let matrices = known.map_or_else(|| sizes.map(central), |k| [k.a, k.b]);
    let deviation = |logarithms: Vector2<f64>| {
        if logarithms.min() < least || logarithms.max() > most {
            return f64::INFINITY;
        }
        let [a, b] = [0, 1].map(|k| {
            let focal = sizes[k].width as f64 * logarithms[k].exp();
            with_focal_length(&matrices[k], focal)
        });
        CameraMatrices { a, b }.deviation(f)
    };
    let step = (most - least) / (TRIED - 1) as f64;
    let at = |k: usize| least + step * k as f64;
    let mut tried: Vec<(f64, Vector2<f64>)> = (0..TRIED * TRIED)
        .map(|k| Vector2::new(at(k / TRIED), at(k % TRIED)))
        .map(|logarithms| (deviation(logarithms), logarithms))
        .collect();
    tried.sort_by(|p, q| p.0.total_cmp(&q.0));
    let improved = tried[..IMPROVED].iter().map(|&start| improved(start, step, deviation));
    improved.fold(f64::INFINITY, f64::min)
}

/// The least that is found downhill, by steps that are halved where none goes down.
fn improved(
    (mut value, mut at): (f64, Vector2<f64>),
    mut step: f64,
    deviation: impl Fn(Vector2<f64>) -> f64,
) -> f64 {
    let around = [-1.0, 0.0, 1.0];
    while step > FINEST {
        let moves = around.iter().flat_map(|&i| around.map(|j| at + step * Vector2::new(i, j)));
        let best = moves.map(|to| (deviation(to), to)).min_by(|p, q| p.0.total_cmp(&q.0));
        match best.filter(|(least, _)| *least < value) {
            Some((least, to)) => (value, at) = (least, to),
            None => step *= 0.5,
        }
    }
    value
}

/// A camera with square pixels and its principal point in the middle; its focal length is a pixel.
fn central(size: ImageSize) -> Matrix3<f64> {
    let [width, height] = [size.width, size.height].map(|side| side as f64);
    Matrix3::new(1.0, 0.0, 0.5 * (width - 1.0), 0.0, 1.0, 0.5 * (height - 1.0), 0.0, 0.0, 1.0)
}

/// The camera with another focal length, pixels along a row.
fn with_focal_length(camera: &Matrix3<f64>, focal: f64) -> Matrix3<f64> {
    let mut camera = *camera;
    let grown = focal / camera[(0, 0)];
    for at in [(0, 0), (0, 1), (1, 1)] {
        camera[at] *= grown;
    }
    camera
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// World to camera, of one that looks at the middle of a hall.
    fn towards_the_middle(from: Vector3<f64>) -> Matrix3<f64> {
        let forward = (Vector3::new(0.0, 0.0, 1.0) - from).normalize();
        let right = forward.cross(&Vector3::z()).normalize();
        Matrix3::from_rows(&[right, forward.cross(&right), forward].map(|row| row.transpose()))
    }

    /// Of two cameras in a hall, one of which sees all heights stretched by a factor.
    fn geometry(sizes: [ImageSize; 2], focal: [f64; 2], stretched: f64) -> Fundamental {
        let places = [Vector3::new(-8.0, -5.0, 3.5), Vector3::new(7.0, -7.0, 2.5)];
        let seen = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, stretched));
        let [a, b] = [0, 1].map(|k| {
            with_focal_length(&central(sizes[k]), focal[k] * sizes[k].width as f64)
                * towards_the_middle(places[k])
        });
        let inverse = |m: Matrix3<f64>| m.try_inverse().unwrap();
        let baseline = places[0] - inverse(seen) * places[1];
        let f = inverse(b * seen).transpose() * baseline.cross_matrix() * inverse(a);
        Fundamental::from_matrix(&f, sizes[0], sizes[1]).unwrap()
    }

    #[test]
    fn some_focal_lengths_fit_two_cameras_and_none_where_one_sees_all_stretched() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(1280, 720).unwrap()];
        for focal in [[0.8, 0.8], [0.7, 2.4], [1.5, 0.6]] {
            let least = |stretched| least_deviation(&geometry(sizes, focal, stretched), sizes, None);
            assert!(least(1.0) < 1e-3, "{focal:?}: {}", least(1.0));
            assert!(least(2.0) > 0.05, "{focal:?}: {}", least(2.0));
        }
    }

    #[test]
    fn of_known_cameras_only_the_focal_lengths_are_not_believed() {
        let sizes = [ImageSize::new(640, 480).unwrap(), ImageSize::new(640, 480).unwrap()];
        let aside = |pixels: f64| {
            let mut camera = central(sizes[0]);
            camera[(0, 2)] += pixels;
            camera[(1, 1)] *= 1.2;
            camera
        };
        let centred = *geometry(sizes, [0.8, 1.1], 1.0).matrix();
        // Columns are shifted and rows stretched: what is then in the middle of A was not before.
        let moved = aside(90.0) * central(sizes[0]).try_inverse().unwrap();
        let inverse = moved.try_inverse().unwrap();
        let f = Fundamental::from_matrix(&(centred * inverse), sizes[0], sizes[1]).unwrap();
        let known = CameraMatrices { a: aside(90.0), b: central(sizes[1]) };
        assert!(least_deviation(&f, sizes, Some(&known)) < 1e-3);
        assert!(least_deviation(&f, sizes, None) > 0.01);
    }
}
