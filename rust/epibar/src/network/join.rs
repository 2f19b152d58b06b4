//! From recordings, clocks and pairs to one network with a verdict on each camera.
//!
//! Solve; ask what speaks for each camera on moments kept aside; take out the one for which least does, and solve again, until
//! all that stand can be relied on; only then free principal points, look at all frames, and say how large errors are.

use super::case::{Finished, NetworkCase, Out};
use super::evidence::alternatives::alternatives;
use super::evidence::cheirality::behind;
use super::evidence::contradictions::{Contradiction, contradictions};
use super::evidence::covariance::covariance_with_principal_points;
use super::evidence::doubts::{Doubt, doubts, with_doubts};
use super::evidence::floor_errors::{FloorErrors, floor_errors};
use super::evidence::outlines::{Shapes, outline_errors, with_uneven_insets};
use super::evidence::parallax::parallax;
use super::evidence::planes::off_plane;
use super::evidence::relief::relief;
use super::evidence::stated_errors::{Expected, expected, ways_to_align};
use super::evidence::support::Support;
use super::given::clocks::Offsets;
use super::given::input::{AS_SOLD, CameraInput, PRINCIPAL_LEVELS};
use super::given::pair::PairFound;
use super::model::camera::CLOCK;
use super::model::joint::standing;
use super::observations::survey::{Survey, shared};
use super::result::{CameraStatus, Network};
use super::solve::collapse::collapsed;
use super::solve::networks::{FRAMES_IN_THE_END, Solved, Solver, settled};
use super::solve::principal::{self, Likely};
use super::solve::relocate::Placed;
use super::solve::settle::Again;
use super::solve::world;
use super::thresholds as limits;
use super::verdict::decide::{NetworkFindings, is_rival, to_take_out};
use crate::error::{Error, Result};
use crate::watch::{Stage, Watch, report};

/// Least radius within which figures of the floor meet, pixels of a 640×480 image.
const FIGURES_WITHIN: f64 = 2.0;

/// One network of some cameras from what their pairs brought, by clocks that are known to a frame or two, or exactly.
///
/// # Errors
/// [`Error::Argument`] for what cannot be known of a camera, for pairs of cameras that are not there, and where there is not a
/// clock for each camera; [`Error::Interrupted`].
pub fn join(
    inputs: &[CameraInput],
    pairs: &[PairFound],
    clocks: &Offsets,
    watch: &mut dyn Watch,
) -> Result<Network> {
    for input in inputs {
        input.known.check()?;
    }
    check(inputs.len(), pairs, clocks)?;
    report(watch, Stage::Network, 0.0)?;
    let case = NetworkCase::new(inputs, pairs, clocks);
    if let Some(status) = case.hopeless() {
        return Ok(case.nothing(status));
    }
    let solver = Solver::new(&case.observed, &case.hypotheses);
    let mut networks = solver.networks(&case.cameras, &case.beliefs);
    report(watch, Stage::Network, 0.4)?;
    if networks.is_empty() {
        return Ok(case.nothing(CameraStatus::NothingInCommon));
    }
    let best = networks.remove(0);
    let mut out = Vec::new();
    let Some(mut sifted) = case.sifted(&solver, best, &mut out, watch)? else {
        return Ok(case.without(&out));
    };
    let rivalled = loop {
        let rival = networks.iter().find(|rival| is_rival(&solver.some, &sifted.0, rival));
        let Some(rival) = rival else { break false };
        let bad = ambiguous(&sifted, rival);
        let left = bad.and_then(|bad| case.taken_out(&solver, &sifted.0, &bad, &mut out));
        let Some(left) = left else { break true };
        let Some(left) = case.sifted(&solver, left, &mut out, watch)? else { return Ok(case.without(&out)) };
        sifted = left;
    };
    report(watch, Stage::Network, 0.7)?;
    let finished = case.agreed(&solver, sifted);
    let rivalled = rivalled || is_mixed(&finished);
    report(watch, Stage::Network, 0.9)?;
    Ok(case.network(&finished, &out, rivalled))
}

