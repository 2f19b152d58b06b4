// Lines are [a, b, c] with a·x + b·y + c = 0; points [x, y] in pixels, pixel centres at integers.

const lineInB = (F, [x, y]) => F.map(row => row[0] * x + row[1] * y + row[2]);
const lineInA = (F, [x, y]) => [0, 1, 2].map(k => F[0][k] * x + F[1][k] * y + F[2][k]);

const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
const norm = p => Math.hypot(...p);
const transposed = F => [0, 1, 2].map(k => F.map(row => row[k]));

// The null vector of F as a point, or null where it is at infinity.
function epipole(F) {
  const products = [[0, 1], [0, 2], [1, 2]].map(([i, j]) => cross(F[i], F[j]));
  const best = products.reduce((p, q) => (norm(q) > norm(p) ? q : p));
  const point = [best[0] / best[2], best[1] / best[2]];
  return point.every(Number.isFinite) ? point : null;
}

// The two ends of a line on the border of an image, the outer edge of its pixels; null where it misses.
function clipLine([a, b, c], [width, height]) {
  const length = Math.hypot(a, b);
  if (!(length > 0)) return null;
  [a, b, c] = [a / length, b / length, c / length];
  const middle = [(width - 1) / 2, (height - 1) / 2];
  const offset = a * middle[0] + b * middle[1] + c;
  const foot = [middle[0] - offset * a, middle[1] - offset * b];
  const direction = [-b, a];
  let low = -Infinity, high = Infinity;
  for (const [k, size] of [width, height].entries()) {
    if (direction[k] === 0) {
      if (foot[k] < -0.5 || foot[k] > size - 0.5) return null;
      continue;
    }
    const ends = [(-0.5 - foot[k]) / direction[k], (size - 0.5 - foot[k]) / direction[k]];
    low = Math.max(low, Math.min(...ends));
    high = Math.min(high, Math.max(...ends));
  }
  if (!(low < high)) return null;
  return [low, high].map(t => [foot[0] + t * direction[0], foot[1] + t * direction[1]]);
}

// A barcode packed low bit first in base64, as an array of booleans.
function unpackBits(text, count) {
  const bytes = atob(text);
  return Array.from({ length: count }, (_, i) => (bytes.charCodeAt(i >> 3) >> (i & 7)) & 1);
}
