// Stability maps: energy gained or lost per step over the shape of the body and the step, one map for each axis that the
// body spins about. Colours diverge from no change with lightness in even steps; where a run failed or an engine held
// the body, a pattern says so.

const axes_words = { least: "about the axis of least moment", middle: "about the middle axis", greatest: "about the axis of greatest moment" };
const map_quiet = 1e-12, map_loud = 1e-1;  // growth per step: below and above, colours do not change any more

// Position of a growth on the palette: -1 loses all, 0 keeps, +1 gains most; logarithmic between.
function growth_position(growth) {
  const size = Math.abs(growth);
  if (size < map_quiet) return 0;
  return Math.sign(growth) * Math.min(1, 0.12 + 0.88 * Math.log(size / map_quiet) / Math.log(map_loud / map_quiet));
}

// OKLCH to sRGB. Source: B. Ottosson, A perceptual color space for image processing (2020).
function oklch(lightness, chroma, hue) {
  const a = chroma * Math.cos((hue * Math.PI) / 180), b = chroma * Math.sin((hue * Math.PI) / 180);
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s, -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s].map((c) =>
    Math.round(255 * Math.min(1, Math.max(0, c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055))));
}
function growth_colour(position) {
  const size = Math.abs(position), hue = position < 0 ? 250 : 48;
  const lightness = is_dark() ? 0.27 + 0.55 * size : 0.97 - 0.47 * size;
  return oklch(lightness, 0.145 * size, hue);
}

function heat_map_part() {
  const t = table("stability_map.csv");
  if (t.rows === 0) return;
  heading("stability", "Stability maps");
  const solvers = in_order(new Set(t.values("solver")));
  state.map_solver = solvers[0];
  // Beside the first: one of another kind, as far down the list as there is.
  const far = family_of.get(solvers[solvers.length - 1]);
  state.map_other = solvers.length > 1 ? solvers.find((solver, i) => i > 0 && family_of.get(solver) === far) : "";
  place("stability", "how", [], () => "A body spins near one of its principal axes. Across: its shape, from a rod to a disc; up: the "
    + "angle that it turns in a step. Blue loses energy, orange gains it; the line is where it begins to gain, the dashed one where linear theory says so.");
  place("stability", "controls", ["map_solver", "map_other"], () => [
    pick("Solver", solvers.map((s) => [s, s]), state.map_solver, (map_solver) => change({ map_solver })),
    solvers.length > 1 && pick("beside", [["", "none"], ...solvers.map((s) => [s, s])], state.map_other,
      (map_other) => change({ map_other })),
  ]);
  place("stability", "maps", ["map_solver", "map_other", "theme"], () =>
    [state.map_solver, state.map_other].filter(Boolean).map((solver) => map_row(t, solver)).concat(map_legend()));
}

function map_row(t, solver) {
  const rows = t.where("solver", solver);
  const axes = Object.keys(axes_words).filter((axis) => rows.some((i) => t.text(i, "axis") === axis));
  return el("div", { class: "map-row" }, el("h4", {}, named(solver)), el("div", { class: "map-grid" },
    axes.map((axis) => one_map(t, rows.filter((i) => t.text(i, "axis") === axis), `${solver}, spin ${axes_words[axis]}`, axis))),
    data.map_says?.[solver] && el("p", { class: "says" }, data.map_says[solver]));
}

function one_map(t, rows, label, axis) {
  const sorted = (name) => [...new Set(rows.map((i) => t.number(i, name)))].sort((a, b) => a - b);
  const ratios = sorted("inertia_ratio"), steps = sorted("h_w");
  const cells = ratios.map(() => steps.map(() => null));
  for (const i of rows)
    cells[ratios.indexOf(t.number(i, "inertia_ratio"))][steps.indexOf(t.number(i, "h_w"))] =
      { growth: t.number(i, "energy_growth_per_step"), outcome: t.text(i, "outcome"),
        grows: t.has("grows") ? t.text(i, "grows") === "1" : t.number(i, "energy_growth_per_step") > 1e-9 };
  const theory = ratios.map((ratio) => {
    const i = rows.find((row) => t.number(row, "inertia_ratio") === ratio);
    return t.has("theory_h_w") ? t.number(i, "theory_h_w") : NaN;
  });
  const canvas = el("canvas", { class: "map", role: "img", "aria-label": label });
  const says_cell = el("output", { class: "soft" }, "\u00a0");
  const size = { width: 300, height: 250, left: 44, bottom: 34, top: 4, right: 6 };
  draw_map(canvas, size, cells, ratios, steps, theory);
  canvas.addEventListener("pointermove", (event) => {
    const box = canvas.getBoundingClientRect(), scale = size.width / box.width;
    const x = Math.floor((((event.clientX - box.left) * scale - size.left) / (size.width - size.left - size.right)) * ratios.length);
    const y = Math.floor(((size.height - size.bottom - (event.clientY - box.top) * scale) / (size.height - size.bottom - size.top)) * steps.length);
    const cell = cells[x]?.[y];
    says_cell.textContent = !cell ? "\u00a0" : `I/I⊥ ${pretty(ratios[x])}, h·|ω| ${pretty(steps[y])}: `
      + (Number.isFinite(cell.growth) ? `${pretty(cell.growth)} per step` : spaced(cell.outcome));
  });
  return el("figure", { class: "map-figure" }, el("figcaption", {}, sentence_case(axes_words[axis])), canvas, says_cell);
}

