// The lecture's picture of a step: the interval on the ray, the plane, near and far coloured.
//
// Inside [t_near, t_far] it is to scale. Beyond, where the axis is dotted, it is squeezed, so that
// a plane that lies a thousand times farther still has its place on the right side.

const SVG = "http://www.w3.org/2000/svg";

class Picture {
  constructor(element) {
    this.element = element;
  }

  draw(walk, index, drawing) {
    const step = walk.steps[index];
    this.element.replaceChildren();
    this.width = this.element.clientWidth;
    this.height = this.element.clientHeight;
    if (this.width < 50 || this.height < 40) return;
    this.em = parseFloat(getComputedStyle(this.element).fontSize);
    this.element.setAttribute("viewBox", `0 0 ${this.width} ${this.height}`);
    this.hatches();
    this.walk = walk;
    this.frame = drawing.frame;
    this.triangleOf = (face) => drawing.triangles.get(face);
    this.right = this.width - 8;
    if (step.kind === "clip") this.slabs(step);
    else if (step.kind === "inner" && step.t_split === null) this.parallel(step);
    else if (step.kind === "inner") this.split(step);
    else if (step.kind === "leaf") this.leaf(step, drawing.selectedFace);
    else if (step.kind === "pop") this.pop(step, walk.after[index].best);
    else this.end(index, drawing.missEnds());
  }

  add(name, attributes, text, parent = this.element) {
    const element = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    if (text !== undefined) element.textContent = text;
    parent.append(element);
    return element;
  }

  hatches() {
    for (const role of ["near", "far"]) {
      const pattern = this.add("pattern", { id: `hatch-${role}`, width: 8, height: 8,
        patternUnits: "userSpaceOnUse", patternTransform: "rotate(45)" });
      this.add("rect", { width: 8, height: 8, class: "hatch-ground" }, undefined, pattern);
      this.add("rect", { width: 4, height: 8, class: `fill-${role}` }, undefined, pattern);
    }
  }

  line(x1, y1, x2, y2, classes) {
    return this.add("line", { x1, y1, x2, y2, class: classes });
  }

  text(x, y, text, classes = "", anchor = "middle") {
    const element = this.add("text", { x, y, class: classes, "text-anchor": anchor }, text);
    const width = element.getComputedTextLength();
    // A text at the rim is moved in, so that it can be read.
    const start = { start: x, middle: x - width / 2, end: x - width }[anchor];
    const shift = Math.max(2 - start, 0) + Math.min(this.right - start - width, 0);
    if (shift) element.setAttribute("x", x + shift);
    return element;
  }

  rectangle(x, y, width, height, classes) {
    return this.add("rect", { x, y, width: Math.max(width, 0), height, class: classes });
  }

  /** The axis of t, and where on it a t lies. */
  axis(y, low, high, left = 0) {
    const [from, to] = [left + (this.right - left) * 0.24, left + (this.right - left) * 0.76];
    const span = high - low;
    const middle = (from + to) / 2;
    const margin = (to - from) * 0.36;
    const squeezed = (beyond) => margin * (0.25 + 0.75 * (1 - 1 / (1 + beyond)));
    const place = (t) => {
      if (span === Infinity) return t <= low ? from : t >= high ? to : middle;
      if (!(span > 0)) return t < low ? middle - margin : t > high ? middle + margin : middle;
      if (t < low) return t === -Infinity ? from - margin : from - squeezed((low - t) / span);
      if (t > high) return t === Infinity ? to + margin : to + squeezed((t - high) / span);
      return from + (to - from) * ((t - low) / span);
    };
    this.line(left + 6, y, from, y, "axis beyond");
    this.line(from, y, to, y, "axis");
    this.line(to, y, this.right - 8, y, "axis beyond");
    this.add("path", { d: `M${this.right},${y} l-11,-5 v10 z`, class: "axis-head" });
    this.text(this.right - 2, y + 1.2 * this.em, "t", "name", "end");
    return place;
  }

  /** A t with its name and value, below the axis. */
  mark(x, y, name, value, row = 0, classes = "") {
    const below = y + 1.6 * this.em + row * 1.25 * this.em;
    this.line(x, y - 7, x, below - 0.85 * this.em, `tick ${classes}`);
    this.text(x, below, `${name} = ${value}`, `value ${classes}`);
  }

