// From the mesh's coordinates to the screen's.
//
// Meshes may be tiny, huge, or far from zero. So every position is first moved and scaled, in double
// precision, into a frame in which the root's box reaches from -1 to 1 on its longest side; the
// camera is orthographic, so that edges that are parallel in space are parallel on the screen.

const AXES = ["x", "y", "z"];

const add = (p, q) => [p[0] + q[0], p[1] + q[1], p[2] + q[2]];
const subtract = (p, q) => [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
const scaled = (p, factor) => [p[0] * factor, p[1] * factor, p[2] * factor];
const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
const cross = (p, q) => [
  p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0],
];
const length = (p) => Math.hypot(p[0], p[1], p[2]);
const mixed = (p, q, share) => add(scaled(p, 1 - share), scaled(q, share));
const isPosition = (p) => Array.isArray(p) && p.length === 3 && p.every(Number.isFinite);
const isBox = (box) => Array.isArray(box) && box.length === 2 && box.every(isPosition);

/** The box around positions. */
function boxAround(positions) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const p of positions) {
    for (let axis = 0; axis < 3; axis++) {
      low[axis] = Math.min(low[axis], p[axis]);
      high[axis] = Math.max(high[axis], p[axis]);
    }
  }
  return [low, high];
}

const centerOf = ([low, high]) => mixed(low, high, 0.5);
const radiusOf = ([low, high]) => length(subtract(high, low)) / 2;

/** The eight corners; bit k of a corner's index tells whether it is high on axis k. */
function cornersOf(box) {
  return Array.from({ length: 8 }, (_, corner) =>
    AXES.map((_, axis) => box[(corner >> axis) & 1][axis]));
}

/** The frame in which everything is drawn. */
class Frame {
  constructor(bounds, ray) {
    const [low, high] = isBox(bounds) ? bounds : [ray.origin, ray.origin];
    // Halves first: the difference of two huge numbers could overflow.
    this.center = AXES.map((_, axis) => low[axis] / 2 + high[axis] / 2);
    const halves = AXES.map((_, axis) => high[axis] / 2 - low[axis] / 2);
    // A model of one point is seen from the ray's origin, if that is elsewhere.
    const toOrigin = AXES.map((_, axis) => Math.abs(ray.origin[axis] - this.center[axis]));
    this.half = Math.max(...halves) || Math.max(...toOrigin) || 1;
    const largest = Math.max(...ray.direction.map(Math.abs)) || 1;
    const shape = ray.direction.map((d) => d / largest);
    this.largest = largest;
    this.shapeLength = length(shape) || 1;
    this.direction = scaled(shape, 1 / this.shapeLength);
    this.origin = this.point(ray.origin);
    this.rootBox = this.box([low, high]);
  }

  point(p) {
    return AXES.map((_, axis) => (p[axis] / 2 - this.center[axis] / 2) / this.half * 2);
  }

  box(bounds) {
    return bounds.map((p) => this.point(p));
  }

  /** How far from the origin the ray is at t, in the frame's units. */
  distance(t) {
    const way = t * this.largest;
    // Of a huge mesh the way may be beyond all doubles, while it is a few units here.
    const units = Number.isFinite(way) ? way / this.half : t / this.half * this.largest;
    return units * this.shapeLength;
  }

  /** Where the ray is at t. */
  at(t) {
    return add(this.origin, scaled(this.direction, this.distance(t)));
  }
}

/** An orthographic view, turned by an azimuth around the axis that is up, and an elevation. */
class Camera {
  constructor(frame, up) {
    this.frame = frame;
    this.up = up;
    this.reset();
  }

  /** Turns so that the ray runs over the picture, and no axis is seen end on. */
  reset() {
    const [first, second] = this.sideways();
    const along = [this.frame.direction[first], this.frame.direction[second]];
    this.elevation = 0.4;
    this.zoom = 1;
    this.pan = [0, 0];
    this.azimuth = -1;
    if (Math.hypot(...along) > 0.1) {
      const across = Math.atan2(-along[0], along[1]);
      const quarter = Math.PI / 2;
      const fromAxis = (angle) => {
        const rest = ((angle % quarter) + quarter) % quarter;
        return Math.min(rest, quarter - rest);
      };
      const turns = [0.35, -0.35, 0.5, -0.5, 0.65, -0.65];
      const score = (turn) => Math.min(fromAxis(across + turn), 0.45) - Math.abs(turn) / 8;
      this.azimuth = across + turns.reduce((a, b) => (score(b) > score(a) ? b : a));
    }
  }

  sideways() {
    return [(this.up + 1) % 3, (this.up + 2) % 3];
  }

  /** Makes the view look at a point, with this much around it, in a rectangle of the canvas. */
  aim(center, radius, { x, y, width, height }) {
    const [first, second] = this.sideways();
    const [cosine, sine] = [Math.cos(this.azimuth), Math.sin(this.azimuth)];
    const [level, steep] = [Math.cos(this.elevation), Math.sin(this.elevation)];
    this.eye = [0, 0, 0];
    this.right = [0, 0, 0];
    this.above = [0, 0, 0];
    this.eye[first] = level * cosine;
    this.eye[second] = level * sine;
    this.eye[this.up] = steep;
    this.right[first] = -sine;
    this.right[second] = cosine;
    this.above[first] = -steep * cosine;
    this.above[second] = -steep * sine;
    this.above[this.up] = level;
    this.center = center;
    this.viewport = { x, y, width, height };
    this.scale = Math.min(width, height) / 2 / radius * this.zoom;
    this.middle = [x + width / 2 + this.pan[0], y + height / 2 + this.pan[1]];
  }

  /** From the frame to the canvas, in CSS pixels. */
  project(p) {
    const q = subtract(p, this.center);
    return [
      this.middle[0] + dot(this.right, q) * this.scale,
      this.middle[1] - dot(this.above, q) * this.scale,
    ];
  }

  /** How near to the eye a position is; more is nearer. */
  nearness(p) {
    return dot(this.eye, p);
  }

  /** The corner of boxes that the eye cannot see; its bits are as those of `cornersOf`. */
  hiddenCorner() {
    return this.eye.reduce((corner, e, axis) => corner | ((e > 0 ? 0 : 1) << axis), 0);
  }

  /** The part [from, to] of a line, in distances from the ray's origin, that the canvas shows. */
  visiblePart(from, to) {
    const { x, y, width, height } = this.viewport;
    const start = this.project(this.frame.origin);
    const step = [dot(this.right, this.frame.direction), -dot(this.above, this.frame.direction)];
    const limits = [[x, x + width], [y, y + height]];
    for (let k = 0; k < 2; k++) {
      const speed = step[k] * this.scale;
      const [low, high] = limits[k].map((limit) => limit - start[k]);
      if (Math.abs(speed) < 1e-9 * this.scale) {
        if (low > 0 || high < 0) return null;
        continue;
      }
      const ends = [low / speed, high / speed];
      from = Math.max(from, Math.min(...ends));
      to = Math.min(to, Math.max(...ends));
    }
    // A line that is seen as a point has no end on the screen, yet needs some.
    [from, to] = [Math.max(from, -1e300), Math.min(to, 1e300)];
    return from <= to ? [from, to] : null;
  }
}
