//! What decides about a network: every number, and where it comes from.

/// Normal deviate that the tangents of an accepted camera have on moments kept aside: by chance once in three million.
pub const CAMERA_DEVIATES: f64 = 5.0;
/// The same of whole silhouettes, which floors without walkers cannot have.
pub const WHOLE_DEVIATES: f64 = 3.0;
/// Whole silhouettes of a camera that meet beyond chance, of those that could in its pairs; or the evidence of a tangent. What is far
/// from chance may still explain next to nothing: a camera 16° off, put there by a pair that saw other people, had 0.008 and
/// 0.07; right ones 0.06 to 0.7 of silhouettes, but one of `wildtrack`, which cuts nearly all of them, 0.01 and 0.14.
pub const CAMERA_WHOLE: f64 = 0.02;
/// The same of the evidence of a tangent.
pub const CAMERA_EVIDENCE: f64 = 0.1;
/// The same of the tangents of a pair that confirms a network.
pub const PAIR_DEVIATES: f64 = 3.0;
/// Pairs that must confirm a camera among more than two: two directions are needed for its place.
pub const CONFIRMED_PAIRS: usize = 2;
/// Expected errors, nine times in ten below, that are still of use: of the focal length, relative.
pub const MAX_FOCAL: f64 = 0.08;
/// Of the rotation, radians: 2°.
pub const MAX_ROTATION: f64 = 2.0 * std::f64::consts::PI / 180.0;
/// Of the position, as a share of the largest distance between two cameras.
pub const MAX_POSITION: f64 = 0.05;
/// A network whose cameras are turned by more than this against one another is another geometry, radians: 3°.
pub const RIVAL_TURN: f64 = 3.0 * std::f64::consts::PI / 180.0;
/// It is a rival with less than this share less evidence.
pub const RIVAL_SHARE: f64 = 0.1;
/// And where it is not worse by so many standard deviations over parts of the recording.
pub const RIVAL_DEVIATES: f64 = 3.0;
/// A tangent that a pair found agrees with the network below this residual, pixels of a 640×480 image.
pub const AGREE: f64 = 4.0;
/// A pair contradicts the network where less than this share of what it found agrees.
pub const CONTRADICTS: f64 = 0.3;
/// Silhouettes that fill their hulls to more than this share may be boxes or ellipses that stand for something else.
pub const CONVEX: f64 = 0.96;
/// By how many pixels the outlines of one camera may all be wrong alike in one part of the image, at least.
pub const OUTLINE_ERROR: f64 = 0.06;
/// Scatter of tangents of perfect masks, pixels: those of the grid, of two images.
pub const PIXELS: f64 = 0.5;
/// The share of the scatter that is common to the outlines of one camera in one part of the image: of what pixels do by
/// themselves, and of what is more than that.
pub const OUTLINE_SHARE: [f64; 2] = [0.5, 0.9];
/// The same as a multiple of the scatter where outlines are wrong in the same way everywhere.
pub const OUTLINE_STRAINED: f64 = 4.0;
/// The share of it that is another one after a move, when a camera sees the same outlines elsewhere in its image. Of 22 moves of
/// development the error of 19 is below what is stated; with all of it what is stated is some ten times the error, and without any the
/// error was below in 4 of 6.
pub const OUTLINE_MOVED: f64 = 0.25;
/// Standard deviation of clocks' offsets where barcodes found that all started together, seconds.
pub const CLOCK_TOGETHER: f64 = 0.02;
/// The same where barcodes found the offsets, to a frame or two.
pub const CLOCK_FOUND: f64 = 0.1;
/// Standard deviation of clocks' drifts, ppm: quartz.
pub const DRIFT: f64 = 30.0;
/// A camera has moved where it now looks another way, or stands elsewhere, by so many times what is below nine times in ten.
pub const MOVED: f64 = 2.0;
/// And where what it sees agrees better with that, by so many standard deviations over parts of the footage.
pub const MOVED_DEVIATES: f64 = 4.0;
/// The same of a move that only the end of the footage shows, which is asked for besides.
pub const MOVED_WITHIN_DEVIATES: f64 = 6.0;
/// A camera may have been turned far while it was filmed where less than this share of its evidence is left at the end.
pub const FADES: f64 = 0.6;
/// One camera is named, and not another, where by so many standard deviations over parts of the footage more speaks for it. On
/// development seeds those that did not move were ruled out by 6 or more, but for moves of about a pixel, by 2.
pub const RULED_OUT: f64 = 5.0;
/// And by at least this share of what its move explains: of two that explain nearly the same, either may have moved. Those that did
/// not move explained 20 % less or worse.
pub const RULED_OUT_SHARE: f64 = 0.15;
/// Or where the other would have spoiled pairs that stand by this share of it: 5 to 17 %.
pub const SPOILED_SHARE: f64 = 0.05;
/// A focal length changed where it explains more than a pose does, by so many standard deviations over parts of the footage.
pub const ZOOMED_DEVIATES: f64 = 4.0;
/// And, where a pose has changed too, by at least this share of all that is explained: seven numbers always explain more than six.
pub const ZOOMED_SHARE: f64 = 0.1;
/// A place leaves something over where a pair by itself agrees better with another one by this share of its evidence: of true places
/// below 0.02.
pub const LEFT_OVER: f64 = 0.05;
/// A camera that stands still has at least this share of its evidence, by what could meet, on either side of any moment.
pub const KNOCKED_KEEPS: f64 = 0.35;
/// And at least this share of what pairs keep that it has no part in.
pub const KNOCKED_OF_OTHERS: f64 = 0.45;
/// Nothing is said of a knock where those pairs keep less than this share.
pub const OTHERS_KEEP: f64 = 0.4;
/// Nor where its evidence on the better side is less than this many tangents.
pub const KNOCKED_CLEAR: f64 = 60.0;
/// Nor where on one side it sees less than this share of what it sees on the other.
pub const KNOCKED_SHOWS: f64 = 0.2;
