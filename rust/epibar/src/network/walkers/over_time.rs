//! Over time: which walker of one moment is which of the next.
//!
//! A track goes on where it is expected to, as tall as before, and best where some camera has followed its silhouette. Where two tracks could
//! go on as the same walker neither does: a gap does less harm than a swap.

use nalgebra::Vector3;

use super::over_cameras::Group;
use crate::network::observations::observed::Observed;

/// A track that is not seen for so many seconds has ended.
const GAP: f64 = 0.8;
/// How far a top may be from where it is expected, in median heights: at once, and by each second since.
const REACH: [f64; 2] = [0.12, 0.7];
/// By so many standard deviations of where its cameras have it a top may be off besides.
const DEVIATIONS: f64 = 2.0;
/// What a silhouette that a camera has followed is worth, in reaches.
const FOLLOWED: f64 = 0.5;
/// Two that could go on, nearer to each other than this, in reaches, are not told apart.
const ALIKE: f64 = 0.35;
/// Seconds over which a speed is taken.
const WINDOW: f64 = 0.5;
/// Median heights a second that nobody walks.
const FASTEST: f64 = 3.0;
/// A height may differ by this share from that of its track.
const TALL: f64 = 0.1;
/// At one moment it may differ so many times as much.
const TALLER: f64 = 1.5;
/// A top may be so many median heights off those before and after it.
const SMOOTH: f64 = 0.1;
/// Seconds and moments that a track has at least.
const LEAST: (f64, usize) = (0.5, 5);
/// Seconds and moments of a track that hardly ever more than two cameras see at once.
const LEAST_OF_TWO: (f64, usize) = (1.0, 8);
/// Share of the moments at which more than two cameras see it, from which on it is not one of these.
const OFTEN: f64 = 0.2;
/// Share of the moments between its first and its last at which a track is seen, at least.
const DENSE: f64 = 0.4;

/// A walker at some moments.
#[derive(Debug, Clone, Default)]
pub struct WalkerTrack {
    /// Which moment, and what is seen then.
    pub points: Vec<(usize, Group)>,
}

/// Moments, and who is seen at each.
pub struct Crowd<'a> {
    /// What each camera saw.
    pub observed: &'a [Observed],
    /// Seconds of each moment.
    pub times: &'a [f64],
    /// Median height.
    pub height: f64,
}

