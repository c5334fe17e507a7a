// The ray in the drawing, with its marks; the axes, and the small map of the whole model.

Object.assign(Drawing.prototype, {
  /** The half-line with an arrow, and on it the step's interval, thick. */
  drawRay(step, index) {
    const { brush, frame, walk } = this;
    const { t_min, t_max } = walk.data.ray;
    const place = (distance) => add(frame.origin, scaled(frame.direction, distance));
    const begin = t_min === null ? -Infinity : frame.distance(t_min);
    const end = t_max === null ? Infinity : frame.distance(t_max);
    const visible = this.camera.visiblePart(begin, end);
    if (visible) {
      const [from, to] = visible.map(place);
      brush.line([from, to], "canvas", 4.5, { alpha: 0.6 });
      brush.line([from, to], "ray", 1.8);
      this.drawArrow(from, to);
    }
    const before = this.camera.visiblePart(0, begin);
    if (begin > 0 && before) brush.line(before.map(place), "ray", 1.2, { dash: [2, 5] });
    for (const [interval, color] of this.intervals(step)) {
      const part = interval && this.camera.visiblePart(...interval.map((t) => frame.distance(t)));
      if (!part) continue;
      brush.line(part.map(place), "canvas", 9, { alpha: 0.7 });
      brush.line(part.map(place), color, 6);
    }
    const { best } = walk.after[index];
    if (best && step.kind !== "leaf") brush.dot(frame.at(best.t), 5, "hit");
    brush.dot(frame.origin, 5, "ray");
    brush.label(frame.origin, "origin", "ink", { importance: 2 });
  },

  /** The parts of the ray that the step is about, with their colours. */
  intervals(step) {
    const whole = [step.t_near, step.t_far];
    if (whole.some((t) => t === null || t === undefined)) return [];
    if (step.kind !== "inner" || step.t_split === null) return [[whole, "interval"]];
    const split = Math.min(Math.max(step.t_split, step.t_near), step.t_far);
    const parts = [[[step.t_near, split], "near"], [[split, step.t_far], "far"]];
    return parts.filter(([[from, to]]) => from < to || step.t_near === step.t_far);
  },

  /** The arrow's head, where the ray leaves the view or ends. */
  drawArrow(from, to) {
    const { context } = this.brush;
    const [x0, y0] = this.camera.project(from);
    const [x, y] = this.camera.project(to);
    const size = Math.hypot(x - x0, y - y0);
    if (size < 2) {
      this.brush.stroke("ray", 1.8, () => context.arc(x, y, 9, 0, 2 * Math.PI));
      return;
    }
    const [dx, dy] = [(x - x0) / size, (y - y0) / size];
    this.brush.fill("ray", 1, () => {
      context.moveTo(x, y);
      context.lineTo(x - 15 * dx - 6 * dy, y - 15 * dy + 6 * dx);
      context.lineTo(x - 15 * dx + 6 * dy, y - 15 * dy - 6 * dx);
      context.closePath();
    });
  },

  /** t_near, t_split and t_far, hits, and the nearest miss. */
  drawMarks(step, index) {
    const { brush, frame, walk } = this;
    const { direction } = frame;
    const ends = [["t_near", step.t_near], ["t_far", step.t_far]];
    for (const [name, t] of ends) {
      if (t === null || t === undefined) continue;
      brush.dot(frame.at(t), 3.5, "ink");
      brush.label(frame.at(t), name, "ink", { importance: 2 });
    }
    if (step.kind === "inner" && step.t_split !== null) {
      const isInside = step.t_near <= step.t_split && step.t_split <= step.t_far;
      brush.tick(frame.at(step.t_split), direction, 11, "canvas", 6);
      brush.tick(frame.at(step.t_split), direction, 10, "plane", 3.5);
      brush.label(frame.at(step.t_split), "t_split", "plane", { importance: isInside ? 3 : 1 });
    }
    if (step.kind === "leaf") {
      for (const test of step.tests) {
        if (test.t !== null && test.verdict !== "hit") brush.dot(frame.at(test.t), 3, "farther");
      }
      if (step.closest) {
        brush.dot(frame.at(step.closest.t), 6, "hit");
        brush.label(frame.at(step.closest.t), "hit", "hit", { importance: 4, weight: 700 });
      }
    }
    if (step.kind === "end") this.drawResult(index);
  },

  drawResult(index) {
    const { brush, frame, walk } = this;
    const { best } = walk.after[index];
    if (best) {
      const text = `hit: face ${best.face}`;
      brush.label(frame.at(best.t), text, "hit", { importance: 6, size: 1.05, weight: 700 });
    }
    const miss = this.missEnds();
    if (miss.length) {
      brush.line(miss, "canvas", 6, { alpha: 0.7 });
      brush.line(miss, "far", 3, { dash: [6, 4] });
      miss.forEach((p) => brush.dot(p, 4.5, "far"));
      const { face, distance } = walk.data.nearest_miss;
      brush.label(miss[1], `nearest: face ${face}, by ${formatNumber(distance)}`, "far",
        { importance: 6, size: 1.05, weight: 700 });
    }
  },

  /** Which way the axes point. */
  drawTriad() {
    const { brush, camera } = this;
    const { context } = brush;
    const size = 2 * brush.em;
    const [x, y] = [size + 12, brush.height - size - 12];
    brush.reserve(x - size - 10, y - size - 10, x + size + 10, y + size + 10);
    for (const [axis, name] of AXES.entries()) {
      const [dx, dy] = [camera.right[axis] * size, -camera.above[axis] * size];
      brush.stroke("ink", 1.6, () => {
        context.moveTo(x, y);
        context.lineTo(x + dx, y + dy);
      });
      context.save();
      context.fillStyle = brush.colors.ink;
      context.font = `600 ${brush.em * 0.85}px system-ui, sans-serif`;
      context.textAlign = "center";
      context.textBaseline = "middle";
      context.fillText(name, x + dx * 1.28, y + dy * 1.28);
      context.restore();
    }
  },

  /** The whole model in the corner, with what the large view shows of it. */
  drawInset(step, whole, view) {
    const { brush, camera } = this;
    const { context } = brush;
    const size = Math.round(Math.min(brush.width, brush.height) * 0.3);
    const [x, y] = [brush.width - size - 10, brush.height - size - 10];
    const large = { ...camera };
    brush.fill("canvas", 0.92, () => context.rect(x, y, size, size));
    brush.stroke("ink", 1, () => context.rect(x, y, size, size), { alpha: 0.5 });
    context.save();
    context.beginPath();
    context.rect(x, y, size, size);
    context.clip();
    camera.zoom = 1;
    camera.pan = [0, 0];
    camera.aim(whole.center, whole.radius, { x, y, width: size, height: size });
    this.drawScenery(0.6);
    brush.boxes([this.frame.rootBox], "ink", 0.8, { alpha: 0.6 });
    const visible = camera.visiblePart(0, Infinity);
    if (visible) {
      const ends = visible.map((d) => add(this.frame.origin, scaled(this.frame.direction, d)));
      brush.line(ends, "ray", 1.2);
    }
    const [cx, cy] = camera.project(view.center);
    const radius = Math.max(view.radius / large.zoom * camera.scale, 5);
    brush.stroke("current", 2, () => context.rect(cx - radius, cy - radius, 2 * radius, 2 * radius));
    context.restore();
    Object.assign(camera, large);
  },
});
