//! The tests of a geometry, in their order: the first that finds fault is the verdict.
//!
//! Before them [`untestable`](super::untestable) refuses what has nothing to test, and after them an accepted one may fall by what its clock was
//! chosen among: [`trials`](super::trials), and [`other_clocks`](super::other_clocks).

use std::collections::HashSet;

use super::allowed_beyond::{is_flat, most_beyond, most_possible, most_turned};
use super::evidence::Evidence;
use super::findings::Findings;
use super::given_cameras::contradict;
use super::prose;
use super::rivals::Rival;
use super::thresholds::{
    CLEAN_RADIUS, HOLDS, MIN_BOTH_ENDS, MIN_CLASS_EXPLAINED, MIN_CLASS_Z, MIN_EXPLAINED, MIN_PLACES,
    MIN_WHOLE_Z, MIN_Z, MIRROR_SHARE, NO_CAMERAS, PLACE, REPEATS, SAME, reaches, within,
};
use super::verdict::{Kind, Verdict};
use crate::frontier::TangentMatch;

/// A test that finds fault, or does not.
type Test = fn(&Findings) -> Option<Verdict>;

/// The tests by name, in their order.
pub const TESTS: [(&str, Test); 16] = [
    ("stands out against shifted clocks", stands_out),
    ("explains enough of the tangents", explains_enough),
    ("supported by tops and by bottoms", both_classes),
    ("whole silhouettes meet", whole_silhouettes),
    ("matched at enough places", enough_places),
    ("does not repeat itself", does_not_repeat),
    ("holds throughout", holds_throughout),
    ("is the same in both halves", same_in_both_halves),
    ("has more depth than outlines are off", depth_beyond_outlines),
    ("may not turn about a plane", may_not_turn),
    ("known beyond the motion", known_beyond_motion),
    ("what was tested is what is returned", as_tested),
    ("no rival far away", no_rival),
    ("what was given agrees", given_cameras_agree),
    ("may be of two cameras", of_two_cameras),
    ("accurate enough", accurate),
];

/// The verdict.
pub fn decide(findings: &Findings) -> Verdict {
    let fault = TESTS.iter().find_map(|(_, test)| test(findings));
    fault.unwrap_or_else(|| Verdict::new(Kind::Accepted, prose::accepted(findings)))
}

/// Fault, unless it is sound.
fn unless(sound: bool, kind: Kind, reason: impl FnOnce() -> String) -> Option<Verdict> {
    (!sound).then(|| Verdict::new(kind, reason()))
}

fn stands_out(f: &Findings) -> Option<Verdict> {
    unless(reaches(f.evidence.z, MIN_Z), Kind::NoCommonScene, || prose::faint(f.evidence.z))
}

fn explains_enough(f: &Findings) -> Option<Verdict> {
    let explained = f.evidence.explained;
    unless(reaches(explained, MIN_EXPLAINED), Kind::NoCommonScene, || prose::unexplained(explained))
}

fn both_classes(f: &Findings) -> Option<Verdict> {
    let Evidence { z_tops, z_bottoms, explained_tops, explained_bottoms, .. } = *f.evidence;
    let tops = reaches(z_tops, MIN_CLASS_Z) && reaches(explained_tops, MIN_CLASS_EXPLAINED);
    let bottoms = reaches(z_bottoms, MIN_CLASS_Z) && reaches(explained_bottoms, MIN_CLASS_EXPLAINED);
    unless(tops && bottoms, Kind::Undetermined, || prose::one_class(!tops && (bottoms || z_tops < z_bottoms)))
}

fn whole_silhouettes(f: &Findings) -> Option<Verdict> {
    let Evidence { z_whole, both_ends, .. } = *f.evidence;
    let seldom_shown = both_ends < MIN_BOTH_ENDS;
    unless(seldom_shown || reaches(z_whole, MIN_WHOLE_Z), Kind::Undetermined, || prose::torn(z_whole))
}

fn enough_places(f: &Findings) -> Option<Verdict> {
    let places = places(f.matches, PLACE * f.scale);
    unless(places >= MIN_PLACES, Kind::Undetermined, || prose::few_places(places))
}