  /** A ray that crosses the plane somewhere: t_split against the interval. */
  split(step) {
    const format = formatter([step.t_near, step.t_split, step.t_far]);
    const y = this.height * 0.5;
    const band = Math.min(this.height * 0.3, 3.4 * this.em);
    const entered = (role) => (step[role] === step.enter ? 0 : step[role] === step.push ? 1 : 2);
    // The whole axis before the plane is the near side, and all behind it the far side.
    const zones = this.add("g", {});
    const place = this.axis(y, step.t_near, step.t_far);
    const [a, s, b] = [step.t_near, step.t_split, step.t_far].map(place);
    for (const [role, from, to] of [["near", 0, s], ["far", s, this.right]]) {
      const attributes = { x: from, y: y - band, width: to - from, height: band * 1.45,
        class: `zone fill-${role}` };
      this.add("rect", attributes, undefined, zones);
    }
    this.zoneWords(s, y - band + 1.1 * this.em,
      ["near", "far"].map((role) => ["enter", "push", "not met"][entered(role)]));
    const thickness = Math.max(12, 0.9 * this.em);
    const bars = b - a < 8 ? [[a - 4, b + 4]] : [[a, b]];
    for (const [from, to] of bars) {
      const cut = Math.min(Math.max(s, from), to);
      for (const [role, left, right] of [["near", from, cut], ["far", cut, to]]) {
        if (right - left < 0.5) continue;
        const style = entered(role) === 1 ? `hatched-${role}` : `fill-${role}`;
        this.rectangle(left, y - thickness / 2, right - left, thickness, `bar ${style}`);
      }
    }
    this.line(s, y - band - 4, s, y + band * 0.6, "plane");
    this.text(s, y - band - 0.6 * this.em, `plane ${step.axis} = ${formatNumber(step.plane)}`,
      "name text-plane");
    if (step.plane_touched) this.add("circle", { cx: s, cy: y, r: 13, class: "touched" });
    const isNarrow = b - a < 11 * this.em;
    this.mark(a, y, "t_near", format(step.t_near), isNarrow ? 2 : 0);
    this.mark(b, y, "t_far", format(step.t_far));
    this.mark(s, y, "t_split", format(step.t_split), 1, "text-plane");
  }

  /** What becomes of the near and the far side, on either side of the plane at x. */
  zoneWords(x, y, [near, far]) {
    const left = this.text(x - 10, y, `near side: ${near}`, "side text-near", "end");
    const right = this.text(x + 10, y, `far side: ${far}`, "side text-far", "start");
    const isMoved = [() => left.getBBox().x + left.getBBox().width > x, () => right.getBBox().x < x];
    // A text that is wider than its side was moved over the plane: say less, else one line lower.
    for (const [k, text] of [left, right].entries()) {
      if (!isMoved[k]()) continue;
      text.textContent = text.textContent.replace(" side", "");
      text.setAttribute("x", k === 0 ? Math.max(x - 10, text.getBBox().width + 2)
        : Math.min(x + 10, this.right - text.getBBox().width));
      if (isMoved[k]()) text.setAttribute("y", y + 1.1 * this.em);
    }
  }

  /** A ray that never crosses the plane, or lies in it. */
  parallel(step) {
    const format = formatter([step.t_near, step.t_far]);
    const middle = this.height * 0.46;
    const reach = this.height * 0.32;
    const isIn = step.case === "in plane";
    const isBelow = step.case === "parallel, below";
    const roles = step.near !== null && this.walk.cells[step.near]?.side === "above"
      ? ["far", "near"] : ["near", "far"];
    const [below, above] = roles;
    const fate = (role) => (step[role] === step.enter ? "enter" : step[role] === step.push ? "push"
      : "not met");
    this.rectangle(0, middle - reach, this.right, reach, `zone fill-${above}`);
    this.rectangle(0, middle, this.right, reach, `zone fill-${below}`);
    const sides = [[above, "above", middle - reach + 1.2 * this.em],
      [below, "below", middle + reach - 0.5 * this.em]];
    for (const [role, side, y] of sides) {
      this.text(8, y, `${side}: ${fate(role)}`, `side text-${role}`, "start");
    }
    this.line(0, middle, this.right, middle, "plane");
    this.text(this.right - 4, middle - 0.5 * this.em,
      `plane ${step.axis} = ${formatNumber(step.plane)}`, "name text-plane", "end");
    const y = isIn ? middle : middle + (isBelow ? 0.45 : -0.45) * reach;
    const [a, b] = [this.right * 0.28, this.right * 0.62];
    this.line(6, y, b + 60, y, "axis beyond");
    this.add("path", { d: `M${b + 70},${y} l-11,-5 v10 z`, class: "axis-head" });
    const role = isBelow ? below : above;
    const thickness = Math.max(12, 0.9 * this.em);
    if (isIn) {
      this.rectangle(a, y - thickness / 2, b - a, thickness / 2, `bar fill-${above}`);
      this.rectangle(a, y, b - a, thickness / 2, `bar fill-${below}`);
    } else {
      this.rectangle(a, y - thickness / 2, b - a, thickness, `bar fill-${role}`);
    }
    const words = this.height - 0.6 * this.em;
    for (const [x, name, t] of [[a, "t_near", step.t_near], [b, "t_far", step.t_far]]) {
      this.line(x, y - 8, x, words - 0.9 * this.em, "tick");
      this.text(x, words, `${name} = ${format(t)}`, "value");
    }
  }

