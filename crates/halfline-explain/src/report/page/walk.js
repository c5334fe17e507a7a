// The page: which step is shown, and by which keys, buttons and links one gets to another.

const walk = new Walk(JSON.parse(byId("walk-data").textContent));
const drawing = new Drawing(byId("drawing"), walk);
const picture = new Picture(byId("picture"));
const words = new Words(walk, selectFace, goTo);
const wantsLessMotion = matchMedia("(prefers-reduced-motion: reduce)");

const MILLISECONDS_PER_STEP = 1100;
const MILLISECONDS_OF_FLIGHT = 320;

let current = -1;
let colors = readColors();
let view = null;
let flight = null;
let isAsked = false;
let hashTimer = 0;
let playTimer = 0;

/** The colours of the style sheet, for the canvas. */
function readColors() {
  const style = getComputedStyle(document.documentElement);
  const names = ["canvas", "ink", "ray", "current", "near", "far", "plane", "stack", "visited",
    "scenery", "interval", "engine", "hit", "farther", "beyond", "behind", "outside", "edge-on",
    "no-area"];
  return Object.fromEntries(names.map((name) => [name, style.getPropertyValue(`--${name}`).trim()]));
}

/** Shows a step; the first is 0, as in the explanation. */
function goTo(index, { isSudden = false } = {}) {
  const wanted = Math.min(Math.max(Math.trunc(index), 0), walk.steps.length - 1);
  if (wanted === current || Number.isNaN(wanted)) return;
  current = wanted;
  const step = walk.steps[current];
  drawing.selectedFace = step.kind === "leaf" ? walk.firstToLookAt(step) : null;
  words.show(current, drawing.selectedFace);
  drawPicture();
  byId("slider").value = current;
  byId("slider").setAttribute("aria-valuetext", `step ${current}: ${listText(step)}`);
  byId("drawing").setAttribute("aria-label",
    `The cells, the ray and the triangles at step ${current}: ${step.why ?? ""}`);
  const atStart = current === 0;
  const atEnd = current === walk.steps.length - 1;
  for (const id of ["first", "back"]) byId(id).setAttribute("aria-disabled", atStart);
  for (const id of ["forward", "last"]) byId(id).setAttribute("aria-disabled", atEnd);
  if (atEnd) pause();
  tellState(step);
  writeHash();
  aim(isSudden);
}

/** What the page shows, for programs. */
function tellState(step) {
  const cell = walk.cellOf(step);
  Object.assign(document.body.dataset, {
    step: current, steps: walk.steps.length, kind: step.kind, cell,
    depth: walk.cells[cell]?.depth ?? "", case: step.case ?? "", drawn: "",
    stack: walk.stackAfter(current).map((entry) => entry.cell).join(" "),
  });
}

function drawPicture() {
  picture.draw(walk, current, drawing);
}

function selectFace(face) {
  drawing.selectedFace = face;
  words.show(current, face);
  drawPicture();
  ask();
}

/** Flies to where the step is best seen. */
function aim(isSudden) {
  const target = drawing.target(current);
  if (!view || isSudden || wantsLessMotion.matches) {
    view = target;
    flight = null;
  } else {
    flight = { from: view, to: target, start: performance.now() };
  }
  ask();
}

/** Asks for the drawing to be made anew, once, when the screen is ready for it. */
function ask() {
  if (isAsked) return;
  isAsked = true;
  requestAnimationFrame((now) => {
    isAsked = false;
    if (flight) {
      const share = Math.min(Math.max((now - flight.start) / MILLISECONDS_OF_FLIGHT, 0), 1);
      const eased = share * share * (3 - 2 * share);
      const { from, to } = flight;
      const radius = from.radius * (to.radius / from.radius) ** eased;
      // The centre keeps pace with the radius, so that a deep cell does not rush out of view.
      const change = to.radius - from.radius;
      const pace = Math.abs(change) > 1e-9 * to.radius ? (radius - from.radius) / change : eased;
      view = { center: mixed(from.center, to.center, pace), radius };
      if (share === 1) {
        view = to;
        flight = null;
      }
    }
    drawing.draw(current, view, colors);
    if (flight) ask();
    else document.body.dataset.drawn = current;
  });
}

// Browsers refuse to change an address many times a second, so it follows at leisure.
function writeHash() {
  clearTimeout(hashTimer);
  hashTimer = setTimeout(() => {
    const hash = `#step=${current}`;
    if (location.hash !== hash) history.replaceState(null, "", hash);
  }, 250);
}

/** The step that the address asks for; `null` if it asks for none. */
function readHash() {
  const match = /^#step=(\d+)$/.exec(location.hash);
  return match ? Number(match[1]) : null;
}

function play() {
  if (playTimer) return pause();
  if (current === walk.steps.length - 1) goTo(0);
  playTimer = setInterval(() => goTo(current + 1), MILLISECONDS_PER_STEP);
  return tellPlaying();
}

