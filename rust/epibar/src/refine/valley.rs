//! Walking along the valley of the score in which a geometry lies.
//!
//! Where heads lie near the horizon the score hardly changes along one or two directions of the seven, and
//! refinement ends wherever it entered that valley. The normal equations of the tangents that meet name these
//! directions: steps of growing length along the weakest, both ways, are refined anew, and the walk goes on from the
//! best as long as the score grows.

use rayon::prelude::*;

use super::polish::refine;
use super::sampson::residual_rows;
use crate::frontier::{Views, symmetric_score, tangent_matches};
use crate::geometry::Fundamental;
use crate::geometry::seven_parameters::{SevenParameters, Step};

/// Directions, weakest first, that are walked.
const DIRECTIONS: usize = 3;
/// Mean distance by which a step moves the frontier points, pixels of a 640×480 image.
const LENGTHS: [f64; 4] = [0.5, 1.5, 4.0, 10.0];
/// Fewest tangents that meet of which a valley is told.
const FEWEST: usize = 20;
/// Most rounds.
const ROUNDS: usize = 6;

/// Eigenvectors of the normal equations, scaled so that a unit step moves the residuals by a pixel each
/// (root mean square), weakest first.
fn weak_directions(views: &Views, f: &Fundamental, radius: f64) -> Option<(SevenParameters, Vec<Step>)> {
    let points = tangent_matches(views, f, radius);
    let at = SevenParameters::new(f, views.sizes())?;
    if points.len() < FEWEST {
        return None;
    }
    let mut normal = nalgebra::SMatrix::<f64, 7, 7>::zeros();
    for (_, row) in residual_rows(&at, &points) {
        normal.ger(1.0 / points.len() as f64, &row, &row, 1.0);
    }
    let eigen = normal.try_symmetric_eigen(1e-14, 200)?;
    let mut order: Vec<usize> = (0..7).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    let directions = order
        .into_iter()
        .take(DIRECTIONS)
        .map(|k| eigen.eigenvectors.column(k) / eigen.eigenvalues[k].max(1e-12).sqrt())
        .collect();
    Some((at, directions))
}

/// Geometries met on a walk from `f`, itself the first, each with its symmetric score less `chance`.
///
/// `score`: that of `f`, less `chance` as well.
pub fn walk(views: &Views, f: &Fundamental, score: f64, chance: f64) -> Vec<(Fundamental, f64)> {
    let scale = views.pixel_scale();
    let mut best = (*f, score);
    let mut visited = vec![best];
    for _ in 0..ROUNDS {
        let radius = symmetric_score(views, &best.0).radius;
        let Some((at, directions)) = weak_directions(views, &best.0, 2.0 * radius) else {
            break;
        };
        let steps: Vec<Step> = directions
            .iter()
            .flat_map(|d| LENGTHS.iter().flat_map(move |l| [d * (l * scale), d * (-l * scale)]))
            // A rotation of more than a quarter of a radian has left the valley.
            .map(|step| if step.norm() > 0.25 { step * (0.25 / step.norm()) } else { step })
            .collect();
        let found: Vec<(Fundamental, f64)> = steps
            .par_iter()
            .filter_map(|step| {
                let f = at.stepped(step).fundamental()?;
                let refined = refine(views, &f, &[2.0 * radius, radius], 3)?;
                let score = symmetric_score(views, &refined).total - chance;
                score.is_finite().then_some((refined, score))
            })
            .collect();
        let next = found.iter().max_by(|p, q| p.1.total_cmp(&q.1)).copied();
        visited.extend(found);
        match next {
            Some(next) if next.1 > best.1 * 1.0005 => best = next,
            _ => break,
        }
    }
    visited
}