fn does_not_repeat(f: &Findings) -> Option<Verdict> {
    let repeats = f.evidence.repeats;
    unless(!repeats.is_nan() && repeats < REPEATS, Kind::Ambiguous, || prose::repeats(repeats))
}

fn holds_throughout(f: &Findings) -> Option<Verdict> {
    let holds = f.evidence.holds;
    unless(reaches(holds, HOLDS), Kind::Knocked, || prose::knocked(holds))
}

fn same_in_both_halves(f: &Findings) -> Option<Verdict> {
    let apart = f.evidence.halves_apart;
    unless(within(apart, f.max_expected_error), Kind::Knocked, || prose::halves(apart))
}

fn depth_beyond_outlines(f: &Findings) -> Option<Verdict> {
    let clean = within(f.best_radius, CLEAN_RADIUS * f.scale);
    unless(clean || !is_flat(f), Kind::Undetermined, || prose::flat(f.evidence.plane_residual))
}

fn may_not_turn(f: &Findings) -> Option<Verdict> {
    let turned = f.evidence.may_turn;
    unless(within(turned, most_turned(f)), Kind::Undetermined, || prose::turns(turned))
}

fn known_beyond_motion(f: &Findings) -> Option<Verdict> {
    if f.beyond_motion.is_nan() {
        return Some(Verdict::new(Kind::Inaccurate, prose::unmeasured()));
    }
    let known = within(f.beyond_motion, most_beyond(f)) && within(f.possible_beyond, most_possible(f));
    unless(known, Kind::Undetermined, || prose::unknown_beyond(f.possible_beyond))
}

fn as_tested(f: &Findings) -> Option<Verdict> {
    let apart = f.evidence.tested_distance;
    // However strict the limit, what is so near is the same geometry: its distance is of the expected error.
    let same = f.max_expected_error.max(SAME * f.scale);
    unless(within(apart, same), Kind::Ambiguous, || prose::otherwise(apart))
}

fn no_rival(f: &Findings) -> Option<Verdict> {
    let as_likely = |r: &&Rival| r.is_undecided() || (!f.upright && !within(r.share, MIRROR_SHARE));
    let near = |r: &&Rival| within(r.distance, f.max_expected_error);
    let rival = f.rivals.iter().filter(as_likely).find(|r| !near(r))?;
    Some(Verdict::new(Kind::Ambiguous, prose::rival(rival)))
}

fn given_cameras_agree(f: &Findings) -> Option<Verdict> {
    let without = f.without_given_cameras.filter(contradict)?;
    Some(Verdict::new(Kind::Inaccurate, prose::contradicted(&without)))
}

fn of_two_cameras(f: &Findings) -> Option<Verdict> {
    unless(within(f.from_cameras, NO_CAMERAS), Kind::Inaccurate, || prose::no_cameras(f))
}

fn accurate(f: &Findings) -> Option<Verdict> {
    let (error, limit) = (f.expected_error, f.max_expected_error);
    unless(within(error, limit), Kind::Inaccurate, || prose::inaccurate(error, limit))
}

/// At how many different places tangents meet, in cells of both images together.
fn places(matches: &[TangentMatch], cell: f64) -> usize {
    let cells = |p: [f64; 2]| p.map(|v| (v / cell).round() as i64);
    matches.iter().map(|p| (cells(p.a), cells(p.b))).collect::<HashSet<_>>().len()
}

#[cfg(test)]
mod tests {
    use super::super::gains::Gain;
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

    /// Evidence without fault.
    const GOOD: Evidence = Evidence {
        z: 9.0,
        z_tops: 6.0,
        z_bottoms: 7.0,
        z_whole: 6.0,
        both_ends: 0.7,
        explained: 0.7,
        explained_tops: 0.6,
        explained_bottoms: 0.8,
        explained_by_chance: 0.2,
        tested_distance: 0.1,
        plane_residual: 4.0,
        spread_of_bottoms: 0.2,
        tops_off_floor: 2.0,
        may_turn: 0.0,
        holds: 0.9,
        halves_apart: 0.0,
        repeats: 0.1,
        on_all_frames: false,
        essential_deviation: f64::NAN,
    };

