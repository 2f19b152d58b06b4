//! What decides about a network: every number, and where it comes from.
//!
//! In the order in which they are asked. `docs/trust.md` says what each is for; where a number was measured, what stood on either
//! side of it is said here, and `benchmarks/README.md` names the command. The others are choices, and give their reason. How a solver
//! walks (steps, starts, radii) stands with the solver.

// --- the clocks ---

/// Two offsets agree within so many seconds: barcodes tell one to a frame or two, 0.1 s, and three of them close a triangle.
pub const OFFSETS_AGREE: f64 = 0.3;
/// An offset below this, seconds, is none: that frame or two.
pub const NO_OFFSET: f64 = 0.15;
/// Without an offset barcodes agree as well with this share of the score of the best offset: that is a maximum over all
/// offsets, and so a little above what is the truth by itself.
pub const NO_OFFSET_SHARE: f64 = 0.97;
/// Share of the pairs that must have no offset for all cameras to have started together; of the others some are wrong.
pub const NO_OFFSET_PAIRS: f64 = 0.6;

/// What moves leaves a clock open where another one has a geometry of its own that is further away than so many pixels of a 640×480 image, and explains as
/// much ([`CLOCK_SHARE`](crate::verify::thresholds::CLOCK_SHARE)), and speaks against one that was given where it explains more ([`CLOCK_BETTER`](crate::verify::thresholds::CLOCK_BETTER)).
pub const CLOCK_OPEN: f64 = 3.0;

// --- who enters ---

/// Relative standard deviation below which a focal length that is given is known; two known ones make a network of two cameras.
pub const KNOWN_FOCAL: f64 = 0.05;
/// Fewer tangents that meet say nothing of a pair, whose geometry has seven numbers.
pub const LEAST_MEETINGS: usize = 20;
/// A tangent of a pair agrees with a start below this residual, pixels.
pub const START_AGREES: f64 = 3.0;
/// Share of a pair's tangents that must agree with a camera for it to enter; what is wrong there is tried elsewhere later.
pub const ENTERS: f64 = 0.4;
/// A camera is tried elsewhere where less than this share of its pairs' tangents agree.
pub const TRIED_ELSEWHERE: f64 = 0.6;
/// Another place of it is better with so many times the evidence, so that the same place from another start is not.
pub const ELSEWHERE_BETTER: f64 = 1.03;
/// Radius at which networks are compared, pixels of a 640×480 image: four times a scatter of 0.75.
pub const COMPARED: f64 = 3.0;

// --- principal points ---

/// A belief in how far principal points are from the middle that is less likely than this counts for nothing in stated errors.
pub const PRINCIPAL_LEAST_LIKELY: f64 = 0.01;
/// Principal points that are believed in are under strain where the tangents would pay so many nats more for others than the wider
/// belief costs by itself.
pub const PRINCIPAL_NATS: f64 = 6.0;
/// Standard deviation of principal points, widths of the image, with which it is asked whether those believed in are under strain:
/// that of images that were cropped.
pub const PRINCIPAL_STRAINED: f64 = 0.04;

/// Normal deviate from which on another number contradicts the one that is given. Of true ones of four made-up and three real networks
/// another explained more in ellipses alone, by 3.0 at most; 5 % off of the one camera focal lengths had 2.7 to 18.
pub const CONTRADICTED_DEVIATES: f64 = 4.0;
/// Logarithm of the Bayes factor of another number in one camera, of masks, from which on that contradicts the one that is given: of true
/// numbers of eight made-up and two real networks 9.1 in one and at most 1.4 in the others, of principal points 3 % of the width aside 17
/// to 640 in eight of eleven, 3.9 in one, and nothing in two.
pub const CONTRADICTED_NATS: f64 = 12.0;
/// How likely it is before anything is seen that a kind of number that is given of a camera is wrong: of another zoom, of other pixels, of
/// an image that was cropped. A choice.
pub const GIVEN_WRONG: f64 = 0.05;
/// How likely a number that is given must be wrong for the reason to say so.
pub const DOUBT_SAID: f64 = 0.25;
/// Standard deviation of the fy / fx that fits, beside what is stated: outlines of one camera that are all a little too tall look like it.
/// True ones of ten made-up networks were within 2.5 of what is stated but for one, 0.9 % off where 0.2 % is; 2 to 3 % are looked for.
pub const ASPECT_ALIKE: f64 = 0.0025;

// --- what speaks for a camera ---

