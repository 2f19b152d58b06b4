//! Walking along the valley of a solution.
//!
//! Where heads lie near the horizon the evidence hardly changes along one or two directions of the seven, and
//! refinement ends wherever it entered that valley. The normal equations of the frontier points name these
//! directions: steps of growing length along the weakest, both ways, are refined anew, and the walk goes on from the
//! best as long as the evidence grows. What was visited stays as rivals.

use rayon::prelude::*;

use super::evidence::evidence;
use super::frontier::{FrontierOptions, compare};
use super::optimise::{SevenParameters, Step};
use super::refine::{refine, residual_rows};
use super::search::Solution;
use super::views::Views;
use crate::geometry::Fundamental;

/// Directions, weakest first, that are walked.
const DIRECTIONS: usize = 3;
/// Mean distance by which a step moves the frontier points, pixels of a 640×480 image.
const LENGTHS: [f64; 4] = [0.5, 1.5, 4.0, 10.0];
/// Most rounds.
const ROUNDS: usize = 6;

/// Eigenvectors of the normal equations, scaled so that a unit step moves the residuals by a pixel each
/// (root mean square), weakest first.
fn weak_directions(
    views: &Views,
    f: &Fundamental,
    radius: f64,
    upright: bool,
) -> Option<(SevenParameters, Vec<Step>)> {
    let points = compare(views, f, &FrontierOptions { radius, upright, shift: 0 }).points;
    let at = SevenParameters::new(f, views.sizes())?;
    if points.len() < 20 {
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

/// All solutions met on the walk, the start among them, best first.
pub fn explore(views: &Views, start: &Solution, scale: f64, upright: bool) -> Vec<Solution> {
    let mut visited = vec![start.clone()];
    let mut best = start.clone();
    for _ in 0..ROUNDS {
        let radius = evidence(views, &best.fundamental, upright).radius;
        let Some((at, directions)) = weak_directions(views, &best.fundamental, 2.0 * radius, upright) else {
            break;
        };
        let steps: Vec<Step> = directions
            .iter()
            .flat_map(|d| LENGTHS.iter().flat_map(move |l| [d * (l * scale), d * (-l * scale)]))
            // A rotation of more than a quarter of a radian has left the valley.
            .map(|step| if step.norm() > 0.25 { step * (0.25 / step.norm()) } else { step })
            .collect();
        let found: Vec<Solution> = steps
            .par_iter()
            .filter_map(|step| {
                let f = at.stepped(step).fundamental()?;
                let refined = refine(views, &f, &[2.0 * radius, radius], 3, upright)?;
                let evidence = evidence(views, &refined, upright).total - start.chance;
                evidence.is_finite().then_some(Solution { fundamental: refined, evidence, ..*start })
            })
            .collect();
        let next = found.iter().max_by(|p, q| p.evidence.total_cmp(&q.evidence)).cloned();
        visited.extend(found);
        match next {
            Some(next) if next.evidence > best.evidence * 1.0005 => best = next,
            _ => break,
        }
    }
    visited.sort_by(|p, q| q.evidence.total_cmp(&p.evidence));
    visited
}
