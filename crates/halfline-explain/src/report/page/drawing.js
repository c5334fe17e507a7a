// The walk in space: cells, planes, triangles and the ray, as of one step.

class Drawing {
  constructor(canvas, walk) {
    this.walk = walk;
    this.frame = new Frame(walk.cells[0]?.bounds, walk.data.ray);
    this.camera = new Camera(this.frame, walk.data.up ?? 2);
    this.brush = new Brush(canvas);
    this.isFollowing = true;
    this.boxes = walk.cells.map((cell) => (isBox(cell.bounds) ? this.frame.box(cell.bounds) : null));
    this.scenery = (walk.data.scenery ?? []).map((p) => this.frame.point(p));
    this.triangles = new Map(Object.entries(walk.data.triangles).map(([face, corners]) =>
      [Number(face), corners.map((p) => this.frame.point(p))]));
    this.selectedFace = null;
    this.engineBox = null;
  }

  /** The whole model: the root's box, and of the ray and the nearest miss what is not far off. */
  wholeView() {
    const { origin, rootBox } = this.frame;
    const center = centerOf(rootBox);
    const radius = radiusOf(rootBox);
    if (radius === 0) return { center, radius: 1 };
    const near = [origin, ...this.missEnds()].filter((p) =>
      length(subtract(p, center)) < 2.2 * radius);
    // A ray that comes from afar still shows where it comes from.
    near.push(add(center, scaled(this.frame.direction, -radius)));
    const box = boxAround([...cornersOf(rootBox), ...near.filter((p) => p.every(Number.isFinite))]);
    return { center: centerOf(box), radius: radiusOf(box) * 0.82 };
  }

  /** What the camera should look at for a step. */
  target(index) {
    const whole = this.wholeView();
    const step = this.walk.steps[index];
    const box = this.boxes[this.walk.cellOf(step)];
    if (!this.isFollowing || step.kind === "clip" || !box) return whole;
    if (step.kind === "end") return this.missView(whole);
    let radius = radiusOf(box);
    let center = centerOf(box);
    if (step.kind === "leaf") {
      // Triangles reach out of their leaf: show as much of them as leaves the cell large enough.
      const reach = boxAround([...cornersOf(box),
        ...step.tests.flatMap((test) => this.triangles.get(test.face) ?? [])]);
      const share = Math.min(1, 2 * radius / (radiusOf(reach) || 1));
      center = mixed(center, centerOf(reach), share * 0.7);
      radius = Math.min(radiusOf(reach), Math.max(2 * radius, 1e-12));
    }
    radius = Math.max(radius * 1.45, 1e-12);
    return radius < whole.radius ? { center, radius } : whole;
  }

  /** The nearest miss so large that it can be seen, if it is small. */
  missView(whole) {
    const ends = this.missEnds();
    const corners = this.triangles.get(this.walk.data.nearest_miss?.face);
    if (ends.length === 0 || !corners) return whole;
    const distance = length(subtract(...ends));
    const triangle = radiusOf(boxAround([...corners, ...ends]));
    const radius = Math.max(distance * 2.5, Math.min(triangle * 1.4, distance * 14), 1e-12);
    return radius < whole.radius ? { center: mixed(...ends, 0.5), radius } : whole;
  }

  /** The ends of the nearest miss. */
  missEnds() {
    const miss = this.walk.data.nearest_miss;
    if (!miss || !isPosition(miss.point_on_ray) || !isPosition(miss.point_on_face)) return [];
    return [this.frame.point(miss.point_on_ray), this.frame.point(miss.point_on_face)];
  }

  draw(index, view, colors) {
    const { brush, walk } = this;
    const step = walk.steps[index];
    const canvas = brush.canvas;
    const margin = Math.min(26, canvas.clientWidth / 12);
    this.camera.aim(view.center, view.radius, {
      x: margin, y: margin, width: canvas.clientWidth - 2 * margin,
      height: canvas.clientHeight - 2 * margin,
    });
    brush.begin(this.camera, colors);
    this.reserveButtons();
    this.drawScenery(1);
    brush.boxes([this.frame.rootBox], "ink", 1, { alpha: 0.6 });
    this.drawPast(index, view.radius / this.camera.zoom);
    this.drawStep(step);
    if (this.engineBox) {
      brush.boxes([this.engineBox], "engine", 2.5, { dash: [10, 4, 2, 4] });
      brush.label(this.engineBox[1], "fast tree", "engine", { importance: 3 });
    }
    this.drawRay(step, index);
    this.drawMarks(step, index);
    this.drawTriad();
    brush.finish();
    const whole = this.wholeView();
    if (view.radius * 2.2 < whole.radius * this.camera.zoom) this.drawInset(step, whole, view);
  }

