// Extremes, a matrix of solvers and cases with a verdict in each cell; and whether a tolerance is kept.

// Letter, look and meaning of a verdict. The looks differ in shape and letter, not in colour alone.
const verdict_words = {
  right: ["R", "good", "right: attitude within 10⁻³ rad and rates within 10⁻³ of the truth (or ten times what doubles resolve)"],
  bounded_but_wrong: ["B", "fair", "bounded but wrong: another motion, but its energy stays within a hundredth"],
  dissipates: ["D", "poor", "dissipates: not right, and loses energy that the body keeps"],
  gains_energy: ["G", "bad", "gains energy: not right, and gains what nothing gives it"],
  clamped: ["C", "odd", "clamped: the engine cut a rotation or a torque"],
  asleep: ["A", "odd", "asleep: the engine stopped a body that moves"],
  not_finite: ["N", "bad", "not finite: the state left the numbers"],
  solver_failed: ["F", "bad", "solver failed: it gave up and said so"],
  timeout: ["T", "odd", "timeout: not done in the time given"],
  unsupported: ["–", "none", "unsupported: the solver does not apply"],
  no_truth: ["∅", "none", "no truth: nothing to measure it against within the budget"],
};
const verdict_of = (id) => verdict_words[id] || ["?", "none", spaced(id)];
function verdict_cell(id, hint) {
  const [letter, looks, words] = verdict_of(id);
  return el("span", { class: `verdict-cell ${looks}`, title: hint || words, role: "img", "aria-label": words.split(":")[0] }, letter);
}

function extremes_part() {
  const t = table("extremes.csv");
  if (t.rows === 0) return;
  heading("stability", "Extremes");
  const candidates = () => new Set(t.values("solver"));
  const cases = t.values("case");
  const title = (id) => t.text(t.where("case", id)[0], "title") || spaced(id);
  place("stability", "how", [], () => "Bodies and motions on which integrators are known to fail. Rest on a cell for its number.");
  solver_picker("stability", candidates);
  place("stability", "matrix", ["families", "every", "pinned", "scene", "norm", "bound", "theme"], () => {
    const solvers = shown(candidates());
    const at = new Map();
    for (let i = 0; i < t.rows; ++i) at.set(`${t.text(i, "solver")}\n${t.text(i, "case")}`, i);
    const cell = (solver, id) => {
      const i = at.get(`${solver}\n${id}`);
      if (i === undefined) return "";
      const value = t.number(i, "value");
      const knob = Number.isFinite(t.number(i, "knob_value")) ? `, ${setting(t.text(i, "knob"), t.number(i, "knob_value"))}` : "";
      return verdict_cell(t.text(i, "verdict"), `${solver}${knob}: ${verdict_of(t.text(i, "verdict"))[2]}`
        + (Number.isFinite(value) ? `; ${spaced(t.text(i, "value_meaning"))} ${pretty(value)}` : ""));
    };
    return data_table([
      { title: "Solver", head: true, cell: named },
      ...cases.map((id) => ({ title: title(id), cell: (solver) => cell(solver, id) })),
    ], solvers, { label: "Extremes: solvers and cases", tall: true });
  });
  const met = new Set(t.values("verdict"));
  document.getElementById("stability").append(el("ul", { class: "verdict-key" }, Object.keys(verdict_words)
    .filter((id) => met.has(id)).map((id) => el("li", {}, verdict_cell(id), " ", verdict_of(id)[2]))));
}

const below_floor_words = { keeps: "keeps its best", worse: "gets worse", fails: "does not end" };

function tolerance_part() {
  const t = table("tolerance.csv"), v = table("tolerance_verdict.csv");
  if (t.rows === 0) return;
  const scenes = t.values("scene");
  heading("stability", "Does the error follow the tolerance?");
  place("stability", "how", [], () => "Largest error over the tolerance that was asked for. A tolerance bounds the error of one step, so "
    + "that a ratio above one is no fault; a slope far from one is, and so is a run that is deceived: off by more than ten (!) or a "
    + "hundred (!!) tolerances times what the scene makes of any disturbance.");
  place("stability", "", ["scene"], () => (scenes.includes(state.scene) ? [] : el("p", { class: "soft" }, "Not asked on this scene, but on: ",
    scenes.map((scene) => el("button", { type: "button", class: "chip", on_click: () => change({ scene }) }, scene_title(scene))))));
  place("stability", "", ["scene", "theme"], () => {
    const rows = t.where("scene", state.scene), verdict_rows = v.where("scene", state.scene);
    if (rows.length === 0) return [];
    const solvers = t.values("solver", rows), tolerances = t.values("rtol", rows).filter(Boolean).sort((a, b) => b - a);
    if (tolerances.length === 0) return el("p", { class: "soft" }, "There is no truth of this scene to measure errors against.");
    const every = Math.ceil(tolerances.length / 6);
    const at = (solver, rtol) => rows.find((i) => t.text(i, "solver") === solver && t.text(i, "rtol") === rtol);
    const deceived = (i) => ({ 10: " !", 100: " !!" })[t.text(i, "deceived")];
    const cell = (i) => (i === undefined ? "–" : t.text(i, "outcome") !== "ok" ? el("small", {}, spaced(t.text(i, "outcome")))
      : [pretty(t.number(i, "error_over_tolerance"), 2), " ", deceived(i) && el("span", { class: "badge bad" }, deceived(i))]);
    const verdict = (solver) => verdict_rows.find((i) => v.text(i, "solver") === solver);
    const told = (title, hint, text) => verdict_rows.length > 0 && { title, hint, cell: (solver) => {
      const i = verdict(solver);
      return i === undefined ? "–" : text(i);
    } };
    return data_table([
      { title: "Solver", head: true, cell: named },
      ...tolerances.filter((_, k) => k % every === 0).map((rtol) => ({ title: `rtol ${pretty(Number(rtol))}`, number: true,
        cell: (solver) => cell(at(solver, rtol) ?? at(solver, "")) })),
      told("Slope", "of the error against the tolerance, above the rounding floor", (i) => (Number.isFinite(v.number(i, "slope"))
        ? `${v.number(i, "slope").toFixed(2)} ± ${pretty(v.number(i, "slope_error"), 1)}` : "–")),
      told("Below the floor", "what tolerances finer than rounding do", (i) => below_floor_words[v.text(i, "below_floor")] || "–"),
    ].filter(Boolean), solvers, { label: "Error over tolerance", tall: true });
  });
}