  /** The root's box as three slabs: the ray is in the box where it is in all of them. */
  slabs(step) {
    const { ray, cells } = this.walk.data;
    const bounds = cells[0]?.bounds;
    if (!isBox(bounds)) {
      this.text(this.right / 2, this.height / 2, "no box: there are no triangles", "side");
      return;
    }
    const parts = [...AXES.map((axis, k) => [`in ${axis}`, slabOf(ray, bounds, k)]),
      ["ray’s t", [ray.t_min ?? -Infinity, ray.t_max ?? Infinity]]];
    const met = parts.filter(([, part]) => part);
    const entered = met.reduce((a, b) => (b[1][0] > a[1][0] ? b : a));
    const first = met.reduce((a, b) => (b[1][1] < a[1][1] ? b : a));
    const [enter, leave] = [entered[1][0], first[1][1]];
    // Show what decides: where the last slab is entered and the first one left.
    const span = Math.abs(leave - enter);
    const isScaled = Number.isFinite(span) && span > 0;
    const gutter = 4.6 * this.em;
    const width = this.right - gutter;
    const place = (t) => {
      if (!isScaled) return gutter + width * (t < enter ? 0.1 : t > leave ? 0.9 : 0.5);
      const share = 0.33 + 0.34 * (t - Math.min(enter, leave)) / span;
      return gutter + width * Math.min(Math.max(share, 0), 1);
    };
    const row = Math.min(this.height / 6, 2.1 * this.em);
    const bar = (y, [from, to], style) =>
      this.rectangle(place(from), y - row * 0.3, Math.max(place(to) - place(from), 4),
        row * 0.6, `bar ${style}`);
    parts.forEach(([name, part], index) => {
      const y = row * (index + 0.75);
      this.text(gutter - 8, y + 0.33 * this.em, name, "name", "end");
      this.line(gutter, y, this.right, y, "axis beyond");
      if (part) bar(y, part, index < 3 ? "slab" : "slab-ray");
      else this.text(gutter + 10, y - 0.2 * this.em, "never: it runs beside the slab", "side", "start");
    });
    const y = row * 4.75;
    this.line(gutter, y, this.right, y, "axis");
    this.text(gutter - 8, y + 0.33 * this.em, "in all", "name strong", "end");
    for (const t of [enter, leave]) {
      if (Number.isFinite(t)) this.line(place(t), row * 0.3, place(t), y + 4, "guide");
    }
    const format = formatter([enter, leave]);
    const middle = gutter + width / 2;
    const below = y + 1.5 * this.em;
    if (!step.is_met) {
      const words = met.length < 4 || enter <= leave ? "nowhere"
        : `nowhere: it leaves “${first[0]}” at t = ${format(leave)}, `
          + `before it enters “${entered[0]}” at t = ${format(enter)}`;
      this.text(middle, below, words, "value");
      return;
    }
    bar(y, [step.t_near, step.t_far ?? Infinity], "interval");
    const [a, b] = [place(step.t_near), place(step.t_far ?? Infinity)];
    const words = [`t_near = ${format(step.t_near)}`, `t_far = ${format(step.t_far)}`];
    if (b - a > 13 * this.em) {
      this.text(a, below, words[0], "value");
      this.text(b, below, words[1], "value");
    } else {
      this.text(middle, below, words.join(",  "), "value");
    }
  }

