//! Masks without geometry, and the plain algorithms that recordings are compared with.

use epibar::ImageSize;

pub type Mask = Vec<u8>;

/// A small generator (xorshift64*), enough to make scenes.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 33) as usize % n
    }

    /// Uniform between two numbers, in steps of a millionth.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.below(1_000_001) as f64 / 1e6)
    }
}

/// A mask in which each pixel moves with a probability of some per cent.
pub fn noise(size: ImageSize, percent: usize, random: &mut Random) -> Mask {
    (0..size.pixels()).map(|_| u8::from(random.below(100) < percent)).collect()
}

/// A 4-connected blob: a few overlapping discs along a random walk, convex when there is one.
pub fn blob(size: ImageSize, random: &mut Random) -> Mask {
    let mut mask = vec![0; size.pixels()];
    let (mut x, mut y) = (random.below(size.width()) as i64, random.below(size.height()) as i64);
    for _ in 0..=random.below(4) {
        let radius = 1 + random.below(6) as i64;
        for (pixel, value) in mask.iter_mut().enumerate() {
            let (dx, dy) = ((pixel % size.width()) as i64 - x, (pixel / size.width()) as i64 - y);
            if dx * dx + dy * dy <= radius * radius {
                *value = 1;
            }
        }
        // The next centre is a pixel of this disc, along one axis so that discs stay joined at a side.
        let step = random.below(2 * radius as usize + 1) as i64 - radius;
        if random.below(2) == 0 {
            x = (x + step).clamp(0, size.width() as i64 - 1);
        } else {
            y = (y + step).clamp(0, size.height() as i64 - 1);
        }
    }
    mask
}

/// The 8-connected components, each sorted, in the order of their first pixels.
pub fn flood_fill(mask: &[u8], size: ImageSize) -> Vec<Vec<usize>> {
    let mut left = mask.to_vec();
    let mut components = Vec::new();
    for start in 0..mask.len() {
        if left[start] == 0 {
            continue;
        }
        left[start] = 0;
        let (mut component, mut front) = (vec![start], vec![start]);
        while let Some(pixel) = front.pop() {
            let (x, y) = (pixel % size.width(), pixel / size.width());
            for near_y in y.saturating_sub(1)..=(y + 1).min(size.height() - 1) {
                for near_x in x.saturating_sub(1)..=(x + 1).min(size.width() - 1) {
                    let near = near_y * size.width() + near_x;
                    if std::mem::take(&mut left[near]) != 0 {
                        component.push(near);
                        front.push(near);
                    }
                }
            }
        }
        component.sort_unstable();
        components.push(component);
    }
    components
}

/// Positive where a → b → c turns right on the screen.
pub fn turn(a: [u16; 2], b: [u16; 2], c: [u16; 2]) -> i32 {
    let [(ax, ay), (bx, by), (cx, cy)] = [a, b, c].map(|[x, y]| (i32::from(x), i32::from(y)));
    (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
}

/// The points that are not in the hull of the others, by Carathéodory: in no triangle and on no segment
/// of them.
pub fn extreme_points(points: &[[u16; 2]]) -> Vec<[u16; 2]> {
    let inside = |p: [u16; 2], a: [u16; 2], b: [u16; 2], c: [u16; 2]| {
        let turns = [turn(a, b, p), turn(b, c, p), turn(c, a, p)];
        turns.iter().all(|&t| t >= 0) || turns.iter().all(|&t| t <= 0)
    };
    let within = |p: [u16; 2], a: [u16; 2], b: [u16; 2]| {
        (0..2).all(|axis| (a[axis].min(b[axis])..=a[axis].max(b[axis])).contains(&p[axis]))
    };
    let covered = |p: [u16; 2]| {
        let others: Vec<_> = points.iter().copied().filter(|&q| q != p).collect();
        others.iter().enumerate().any(|(i, &a)| {
            others[..i].iter().enumerate().any(|(j, &b)| {
                if turn(a, b, p) == 0 {
                    return within(p, a, b);
                }
                others[..j].iter().any(|&c| turn(a, b, c) != 0 && inside(p, a, b, c))
            })
        })
    };
    points.iter().copied().filter(|&p| !covered(p)).collect()
}
