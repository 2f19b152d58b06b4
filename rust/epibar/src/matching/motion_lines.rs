//! Straight paths with heavy traffic, found on the motion heat map (paper §4.2).
//!
//! Where many objects follow one straight line, its images in A and in B are crossed at the same moments by
//! the same objects, and correlate without being epipolar. The heat map, the sum of the masks over time, shows
//! such a path as a bright ridge: a Hough transform weighted with the heat, normalised by the length of each
//! line inside the image, has a peak there. A peak counts where the ridge is both hot and narrow.

use crate::geometry::area_between;
use crate::image::{ImageSize, Line, Segment};
use crate::recording::Recording;

/// What makes a ridge of the heat map a motion line.
#[derive(Debug, Clone)]
pub struct MotionLineOptions {
    /// Most lines reported.
    pub limit: usize,
    /// Least share of all motion that lies within the band around the line.
    pub share: f64,
    /// Half width of that band as a share of the image diagonal.
    pub band: f64,
    /// Least ratio of the heat in the band to that of the same band moved sideways by three half widths.
    pub contrast: f64,
}

impl Default for MotionLineOptions {
    fn default() -> Self {
        Self { limit: 8, share: 0.35, band: 0.025, contrast: 4.0 }
    }
}

const ANGLES: usize = 180;
/// Cells of the coarse heat map along the longer side.
const CELLS: usize = 160;

/// A candidate line overlaps a motion line where they enclose less than 3 × image width (paper §3.2).
pub(crate) fn overlaps(line: &Line, path: &Line, size: ImageSize) -> bool {
    area_between(line, path, size) < 3.0 * size.width as f64
}

/// Heat per cell of a coarse grid, with the cell's centre in pixels.
fn coarse_heat(recording: &Recording) -> Vec<([f64; 2], f64)> {
    let ImageSize { width, height } = recording.size;
    let cell = width.max(height).div_ceil(CELLS).max(1);
    let (columns, rows) = (width.div_ceil(cell), height.div_ceil(cell));
    let mut sums = vec![0.0; columns * rows];
    for (y, row) in recording.heat.chunks_exact(width).enumerate() {
        for (x, &heat) in row.iter().enumerate() {
            sums[(y / cell) * columns + x / cell] += f64::from(heat);
        }
    }
    let half = 0.5 * (cell as f64 - 1.0);
    sums.into_iter()
        .enumerate()
        .filter(|&(_, heat)| heat > 0.0)
        .map(|(i, heat)| {
            let (x, y) = ((i % columns * cell) as f64 + half, (i / columns * cell) as f64 + half);
            ([x, y], heat)
        })
        .collect()
}

/// Motion lines of one recording, strongest first.
pub fn motion_lines(recording: &Recording, options: &MotionLineOptions) -> Vec<Line> {
    let size = recording.size;
    let mut cells = coarse_heat(recording);
    let total: f64 = cells.iter().map(|c| c.1).sum();
    let half_band = (options.band * size.diagonal()).max(1.0);
    let mut found = Vec::new();
    while found.len() < options.limit {
        let Some(ridge) = strongest_ridge(&cells, size, half_band) else { break };
        let line = centred(&cells, ridge, half_band);
        let near = |offset: f64| -> f64 {
            cells
                .iter()
                .filter(|(p, _)| (line.signed_distance(p[0], p[1]) - offset).abs() <= half_band)
                .map(|c| c.1)
                .sum()
        };
        let (inside, beside) = (near(0.0), near(3.0 * half_band).max(near(-3.0 * half_band)));
        if inside < options.share * total || inside < options.contrast * beside {
            break;
        }
        if !spans(&cells, &line, half_band, size) {
            break;
        }
        cells.retain(|(p, _)| line.signed_distance(p[0], p[1]).abs() > 2.0 * half_band);
        found.push(line);
    }
    found
}

/// A path is long: the middle 80 % of the heat in its band covers a third of the image diagonal. This distinguishes a
/// path from one object that stays in place, which is hot but leads nowhere.
fn spans(cells: &[([f64; 2], f64)], line: &Line, half_band: f64, size: ImageSize) -> bool {
    let mut along: Vec<(f64, f64)> = cells
        .iter()
        .filter(|(p, _)| line.signed_distance(p[0], p[1]).abs() <= half_band)
        .map(|(p, heat)| (-line.b * p[0] + line.a * p[1], *heat))
        .collect();
    along.sort_by(|p, q| p.0.total_cmp(&q.0));
    let total: f64 = along.iter().map(|c| c.1).sum();
    let quantile = |share: f64| {
        let mut sum = 0.0;
        along.iter().find(|c| {
            sum += c.1;
            sum >= share * total
        })
    };
    match (quantile(0.1), quantile(0.9)) {
        (Some(low), Some(high)) => high.0 - low.0 > size.diagonal() / 3.0,
        _ => false,
    }
}

/// The line along the middle of the heat in the band around `ridge`: least squares of the distances, and again in
/// the band of the result. A path narrower than the band lies whole in the bands of many lines, and the transform
/// returns any one of them.
fn centred(cells: &[([f64; 2], f64)], ridge: Line, half_band: f64) -> Line {
    let mut line = ridge;
    for _ in 0..4 {
        let near = || cells.iter().filter(|(p, _)| line.signed_distance(p[0], p[1]).abs() <= half_band);
        let (mut total, mut x, mut y) = (0.0, 0.0, 0.0);
        for (p, heat) in near() {
            total += heat;
            x += heat * p[0];
            y += heat * p[1];
        }
        (x, y) = (x / total, y / total);
        let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
        for (p, heat) in near() {
            let (dx, dy) = (p[0] - x, p[1] - y);
            xx += heat * dx * dx;
            xy += heat * dx * dy;
            yy += heat * dy * dy;
        }
        // The heat extends most along this angle; the normal is a right angle from it.
        let (b, a) = (0.5 * (2.0 * xy).atan2(xx - yy) + 0.5 * std::f64::consts::PI).sin_cos();
        let fitted = Line { a, b, c: -a * x - b * y };
        if !fitted.c.is_finite() {
            break;
        }
        line = fitted;
    }
    line
}

/// The line with the most heat in its band.
fn strongest_ridge(cells: &[([f64; 2], f64)], size: ImageSize, half_band: f64) -> Option<Line> {
    let step = 0.5 * half_band;
    let reach = size.diagonal();
    let bins = (2.0 * reach / step).ceil() as usize + 1;
    let mut best: Option<(f64, Line)> = None;
    let mut histogram = vec![0.0; bins];
    for angle in 0..ANGLES {
        let (b, a) = (std::f64::consts::PI * angle as f64 / ANGLES as f64).sin_cos();
        histogram.fill(0.0);
        for (p, heat) in cells {
            let offset = a * p[0] + b * p[1];
            histogram[((offset + reach) / step).round() as usize] += heat;
        }
        for centre in 2..bins - 2 {
            let heat: f64 = histogram[centre - 2..=centre + 2].iter().sum();
            if best.as_ref().is_none_or(|(most, _)| heat > *most) {
                best = Some((heat, Line { a, b, c: reach - centre as f64 * step }));
            }
        }
    }
    let (heat, line) = best?;
    (heat > 0.0 && line.clip(size).is_some_and(|s: Segment| s.length() > 0.0)).then_some(line)
}