  /** A leaf: where on the ray its triangles are met, and how they look along the ray. */
  leaf(step, selectedFace) {
    this.along(step.tests, selectedFace, step.t_near);
    const format = formatter([step.t_near, step.t_far]);
    const y = this.height * 0.52;
    const place = this.axis(y, step.t_near, step.t_far);
    const [a, b] = [place(step.t_near), place(step.t_far)];
    this.rectangle(Math.min(a, b - 6), y - 6, Math.max(b - a, 6), 12, "bar interval");
    this.mark(a, y, "t_near", format(step.t_near), b - a < 11 * this.em ? 1 : 0);
    this.mark(b, y, "t_far", format(step.t_far));
    const met = step.tests.filter((test) => test.t !== null).sort((p, q) => p.t - q.t);
    for (const test of met) {
      const { color, mark } = VERDICTS[test.verdict];
      const x = place(test.t);
      this.line(x, y - 1.4 * this.em, x, y + 8, `met stroke-${color}`);
      if (met.length <= 4 || test.face === step.closest?.face) {
        const row = met.indexOf(test) % 3;
        this.text(x, y - (1.8 + 1.15 * row) * this.em, `${test.face} ${mark}`, "name");
      }
    }
    if (met.length === 0) this.text((a + b) / 2, y - 1.4 * this.em, "nothing met", "side");
  }

  /** Triangles as seen along the ray, which is the cross in the middle; takes its place at the
   * right. `t` is where on the ray they are, so that a far origin costs no digits. */
  along(tests, selectedFace, t, nearest = null) {
    const side = Math.min(this.height - 8, this.width * 0.36);
    const left = this.width - side - 2;
    this.right = left - 16;
    const view = viewAlong(this.frame, this.frame.at(t));
    const selected = this.triangleOf(selectedFace);
    const reach = [...(selected ?? []), ...(nearest ? [nearest] : [])].flatMap((p) => view(p));
    const scale = side * 0.42 / (Math.max(...reach.map(Math.abs)) || 1);
    const middle = [left + side / 2, 4 + side / 2];
    const place = (p) => view(p).map((value, k) => middle[k] + value * scale);
    const clip = this.add("clipPath", { id: "window" });
    this.add("rect", { x: left, y: 4, width: side, height: side }, undefined, clip);
    this.rectangle(left, 4, side, side, "window");
    const group = this.add("g", { "clip-path": "url(#window)" });
    const shape = (face, classes) => {
      const points = this.triangleOf(face)?.map((p) => place(p).join()).join(" ");
      if (points) this.add("polygon", { points, class: classes }, undefined, group);
    };
    const color = (test) => `fill-${VERDICTS[test.verdict].color}`;
    const others = tests.filter((test) => test.face !== selectedFace).slice(0, 200);
    for (const test of others) shape(test.face, `seen ${color(test)}`);
    const test = tests.find((one) => one.face === selectedFace);
    if (selected && test) {
      shape(selectedFace, `seen selected ${color(test)}`);
      this.nameParts(test, selected.map(place), group);
    }
    const [x, y] = middle;
    const isBeside = test?.verdict === "outside" && selected && !nearest;
    const end = nearest ? place(nearest) : isBeside ? nearestOf(selected.map(place), middle) : null;
    if (end) this.line(x, y, end[0], end[1], "gap");
    this.line(x - 8, y, x + 8, y, "cross");
    this.line(x, y - 8, x, y + 8, "cross");
    this.add("text", { x: left + 5, y: side - 2, class: "small" }, "seen along the ray");
  }

  /** Corners and edge signs of a triangle, and the edge that the ray passes outside of. */
  nameParts(test, corners, group) {
    const center = [0, 1].map((k) => (corners[0][k] + corners[1][k] + corners[2][k]) / 3);
    const inwards = (p, share) => p.map((value, k) => value + (center[k] - value) * share);
    const label = ([x, y], text, classes) => this.add("text",
      { x, y: y + 0.35 * this.em, class: classes, "text-anchor": "middle" }, text, group);
    corners.forEach((corner, k) => {
      const [[x1, y1], [x2, y2]] = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
      if (test.edge === EDGES[k]) {
        this.add("line", { x1, y1, x2, y2, class: "crossed-edge" }, undefined, group);
      }
      const sign = signText(test.edge_signs?.[k]);
      label(inwards([(x1 + x2) / 2, (y1 + y2) / 2], 0.28), sign, "sign");
      label(inwards(corner, 0.16), "abc"[k], "corner");
    });
  }

