// Extremes, a matrix of solvers and cases with a verdict in each cell; and whether a tolerance is kept.

// Letter, look and meaning of a verdict. The looks differ in shape and letter, not in colour alone.
const verdict_words = {
  right: ["R", "good", "right: the error is as small as the setting promises"],
  bounded_but_wrong: ["B", "fair", "bounded but wrong: energy and momentum stay near, the motion is another one"],
  dissipates: ["D", "poor", "dissipates: loses energy that the body keeps"],
  gains_energy: ["G", "bad", "gains energy that nothing gives it"],
  clamped: ["C", "odd", "clamped: the engine cut a rotation or a torque"],
  asleep: ["A", "odd", "asleep: the engine stopped a body that moves"],
  not_finite: ["N", "bad", "not finite: the state left the numbers"],
  solver_failed: ["F", "bad", "solver failed: it gave up and said so"],
  timeout: ["T", "odd", "timeout: not done in the time given"],
  unsupported: ["–", "none", "unsupported: the solver does not apply"],
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
        + (Number.isFinite(value) ? `; ${t.text(i, "value_meaning")} ${pretty(value)}` : ""));
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

function tolerance_part() {
  const t = table("tolerance.csv");
  if (t.rows === 0) return;
  heading("stability", "Is the tolerance kept?");
  place("stability", "how", [], () => "Error of the motion over the tolerance that was asked for. A tolerance bounds the error of a "
    + "step, so that a ratio above one is no fault; one that grows as the tolerance shrinks, or a slope far from one, is.");
  place("stability", "", ["scene", "theme"], () => {
    const rows = t.where("scene", state.scene);
    if (rows.length === 0) return el("p", { class: "soft" }, "Not asked on this scene.");
    const solvers = t.values("solver", rows), tolerances = t.values("rtol", rows).sort((a, b) => b - a);
    const at = (solver, rtol) => rows.find((i) => t.text(i, "solver") === solver && t.text(i, "rtol") === rtol);
    const cell = (i) => (i === undefined ? "–" : t.text(i, "outcome") !== "ok" ? spaced(t.text(i, "outcome"))
      : [pretty(t.number(i, "error_over_tolerance"), 2), deceived(i) && el("small", {}, "deceived")]);
    const deceived = (i) => ["1", "true", "yes"].includes(t.text(i, "deceived"));
    const slope = (solver) => rows.map((i) => (t.text(i, "solver") === solver ? t.number(i, "slope") : NaN)).find(Number.isFinite);
    return data_table([
      { title: "Solver", head: true, cell: named },
      ...tolerances.map((rtol) => ({ title: `rtol ${pretty(Number(rtol))}`, number: true, cell: (solver) => cell(at(solver, rtol)) })),
      { title: "Slope", number: true, hint: "of the error in the tolerance", cell: (solver) => pretty(slope(solver) ?? NaN, 2) },
    ], solvers, { label: "Error over tolerance", tall: true });
  });
}
