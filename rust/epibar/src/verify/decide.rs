//! The tests of a geometry, in their order: the first that finds fault is the verdict.

use std::collections::HashSet;

use super::evidence::Evidence;
use super::findings::Findings;
use super::prose;
use super::rivals::Rival;
use super::thresholds::{
    MAX_BEYOND, MIN_CLASS_Z, MIN_DEPTH, MIN_EXPLAINED, MIN_PLACES, MIN_Z, MIRROR_SHARE, PLACE, RIVAL_Z,
};
use super::verdict::{Kind, Verdict};
use crate::frontier::TangentMatch;

/// A test that finds fault, or does not.
type Test = fn(&Findings) -> Option<Verdict>;

/// The tests by name, in their order.
pub const TESTS: [(&str, Test); 8] = [
    ("stands out against shifted clocks", stands_out),
    ("explains enough of the tangents", explains_enough),
    ("supported by tops and by bottoms", both_classes),
    ("matched at enough places", enough_places),
    ("has depth", has_depth),
    ("known beyond the motion", known_beyond_motion),
    ("no rival far away", no_rival),
    ("accurate enough", accurate),
];

/// The verdict.
pub fn decide(findings: &Findings) -> Verdict {
    let fault = TESTS.iter().find_map(|(_, test)| test(findings));
    fault.unwrap_or_else(|| Verdict::new(Kind::Accepted, prose::accepted(findings)))
}

fn stands_out(f: &Findings) -> Option<Verdict> {
    (f.evidence.z < MIN_Z).then(|| Verdict::new(Kind::NoCommonScene, prose::faint(f.evidence.z)))
}

fn explains_enough(f: &Findings) -> Option<Verdict> {
    let explained = f.evidence.explained;
    (!explained.is_finite() || explained < MIN_EXPLAINED)
        .then(|| Verdict::new(Kind::NoCommonScene, prose::unexplained(explained)))
}

fn both_classes(f: &Findings) -> Option<Verdict> {
    let Evidence { z_tops, z_bottoms, .. } = *f.evidence;
    (z_tops < MIN_CLASS_Z || z_bottoms < MIN_CLASS_Z)
        .then(|| Verdict::new(Kind::Undetermined, prose::one_class(z_tops < z_bottoms)))
}

fn enough_places(f: &Findings) -> Option<Verdict> {
    let places = places(f.matches, PLACE * f.scale);
    (places < MIN_PLACES).then(|| Verdict::new(Kind::Undetermined, prose::few_places(places)))
}

fn has_depth(f: &Findings) -> Option<Verdict> {
    let plane = f.evidence.plane_residual;
    (plane < MIN_DEPTH).then(|| Verdict::new(Kind::Undetermined, prose::flat(plane)))
}

fn known_beyond_motion(f: &Findings) -> Option<Verdict> {
    (f.beyond_motion > MAX_BEYOND * f.scale)
        .then(|| Verdict::new(Kind::Undetermined, prose::unknown_beyond(f.beyond_motion)))
}

fn no_rival(f: &Findings) -> Option<Verdict> {
    let as_likely = |r: &&Rival| r.z < RIVAL_Z || (!f.upright && r.share > MIRROR_SHARE);
    let rival = f.rivals.iter().filter(as_likely).find(|r| r.distance > f.max_expected_error)?;
    Some(Verdict::new(Kind::Ambiguous, prose::rival(rival)))
}

fn accurate(f: &Findings) -> Option<Verdict> {
    let (error, limit) = (f.expected_error, f.max_expected_error);
    (error.is_nan() || error > limit).then(|| Verdict::new(Kind::Inaccurate, prose::inaccurate(error, limit)))
}

/// At how many different places tangents meet, in cells of both images together.
fn places(matches: &[TangentMatch], cell: f64) -> usize {
    let cells = |p: [f64; 2]| p.map(|v| (v / cell).round() as i64);
    matches.iter().map(|p| (cells(p.a), cells(p.b))).collect::<HashSet<_>>().len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frontier::{Class, CommonFrame};

    fn matched(k: u32, a: [f64; 2], b: [f64; 2]) -> TangentMatch {
        TangentMatch { frame: CommonFrame(k), a, b, distance: 0.1, surprise: 1.0, class: Class::Top }
    }

    #[test]
    fn places_are_counted_once() {
        let lamps: Vec<_> = (0..90).map(|k| matched(k, [f64::from(k % 3) * 50.0, 7.0], [9.0, 9.0])).collect();
        assert_eq!(places(&lamps, 4.0), 3);
        let walk: Vec<_> = (0..90).map(|k| matched(k, [f64::from(k) * 4.0, 7.0], [9.0, 9.0])).collect();
        assert_eq!(places(&walk, 4.0), 90);
        assert_eq!(places(&[], 4.0), 0);
    }

    /// A geometry without fault, whose parts a test spoils.
    fn findings<'a>(evidence: &'a Evidence, matches: &'a [TangentMatch]) -> Findings<'a> {
        Findings {
            evidence,
            matches,
            radius: 1.5,
            expected_error: 0.3,
            beyond_motion: 0.9,
            rivals: &[],
            scale: 1.0,
            upright: true,
            max_expected_error: 3.0,
        }
    }

    #[test]
    fn the_first_fault_is_the_verdict() {
        let walk: Vec<_> = (0..90).map(|k| matched(k, [f64::from(k) * 9.0, 7.0], [9.0, 9.0])).collect();
        let good = Evidence {
            z: 9.0,
            z_tops: 6.0,
            z_bottoms: 7.0,
            explained: 0.7,
            explained_by_chance: 0.2,
            plane_residual: 4.0,
            ..Evidence::default()
        };
        let kind = |findings: &Findings| decide(findings).kind;
        assert_eq!(kind(&findings(&good, &walk)), Kind::Accepted);
        for (evidence, expected) in [
            (Evidence { z: 4.9, explained: 0.1, ..good }, Kind::NoCommonScene),
            (Evidence { explained: 0.1, z_tops: 0.0, ..good }, Kind::NoCommonScene),
            (Evidence { explained: f64::NAN, ..good }, Kind::NoCommonScene),
            (Evidence { z_bottoms: 1.9, ..good }, Kind::Undetermined),
            (Evidence { plane_residual: 0.8, ..good }, Kind::Undetermined),
        ] {
            assert_eq!(kind(&findings(&evidence, &walk)), expected, "{evidence:?}");
        }
        assert_eq!(kind(&findings(&good, &walk[..40])), Kind::Undetermined);
        assert_eq!(kind(&Findings { beyond_motion: 4.1, ..findings(&good, &walk) }), Kind::Undetermined);
        assert_eq!(kind(&Findings { expected_error: 3.1, ..findings(&good, &walk) }), Kind::Inaccurate);
        assert_eq!(kind(&Findings { expected_error: f64::NAN, ..findings(&good, &walk) }), Kind::Inaccurate);
    }
}