  /** A cell from the stack, against the closest hit so far. */
  pop(step, best) {
    const format = formatter([step.t_near, step.t_far, best?.t]);
    const y = this.height * 0.5;
    const place = this.axis(y, step.t_near, step.t_far);
    const [a, b] = [place(step.t_near), place(step.t_far)];
    const style = step.is_entered ? "interval" : "dropped";
    this.rectangle(Math.min(a, b - 6), y - 7, Math.max(b - a, 6), 14, `bar ${style}`);
    this.text((a + b) / 2, y - 1.1 * this.em, step.is_entered ? "entered" : "dropped", "side");
    const isNarrow = b - a < 11 * this.em;
    this.mark(a, y, "t_near", format(step.t_near), isNarrow ? 1 : 0);
    this.mark(b, y, "t_far", format(step.t_far));
    if (!best) return;
    const x = place(best.t);
    this.line(x, y - 2.6 * this.em, x, y + 8, "met stroke-hit");
    this.add("circle", { cx: x, cy: y, r: 6, class: "fill-hit" });
    this.text(x, y - 3 * this.em, `closest hit: t = ${format(best.t)}`, "name");
  }

  /** All leaves that were visited, along the ray, and the hit. */
  end(index, [, nearest]) {
    const miss = this.walk.data.nearest_miss;
    if (miss && nearest) {
      this.along([{ ...miss, verdict: "outside" }], miss.face, miss.t, nearest);
    }
    const steps = this.walk.leavesUpTo(index).map((leaf) => this.walk.steps[leaf]);
    const clip = this.walk.steps.find((step) => step.kind === "clip");
    if (!clip?.is_met || clip.t_far === null) {
      this.text(this.right / 2, this.height / 2, "no cell was visited", "side");
      return;
    }
    const y = this.height * 0.5;
    const { best } = this.walk.after[index];
    const format = formatter([clip.t_near, clip.t_far, best?.t]);
    const place = this.axis(y, clip.t_near, clip.t_far);
    steps.forEach((step, order) => {
      const [a, b] = [place(step.t_near), place(step.t_far)];
      this.rectangle(a, y - 8, Math.max(b - a, 2), 16, `bar ${order % 2 ? "leaf-odd" : "leaf-even"}`);
    });
    const leaves = steps.length === 1 ? "one leaf visited" : `${formatCount(steps.length)} leaves visited`;
    this.text(this.right / 2, y + 3.4 * this.em, leaves, "side");
    this.mark(place(clip.t_near), y, "t_near", format(clip.t_near));
    this.mark(place(clip.t_far), y, "t_far", format(clip.t_far));
    if (best) {
      const x = place(best.t);
      this.line(x, y - 2 * this.em, x, y + 10, "met stroke-hit");
      this.add("circle", { cx: x, cy: y, r: 6, class: "fill-hit" });
      this.text(x, y - 2.4 * this.em, `hit: t = ${format(best.t)}`, "name");
    } else {
      this.text(this.right / 2, y - 1.6 * this.em, "no hit", "name");
    }
  }
}

/** The edges opposite the corners a, b and c. */
const EDGES = ["b-c", "c-a", "a-b"];

const signText = (sign) => (sign > 0 ? "+" : sign < 0 ? "−" : sign === 0 ? "0" : "");

/** Where a ray is within one axis' sides of a box; `null` if nowhere. */
function slabOf({ origin, direction }, [low, high], axis) {
  if (direction[axis] === 0) {
    const isInside = low[axis] <= origin[axis] && origin[axis] <= high[axis];
    return isInside ? [-Infinity, Infinity] : null;
  }
  const ts = [low, high].map((side) => (side[axis] - origin[axis]) / direction[axis]);
  return [Math.min(...ts), Math.max(...ts)];
}

/** The position on a triangle's edges that is nearest to a point, in the plane of the picture. */
function nearestOf(corners, [x, y]) {
  const candidates = corners.map(([x1, y1], k) => {
    const [x2, y2] = corners[(k + 1) % 3];
    const squared = (x2 - x1) ** 2 + (y2 - y1) ** 2;
    const share = squared > 0 ? ((x - x1) * (x2 - x1) + (y - y1) * (y2 - y1)) / squared : 0;
    const inside = Math.min(Math.max(share, 0), 1);
    return [x1 + inside * (x2 - x1), y1 + inside * (y2 - y1)];
  });
  const distance = ([x1, y1]) => Math.hypot(x1 - x, y1 - y);
  return candidates.reduce((a, b) => (distance(b) < distance(a) ? b : a));
}

/** Looks along the ray: from positions to right and down, with `start` on the ray at zero. */
function viewAlong({ direction }, start) {
  const sizes = direction.map(Math.abs);
  const helper = [0, 0, 0];
  helper[sizes.indexOf(Math.min(...sizes))] = 1;
  const across = cross(direction, helper);
  const right = scaled(across, 1 / length(across));
  const up = cross(right, direction);
  return (p) => [dot(right, subtract(p, start)), -dot(up, subtract(p, start))];
}