function pause() {
  clearInterval(playTimer);
  playTimer = 0;
  tellPlaying();
}

function tellPlaying() {
  byId("play").textContent = playTimer ? "pause" : "play";
  byId("play").setAttribute("aria-label", playTimer ? "Pause" : "Play");
  document.body.dataset.playing = Boolean(playTimer);
}

/** A step by hand ends the playing. */
function stepTo(index) {
  pause();
  goTo(index);
}

function toggleFollow() {
  drawing.isFollowing = !drawing.isFollowing;
  byId("follow").setAttribute("aria-pressed", drawing.isFollowing);
  aim(false);
}

function tellUp() {
  byId("up").textContent = `up: ${AXES[drawing.camera.up]}`;
}

function turnUp() {
  drawing.camera.up = (drawing.camera.up + 1) % 3;
  drawing.camera.reset();
  tellUp();
  ask();
}

function resetView() {
  drawing.camera.reset();
  aim(false);
}

function zoomBy(factor, x, y) {
  const { camera } = drawing;
  const before = camera.zoom;
  camera.zoom = Math.min(Math.max(before * factor, 0.05), 1e4);
  const canvas = byId("drawing");
  const grown = camera.zoom / before;
  // What lies under the pointer stays there.
  const offset = [(x ?? canvas.clientWidth / 2) - canvas.clientWidth / 2,
    (y ?? canvas.clientHeight / 2) - canvas.clientHeight / 2];
  camera.pan = camera.pan.map((pan, k) => offset[k] - (offset[k] - pan) * grown);
  ask();
}

function turnBy(dx, dy) {
  const { camera } = drawing;
  camera.azimuth -= dx * 0.008;
  camera.elevation = Math.min(Math.max(camera.elevation + dy * 0.008, -1.55), 1.55);
  ask();
}

function moveBy(dx, dy) {
  const { camera } = drawing;
  camera.pan = [camera.pan[0] + dx, camera.pan[1] + dy];
  ask();
}

const KEYS = {
  ArrowRight: () => stepTo(current + 1),
  ArrowLeft: () => stepTo(current - 1),
  Home: () => stepTo(0),
  End: () => stepTo(walk.steps.length - 1),
  " ": play,
  f: toggleFollow,
  u: turnUp,
  0: resetView,
  "+": () => zoomBy(1.25),
  "=": () => zoomBy(1.25),
  "-": () => zoomBy(0.8),
};

window.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const action = KEYS[event.key];
  // The space bar presses the button that has the focus, as everywhere.
  const isPress = event.key === " " && event.target.closest?.("button, summary");
  if (!action || isPress) return;
  event.preventDefault();
  action();
});

byId("slider").max = walk.steps.length - 1;
byId("slider").addEventListener("input", (event) => stepTo(Number(event.target.value)));
const BUTTONS = {
  first: KEYS.Home, back: KEYS.ArrowLeft, play, forward: KEYS.ArrowRight, last: KEYS.End,
  follow: toggleFollow, up: turnUp, reset: resetView,
};
for (const [id, action] of Object.entries(BUTTONS)) byId(id).addEventListener("click", action);
words.makeEngine((bounds) => {
  drawing.engineBox = isBox(bounds) ? drawing.frame.box(bounds) : null;
  ask();
});

// One pointer turns the view, with Shift or another button it moves it; two pointers move and zoom.
const pointers = new Map();
const canvas = byId("drawing");
canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
});
canvas.addEventListener("pointermove", (event) => {
  const before = pointers.get(event.pointerId);
  if (!before) return;
  const after = [event.offsetX, event.offsetY];
  const [dx, dy] = [after[0] - before[0], after[1] - before[1]];
  const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
  pointers.set(event.pointerId, after);
  if (other) {
    const span = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
    const middle = [0, 1].map((k) => (after[k] + other[k]) / 2);
    moveBy(dx / 2, dy / 2);
    zoomBy(span(after) / span(before), ...middle);
  } else if (event.shiftKey || event.buttons !== 1) {
    moveBy(dx, dy);
  } else {
    turnBy(dx, dy);
  }
});
for (const name of ["pointerup", "pointercancel"]) {
  canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
}
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("dblclick", resetView);
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  const lines = event.deltaMode === WheelEvent.DOM_DELTA_LINE ? 20 : 1;
  zoomBy(Math.exp(-event.deltaY * lines * 0.0015), event.offsetX, event.offsetY);
}, { passive: false });

window.addEventListener("hashchange", () => {
  const index = readHash();
  if (index !== null) stepTo(index);
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  colors = readColors();
  ask();
});
// Where the boxes of the page change, the drawing is made anew, at its new size.
new ResizeObserver(() => {
  drawPicture();
  ask();
}).observe(byId("stage"));

/** Where a position of the mesh is on the canvas, for programs. */
window.whereIs = (position) => drawing.camera.project(drawing.frame.point(position));

goTo(readHash() ?? 0, { isSudden: true });
tellPlaying();
tellUp();