impl Crowd<'_> {
    /// The tracks of the walkers at each moment.
    pub fn tracks(&self, walkers: Vec<Vec<Group>>) -> Vec<WalkerTrack> {
        let mut tracks = Vec::new();
        for (moment, walkers) in walkers.into_iter().enumerate() {
            self.go_on(moment, walkers, &mut tracks);
        }
        self.sound(tracks)
    }

    fn go_on(&self, moment: usize, walkers: Vec<Group>, tracks: &mut Vec<WalkerTrack>) {
        let going: Vec<usize> = (0..tracks.len()).filter(|&t| self.since(&tracks[t], moment) < GAP).collect();
        let mut fits: Vec<(f64, usize, usize)> = Vec::new();
        for &t in &going {
            for (w, walker) in walkers.iter().enumerate() {
                fits.extend(self.fit(&tracks[t], moment, walker).map(|cost| (cost, t, w)));
            }
        }
        fits.sort_by(|p, q| p.0.total_cmp(&q.0).then((p.1, p.2).cmp(&(q.1, q.2))));
        let (mut gone, mut known) = (vec![false; tracks.len()], vec![false; walkers.len()]);
        let mut onto: Vec<Option<usize>> = vec![None; walkers.len()];
        for &(cost, t, w) in &fits {
            if gone[t] || known[w] {
                continue;
            }
            let rivalled = fits
                .iter()
                .any(|&(other, s, v)| (s == t) != (v == w) && !gone[s] && !known[v] && other < cost + ALIKE);
            (gone[t], known[w]) = (true, true);
            if !rivalled {
                onto[w] = Some(t);
            }
        }
        for (walker, onto) in walkers.into_iter().zip(onto) {
            match onto {
                Some(t) => tracks[t].points.push((moment, walker)),
                None => tracks.push(WalkerTrack { points: vec![(moment, walker)] }),
            }
        }
    }

    fn since(&self, track: &WalkerTrack, moment: usize) -> f64 {
        track.points.last().map_or(f64::INFINITY, |(last, _)| self.times[moment] - self.times[*last])
    }

    /// How badly a walker goes on a track, in reaches; `None` where it cannot.
    fn fit(&self, track: &WalkerTrack, moment: usize, walker: &Group) -> Option<f64> {
        let (last, before) = track.points.last()?;
        let seconds = self.times[moment] - self.times[*last];
        let expected = before.top + self.speed(track) * seconds;
        let deviation = walker.deviation.max(before.deviation);
        let reach = (REACH[0] + REACH[1] * seconds) * self.height + DEVIATIONS * deviation;
        let off = (walker.top - expected).norm() / reach;
        let taller = (walker.top.z - walker.foot.z) / tall(track) - 1.0;
        if off >= 1.0 || taller.abs() > TALLER * TALL {
            return None;
        }
        Some(off - if self.followed(before, walker) { FOLLOWED } else { 0.0 })
    }

    /// Whether some camera has followed the silhouette of a walker to that of another moment.
    fn followed(&self, before: &Group, walker: &Group) -> bool {
        let both = before.silhouettes.iter().zip(&walker.silhouettes).zip(self.observed);
        both.filter_map(|((p, q), observed)| Some(((*p)?, (*q)?, observed))).any(|(p, q, observed)| {
            let after = observed.next(p);
            p == q || after == Some(q) || after.and_then(|next| observed.next(next)) == Some(q)
        })
    }

    /// Speed at the end of a track, lengths a second.
    fn speed(&self, track: &WalkerTrack) -> Vector3<f64> {
        let end = track.points.last().map_or(0.0, |(m, _)| self.times[*m]);
        let lately: Vec<(f64, Vector3<f64>)> = track
            .points
            .iter()
            .rev()
            .map(|(m, g)| (self.times[*m] - end, g.top))
            .take_while(|(t, _)| *t > -WINDOW)
            .collect();
        let n = lately.len() as f64;
        let mean_t = lately.iter().map(|(t, _)| t).sum::<f64>() / n;
        let mean = lately.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / n;
        let squares: f64 = lately.iter().map(|(t, _)| (t - mean_t).powi(2)).sum();
        // Of less than half a window a slope is mostly noise.
        if lately.last().is_none_or(|(t, _)| *t > -0.5 * WINDOW) || squares <= 0.0 {
            return Vector3::zeros();
        }
        lately.iter().map(|(t, p)| (p - mean) * (t - mean_t)).sum::<Vector3<f64>>() / squares
    }

    /// What is left of tracks without what does not fit into them, and without those that are too short to be believed; in the order of
    /// their beginnings.
    fn sound(&self, tracks: Vec<WalkerTrack>) -> Vec<WalkerTrack> {
        let mut found: Vec<WalkerTrack> =
            tracks.into_iter().map(|t| self.without_odd(t)).filter(|t| self.is_sound(t)).collect();
        found.sort_by_key(|t| t.points[0].0);
        found
    }

    fn without_odd(&self, track: WalkerTrack) -> WalkerTrack {
        let mut heights: Vec<f64> = track.points.iter().map(|(_, g)| g.top.z - g.foot.z).collect();
        heights.sort_by(f64::total_cmp);
        let tall = heights[heights.len() / 2];
        let near = |at: usize| {
            let time = self.times[track.points[at].0];
            let around = track
                .points
                .iter()
                .enumerate()
                .filter(move |(k, (m, _))| *k != at && (self.times[*m] - time).abs() < 0.5 * WINDOW);
            around.map(move |(_, (m, g))| (self.times[*m] - time, g.top)).collect::<Vec<_>>()
        };
        let fits = |at: usize| {
            let group = &track.points[at].1;
            let near = near(at);
            let smooth = SMOOTH * self.height + DEVIATIONS * group.deviation;
            let height = (group.top.z - group.foot.z) / tall - 1.0;
            let by_all = near.iter().filter(|(seconds, top)| {
                (group.top - top).norm() < smooth + FASTEST * seconds.abs() * self.height
            });
            let straight = line(&near).is_none_or(|top| (top - group.top).norm() < smooth);
            height.abs() < TALL && straight && 2 * by_all.count() >= near.len()
        };
        let keep: Vec<bool> = (0..track.points.len()).map(fits).collect();
        let points = track.points.into_iter().zip(keep).filter(|(_, keep)| *keep).map(|(p, _)| p);
        WalkerTrack { points: points.collect() }
    }

    fn is_sound(&self, track: &WalkerTrack) -> bool {
        let (Some((first, _)), Some((last, _))) = (track.points.first(), track.points.last()) else {
            return false;
        };
        let n = track.points.len();
        let by_many = track.points.iter().filter(|(_, g)| g.cameras() > 2).count() as f64;
        let (seconds, moments) = if by_many < OFTEN * n as f64 { LEAST_OF_TWO } else { LEAST };
        let dense = n as f64 >= DENSE * (last - first + 1) as f64;
        self.times[*last] - self.times[*first] >= seconds && n >= moments && dense
    }
}

/// Height of a track, the median of what was seen lately.
fn tall(track: &WalkerTrack) -> f64 {
    let lately = &track.points[track.points.len().saturating_sub(15)..];
    let mut heights: Vec<f64> = lately.iter().map(|(_, g)| g.top.z - g.foot.z).collect();
    heights.sort_by(f64::total_cmp);
    heights[heights.len() / 2]
}

/// Where a straight line through places at some seconds is at second 0; `None` of too few.
fn line(places: &[(f64, Vector3<f64>)]) -> Option<Vector3<f64>> {
    let n = places.len() as f64;
    if places.len() < 3 {
        return None;
    }
    let mean_t = places.iter().map(|(t, _)| t).sum::<f64>() / n;
    let mean = places.iter().map(|(_, p)| p).sum::<Vector3<f64>>() / n;
    let squares: f64 = places.iter().map(|(t, _)| (t - mean_t).powi(2)).sum();
    let slope =
        places.iter().map(|(t, p)| (p - mean) * (t - mean_t)).sum::<Vector3<f64>>() / squares.max(1e-12);
    Some(mean - slope * mean_t)
}