fn check(cameras: usize, pairs: &[PairFound], clocks: &Offsets) -> Result<()> {
    let refuse = |name, value: String, expected| Err(Error::Argument { name, value, expected });
    if clocks.seconds.len() != cameras {
        return refuse("clocks", clocks.seconds.len().to_string(), "a clock for each camera");
    }
    for pair in pairs {
        if pair.a >= pair.b || pair.b >= cameras || pair.geometries.is_empty() {
            return refuse("pairs", format!("{}, {}", pair.a, pair.b), "two cameras a < b, with a geometry");
        }
    }
    Ok(())
}

/// Whether over all frames two cameras have come together, pairs see different planes, or what meets is behind cameras.
fn is_mixed(Finished { solved, support, .. }: &Finished) -> bool {
    let (settled, placed, confirmed) = (&solved.settled, &solved.network.placed, support.confirmed());
    behind(settled, placed, &confirmed).is_some()
        || off_plane(settled, placed, &confirmed).is_some()
        || !collapsed(settled).is_empty()
}

/// A network for every camera of which enough speaks.
type Sifted = (Solved, Support);

/// Cameras that stand elsewhere in a rival, in which most are where they are; `None` where most are not.
fn ambiguous((now, support): &Sifted, rival: &Solved) -> Option<Vec<Out>> {
    let elsewhere = now.network.turned_elsewhere(&rival.network, limits::RIVAL_TURN)?;
    let status = CameraStatus::Ambiguous;
    Some(
        elsewhere
            .into_iter()
            .map(|c| Out { camera: c, status, deviates: support.cameras[c], at: None })
            .collect(),
    )
}

