//! The numbers that decide between accepted and refused, in one table.
//!
//! Each says what stood on either side of it; `docs/trust.md` says what it is for. Where families of situations are named,
//! they are those of `benchmarks/fresh.py --seeds 1-3`, whose report holds every number that is compared here. A comparison goes
//! through [`reaches`] or [`within`], which a number that is not one never passes.

/// Whether a number is at least so large; NaN is not.
pub fn reaches(value: f64, least: f64) -> bool {
    value >= least
}

/// Whether a number is at most so large; NaN is not.
pub fn within(value: f64, most: f64) -> bool {
    value <= most
}

/// The larger of two; what is not known is not small.
pub fn larger(p: f64, q: f64) -> f64 {
    if p.is_nan() || q.is_nan() { f64::NAN } else { p.max(q) }
}

/// The smaller of two; what is not known is not large.
pub fn smaller(p: f64, q: f64) -> f64 {
    if p.is_nan() || q.is_nan() { f64::NAN } else { p.min(q) }
}

/// Fewest common frames, and frames in which both cameras see a silhouette, that can be calibrated at all.
pub const MIN_FRAMES: usize = 16;
/// Fewest informative lines of a camera.
pub const MIN_LINES: usize = 2;
/// Fewest candidates that make a pencil.
pub const MIN_CANDIDATES: usize = 3;

/// Tangents are held against chance within at least this, pixels of a 640×480 image: what was fitted to other frames is off by more than a pixel on
/// those kept aside.
pub const LEAST_TESTED_RADIUS: f64 = 2.0;