    /// A geometry without fault, whose parts a test spoils.
    fn findings<'a>(evidence: &'a Evidence, matches: &'a [TangentMatch]) -> Findings<'a> {
        Findings {
            evidence,
            matches,
            radius: 1.5,
            best_radius: 1.5,
            expected_error: 0.3,
            beyond_motion: 0.3,
            possible_beyond: 0.9,
            rivals: &[],
            scale: 1.0,
            upright: true,
            from_cameras: 0.001,
            without_given_cameras: None,
            max_expected_error: 3.0,
        }
    }

    #[test]
    fn the_first_fault_is_the_verdict() {
        let walk: Vec<_> = (0..90).map(|k| matched(k, [f64::from(k) * 9.0, 7.0], [9.0, 9.0])).collect();
        let kind = |findings: &Findings| decide(findings).kind;
        assert_eq!(kind(&findings(&GOOD, &walk)), Kind::Accepted);
        let reason = |evidence| decide(&findings(evidence, &walk)).reason;
        assert!(!reason(&GOOD).contains("half of an image"));
        assert!(reason(&Evidence { may_turn: 5.2, ..GOOD }).contains("in half of an image, beyond it, 5 px"));
        for (evidence, expected) in [
            (Evidence { z: 4.9, explained: 0.1, ..GOOD }, Kind::NoCommonScene),
            (Evidence { explained: 0.1, z_tops: 0.0, ..GOOD }, Kind::NoCommonScene),
            (Evidence { explained: f64::NAN, ..GOOD }, Kind::NoCommonScene),
            (Evidence { z_bottoms: 1.9, ..GOOD }, Kind::Undetermined),
            (Evidence { explained_tops: 0.01, ..GOOD }, Kind::Undetermined),
            (Evidence { z_whole: 0.4, ..GOOD }, Kind::Undetermined),
            (Evidence { may_turn: 6.1, ..GOOD }, Kind::Undetermined),
            (Evidence { repeats: 0.5, ..GOOD }, Kind::Ambiguous),
            (Evidence { holds: 0.29, ..GOOD }, Kind::Knocked),
            (Evidence { halves_apart: 3.1, ..GOOD }, Kind::Knocked),
            (Evidence { tested_distance: 3.1, ..GOOD }, Kind::Ambiguous),
            (Evidence { plane_residual: 0.5, ..GOOD }, Kind::Accepted),
        ] {
            assert_eq!(kind(&findings(&evidence, &walk)), expected, "{evidence:?}");
        }
        // Where the view ends before one end does, whole silhouettes are not asked for.
        let cut = Evidence { z_whole: 0.0, both_ends: 0.01, ..GOOD };
        assert_eq!(kind(&findings(&cut, &walk)), Kind::Accepted);
        assert_eq!(kind(&findings(&GOOD, &walk[..40])), Kind::Undetermined);
        assert_eq!(kind(&Findings { beyond_motion: 2.1, ..findings(&GOOD, &walk) }), Kind::Undetermined);
        assert_eq!(kind(&Findings { expected_error: 3.1, ..findings(&GOOD, &walk) }), Kind::Inaccurate);
        for (off, expected) in [(0.05, Kind::Accepted), (0.1, Kind::Inaccurate), (f64::NAN, Kind::Inaccurate)]
        {
            let found = decide(&Findings { from_cameras: off, ..findings(&GOOD, &walk) });
            assert_eq!(found.kind, expected, "{off}");
            assert!(found.reason.contains("No two cameras"), "{}", found.reason);
        }
        assert!(!reason(&GOOD).contains("No two cameras"));
        for (share, deviate, expected) in [(1.5, 9.0, Kind::Accepted), (1.7, 3.4, Kind::Inaccurate)] {
            let without_given_cameras = Some(Gain { share, deviate });
            let found = decide(&Findings { without_given_cameras, ..findings(&GOOD, &walk) });
            assert_eq!(found.kind, expected, "{share} {deviate}");
        }
        let shallow = Evidence { plane_residual: 1.5, ..GOOD };
        for (evidence, possible_beyond, expected) in [
            (&shallow, 3.9, Kind::Accepted),
            (&shallow, 4.1, Kind::Undetermined),
            (&GOOD, 5.9, Kind::Accepted),
            (&GOOD, 6.1, Kind::Undetermined),
        ] {
            assert_eq!(kind(&Findings { possible_beyond, ..findings(evidence, &walk) }), expected);
        }
        assert_eq!(
            kind(&Findings { best_radius: 3.0, beyond_motion: 1.9, ..findings(&GOOD, &walk) }),
            Kind::Accepted
        );
        // Where what moves fills a room nobody asks how the geometry goes on beyond, but for what the covariance says.
        let room = |plane_residual, may_turn, spread_of_bottoms, tops_off_floor| Evidence {
            plane_residual,
            spread_of_bottoms,
            tops_off_floor,
            may_turn,
            ..GOOD
        };
        for (evidence, expected) in [
            (room(0.5, 23.0, 0.8, 0.6), Kind::Accepted),
            (room(1.5, 23.0, 0.8, 0.6), Kind::Accepted),
            (room(4.0, 23.0, 0.8, 0.6), Kind::Accepted),
            (room(0.5, 23.0, 0.8, 0.45), Kind::Accepted),
            (room(0.5, 23.0, 0.7, 0.6), Kind::Undetermined),
            (room(0.5, 23.0, 0.8, 0.4), Kind::Undetermined),
            (room(0.5, 23.0, f64::NAN, 0.6), Kind::Undetermined),
            (room(0.5, f64::NAN, 0.8, 0.6), Kind::Undetermined),
        ] {
            let far = Findings { beyond_motion: 1.9, possible_beyond: 23.0, ..findings(&evidence, &walk) };
            assert_eq!(kind(&far), expected, "{evidence:?}");
            assert_eq!(kind(&Findings { beyond_motion: 2.1, ..far }), Kind::Undetermined);
        }
        // On an image of 160×120 two pixels are a quarter of eight, and not seen of outlines: with depth as much is allowed as where things moved.
        let turned = |plane_residual, may_turn| Evidence { plane_residual, may_turn, ..GOOD };
        for (evidence, possible_beyond, expected) in [
            (turned(4.0, 2.9), 2.9, Kind::Accepted),
            (turned(4.0, 3.1), 2.9, Kind::Undetermined),
            (turned(4.0, 2.9), 3.1, Kind::Undetermined),
            (turned(1.5, 1.4), 0.9, Kind::Accepted),
            (turned(1.5, 1.6), 0.9, Kind::Undetermined),
            (turned(1.5, 1.4), 1.1, Kind::Undetermined),
        ] {
            let small =
                Findings { scale: 0.25, beyond_motion: 0.1, possible_beyond, ..findings(&evidence, &walk) };
            assert_eq!(kind(&small), expected, "{evidence:?} {possible_beyond}");
        }
        // A strict limit makes no other geometry of one that is half a pixel off.
        let strict = |evidence| Findings { max_expected_error: 0.2, ..findings(evidence, &walk) };
        assert_eq!(kind(&strict(&Evidence { tested_distance: 0.4, ..GOOD })), Kind::Inaccurate);
        assert_eq!(kind(&strict(&Evidence { tested_distance: 0.6, ..GOOD })), Kind::Ambiguous);
        assert_eq!(kind(&Findings { expected_error: f64::NAN, ..findings(&GOOD, &walk) }), Kind::Inaccurate);
    }