impl NetworkCase<'_> {
    /// The network without cameras for which nothing speaks; `None` where too few are left.
    fn sifted(
        &self,
        solver: &Solver,
        mut now: Solved,
        out: &mut Vec<Out>,
        watch: &mut dyn Watch,
    ) -> Result<Option<Sifted>> {
        loop {
            report(watch, Stage::Network, 0.4 + 0.3 * out.len() as f64 / self.count() as f64)?;
            let support = Support::of(&self.observed, &now);
            let bad = to_take_out(&NetworkFindings {
                observed: &self.observed,
                survey: &solver.some,
                solved: &now,
                support: &support,
            });
            if bad.is_empty() {
                return Ok(Some((now, support)));
            }
            let Some(left) = self.taken_out(solver, &now, &bad, out) else {
                let is_left = |&c: &usize| now.network.placed[c] && bad.iter().all(|o| o.camera != c);
                let status = CameraStatus::NothingInCommon;
                let left = (0..self.count()).filter(is_left);
                let left = left.map(|c| Out { camera: c, status, deviates: support.cameras[c], at: None });
                out.extend(bad.iter().copied().chain(left));
                return Ok(None);
            };
            now = left;
        }
    }

    /// The network without some cameras, which are put on record; `None`, and nothing is, where too few are left.
    fn taken_out(&self, solver: &Solver, now: &Solved, bad: &[Out], out: &mut Vec<Out>) -> Option<Solved> {
        let mut network = now.network.clone();
        for camera in bad {
            network.placed[camera.camera] = false;
        }
        if !self.are_enough(&network.placed) {
            return None;
        }
        out.extend(bad);
        network.cameras = standing(&network.cameras, &network.placed);
        let radius = Some(Again::FEWER_CAMERAS.after(&now.settled));
        Some(solver.settled(network, &now.beliefs, radius))
    }

    /// The network with principal points as far from the middle as the tangents call for.
    ///
    /// Outlines that are wrong in the same way everywhere, such as of boxes and ellipses that stand for people, ask for other
    /// principal points as well. Shapes without a gap between them and their hulls may be such, so for them it is only said that
    /// nothing is known of principal points, and of outlines no more than how they scatter.
    fn with_principal_points(&self, solver: &Solver, (now, support): (Solved, Support)) -> Freed {
        let likely = principal::likely(&now);
        if Shapes::of(&self.observed) == Shapes::Convex {
            let shapes = if principal::is_strained(&now) { Shapes::Strained } else { Shapes::Convex };
            return Freed { solved: now, support, likely: likely.not_below_sold(), shapes };
        }
        let shapes = Shapes::Masks;
        let beliefs = principal::at_level(&now.beliefs, &self.cameras, likely.level());
        if likely.level() > PRINCIPAL_LEVELS[AS_SOLD] {
            let radius = Some(Again::PRINCIPAL_POINTS.after(&now.settled));
            let free = solver.settled(now.network.clone(), &beliefs, radius);
            if free.excess > now.excess {
                let support = Support::of(&self.observed, &free);
                return Freed { solved: free, support, likely, shapes };
            }
            return Freed { solved: now, support, likely, shapes };
        }
        Freed { solved: Solved { beliefs, ..now }, support, likely, shapes }
    }

    /// The network over all frames, without what was given and is contradicted by what moves.
    fn agreed(&self, solver: &Solver, (mut now, mut support): Sifted) -> Finished {
        let mut contradicted = Vec::new();
        loop {
            let freed = self.with_principal_points(solver, (now.clone(), support));
            let (many, solved) = self.over_all_frames(&freed);
            let cameras = &solved.network.cameras;
            let alternatives = alternatives(&solved, &freed.likely, freed.shapes);
            let Some(found) = contradictions(cameras, &alternatives) else {
                let doubts = doubts(cameras, &alternatives);
                return self.finished(&many, freed, solved, contradicted, doubts);
            };
            let mut beliefs = now.beliefs.clone();
            for one in &found.found {
                one.kind.free(&mut beliefs[one.camera], &found.cameras[one.camera]);
            }
            contradicted.extend(found.found);
            let network = Placed { cameras: found.cameras, ..now.network };
            let radius = Some(Again::PRINCIPAL_POINTS.after(&now.settled));
            now = solver.settled(network, &beliefs, radius);
            support = Support::of(&self.observed, &now);
        }
    }

    /// The network over all frames, and these; with insets that differ from side to side, and where silhouettes are small.
    fn over_all_frames(&self, Freed { solved, support, shapes, .. }: &Freed) -> (Survey<'_>, Solved) {
        let many = Survey::new(&self.observed, shared(FRAMES_IN_THE_END, self.count()));
        let radius = Some(Again::MORE_FRAMES.after(&solved.settled));
        // What meets by chance in pairs that show nothing in common says nothing of where their cameras stand.
        let beliefs = with_uneven_insets(solved.beliefs.clone(), &solved.settled, *shapes);
        let found = settled(&many, solved.network.clone(), &beliefs, &support.confirmed(), radius);
        (many, found)
    }

    /// The network over all frames with its floor, and errors to expect.
    fn finished(
        &self,
        many: &Survey,
        Freed { support, likely, shapes, .. }: Freed,
        solved: Solved,
        contradicted: Vec<Contradiction>,
        doubts: Vec<Doubt>,
    ) -> Finished {
        let floor = world::floor(many, &solved.network, solved.settled.radius.max(FIGURES_WITHIN));
        let outlines = outline_errors(&solved.settled, shapes);
        let errors = covariance_with_principal_points(&solved, &likely, &outlines);
        let Placed { cameras, placed } = &solved.network;
        let stated = errors.and_then(|errors| with_doubts(errors, &doubts)).map(|errors| {
            let ways = ways_to_align(cameras, placed, &errors.active, &errors.matrix);
            let offsets: Vec<f64> = (0..self.count()).map(|c| errors.deviation(c, CLOCK)).collect();
            let of_floor = |floor| floor_errors(&solved.network, floor, &errors.active, &ways);
            let of_floor = floor.as_ref().and_then(of_floor).unwrap_or(FloorErrors::UNKNOWN);
            (expected(self.count(), &errors.active, &ways), offsets, of_floor)
        });
        let unknown =
            || (vec![Expected::UNKNOWN; self.count()], vec![f64::NAN; self.count()], FloorErrors::UNKNOWN);
        let (expected, offsets, floor_errors) = stated.unwrap_or_else(unknown);
        let (parallax, relief) = (parallax(&solved.settled), relief(&solved, &support.confirmed()));
        let strained = shapes == Shapes::Strained;
        Finished {
            solved,
            support,
            expected,
            offsets,
            parallax,
            relief,
            floor,
            floor_errors,
            strained,
            contradicted,
            doubts,
        }
    }
}

/// A network with its principal points.
struct Freed {
    solved: Solved,
    support: Support,
    /// How far from the middle they may be.
    likely: Likely,
    shapes: Shapes,
}