/// Stretches of time, every third of which is kept aside.
pub const STRETCHES: usize = 15;
/// Shifts of the clocks that stand for chance: a Student's t of 19 degrees of freedom.
pub const SHIFTS: usize = 20;
/// Normal deviate that the tangents of an accepted camera have on moments kept aside: by chance once in three million.
pub const CAMERA_DEVIATES: f64 = 5.0;
/// Normal deviate that its whole silhouettes have there, which floors without walkers cannot have.
pub const WHOLE_DEVIATES: f64 = 3.0;
/// Whole silhouettes of a camera that meet beyond chance, of those that could in its pairs; or the evidence of a tangent. What is far
/// from chance may still explain next to nothing: a camera 16° off, put there by a pair that saw other people, had 0.008 and
/// 0.07; right ones 0.06 to 0.7 of silhouettes, but one of `wildtrack`, which cuts nearly all of them, 0.01 and 0.14.
pub const CAMERA_WHOLE: f64 = 0.02;
/// Excess of a tangent of a camera over chance, below which, with fewer whole silhouettes than those, next to nothing is explained.
pub const CAMERA_EXCESS: f64 = 0.1;
/// Normal deviate that the tangents of a pair have that confirms a network.
pub const PAIR_DEVIATES: f64 = 3.0;
/// Pairs that must confirm a camera among more than two: two directions are needed for its place.
pub const CONFIRMED_PAIRS: usize = 2;

/// Of what meets in a pair this share is before both cameras: up to 0.36 where five cameras stood wrongly before one plane, 0.98
/// and more where they stood right (ten networks of development).
pub const BEFORE: f64 = 0.5;
/// What a pair sees keeps to a plane from which four fifths of it are nearer than this share of how far half is from the middle. What most pairs of
/// things in one plane see had 0.04 to 0.12, and of crowds 0.27 at least (six networks of development).
pub const PLANAR: f64 = 0.2;
/// A pair sees another plane than others do where it is further from theirs than this share: 0.53 to 0.97 where cameras stood wrongly, 0.03 to 0.14
/// where they stood right.
pub const PLANES_APART: f64 = 0.3;
/// And turned from it by more than this, radians: 20°. Levels of a building are not.
pub const PLANES_TURNED: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// And so many times as far as from its own: 3.2 to 12 where cameras stood wrongly, 0.9 to 1.3 where they stood right.
pub const PLANES_DIFFER: f64 = 2.5;
/// Two cameras were put at one place by a solution where their rays meet nearer to them than this share of how far away those of other pairs do. It
/// was below 1e-6 where one did, on scenes in one plane; of two heads on one pole that look different ways, and meet by chance, 0.015.
pub const COLLAPSED: f64 = 1e-3;

// --- errors and rivals ---

/// The largest expected error, nine times in ten below, with which a focal length is still of use, relative.
pub const MAX_FOCAL: f64 = 0.08;
/// The largest expected error with which a rotation is still of use, radians: 2°.
pub const MAX_ROTATION: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// The largest expected error with which a position is still of use, as a share of the largest distance between two cameras.
pub const MAX_POSITION: f64 = 0.05;
/// Rays of a camera and of others, in the pair in which that is most, meet at so many pixels of a 640×480 image at least. Outlines are wrong alike by
/// 0.25 to 0.5 pixels, so below this a position would not be known to [`MAX_POSITION`].
pub const PARALLAX: f64 = 8.0;
/// What is seen by cameras of unknown focal lengths is further from one plane than so many pixels of a 640×480 image: 4 to 6 of things a few
/// centimetres high on a floor, of which focal lengths came out 1 to 7 % off where 1 to 2 % was stated, 50 and more of crowds (two and six networks of
/// development); a narrow path is a plane as well.
pub const RELIEF: f64 = 8.0;
/// A plane that so many cameras of known focal lengths see tells those of the others.
pub const FOCALS_TELL: usize = 2;
/// A network whose cameras are turned by more than this against one another is another geometry, radians: 3°.
pub const RIVAL_TURN: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// Another geometry is a rival with less than this share less evidence.
pub const RIVAL_LESS: f64 = 0.1;
/// Another geometry is a rival only where it is not worse by so many standard deviations over parts of the recording.
pub const RIVAL_DEVIATES: f64 = 3.0;
/// A tangent that a pair found agrees with the network below this residual, pixels of a 640×480 image.
pub const AGREE: f64 = 4.0;
/// A baseline is at least so many times as long as the error of where its cameras stand, or its direction is not known to 20°. That of one film by two names was 0.08 times
/// as long.
pub const BASELINE: f64 = 3.0;
/// A pair contradicts the network where less than this share of what it found agrees.
pub const CONTRADICTS: f64 = 0.3;

