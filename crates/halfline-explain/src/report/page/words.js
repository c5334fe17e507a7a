// The right side: a step in words and numbers, the stack, the triangles, the list, the costs.

const KINDS = { clip: "clip to the box", inner: "inner cell", leaf: "leaf", pop: "pop", end: "end" };

const byId = (id) => document.getElementById(id);

/** An element with text or elements in it. */
function make(name, content, attributes = {}) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  element.append(...(Array.isArray(content) ? content : [content]));
  return element;
}

/** A number as shown, which keeps the whole number for whoever asks. */
function numberCell(value, format, attributes = {}) {
  if (value === null || value === undefined) return make("td", "", { class: "number", ...attributes });
  const data = make("data", format(value), { value: String(value), title: String(value) });
  return make("td", [data], { class: "number", ...attributes });
}

class Words {
  constructor(walk, select, goTo) {
    this.walk = walk;
    this.select = select;
    this.items = [];
    this.makeList(goTo);
    this.makeSummary();
    this.makeLegend();
    byId("tests").tBodies[0].addEventListener("click", (event) => {
      const row = event.target.closest("tr");
      if (row) this.select(Number(row.dataset.face));
    });
  }

  show(index, selectedFace) {
    const step = this.walk.steps[index];
    const cell = this.walk.cells[this.walk.cellOf(step)];
    const total = this.walk.steps.length;
    const where = step.kind === "inner" || step.kind === "leaf" || step.kind === "pop"
      ? `, cell ${step.cell}, depth ${cell.depth}` : "";
    byId("heading").textContent = `Step ${index}: ${KINDS[step.kind] ?? step.kind}${where}`;
    byId("why").textContent = step.why ?? "";
    byId("position").textContent = `${index} / ${total - 1}`;
    this.showCase(step);
    this.showNumbers(step, cell);
    this.showTests(step, selectedFace);
    this.showStack(index);
    this.showResult(step);
    this.showCurrent(index);
    const isOpen = index === 0 || index === total - 1;
    if (this.isOpen !== isOpen) byId("summary").open = isOpen;
    this.isOpen = isOpen;
  }

  showCase(step) {
    const figure = byId("case");
    const texts = {
      clip: () => (step.is_met ? ["the box is met", "in all three slabs at once"]
        : ["the box is missed", "never in all three slabs at once"]),
      inner: () => caseWords(step),
      leaf: () => (step.closest ? ["leaf: hit", `face ${step.closest.face}`]
        : ["leaf: no hit", "no triangle of it is met"]),
      pop: () => (step.is_entered ? ["popped and entered", "it may hold a nearer hit"]
        : ["popped and dropped", "the hit lies before it"]),
      end: () => (step.hit ? ["hit", `face ${step.hit.face} at t = ${formatNumber(step.hit.t)}`]
        : ["missed", ""]),
    };
    const [name, rule] = texts[step.kind]?.() ?? ["", ""];
    figure.replaceChildren(make("strong", name), rule ? make("span", rule) : "");
  }

  showNumbers(step, cell) {
    const rows = [];
    const format = formatter([step.t_near, step.t_split, step.t_far]);
    const row = (name, ...cells) => rows.push(make("tr", [make("th", name, { scope: "row" }), ...cells]));
    const plain = (value) => (number) => (number === null ? value : String(number));
    const onRay = (name, t) => {
      if (t === undefined) return;
      row(name, t === null ? make("td", name === "t_split" ? "none: parallel" : "none", { class: "number" }) : numberCell(t, format));
    };
    if (step.kind !== "end") {
      row("cell", numberCell(this.walk.cellOf(step), plain("")));
      row("depth", numberCell(cell?.depth ?? null, plain("")));
      if (step.kind === "inner") {
        row("axis", make("td", step.axis, { class: "number" }));
        row("plane", numberCell(step.plane, this.planeFormat(cell, step)));
      }
      onRay("t_near", step.t_near);
      if (step.kind === "inner") onRay("t_split", step.t_split);
      onRay("t_far", step.t_far);
      row("triangles in it", numberCell(cell?.triangles ?? null, formatCount));
    }
    if (step.kind === "inner") {
      row("enter", this.childCell(step, step.enter, step.enter_interval));
      row("push", step.push === null ? make("td", "nothing") :
        this.childCell(step, step.push, step.push_interval));
    }
    byId("numbers").tBodies[0].replaceChildren(...rows);
  }

  /** A plane with digits enough to be told from the sides of its cell. */
  planeFormat(cell, step) {
    const axis = AXES.indexOf(step.axis);
    return formatter([step.plane, ...(isBox(cell?.bounds) ? cell.bounds.map((p) => p[axis]) : [])]);
  }