    #[test]
    fn flat_motion_needs_clean_outlines_and_must_be_known_better_beyond_itself() {
        let walk: Vec<_> = (0..90).map(|k| matched(k, [f64::from(k) * 9.0, 7.0], [9.0, 9.0])).collect();
        let kind = |findings: &Findings| decide(findings).kind;
        let flat = Evidence { plane_residual: 0.5, ..GOOD };
        assert_eq!(kind(&Findings { best_radius: 3.0, ..findings(&flat, &walk) }), Kind::Undetermined);
        assert_eq!(kind(&Findings { beyond_motion: 0.4, ..findings(&flat, &walk) }), Kind::Undetermined);
        assert_eq!(kind(&Findings { possible_beyond: 2.1, ..findings(&flat, &walk) }), Kind::Undetermined);
        let of_size = |scale, beyond_motion| {
            let clean = Findings { best_radius: 1.5 * scale, possible_beyond: 0.5, ..findings(&flat, &walk) };
            kind(&Findings { beyond_motion, scale, ..clean })
        };
        assert_eq!([of_size(1.5, 0.49), of_size(1.5, 0.51)], [Kind::Accepted, Kind::Undetermined]);
        assert_eq!([of_size(0.5, 0.16), of_size(0.5, 0.18)], [Kind::Accepted, Kind::Undetermined]);
        let some_area = Evidence { spread_of_bottoms: 0.26, ..flat };
        for (evidence, possible_beyond, expected) in [
            (&some_area, 2.9, Kind::Accepted),
            (&some_area, 3.1, Kind::Undetermined),
            (&Evidence { spread_of_bottoms: 0.24, ..flat }, 2.9, Kind::Undetermined),
            (&Evidence { spread_of_bottoms: f64::NAN, ..flat }, 2.9, Kind::Undetermined),
            (&Evidence { may_turn: 3.6, ..some_area }, 2.9, Kind::Undetermined),
        ] {
            assert_eq!(kind(&Findings { possible_beyond, ..findings(evidence, &walk) }), expected);
        }
        let turned = Evidence { may_turn: 3.6, ..flat };
        assert_eq!(kind(&findings(&turned, &walk)), Kind::Undetermined);
        assert_eq!(kind(&findings(&Evidence { plane_residual: 4.0, ..turned }, &walk)), Kind::Accepted);
    }