  /** Labels keep clear of what lies on the canvas. */
  reserveButtons() {
    const canvas = this.brush.canvas.getBoundingClientRect();
    for (const other of this.brush.canvas.parentElement.children) {
      if (other === this.brush.canvas) continue;
      const { left, top, right, bottom } = other.getBoundingClientRect();
      this.brush.reserve(left - canvas.left, top - canvas.top,
        right - canvas.left, bottom - canvas.top);
    }
  }

  drawScenery(size) {
    const { context, ratio } = this.brush;
    context.save();
    context.fillStyle = this.brush.colors.scenery;
    const radius = Math.max(size, 1 / ratio);
    for (const p of this.scenery) {
      const [x, y] = this.camera.project(p);
      context.globalAlpha = 0.45 + 0.35 * Math.max(-1, Math.min(1, this.camera.nearness(p)));
      context.fillRect(x - radius, y - radius, 2 * radius, 2 * radius);
    }
    context.restore();
  }

  /** Leaves already visited with their triangles, and the cells that wait on the stack. */
  drawPast(index, radius) {
    const { brush, walk } = this;
    const seen = walk.leavesUpTo(index);
    const leaves = seen.map((leaf) => this.boxes[walk.steps[leaf].cell]).filter(Boolean);
    const current = this.boxes[walk.cellOf(walk.steps[index])];
    brush.boxes(leaves.filter((box) => box !== current), "visited", 1.2, { alpha: 0.8 });
    const faces = new Set(seen.flatMap((leaf) => walk.steps[leaf].tests.map((test) => test.face)));
    brush.stroke("visited", 0.8, () => {
      for (const face of faces) {
        const corners = this.triangles.get(face);
        if (corners) brush.trace(corners, true);
      }
    }, { alpha: 0.7 });
    for (const { cell } of walk.stackAfter(index).reverse()) {
      const box = this.boxes[cell];
      if (!box) continue;
      // A cell around the whole view would only cover it with lines.
      if (radiusOf(box) < 2 * radius) brush.hatchedSides(box, "stack", 0.16);
      brush.boxes([box], "stack", 1.2, { dash: [6, 4], alpha: 0.75 });
    }
  }

  drawStep(step) {
    const { brush } = this;
    const box = this.boxes[this.walk.cellOf(step)];
    if (!box) return;
    if (step.kind === "inner") {
      this.drawChildren(step, box);
    } else if (step.kind === "leaf") {
      brush.sides(box, "current", 0.1);
      this.drawTests(step);
    } else if (step.kind === "pop") {
      brush.sides(box, step.is_entered ? "current" : "ink", step.is_entered ? 0.16 : 0.06);
      if (!step.is_entered) brush.hatchedSides(box, "ink", 0.3);
    } else if (step.kind === "end" && step.hit) {
      this.drawTriangle(step.hit.face, "hit", true);
    } else if (step.kind === "end" && this.walk.data.nearest_miss) {
      this.drawTriangle(this.walk.data.nearest_miss.face, "outside", true);
    }
    const dash = step.kind === "pop" && !step.is_entered ? [9, 6] : [];
    brush.boxes([box], "current", step.kind === "end" ? 1.5 : 3.2, { dash });
  }