function draw_map(canvas, size, cells, ratios, steps, theory) {
  const dpr = Math.max(2, devicePixelRatio);
  canvas.width = size.width * dpr;
  canvas.height = size.height * dpr;
  const ctx = canvas.getContext("2d");
  ctx.scale(dpr, dpr);
  const w = (size.width - size.left - size.right) / ratios.length, h = (size.height - size.bottom - size.top) / steps.length;
  const left = (x) => size.left + x * w, top = (y) => size.height - size.bottom - (y + 1) * h;
  cells.forEach((column, x) => column.forEach((cell, y) => {
    if (!cell) return;
    ctx.fillStyle = Number.isFinite(cell.growth) ? `rgb(${growth_colour(growth_position(cell.growth))})` : css("--failed");
    ctx.fillRect(left(x), top(y), w + 0.4, h + 0.4);
    if (cell.outcome === "ok" || !cell.outcome) return;
    ctx.strokeStyle = css("--soft");
    ctx.lineWidth = 0.7;
    ctx.beginPath();
    if (cell.outcome === "clamped") hatch(ctx, left(x), top(y), w, h, 1);
    else if (cell.outcome === "asleep") hatch(ctx, left(x), top(y), w, h, -1);
    else ctx.rect(left(x) + w / 2 - 0.5, top(y) + h / 2 - 0.5, 1, 1);
    ctx.stroke();
  }));
  // The line between keeping (or losing) and gaining.
  const gains = (x, y) => { const c = cells[x]?.[y]; return !!c && (c.grows || ["diverged", "not_finite"].includes(c.outcome)); };
  ctx.strokeStyle = css("--ink");
  ctx.lineWidth = 1.4;
  ctx.beginPath();
  for (let x = 0; x < ratios.length; ++x)
    for (let y = 0; y < steps.length; ++y) {
      if (x + 1 < ratios.length && gains(x, y) !== gains(x + 1, y)) { ctx.moveTo(left(x + 1), top(y)); ctx.lineTo(left(x + 1), top(y) + h); }
      if (y + 1 < steps.length && gains(x, y) !== gains(x, y + 1)) { ctx.moveTo(left(x), top(y)); ctx.lineTo(left(x) + w, top(y)); }
    }
  ctx.stroke();
  // Linear theory, where it has a limit within the map.
  const decades = Math.log10(steps[steps.length - 1] / steps[0]) / Math.max(1, steps.length - 1);
  ctx.setLineDash([3, 2]);
  ctx.beginPath();
  theory.forEach((limit, x) => {
    const y = size.height - size.bottom - (Math.log10(limit / steps[0]) / decades + 0.5) * h;
    if (y < size.top || y > size.height - size.bottom) return;
    ctx.moveTo(left(x), y);
    ctx.lineTo(left(x) + w, y);
  });
  ctx.stroke();
  ctx.setLineDash([]);
  map_axes(ctx, size, ratios, steps, left, top, w, h);
}

function hatch(ctx, x, y, w, h, slope) {
  ctx.moveTo(x, slope > 0 ? y + h : y);
  ctx.lineTo(x + w, slope > 0 ? y : y + h);
}

function map_axes(ctx, size, ratios, steps, left, top, w, h) {
  ctx.fillStyle = css("--soft");
  ctx.font = `11px ${css("--sans")}`;
  ctx.textAlign = "center";
  const nearest = (list, value) => list.reduce((best, v, i) => (Math.abs(v - value) < Math.abs(list[best] - value) ? i : best), 0);
  const bottom = size.height - size.bottom;
  for (const [value, text] of [[ratios[0], "rod"], [1, "sphere"], [ratios[ratios.length - 1], "disc"]]) {
    const at = left(nearest(ratios, value)) + w / 2;
    ctx.fillText(text, Math.min(Math.max(at, size.left + 10), size.width - size.right - 12), bottom + 14);
  }
  ctx.fillText("I axial / I transverse", (size.left + size.width - size.right) / 2, bottom + 29);
  ctx.textAlign = "right";
  for (let k = Math.ceil(Math.log10(steps[0]) - 0.01); k <= Math.log10(steps[steps.length - 1]) + 0.01; ++k)
    ctx.fillText(power_of_ten(k), size.left - 5, top(nearest(steps.map(Math.log10), k)) + h / 2 + 4);
  ctx.save();
  ctx.translate(9, (size.top + bottom) / 2);
  ctx.rotate(-Math.PI / 2);
  ctx.textAlign = "center";
  ctx.fillText("h·|ω|", 0, 0);
  ctx.restore();
}

function map_legend() {
  const stops = [-1, -0.75, -0.5, -0.25, 0, 0.25, 0.5, 0.75, 1].map((p) => `rgb(${growth_colour(p)})`);
  return el("div", { class: "map-legend soft" }, el("span", {}, "loses 10 % a step"),
    el("span", { class: "ramp", style: `background: linear-gradient(to right, ${stops.join(", ")})` }), el("span", {}, "gains 10 % a step"),
    el("span", { class: "key" }, svg("svg", { viewBox: "0 0 12 12", class: "swatch" }, svg("path", { d: "M0 12 12 0" })), "clamped"),
    el("span", { class: "key" }, svg("svg", { viewBox: "0 0 12 12", class: "swatch" }, svg("path", { d: "M0 0 12 12" })), "asleep"),
    el("span", { class: "key" }, svg("svg", { viewBox: "0 0 12 12", class: "swatch" }, svg("rect", { x: 5, y: 5, width: 2, height: 2 })), "ended badly"));
}
