// How the network's world, z up, is seen: turned about its middle, in perspective, fitted to a rectangle.

const RADIANS = Math.PI / 180;
const BESIDE = [-20, -10, 0, 10, 20];

class Orbit {
  // `points` are all that must be seen, [x, y, z].
  constructor(points) {
    this.points = points;
    const ends = [0, 1, 2].map(k => points.reduce(([low, high], p) => [Math.min(low, p[k]), Math.max(high, p[k])],
      [Infinity, -Infinity]));
    this.middle = ends.map(([low, high]) => (low + high) / 2);
    this.far = 3.2 * Math.max(1e-9, ...points.map(p => Math.hypot(...p.map((value, k) => value - this.middle[k]))));
    this.reset();
  }

  reset() {
    [this.azimuth, this.elevation, this.zoom] = [-60, 24, 1];
  }

  turn(azimuth, elevation) {
    this.azimuth = (this.azimuth + azimuth) % 360;
    this.elevation = Math.min(90, Math.max(0, this.elevation + elevation));
  }

  magnify(factor) {
    this.zoom = Math.min(12, Math.max(0.5, this.zoom * factor));
  }

  // A function from the world to [right, down, how much larger than in the middle, depth], in its units.
  seenFrom(azimuth) {
    const [sin, cos] = [Math.sin(azimuth * RADIANS), Math.cos(azimuth * RADIANS)];
    const [up, level] = [Math.sin(this.elevation * RADIANS), Math.cos(this.elevation * RADIANS)];
    return place => {
      const [x, y, z] = place.map((value, k) => value - this.middle[k]);
      const [right, ahead] = [-sin * x + cos * y, -cos * x - sin * y];
      const depth = ahead * level - z * up;
      const size = this.far / (this.far + depth);
      return [size * right, -size * (ahead * up + z * level), size, depth];
    };
  }

  // Left, right, top and bottom of all points from here and from a little beside: what is seen stays in the
  // picture when it is turned, fills it, and does not jump.
  bounds() {
    const box = [Infinity, -Infinity, Infinity, -Infinity];
    for (const side of BESIDE) {
      for (const [x, y] of this.points.map(this.seenFrom(this.azimuth + side))) {
        [box[0], box[1], box[2], box[3]] =
          [Math.min(box[0], x), Math.max(box[1], x), Math.min(box[2], y), Math.max(box[3], y)];
      }
    }
    return box;
  }

  // A function from the world to [x, y, pixels per unit there, depth], for a rectangle of so many pixels.
  projection(width, height, margin) {
    const [left, right, top, bottom] = this.bounds();
    const scale = this.zoom * Math.min((width - 2 * margin) / Math.max(right - left, 1e-9),
      (height - 2 * margin) / Math.max(bottom - top, 1e-9));
    const seen = this.seenFrom(this.azimuth);
    return place => {
      const [x, y, size, depth] = seen(place);
      return [width / 2 + scale * (x - (left + right) / 2), height / 2 + scale * (y - (top + bottom) / 2), scale * size, depth];
    };
  }
}