/// Evidence below this normal deviate on frames kept aside is none. Unrelated pairs were never seen to reach 3, true ones of
/// 400 frames stood at 7 and more.
pub const MIN_Z: f64 = 5.0;
/// From this normal deviate on frames kept aside are followed by others where they do not decide. Pairs that have nothing in common stand
/// at -2 to 3, one in six of them above this; true ones of few frames or few movers at 1.2 to 4.9.
pub const FAINT_Z: f64 = 1.0;
/// From this normal deviate on something suggests a common scene, if not enough.
pub const SOME_Z: f64 = 2.0;
/// Below this share of the tangents that meet one of the other camera, an `F` is not the geometry of the scene.
pub const MIN_EXPLAINED: f64 = 0.15;
/// A class of tangents of which less than this share meets is not explained, however far it stands above chance: under a
/// wrong geometry that has the floor right 0.002 to 0.01 of the tops met, 0.22 to 0.8 under accepted ones.
pub const MIN_CLASS_EXPLAINED: f64 = 0.05;
/// A class of tangents below this normal deviate matches no better than chance.
pub const MIN_CLASS_Z: f64 = 2.0;
/// Whole silhouettes below this normal deviate meet no more often than by chance: 0 of a thousand under a floor with a wrong
/// epipole, where shifted clocks give as many; accepted ones stood at 3.7 to 32.
pub const MIN_WHOLE_Z: f64 = 2.0;
/// Where less than this share of the silhouettes that met shows both ends, whole ones say nothing.
pub const MIN_BOTH_ENDS: f64 = 0.05;
/// Below this on the frames kept aside tops, bottoms and whole silhouettes are judged on all frames.
pub const FAINT_CLASS_Z: f64 = 3.0;
/// Where four fifths of the matched points are farther than this from any plane, in widths of a silhouette, `F` has turned only where
/// it kept [`DEEP_TURNED_SHARE`]. One path, with strays or without, one plane, the bare floor and no baseline gave 0.06 to 0.32, and one path of
/// nearly a metre 0.95; later ones 2.1 to 3.1.
pub const DEPTH: f64 = 2.0;
/// Where four fifths of the matched points are nearer than this to a plane, in widths of a silhouette, little says what `F` is off it,
/// and more is asked of that: outlines must be clean, as what they are off alike in all frames may be all that leaves the plane
/// (ellipses at 0.41 gave 3.9 px where 2.7 are stated), and `F` must be known to [`FLAT_BEYOND`].
pub const FLAT: f64 = 0.9;
/// Half of an image may be known no worse than this where the motion is flat, pixels of a 640×480 image, by the covariance alone, which says too little
/// where all keep to one path: 0.4 where `F` was 4.3 px off over the room, 0.3 to 0.77 in ten of the other seventeen; 0.03 to 0.28 where it
/// was right.
pub const FLAT_BEYOND: f64 = 0.333;
/// Half of an image may be known no worse than this where the motion is flat and what outlines are off alike counts as well, pixels of a 640×480
/// image: of accepted pairs on one path, with strays or without, six had 2.1 to 3.0, four of which were off by 2 to 3.9 px over the room, and eight
/// 0.6 to 1.9, none of them by as much as 1 px; of right ones of families with an answer three of nine had more.
pub const FLAT_POSSIBLE: f64 = 2.0;
/// Where four fifths of the bottoms lie farther than this from any line, in widths of a silhouette, what moves has some area, though it does not fill a
/// room. Of 46 pairs on one path, with strays or without, 36 had less.
pub const SOME_AREA: f64 = 0.25;
/// Half of an image may be known no worse than this where flat motion has [`SOME_AREA`], in the sense of [`FLAT_POSSIBLE`]: of those on a path that
/// turn by no more than [`FLAT_TURN`] the first that is off over the room, by 6.1 px, had 4.3; right ones with an answer had 2.1 to 2.7, and one 3.8.
pub const SOME_AREA_POSSIBLE: f64 = 3.0;
/// Half of an image may be known no worse than this where the motion is not [`FLAT`] and has less than [`DEPTH`], in the sense of [`FLAT_POSSIBLE`]:
/// a pair on one path that was accepted 8.2 px off over the room had 5.4, another one 5.2, and one that was 6.5 px off 4.2; of 45 right ones with an
/// answer one had more, 6.3, and all others at most 4.4.
pub const SHALLOW_POSSIBLE: f64 = 4.0;
/// Half of an image may be known no worse than this at any depth, in the sense of [`FLAT_POSSIBLE`]: a crowd on one plane had 51, and walkers on a
/// path 28 and 12, off by 38, 5.1 and 8.3 px over the room; right ones with an answer had at most 5.6, and 7.6 once.
pub const DEEP_POSSIBLE: f64 = 6.0;
/// A geometry that has turned about the plane and kept this share of the evidence may be the truth as well, however certain the
/// difference is: what outlines have in common is the same in all frames. On a plane and without a baseline turned ones kept 0.988 to
/// 1.03 of it; where there is an answer those as far away at most 0.92, and 0.99 once.
pub const TURNED_SHARE: f64 = 0.95;
/// A geometry that has turned about the plane counts where the motion has [`DEPTH`] only if it kept this share of the evidence. What matches by
/// chance leaves any plane as well: in a crowd on one plane, three quarters of which met by chance, turned ones kept 1.06 to 1.27; walkers on a path
/// 0.96 to 1.00 as far as 8 px away, and right ones at most 0.988.
pub const DEEP_TURNED_SHARE: f64 = 0.99;
/// A geometry may have turned about the plane no farther than this, pixels of a 640×480 image, over the images. One plane, the bare floor and no baseline gave 10 to
/// 28; paths with and without strays where `F` was 4.9 and 23 px off over the room 6.03 and 6.9. Of right ones three stood between this and 8, at
/// 6.3 to 7.2, all others at 5.6 and less.
pub const MAX_TURN: f64 = 6.0;
/// A geometry may have turned about the plane no farther than this where the motion is flat, pixels of a 640×480 image: of pairs on one path that
/// were accepted five had turned by 1.9 to 5.7, four of them by 4.8 and more, and were off by 2 to 3.9 px over the room; right ones, with an answer
/// or on a path, by at most 3.1 but for one at 4.1.
pub const FLAT_TURN: f64 = 3.5;
/// What moves fills a room where four fifths of the bottoms lie farther than this from any line, in widths of a silhouette, in both images. One
/// path gave at most 0.47, with strays 0.64 where `F` was 8.7 px off over the room; pairs of families with an answer that were more than 3 px off over the
/// volume or the room 0.24, right ones that turn about a plane 0.66 to 3.6.
pub const ROOM_AREA: f64 = 0.75;
/// What moves fills a room where it has [`ROOM_AREA`] and the tops that do not meet by chance lie farther than this from the plane of the bottoms, in
/// widths of a silhouette: one plane and the bare floor gave at most 0.33, right ones that turn about a plane 0.49 to 4.
pub const ROOM_HEIGHT: f64 = 0.42;
/// Matched points at fewer different places say nothing: lamps that blink where they stand meet at the right moments under any
/// of many geometries. Such lamps were seen at 5 to 10 places, two walkers in 400 frames at 950.
pub const MIN_PLACES: usize = 50;
/// Size of a place, pixels of a 640×480 image.
pub const PLACE: f64 = 4.0;
/// Half of an image may be known no worse than this, pixels of a 640×480 image, by the covariance alone: of scenes with
/// depth it is 0.1 to 1.7, where all keep to one path 2.7 and more.
pub const MAX_BEYOND: f64 = 2.0;
/// A different geometry whose score differs by less than this many standard deviations may be the truth as well.
pub const RIVAL_Z: f64 = 2.5;
/// What matrices say for or against a rival counts for so many deviations at most: they are measured too.
pub const MOST_OF_CAMERAS: f64 = 3.0;
/// A geometry that has no more than this share of the evidence is not the truth, however few blocks of time there are to tell by. Where the truth itself
/// was found and lost, it had 0.75 of the evidence at the least.
pub const RIVAL_SHARE: f64 = 0.5;
/// Geometries that differ by less are one, pixels of a 640×480 image.
pub const SAME: f64 = 0.5;
/// Where nothing says which end of what moves is up, the mirror of the truth may have a higher score than the truth, which
/// was seen with this share of it.
pub const MIRROR_SHARE: f64 = 0.65;

