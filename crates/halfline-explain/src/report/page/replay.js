// What the walk's steps add up to: the stack, the best hit and the cells seen after each of them.

/** True for an inner step whose ray never crosses the plane. */
const isParallel = (step) => step.case === "in plane" || step.case.startsWith("parallel");

/** A step with the infinite t that JSON cannot hold. */
function withInfinities(step) {
  if (step.kind === "clip" || step.kind === "end") return step;
  const ends = ([from, to]) => [from ?? -Infinity, to ?? Infinity];
  const [t_near, t_far] = ends([step.t_near, step.t_far]);
  if (step.kind !== "inner") return { ...step, t_near, t_far };
  const t_split = step.t_split === null && !isParallel(step)
    ? { "near only": Infinity, "far only": -Infinity }[step.case] ?? t_far : step.t_split;
  return {
    ...step, t_near, t_far, t_split,
    enter_interval: ends(step.enter_interval),
    push_interval: step.push_interval && ends(step.push_interval),
  };
}

/** Everything that the page asks about a walk, ready to be asked about any step. */
class Walk {
  constructor(data) {
    this.data = data;
    this.steps = data.steps.map(withInfinities);
    this.cells = data.cells;
    this.after = [];
    this.leafSteps = [];
    // The stack is a chain of entries, so that each step can keep its own at no cost.
    let stack = null;
    let best = null;
    for (const [index, step] of this.steps.entries()) {
      let pushed = null;
      let popped = null;
      if (step.kind === "inner" && step.push !== null) {
        pushed = { cell: step.push, interval: step.push_interval, below: stack };
        pushed.size = 1 + (stack ? stack.size : 0);
        stack = pushed;
      } else if (step.kind === "pop" && stack) {
        popped = stack;
        stack = stack.below;
      } else if (step.kind === "leaf") {
        this.leafSteps.push(index);
        const { closest } = step;
        const isNearer = closest && (!best || closest.t < best.t
          || (closest.t === best.t && closest.face < best.face));
        if (isNearer) best = closest;
      }
      this.after.push({ stack, pushed, popped, best });
    }
  }

  /** The entries of the stack after a step, top first. */
  stackAfter(index) {
    const entries = [];
    for (let entry = this.after[index].stack; entry; entry = entry.below) entries.push(entry);
    return entries;
  }

  /** The steps at leaves up to this one. */
  leavesUpTo(index) {
    return this.leafSteps.filter((leaf) => leaf <= index);
  }

  /** The cells above a cell, from its parent to the root. */
  ancestors(cell) {
    const above = [];
    let parent = this.cells[cell]?.parent;
    while (parent !== null && parent !== undefined && above.length < this.cells.length) {
      above.push(parent);
      parent = this.cells[parent].parent;
    }
    return above;
  }

  /** The cell that a step is about; the last step is about the root. */
  cellOf(step) {
    return step.cell ?? 0;
  }

  /** Of a leaf's triangles the one to look at first: what is hit, else what is missed by least. */
  firstToLookAt(step) {
    if (step.closest) return step.closest.face;
    const by = (test) => test.by ?? Infinity;
    const least = (a, b) => (by(b) < by(a) ? b : a);
    return step.tests.length ? step.tests.reduce(least).face : null;
  }
}

/** The names that the page gives to the lecture's cases, with the comparison that decides. */
function caseWords(step) {
  const touched = step.plane_touched ? ", plane touched" : "";
  const along = `direction ${step.axis} = 0`;
  switch (step.case) {
    case "near only": return [`near only${touched}`, "t_far < t_split"];
    case "far only": return [`far only${touched}`, "t_split < t_near"];
    case "both": return [`both${touched}`, touchedWords(step)];
    case "parallel, below": return [step.case, `${along}, and the origin lies below the plane`];
    case "parallel, above": return [step.case, `${along}, and the origin lies above the plane`];
    case "in plane": return [step.case, `${along}, and the origin lies on the plane`];
    default: return [String(step.case), ""];
  }
}

function touchedWords(step) {
  if (!step.plane_touched) return "t_near ≤ t_split ≤ t_far";
  const isNearEnd = Math.abs(step.t_split - step.t_near) <= Math.abs(step.t_far - step.t_split);
  return isNearEnd ? "t_split touches t_near" : "t_split touches t_far";
}

/** How each verdict is shown: a mark, so that colour is never alone, and a colour. */
const VERDICTS = {
  hit: { mark: "●", color: "hit" },
  farther: { mark: "◐", color: "farther" },
  beyond: { mark: "▷", color: "beyond" },
  behind: { mark: "◁", color: "behind" },
  outside: { mark: "○", color: "outside" },
  "edge-on": { mark: "│", color: "edge-on" },
  "no area": { mark: "×", color: "no-area" },
};

/** Numbers that are shown together, with digits enough to tell them apart, six at least. */
function formatter(values) {
  const finite = values.filter((value) => typeof value === "number" && Number.isFinite(value));
  const largest = Math.max(0, ...finite.map(Math.abs));
  const sorted = [...new Set(finite)].sort((a, b) => a - b);
  const gaps = sorted.slice(1).map((value, index) => value - sorted[index]);
  // Gaps of a few roundings are no more than that, and need no digits.
  const gap = Math.min(...gaps.filter((width) => width > 1e-13 * largest), largest || 1);
  const digits = Math.min(Math.max(6, Math.ceil(Math.log10(largest / gap) || 0) + 3), 15);
  return (value) => formatNumber(value, digits);
}

/** The shortest text of a number's first digits. */
function formatNumber(value, digits = 6) {
  if (value === null || value === undefined) return "∞";
  if (Number.isNaN(value)) return "not a number";
  if (Math.abs(value) === Infinity) return value < 0 ? "−∞" : "∞";
  const rounded = Number(value.toPrecision(digits));
  const isSmall = rounded !== 0 && Math.abs(rounded) < 1e-4;
  const text = isSmall ? rounded.toExponential() : String(rounded);
  return text.replace("e+", "e").replaceAll("-", "−");
}

const formatCount = (count) => String(count).replace(/\B(?=(\d{3})+$)/g, ",");
const formatPosition = (p, format = formatter(p)) => `(${p.map(format).join(", ")})`;