  /** The two children and the plane between them, from back to front. */
  drawChildren(step, box) {
    const { brush, frame } = this;
    const axis = AXES.indexOf(step.axis);
    const onAxis = [0, 0, 0];
    onAxis[axis] = step.plane;
    const plane = frame.point(onAxis)[axis];
    const rectangle = brush.rectangle(box, axis, plane);
    const children = [["near", step.near], ["far", step.far]].map(([role, cell]) => ({
      role, cell, box: this.boxes[cell],
      isUsed: cell === step.enter || cell === step.push,
    })).filter((child) => child.box);
    const depth = (child) => centerOf(child.box)[axis] * this.camera.eye[axis];
    children.sort((a, b) => depth(a) - depth(b));
    children.forEach((child, order) => {
      brush.sides(child.box, child.role, child.isUsed ? 0.3 : 0.07);
      if (child.cell === step.push) brush.hatchedSides(child.box, child.role, 0.5);
      brush.boxes([child.box], child.role, child.isUsed ? 2 : 1, { alpha: child.isUsed ? 1 : 0.5 });
      if (order === 0) brush.polygon(rectangle, "plane", 0.34);
      const fate = child.cell === step.enter ? "" : child.cell === step.push ? ", later" : ", not met";
      brush.label(this.awayFromRay(child.box), child.role + fate, child.role,
        { importance: 5, size: 1.05, weight: 700, isCentered: true });
    });
    if (children.length === 0) brush.polygon(rectangle, "plane", 0.34);
    brush.outline(rectangle, "plane", 2.4);
    brush.label(rectangle[2], `${step.axis} = ${formatNumber(step.plane)}`, "plane",
      { importance: 4 });
  }

  /** A place in a box that is not on the ray, as seen from here. */
  awayFromRay(box) {
    const center = centerOf(box);
    const origin = this.camera.project(this.frame.origin);
    const ahead = this.camera.project(add(this.frame.origin, this.frame.direction));
    const along = [ahead[0] - origin[0], ahead[1] - origin[1]];
    const size = Math.hypot(...along) || 1;
    const fromRay = (p) => {
      const [x, y] = this.camera.project(p);
      return Math.abs((x - origin[0]) * along[1] - (y - origin[1]) * along[0]) / size;
    };
    const places = [center, ...cornersOf(box).map((corner) => mixed(center, corner, 0.45))];
    const isFar = (p) => Math.min(fromRay(p), 2.2 * this.brush.em);
    return places.reduce((a, b) => (isFar(b) > isFar(a) + 1 ? b : a));
  }

  /** The triangles of a leaf in the colours of their verdicts, the selected one on top. */
  drawTests(step) {
    const depth = (test) => {
      const corners = this.triangles.get(test.face);
      return corners ? this.camera.nearness(centerOf(boxAround(corners))) : 0;
    };
    const tests = step.tests.map((test) => ({ test, depth: depth(test) }));
    tests.sort((a, b) => a.depth - b.depth);
    const isHit = (test) => test.verdict === "hit";
    const rank = ({ test }) => (test.face === this.selectedFace ? 2 : isHit(test) ? 1 : 0);
    tests.sort((a, b) => rank(a) - rank(b));
    for (const { test } of tests) {
      const { color, mark } = VERDICTS[test.verdict];
      const isSelected = test.face === this.selectedFace;
      this.drawTriangle(test.face, color, isSelected, tests.length > 60 ? 0.04 : 0.2);
      if (isSelected) this.nameCorners(test);
      const corners = this.triangles.get(test.face);
      if (corners && (tests.length <= 8 || isSelected || isHit(test))) {
        const middle = scaled(corners.reduce(add), 1 / 3);
        this.brush.label(middle, `${test.face} ${mark}`, "ink",
          { importance: isSelected ? 4 : 1, weight: isSelected ? 700 : 400, isCentered: true });
      }
    }
  }

  drawTriangle(face, color, isStrong, alpha = 0.2) {
    const corners = this.triangles.get(face);
    if (!corners) return;
    this.brush.polygon(corners, color, isStrong ? 0.5 : alpha);
    const dash = color === "hit" || isStrong ? [] : [5, 3];
    this.brush.outline(corners, color, isStrong ? 2.2 : alpha < 0.2 ? 0.6 : 1.2, { dash });
  }

  /** a, b and c, and the edge that the ray passes outside of. */
  nameCorners(test) {
    const corners = this.triangles.get(test.face);
    const middle = scaled(corners.reduce(add), 1 / 3);
    corners.forEach((corner, index) => {
      this.brush.label(mixed(middle, corner, 1.04), "abc"[index], "ink", { importance: 3 });
    });
    if (test.edge) {
      const ends = test.edge.split("-").map((name) => corners["abc".indexOf(name)]);
      this.brush.line(ends, "far", 4);
    }
  }
}