  childCell(step, child, interval) {
    const role = child === step.near ? "near" : child === step.far ? "far" : "";
    const text = `cell ${child}${interval ? ` ${intervalText(interval)}` : ""}`;
    return make("td", [make("b", role, { class: `role-${role}` }), ` ${text}`]);
  }

  showTests(step, selectedFace) {
    const isLeaf = step.kind === "leaf";
    byId("tests-section").hidden = !isLeaf;
    if (!isLeaf) return;
    const format = formatter(step.tests.map((test) => test.t));
    const rows = step.tests.map((test) => {
      const { mark, color } = VERDICTS[test.verdict] ?? { mark: "", color: "ink" };
      const badge = make("span", mark, { class: `mark text-${color}`, "aria-hidden": "true" });
      const face = make("button", String(test.face), { type: "button" });
      const isSelected = test.face === selectedFace;
      face.setAttribute("aria-pressed", isSelected);
      const edge = test.edge === null || test.by === null ? []
        : [make("data", formatNumber(test.by, 4), { value: String(test.by), title: String(test.by) }),
          ` outside ${test.edge}`];
      return make("tr", [
        make("td", [face]),
        ...test.edge_signs.map((sign) => make("td", signText(sign), { class: "sign" })),
        make("td", [badge, ` ${test.verdict}`]),
        numberCell(test.t, format),
        make("td", edge),
      ], { "data-face": test.face, title: test.why ?? "", class: isSelected ? "selected" : "" });
    });
    byId("tests").tBodies[0].replaceChildren(...rows);
    const selected = step.tests.find((test) => test.face === selectedFace);
    byId("test-why").textContent = selected ? `Face ${selected.face}: ${selected.why}` : "";
  }

  showStack(index) {
    const { pushed, popped } = this.walk.after[index];
    const entries = this.walk.stackAfter(index);
    const box = (entry, note) => make("li", [
      make("b", `cell ${entry.cell}`), ` ${intervalText(entry.interval)} `,
      note ? make("em", note) : "",
    ], { class: note, "data-cell": entry.cell });
    const boxes = entries.slice(0, 40).map((entry) => box(entry, entry === pushed ? "pushed" : ""));
    if (popped) boxes.unshift(box(popped, "popped"));
    if (entries.length > 40) boxes.push(make("li", `and ${entries.length - 40} more`));
    if (entries.length === 0) boxes.push(make("li", "empty", { class: "empty" }));
    byId("stack").replaceChildren(...boxes);
  }

  /** What came of the walk, on its last step. */
  showResult(step) {
    const { hit, nearest_miss: miss } = this.walk.data;
    const section = byId("result");
    section.hidden = step.kind !== "end";
    if (section.hidden) return;
    const rows = (heading, pairs) => section.replaceChildren(
      make("h3", heading),
      make("table", [make("tbody", pairs.map(([name, value]) =>
        make("tr", [make("th", name, { scope: "row" }), make("td", value)])))]));
    if (hit) {
      rows("The hit", [["face", String(hit.face)], ["t", formatNumber(hit.t)],
        ["u, v", hit.uv.map((value) => formatNumber(value)).join(", ")],
        ["point", formatPosition(hit.point)]]);
    } else if (miss) {
      rows("The nearest miss", [["face", String(miss.face)],
        ["by", formatNumber(miss.distance)], ["why", miss.why],
        ["at t", formatNumber(miss.t)], ["on the ray", formatPosition(miss.point_on_ray)],
        ["on the face", formatPosition(miss.point_on_face)]]);
    } else {
      section.replaceChildren();
    }
  }

  makeList(goTo) {
    const deepest = Math.max(1, ...this.walk.cells.map((cell) => cell.depth));
    const list = byId("list");
    for (const [index, step] of this.walk.steps.entries()) {
      const depth = this.walk.cells[this.walk.cellOf(step)]?.depth ?? 0;
      const button = make("button", [make("span", String(index), { class: "count" }),
        make("span", listText(step))], { type: "button", tabindex: "-1", class: `step-${step.kind}` });
      button.style.setProperty("--indent", (depth / Math.max(deepest, 8)).toFixed(3));
      this.items.push(button);
      list.append(make("li", [button]));
    }
    list.addEventListener("click", (event) => {
      const position = this.items.indexOf(event.target.closest("button"));
      if (position >= 0) goTo(position);
    });
  }