/// What repeats itself with others in the places resembles its past at least so much in both cameras: columns and carousels by 0.47 to
/// 0.98, all else by at most 0.28.
pub const REPEATS: f64 = 0.4;
/// A geometry that holds throughout has at least this share of the evidence, in any part, that another one, fitted to that part, has
/// there. Where a camera was turned so far that either part was 2 px off or more, 0 to 0.43 was left; right ones that had less in a
/// part than elsewhere had 0.98 to 1.02 of the other's (`pets_cameras` and made-up ones). Fresh ones that were 8 px off had up to 0.45.
pub const HOLDS: f64 = 0.5;
/// Whether a geometry holds throughout is not asked where the evidence on the better side of a moment is less than this many tangents.
pub const HOLDS_CLEAR: f64 = 60.0;
/// Whether a geometry holds throughout is not asked where on one side of a moment less than this share is seen of what is seen on the other.
pub const HOLDS_SHOWS: f64 = 0.2;
/// A geometry holds throughout where one side of a moment has at least this share of the evidence of the other, by what could meet.
pub const HOLDS_LESS: f64 = 0.65;
/// A geometry holds throughout where the evidence on both sides of a moment is nearer than so many standard errors by the parts they are made of. A
/// scene of four seconds had 0.23 in its last by chance, at 2.3; cameras that were moved stood at 2.4 to 36.
pub const HOLDS_DIFFERS: f64 = 2.4;
/// Another geometry explains a part where it has this share of the evidence that the better side has, by what could meet: 0.47 to 2.2 of it
/// where a camera was turned, 0.22 where nothing was and hardly anything met, so that what was found is chance.
pub const HOLDS_OTHER: f64 = 0.4;
/// Where no other geometry explains a part, the camera may have been turned too far: less than this share of the evidence is left then.
pub const HOLDS_NOTHING: f64 = 0.1;
/// A camera is said to have been turned too far only where both see at least this share of what they see on the other side, by time: otherwise people have gone
/// where one of them alone looks.
pub const HOLDS_AS_MUCH: f64 = 0.65;