/// Another place of a camera that is added is solved for with all it sees where it has this share of the evidence of the best one on a few
/// frames, on which evidence is known to a third or so.
pub const ADDED_RIVAL: f64 = 0.5;

// --- outlines and clocks as errors count them ---

/// Silhouettes that fill their hulls to more than this share are convex: outlines of people and animals are not.
pub const CONVEX: f64 = 0.96;
/// By how many pixels the outlines of one camera may all be wrong alike in one part of the image, at least.
pub const OUTLINE_ERROR: f64 = 0.06;
/// Scatter of tangents of perfect masks, pixels: those of the grid, of two images.
pub const PIXELS: f64 = 0.5;
/// The share of the scatter that is common to the outlines of one camera in one part of the image: of what pixels do by
/// themselves, and of what is more than that.
pub const OUTLINE_SHARE: [f64; 2] = [0.5, 0.9];
/// What is common to shapes without a gap between them and their hulls, as a multiple of what they scatter by more than pixels do: ellipses
/// in the boxes of a detector are wrong by what they stand for, and people in one part of the room all alike.
pub const OUTLINE_COARSE: f64 = 2.5;
/// What is common to shapes without such a gap as a multiple of the scatter, where outlines are wrong in the same way everywhere.
pub const OUTLINE_STRAINED: f64 = 4.0;
/// The share of what is common to outlines that is another one after a move, when a camera sees the same outlines elsewhere in its image.
/// Of 23 moves of development the error of 20 is below what is stated; with all of it what is stated is some ten times the error, and
/// without any the error was below in 4 of 6.
pub const OUTLINE_MOVED: f64 = 0.25;
/// Standard deviation of by how much more the hulls of silhouettes half as large as usual lie inside of the true outlines, in so many times what outlines
/// of the camera are wrong by alike. Ragged and filtered masks of people of 50 pixels leave out up to 1.4 pixels on some sides, and half of that of people
/// of 100 pixels (two networks of development); twelve are as good with 3.
pub const UNEVEN_BY_SIZE: f64 = 2.0;
/// Standard deviation of by how much more that is on one side, likewise: up to a pixel between feet and heads there. With 2 the same twelve are worse, and without
/// sides their focal lengths by a third.
pub const UNEVEN_BY_SIDE: f64 = 1.0;
/// Standard deviation of clocks' offsets where barcodes found that all started together, seconds.
pub const CLOCK_TOGETHER: f64 = 0.02;
/// Standard deviation of offsets that barcodes found to a frame or two, seconds.
pub const CLOCK_FOUND: f64 = 0.1;
/// Standard deviation of clocks' drifts, ppm: quartz.
pub const DRIFT: f64 = 30.0;

// --- has a camera moved? ---

/// Standard deviation of offsets that new footage has, beside what scatters, as a share of the time between two frames, where nothing but
/// their pull to whole frames tells of them: that of anything that is rounded to whole frames is 0.29.
pub const OFFSET_OF_FRAMES: f64 = 0.3;
/// That pull as a share of what tells of an offset of cameras that are known. What is left where they follow the offset is 0.005 to 0.05 of
/// people who walk one way, whose offsets are 0.1 to 0.6 frames off, and 0.93 to 0.99 of people who walk as they like, on development
/// scenes.
pub const PULLED_TO_FRAMES: f64 = 0.1;
/// Nine in ten cameras that stand seem to have moved by no more than so many times what new footage scatters and stored poses scatter with
/// it, for lenses and other cameras are stored as they were found, too. Of 72 cameras that stood, on development networks, nine in ten turns
/// were within 1.33 of it, shifts within 1.43, and focal lengths within 1.27; of 96 others within 1.40, 1.32 and 1.25.
pub const STORED_WRONG: f64 = 1.4;
/// A camera has moved where it now looks another way, or stands elsewhere, by so many times what scatters, nine times in ten.
pub const MOVED: f64 = 2.0;
/// A camera that does not clearly move is not said to stand where it agrees best so many times what scatters away, nine times in ten. Of 192
/// cameras that stood, of development networks and others, 5.2 at most; one that was shifted by 5 cm and seen for an eighth of the time had 7.3.
pub const SEEMS_MOVED: f64 = 6.0;
/// A move after this share of the footage is one that was filmed: from the fourth of 48 parts on.
pub const MOVED_LATER: f64 = 0.05;
/// A camera has moved only where what it sees agrees better with that, by so many standard deviations over parts of the footage.
pub const MOVED_DEVIATES: f64 = 4.0;
/// Standard deviations that a move asks for which only the end of the footage shows, as that is asked for besides.
pub const MOVED_WITHIN_DEVIATES: f64 = 6.0;
/// A camera may have been turned far while it was filmed where less than this share of its evidence is left at the end.
pub const FADES: f64 = 0.6;
/// One camera is named, and not another, where by so many standard deviations over parts of the footage more speaks for it. On
/// development seeds those that did not move were ruled out by 6 or more, but for moves of about a pixel, by 2.
pub const RULED_OUT: f64 = 5.0;
/// One camera is named, and not another, only where by at least this share of what its move explains more speaks for it: of two that
/// explain nearly the same, either may have moved. Those that did not move explained 20 % less or worse.
pub const RULED_OUT_SHARE: f64 = 0.15;
/// One camera is named as well where a move of the other would have spoiled pairs that stand, by this share of what it explains: 5 to 17 %.
pub const SPOILED_SHARE: f64 = 0.05;
/// A focal length changed where it explains more than a pose does, by so many standard deviations over parts of the footage.
pub const ZOOMED_DEVIATES: f64 = 4.0;
/// A focal length changed, where a pose has too, only if it explains at least this share of all that is explained: seven numbers always
/// explain more than six.
pub const ZOOMED_SHARE: f64 = 0.1;
/// A place leaves something over where a pair by itself agrees better with another one by this share of its evidence: of true places
/// below 0.02.
pub const LEFT_OVER: f64 = 0.05;

