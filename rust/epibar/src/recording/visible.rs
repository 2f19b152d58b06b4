//! Where the view ends.
//!
//! A silhouette cut there has the outline of the view, not of the object, and no tangent that means anything. The
//! view ends at the border of the image, and earlier where an undistorted image has corners that the lens did not
//! look into, or where motion is not counted.

use crate::image::ImageSize;

/// Whether a point of a silhouette is where the view ends: on the border of the image, or on a pixel that is not
/// visible. `visible` is row-major, 0 where it is not; `None` where every pixel is.
pub fn on_border(size: ImageSize, visible: Option<&[u8]>, [x, y]: [f64; 2]) -> bool {
    if x < 0.5 || y < 0.5 || x > size.x_max() - 0.5 || y > size.y_max() - 0.5 {
        return true;
    }
    visible.is_some_and(|visible| visible[y.round() as usize * size.width + x.round() as usize] == 0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_view_ends_at_the_image_and_at_hidden_pixels() {
        let size = ImageSize::new(6, 4).unwrap();
        let mut visible = vec![1; 24];
        visible[2 * 6 + 4] = 0;
        for x in 0..6 {
            for y in 0..4 {
                let outer = x == 0 || y == 0 || x == 5 || y == 3;
                let p = [f64::from(x), f64::from(y)];
                assert_eq!(on_border(size, None, p), outer, "{p:?}");
                assert_eq!(on_border(size, Some(&visible), p), outer || (x, y) == (4, 2), "{p:?}");
            }
        }
        // Silhouettes drawn between frames have vertices between pixels.
        assert!(on_border(size, Some(&visible), [3.6, 1.7]));
        assert!(!on_border(size, Some(&visible), [3.4, 1.7]));
        assert!(on_border(size, Some(&visible), [4.6, 2.0]));
    }
}