  /** Marks the step in the list, and scrolls the list, and nothing else, to it. */
  showCurrent(index) {
    const previous = this.current;
    if (previous) {
      previous.removeAttribute("aria-current");
      previous.tabIndex = -1;
    }
    this.current = this.items[index];
    this.current.setAttribute("aria-current", "step");
    this.current.tabIndex = 0;
    const list = byId("list");
    const [item, view] = [this.current.getBoundingClientRect(), list.getBoundingClientRect()];
    if (item.top < view.top + 30 || item.bottom > view.bottom - 30) {
      list.scrollTop += (item.top + item.bottom - view.top - view.bottom) / 2;
    }
  }

  makeSummary() {
    const { counts, mesh, tree, ending, ray } = this.walk.data;
    byId("ending").textContent = ending;
    const names = [["brute_force", "brute force"], ["textbook", "textbook tree"],
      ["engine", "fast tree"]];
    const rows = names.filter(([key]) => counts[key]).map(([key, name]) => make("tr", [
      make("th", name, { scope: "row" }),
      ...["nodes", "leaves", "triangles"].map((what) => numberCell(counts[key][what], formatCount)),
    ], { "data-who": key }));
    byId("counts").tBodies[0].replaceChildren(...rows);
    const share = (key) => formatNumber(100 * counts[key].triangles / mesh.triangles, 2);
    byId("share").textContent = mesh.triangles > 0
      ? `Of ${formatCount(mesh.triangles)} triangles the textbook tree tests ${share("textbook")} %, `
        + `the fast tree ${share("engine")} %.`
      : "The mesh has no triangles.";
    const first = ray.t_min === null ? "−∞" : formatNumber(ray.t_min);
    const range = `t from ${first} to ${formatNumber(ray.t_max)}`;
    byId("setting").textContent = `Ray from ${formatPosition(ray.origin)} along `
      + `${formatPosition(ray.direction)}, ${range}. Textbook tree: planes by ${ruleWords(tree.rule)}, `
      + `at most ${tree.few_triangles} triangles in a leaf or ${tree.maximum_depth} levels.`;
  }

  makeLegend() {
    const entries = [["current", "this cell"], ["near", "near"], ["far", "far"],
      ["plane", "plane"], ["stack", "on the stack"], ["visited", "visited"]];
    byId("legend").replaceChildren(...entries.map(([key, text]) =>
      make("li", [make("i", "", { class: `key-${key}` }), text])));
  }

  /** The fast tree's steps, of which a click draws the box. */
  makeEngine(showBox) {
    const steps = this.walk.data.engine?.steps ?? [];
    byId("engine").hidden = steps.length === 0;
    byId("engine-words").textContent = "Its nodes have up to eight children with boxes of their own; "
      + "t limit is the closest hit so far. Choose a row to draw its box.";
    const body = byId("engine-steps").tBodies[0];
    body.replaceChildren(...steps.map((step, index) => make("tr", [
      make("td", [make("button", String(index), { type: "button", "aria-pressed": "false" })],
        { class: "number" }),
      make("td", step.kind), make("td", String(step.depth), { class: "number" }),
      make("td", step.kind === "leaf" ? (step.faces ?? []).join(", ") : `${step.children} children`),
      make("td", formatNumber(step.t_limit), { class: "number" }),
    ])));
    body.addEventListener("click", (event) => {
      const row = event.target.closest("tr");
      if (!row) return;
      const isShown = row.classList.toggle("selected");
      for (const other of body.rows) {
        if (other !== row) other.classList.remove("selected");
        const isPressed = other === row && isShown;
        other.querySelector("button").setAttribute("aria-pressed", isPressed);
      }
      showBox(isShown ? steps[row.sectionRowIndex].bounds : null);
    });
  }
}

function intervalText(interval) {
  const format = formatter(interval);
  return `[${interval.map(format).join(", ")}]`;
}

function ruleWords(rule) {
  return { sah: "the surface-area heuristic", middle: "the cell’s middle",
    median: "the triangles’ median" }[rule] ?? rule;
}

/** A step in a few words, for the list. */
function listText(step) {
  switch (step.kind) {
    case "clip": return step.is_met ? "clip: the box is met" : "clip: the box is missed";
    case "inner": return `${step.axis} = ${formatNumber(step.plane)}: ${caseWords(step)[0]}`;
    case "leaf": {
      const count = step.tests.length === 1 ? "1 triangle" : `${formatCount(step.tests.length)} triangles`;
      return `leaf: ${count}, ${step.closest ? `hits ${step.closest.face}` : "no hit"}`;
    }
    case "pop": return `pop cell ${step.cell}${step.is_entered ? "" : ": dropped"}`;
    default: return step.hit ? `end: face ${step.hit.face}` : "end: missed";
  }
}
