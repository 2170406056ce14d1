// What the reader has chosen. Every part of the page that depends on a choice asks to be told when it changes.

const state = {
  scene: "",
  norm: "",            // a column of work_precision.csv
  bound: 1e-6,         // in the unit of the norm
  cost: "time_min_s",  // or rhs_evals
  families: new Set(), // shown in charts
  every: false,        // all members of those, or the best of each
  pinned: new Set(),   // solvers shown in any case
  theme: "",           // light or dark; "" follows the system
};

const listeners = [];
function on_change(parts, listener) { listeners.push([parts, listener]); }
function change(parts) {
  Object.assign(state, parts);
  const changed = Object.keys(parts);
  for (const [wanted, listener] of listeners) if (wanted.some((part) => changed.includes(part))) listener();
}

// Solvers with their families, in the order of solvers.csv, which is that of the registry and knows all of them; of a
// folder without that table, those of the others.
const family_of = new Map();
function read_families() {
  const t = table("solvers.csv");
  for (let i = 0; i < t.rows; ++i) family_of.set(t.text(i, "solver"), t.text(i, "family") || "other");
  if (t.rows > 0) return;
  for (const each of tables.values())
    if (each.has("solver"))
      for (const solver of each.values("solver")) if (solver && !family_of.has(solver)) family_of.set(solver, "other");
}
const in_order = (solvers) => [...family_of.keys()].filter((solver) => solvers.has(solver));

// Colour, mark and dash of a solver: the same in every figure. Hues are made lighter on a dark page.
const shapes = { 7: "circle", 5: "square", 9: "up", 11: "down", 13: "diamond", 15: "left" };
function look(solver) {
  const [colour, mark, dash] = (data.looks || {})[solver] || ["#777777", 7, 1];
  return { colour: is_dark() ? lighter(colour) : colour, shape: shapes[mark] || "circle", dashed: dash !== 1 };
}
function lighter(colour) {
  const channels = [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16));
  const bright = (0.2126 * channels[0] + 0.7152 * channels[1] + 0.0722 * channels[2]) / 255;
  const part = Math.max(0.12, 0.62 - bright);
  return "#" + channels.map((c) => Math.round(c + (255 - c) * part).toString(16).padStart(2, "0")).join("");
}

const system_dark = matchMedia("(prefers-color-scheme: dark)");
function is_dark() { return state.theme ? state.theme === "dark" : system_dark.matches; }
system_dark.addEventListener("change", () => change({ theme: state.theme }));

// Corners of a mark around the origin, for any canvas or SVG; a circle has none.
function corners(shape, r) {
  const ring = (n, turn) => Array.from({ length: n }, (_, k) => {
    const a = turn + (2 * Math.PI * k) / n;
    return [r * Math.sin(a), -r * Math.cos(a)];
  });
  if (shape === "square") return ring(4, Math.PI / 4);
  if (shape === "diamond") return ring(4, 0);
  if (shape === "up") return ring(3, 0);
  if (shape === "down") return ring(3, Math.PI);
  return shape === "left" ? ring(3, -Math.PI / 2) : [];
}

// The mark of a solver as a small picture beside its name.
function glyph(solver) {
  const { colour, shape } = look(solver);
  const mark = shape === "circle"
    ? svg("circle", { r: 4.4, fill: colour })
    : svg("polygon", { points: corners(shape, 5.4).map((p) => p.join(",")).join(" "), fill: colour });
  return svg("svg", { class: "glyph", viewBox: "-7 -7 14 14", "aria-hidden": "true" }, mark);
}
const named = (solver) => el("span", { class: "named" }, glyph(solver), code(solver));

const scene_title = (id) => (data.scenes || []).find((scene) => scene.id === id)?.title || id;
const says = (about) => (data.scenes || []).find((scene) => scene.id === state.scene)?.says[about] || "";
const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