/// Half of a recording asks for a geometry of its own where that of all frames has less than this share of its evidence there. Right
/// ones had 0.96 to 1.03 (four real recordings, 25 made-up families), and 0.82 once; of cameras that were moved by 4 to 15 px
/// at half time the worse half had 0.5 to 0.86.
pub const HALF_SHARE: f64 = 0.93;
/// Half of a recording asks for a geometry of its own only where that gains by so many standard errors, over blocks of the half: right ones 2.3 at
/// most, and 1.4 where they had 0.82; those of moved cameras 4.4 and more.
pub const HALF_DIFFERS: f64 = 3.3;

/// Without camera matrices a geometry that is so far from any two cameras with square pixels and principal points in the middle
/// ([`least_deviation`](crate::geometry::possible_cameras::least_deviation)) is refused: 0.10 to 0.43 where one camera saw walkers without legs, with a shadow towards it, or heads alone; at most 0.015 of 24 right pairs.
/// Of 65 pairs of real cameras at most 0.080, of some whose principal points are 30 % of the image aside, and 0.024 of all but six.
pub const NO_CAMERAS: f64 = 0.09;
/// From here on it is said: 0.029 to 0.073 where one camera did not see the lower 25 cm of walkers.
pub const CAMERAS_DOUBTED: f64 = 0.02;
/// Pixels of a 640×480 image that a geometry is off for each unit of this deviation: 62 to 153 where one camera did not see the lower 10 or 25 cm of walkers, 76 to 138 of four
/// right pairs of ordinary made-up situations. Real principal points are not in the middle, so that less is taken for error: of 28 right pairs of `pets_cameras` it refuses one.
pub const CAMERAS_ERROR: f64 = 30.0;
/// Pixels for each unit of this deviation where principal points are known.
pub const CAMERAS_ERROR_GIVEN: f64 = 60.0;
/// So many of its own standard errors are chance: what is known of a geometry badly is far from any two cameras though the truth is not.
pub const CAMERAS_CHANCE: f64 = 2.0;

/// Camera matrices contradict what moves where without them so many times as much is explained: 1.9 to 3.2 where one camera did not see the feet of walkers, or matrices were those of images
/// of another size; at most 1.006 of 28 pairs of `pets_cameras`, and 1.3 of one pair of `wildtrack`, whose people are ellipses.
pub const CONTRADICTED_SHARE: f64 = 1.6;
/// And that is so many standard errors more, over blocks of frames: 4.9 to 7.8, and at most 3.4.
pub const CONTRADICTED_GAIN: f64 = 3.3;

/// Another clock may be the truth as well where a geometry of its own, further away than may be expected, keeps this share of the evidence: 0.86 to 1.5 where all
/// walked or drove one way at one speed, to within 5 %, at most 0.42 in fourteen pairs of seven families with an answer (seeds 51 and 52).
pub const CLOCK_SHARE: f64 = 0.85;
/// Another clock is the better one where a geometry of its own has so many times the evidence, and is tried: 3.9 times at the true one, where walkers one way were
/// taken to be filmed at once.
pub const CLOCK_BETTER: f64 = 1.1;
/// A clock that was given is spoken against where another one's geometry, whole frames away, gains by so many standard errors over blocks of frames: of walkers one way at
/// one speed 3.3 to 8.8 where an offset was given 0.2 to 0.3 s wrong and their speeds differ by 5 to 10 %, at most 2.5 where it was right.
pub const CLOCK_GAIN: f64 = 3.3;
/// Clocks still further away are not asked where less than this share of the evidence is left. Silhouettes that are drawn between frames meet less exactly:
/// of cars at one speed 0.7 was left between two frames, under both of which all was. Of walkers at one speed 0.17 was left half a stride away, where legs stand the
/// other way, and 1.65 a whole one away, at the true clock.
pub const CLOCK_LOST: f64 = 0.1;

