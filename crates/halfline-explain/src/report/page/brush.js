// Boxes, faces, dots and labels on the canvas, given where they are in the frame.

/** The edges of a box, as pairs of corners that differ in one bit. */
const BOX_EDGES = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((corner) =>
  [1, 2, 4].filter((bit) => !(corner & bit)).map((bit) => [corner, corner | bit]));

class Brush {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.hatches = new Map();
  }

  /** Clears the canvas, whose every pixel is one of the screen's. */
  begin(camera, colors) {
    this.camera = camera;
    this.colors = colors;
    this.ratio = window.devicePixelRatio || 1;
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    const [width, height] = [this.width, this.height].map((size) => Math.round(size * this.ratio));
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    this.context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.context.lineJoin = "round";
    this.context.lineCap = "round";
    this.fill("canvas", 1, () => this.context.rect(0, 0, this.width, this.height));
    this.labels = [];
    this.taken = [];
    this.em = parseFloat(getComputedStyle(this.canvas).fontSize);
  }

  fill(color, alpha, path) {
    this.context.save();
    this.context.globalAlpha = alpha;
    this.context.fillStyle = this.colors[color] ?? color;
    this.context.beginPath();
    path();
    this.context.fill();
    this.context.restore();
  }

  stroke(color, width, path, { alpha = 1, dash = [] } = {}) {
    this.context.save();
    this.context.globalAlpha = alpha;
    this.context.strokeStyle = this.colors[color] ?? color;
    this.context.lineWidth = width;
    this.context.setLineDash(dash);
    this.context.beginPath();
    path();
    this.context.stroke();
    this.context.restore();
  }

  /** Adds lines between positions in the frame to the path. */
  trace(positions, isClosed = false) {
    positions.forEach((p, index) => {
      const [x, y] = this.camera.project(p);
      if (index === 0) this.context.moveTo(x, y);
      else this.context.lineTo(x, y);
    });
    if (isClosed) this.context.closePath();
  }

  line(positions, color, width, options) {
    this.stroke(color, width, () => this.trace(positions), options);
  }

  polygon(positions, color, alpha) {
    this.fill(color, alpha, () => this.trace(positions, true));
  }

  outline(positions, color, width, options) {
    this.stroke(color, width, () => this.trace(positions, true), options);
  }

  /** The edges of boxes in one stroke; those that a box hides itself are dotted. */
  boxes(boxes, color, width, { alpha = 1, dash = [] } = {}) {
    const hidden = this.camera.hiddenCorner();
    const edges = (isHidden) => () => {
      for (const box of boxes) {
        const corners = cornersOf(box);
        for (const [from, to] of BOX_EDGES) {
          const isBehind = from === hidden || to === hidden;
          if (isBehind === isHidden) this.trace([corners[from], corners[to]]);
        }
      }
    };
    this.stroke(color, width * 0.6, edges(true), { alpha: alpha * 0.55, dash: [1.5, 4] });
    this.stroke(color, width, edges(false), { alpha, dash });
  }

  /** The three sides of a box that face the eye, each in its own shade. */
  sides(box, color, alpha) {
    for (let axis = 0; axis < 3; axis++) {
      const facing = this.camera.eye[axis];
      const side = this.rectangle(box, axis, box[facing > 0 ? 1 : 0][axis]);
      this.polygon(side, color, alpha * (0.55 + 0.45 * Math.abs(facing)));
    }
  }

  /** The same sides, hatched. */
  hatchedSides(box, color, alpha) {
    this.fill(this.hatch(color), alpha, () => {
      for (let axis = 0; axis < 3; axis++) {
        const facing = this.camera.eye[axis];
        this.trace(this.rectangle(box, axis, box[facing > 0 ? 1 : 0][axis]), true);
      }
    });
  }

  /** Where a plane cuts a box. */
  rectangle(box, axis, plane) {
    const [first, second] = [(axis + 1) % 3, (axis + 2) % 3];
    return [[0, 0], [1, 0], [1, 1], [0, 1]].map(([i, j]) => {
      const corner = [0, 0, 0];
      corner[axis] = plane;
      corner[first] = box[i][first];
      corner[second] = box[j][second];
      return corner;
    });
  }

  /** A pattern of slanted lines. */
  hatch(color) {
    const shade = this.colors[color];
    const key = `${shade} ${this.ratio}`;
    if (!this.hatches.has(key)) {
      const size = Math.round(9 * this.ratio);
      const tile = document.createElement("canvas");
      tile.width = size;
      tile.height = size;
      const lines = tile.getContext("2d");
      lines.strokeStyle = shade;
      lines.lineWidth = 1.1 * this.ratio;
      lines.beginPath();
      for (const shift of [-size, 0, size]) {
        lines.moveTo(shift - 1, size + 1);
        lines.lineTo(shift + size + 1, -1);
      }
      lines.stroke();
      const pattern = this.context.createPattern(tile, "repeat");
      pattern.setTransform(new DOMMatrix().scale(1 / this.ratio));
      this.hatches.set(key, pattern);
    }
    return this.hatches.get(key);
  }

  dot(p, radius, color, rim = "canvas") {
    const [x, y] = this.camera.project(p);
    this.fill(rim, 1, () => this.context.arc(x, y, radius + 1.5, 0, 2 * Math.PI));
    this.fill(color, 1, () => this.context.arc(x, y, radius, 0, 2 * Math.PI));
  }

  /** A stroke across the ray. */
  tick(p, direction, reach, color, width) {
    const [x, y] = this.camera.project(p);
    const ahead = this.camera.project(add(p, direction));
    const [dx, dy] = [ahead[0] - x, ahead[1] - y];
    const size = Math.hypot(dx, dy);
    const [across, down] = size > 1e-9 ? [-dy / size, dx / size] : [0, 1];
    this.stroke(color, width, () => {
      this.context.moveTo(x - across * reach, y - down * reach);
      this.context.lineTo(x + across * reach, y + down * reach);
    });
  }

  /** Asks for a text beside a position; all are set at the end, the most important first. */
  label(p, text, color, { weight = 600, importance = 1, size = 0.85, isCentered = false } = {}) {
    const at = this.camera.project(p);
    this.labels.push({ at, text, color, weight, importance, size, isCentered });
  }

  /** Sets the labels, each where it covers no other; one that finds no place is left out. */
  finish() {
    this.labels.sort((a, b) => b.importance - a.importance);
    for (const { at, text, color, weight, size, isCentered } of this.labels) {
      const pixels = this.em * size;
      this.context.font = `${weight} ${pixels}px system-ui, sans-serif`;
      const width = this.context.measureText(text).width;
      const place = this.freePlace(at, width, pixels, isCentered);
      if (!place) continue;
      this.taken.push(place);
      this.context.save();
      this.context.textBaseline = "middle";
      this.context.lineWidth = 4;
      this.context.strokeStyle = this.colors.canvas;
      this.context.globalAlpha = 0.85;
      this.context.strokeText(text, place[0], place[1] + pixels / 2);
      this.context.globalAlpha = 1;
      this.context.fillStyle = this.colors[color];
      this.context.fillText(text, place[0], place[1] + pixels / 2);
      this.context.restore();
    }
  }

  /** A rectangle for a text, as [left, top, right, bottom]. */
  freePlace([x, y], width, height, isCentered) {
    const gap = 9;
    const beside = [
      [x + gap, y - gap - height], [x + gap, y + gap], [x - gap - width, y - gap - height],
      [x - gap - width, y + gap], [x - width / 2, y + 2 * gap], [x - width / 2, y - 2 * gap - height],
      [x + gap, y - 3 * gap - height], [x + gap, y + 3 * gap],
    ];
    const centered = [0, 1.3, -1.3, 2.6, -2.6].map((lines) =>
      [x - width / 2, y - height / 2 + lines * height]);
    const places = (isCentered ? centered : beside).map(([left, top]) =>
      [left, top, left + width, top + height]);
    const isFree = (place) =>
      place[0] > 2 && place[1] > 2 && place[2] < this.width - 2 && place[3] < this.height - 2
      && this.taken.every((other) => place[2] + 4 < other[0] || other[2] + 4 < place[0]
        || place[3] + 2 < other[1] || other[3] + 2 < place[1]);
    return places.find(isFree);
  }

  /** Keeps labels out of a rectangle. */
  reserve(left, top, right, bottom) {
    this.taken.push([left, top, right, bottom]);
  }
}