    /// A geometry of what `rival` says, without any other fault.
    fn beside(rival: Rival) -> Kind {
        let walk: Vec<_> = (0..90).map(|k| matched(k, [f64::from(k) * 9.0, 7.0], [9.0, 9.0])).collect();
        decide(&Findings { rivals: &[rival], ..findings(&GOOD, &walk) }).kind
    }

    #[test]
    fn no_number_is_refused_by_every_test() {
        let walk: Vec<_> = (0..90).map(|k| matched(k, [f64::from(k) * 9.0, 7.0], [9.0, 9.0])).collect();
        let refused = |findings: &Findings| decide(findings).kind != Kind::Accepted;
        let unknown = f64::NAN;
        for evidence in [
            Evidence { z: unknown, ..GOOD },
            Evidence { z_tops: unknown, ..GOOD },
            Evidence { z_bottoms: unknown, ..GOOD },
            Evidence { z_whole: unknown, ..GOOD },
            Evidence { explained: unknown, ..GOOD },
            Evidence { explained_tops: unknown, ..GOOD },
            Evidence { explained_bottoms: unknown, ..GOOD },
            Evidence { tested_distance: unknown, ..GOOD },
            Evidence { may_turn: unknown, ..GOOD },
            Evidence { holds: unknown, ..GOOD },
            Evidence { halves_apart: unknown, ..GOOD },
            Evidence { repeats: unknown, ..GOOD },
        ] {
            assert!(refused(&findings(&evidence, &walk)), "{evidence:?}");
        }
        assert!(refused(&Findings { beyond_motion: unknown, ..findings(&GOOD, &walk) }));
        for plane_residual in [0.5, 1.5, 4.0, unknown] {
            let of_depth = Evidence { plane_residual, ..GOOD };
            assert!(refused(&Findings { possible_beyond: unknown, ..findings(&of_depth, &walk) }));
        }
        assert!(refused(&Findings { expected_error: unknown, ..findings(&GOOD, &walk) }));

        let matrix = nalgebra::Matrix3::new(0.0, 1.0, 2.0, -1.0, 0.0, 3.0, -2.0, -3.0, 0.0);
        let fundamental = crate::geometry::Fundamental::from_rank_two(&matrix).unwrap();
        let source = crate::hypotheses::Source::BestLines;
        let rival = |z, distance| Rival { fundamental, share: 0.9, z, distance, source };
        assert_eq!(beside(rival(3.0, 40.0)), Kind::Accepted);
        assert_eq!(beside(rival(1.0, 2.0)), Kind::Accepted);
        for (z, distance) in [(1.0, 40.0), (unknown, 40.0), (1.0, unknown), (1.0, f64::INFINITY)] {
            assert_eq!(beside(rival(z, distance)), Kind::Ambiguous, "{z} {distance}");
        }
    }
}