// --- was a camera knocked while it was filmed? ---

pub use crate::verify::thresholds::{HOLDS_CLEAR as KNOCKED_CLEAR, HOLDS_SHOWS as KNOCKED_SHOWS};
/// A camera that stands still has at least this share of its evidence, by what could meet, on either side of any moment; and at least
/// that share of what pairs keep that it has no part in.
pub const KNOCKED: [f64; 2] = [0.35, 0.45];
/// With less than these a camera may have been knocked by a little: 0.58 and 0.59 was seen of one that stood (of 23), 0.36 to 0.50 of those that
/// were turned by 1° and 1.5°.
pub const KNOCKED_MAYBE: [f64; 2] = [0.65, 0.7];
/// A camera may have been knocked by a little where a turn between the halves moves its image by more than so many pixels, with so many
/// standard deviations: 0.07 and 4.4 was the most of 23 that stood, 0.7 and 13.7 the least of two that were turned by half a degree.
pub const TURNED: (f64, f64) = (0.3, 8.0);
/// A camera that may have been knocked by a little was if another pose explains one side so much better that as it stands it has less than
/// this share of the evidence there.
pub const KNOCKED_OTHER: f64 = 0.75;
/// Nothing is said of a knock where the pairs that the camera has no part in keep less than this share.
pub const OTHERS_KEEP: f64 = 0.4;

// --- the floor ---

/// Fewest figures that tell a floor.
pub const FLOOR_FIGURES: usize = 30;
/// A bottom is on a floor within this share of the median height: 0.14 m of 1.75.
pub const ON_FLOOR: f64 = 0.08;
/// Bottoms further off one plane than this share of the height do not stand on a floor.
pub const FLOOR_UNEVEN: f64 = 0.12;
/// A floor whose normal is further from the mean of the segments than this, radians, is a wall, or none: 34°.
pub const FLOOR_LEANING: f64 = 0.6;
/// Standard deviation of how far the bottoms that are touched lie above the floor, as a share of the height: 2 cm. On 33 made-up networks of
/// development with the geometry of their pairs given, floors were 0.1 to 4 cm off, and 6 to 18 cm where cameras were turned too.
pub const FOOT_ABOVE: f64 = 0.012;
/// Standard deviation of how much more that is one standard deviation of the bottoms further on: the vertical of 16 made-up networks of
/// development, by which it was chosen, was 0.02 to 0.6 degrees off, and below 1.645 times what is stated with this in all.
pub const FOOT_LEANING: f64 = 0.0015;
/// So much more is added where the bottoms are nearer than [`STANCE`] to one line: on one path verticals were 0.4 to 4.2 degrees off, in two of four networks
/// of development by more than 1.645 times what is stated without it.
pub const FOOT_ASIDE: f64 = 0.003;
/// How far from the middle of a path feet are that are set beside each other, as a share of the height.
pub const STANCE: f64 = 0.15;