/// Shifts of the clocks that say what is chance.
pub const SHIFTS: usize = 60;
/// Fewest shifts from which a deviation is taken.
pub const MIN_SHIFTS: usize = 8;
/// The floor of the deviation over shifts is that of a handful of counts: a curve without any chance matches is no proof.
pub const MIN_DEVIATION: f64 = 3.0;
/// Below this normal deviate of a geometry its silhouettes say nothing of the clock.
pub const MIN_Z_FOR_CLOCK: f64 = 4.0;

/// Score of a tangent in a brief search with which an offset needs no comparison: at true ones 0.13 to 2.3, at others 0.38 at most.
pub const SURE: f64 = 0.8;
/// Among a few offsets one stands out with such a score of which the next best has no more than such a share.
pub const STANDS_OUT: [f64; 2] = [0.25, 0.4];
/// Among all that may be it.
pub const STANDS_OUT_OF_ALL: [f64; 2] = [0.08, 0.65];

/// Fewest matched points of which a plane or a covariance is told.
pub const MIN_POINTS: usize = 20;
/// Fewest blocks of frames that give a covariance: seven parameters are fitted.
pub const MIN_BLOCKS: usize = 8;
/// Fewest blocks of frames over which two geometries are compared; with less neither is behind.
pub const MIN_COMPARED: usize = 4;

/// The least radius at which tangents are weighed, pixels of a 640×480 image: that of clean outlines.
pub const CLEAN_RADIUS: f64 = 1.5;
/// Share of what is more that counts as a systematic error.
pub const COARSE_SHARE: f64 = 1.0;
/// What outlines are off alike is not seen as scatter; it counts as much as they scatter, and from this deviation on, pixels of a 640×480 image, as
/// its square over it: residuals of several pixels are outlines of different shape. Of 90 right development pairs (`benchmarks/fresh.py
/// --families answer --seeds 7001-7006 --pairs 1`) the error was below what is stated in 93 % and below twice of it in all; with 0.7 of the scatter in 84 %.
pub const ROUGH_DEVIATION: f64 = 1.2;
/// Silhouettes stand for something else, as those of detectors do, where more than this share of them are upright boxes or ellipses: 0.55 to 0.98 of boxes and
/// ellipses, some of which merge, at most 0.07 of all else but discs, which do not count (`situation(31)` to `33` of seven families). Being convex is
/// not enough: right pairs of thrown things and cars, 0.06 and 0.3 px off, would state 4.1 and 3.6.
pub const STAND_INS: f64 = 0.4;
/// Such silhouettes are off alike by so much of their width, as people in one part of the room all are: on `wildtrack`, ellipses in boxes that were drawn by
/// hand, the error of 12 of 14 pairs is below what is stated, and without this it was of two.
pub const STANDS_IN: f64 = 0.03;
/// Error that rasterisation leaves even in exact masks, pixels of a 640×480 image.
pub const GRID_ERROR: f64 = 0.06;
/// Less than this is not believed of the share that is explained by more than chance.
pub const LEAST_EXPLAINED: f64 = 0.02;
/// A rival near the winner with this share of its evidence may be the truth, however certain the difference is: what is off
/// alike in all frames decides between neighbours.
pub const NEIGHBOUR_SHARE: f64 = 0.93;
/// A rival nearer than this is a neighbour, pixels of a 640×480 image.
pub const NEIGHBOUR: f64 = 6.0;
/// The covariance knows the noise of the outlines but not what all of them share.
pub const FIT_FACTOR: f64 = 4.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_passes_nothing() {
        assert!(reaches(5.0, MIN_Z) && !reaches(4.9, MIN_Z) && !reaches(f64::NAN, MIN_Z));
        assert!(within(3.0, 3.0) && !within(3.1, 3.0) && !within(f64::NAN, 3.0));
        assert!(larger(1.0, 2.0) == 2.0 && larger(f64::NAN, 2.0).is_nan() && larger(1.0, f64::NAN).is_nan());
    }
}
