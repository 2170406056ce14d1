// What a run loses over time: energy, momentum, length of the quaternion; with the class of its growth in words.

const drift_quantities = [
  ["rotational_energy_drift_rel", "rotational_energy", "rotational energy", "energy-drift"],
  ["total_energy_drift_rel", "total_energy", "total energy", "energy-drift"],
  ["momentum_drift_rel", "momentum", "angular momentum", "momentum-drift"],
  ["momentum_direction_drift_rad", "momentum_direction", "direction of the momentum", ""],
  ["attitude_error_rad", "attitude_error", "attitude", ""],
  ["unit_defect", "unit_defect", "unit length", ""],
].map(([column, id, name, figure]) => ({ column, id, name, figure }));

const drift_words = {
  bounded: ["good", "stays bounded"], random_walk: ["fair", "grows like √t, a random walk"],
  linear: ["poor", "grows in proportion to t"], quadratic: ["bad", "grows like t²"],
  exponential: ["bad", "grows exponentially"], not_finite: ["bad", "left the numbers"],
};

function drift_section() {
  const t = table("drift.csv");
  if (t.rows === 0) return;
  state.drift = drift_quantities[0].column;
  const candidates = () => new Set(t.values("solver", t.where("scene", state.scene).filter((i) => was_run(t, i))));
  const quantity = () => {
    const there = quantities_of(t, state.scene);
    return there.find((q) => q.column === state.drift) || there[0] || drift_quantities[0];
  };
  place("drift", "", ["scene", "drift"], () => says(quantity().id) && el("p", { class: "says" }, says(quantity().id)));
  solver_picker("drift", candidates);
  place("drift", "controls", ["scene", "drift"], () => choice("Drift of", quantities_of(t, state.scene)
    .map((q) => [q.column, q.name]), quantity().column, (drift) => change({ drift })));
  const holder = el("div", { class: "figure" });
  document.getElementById("drift").append(holder);
  const draw = () => log_chart(holder, drift_figure(t, shown(candidates()), quantity()));
  on_change(["scene", "drift", "norm", "bound", "families", "every", "pinned", "theme"], draw);
  draw();
  document.getElementById("drift").append(el("p", { class: "how" },
    "Flat is bounded, slope ½ a random walk, slope 1 a secular drift. An exact zero has no logarithm and is left out."));
  place("drift", "", ["scene", "drift", "families", "every", "pinned", "norm", "bound", "theme"],
    () => verdicts(t, shown(candidates()), quantity()));
}

function quantities_of(t, scene) {
  const rows = t.where("scene", scene);
  return drift_quantities.filter((q) => t.has(q.column) && rows.some((i) => t.number(i, q.column) !== 0
    && Number.isFinite(t.number(i, q.column))));
}

// Rows of drift_verdict.csv about a solver and a quantity on this scene.
function verdict_rows(solver, quantity) {
  const t = table("drift_verdict.csv");
  return t.where("scene", state.scene).filter((i) => t.text(i, "solver") === solver && t.text(i, "quantity") === quantity);
}

function drift_figure(t, solvers, quantity) {
  const rows = t.where("scene", state.scene);
  const series = solvers.map((solver) => {
    const [verdict] = verdict_rows(solver, quantity.id);
    const kind = verdict === undefined ? "" : table("drift_verdict.csv").text(verdict, "class");
    return { solver, points: rows.filter((i) => t.text(i, "solver") === solver).map((i) => ({
      x: t.number(i, "t_s"), y: Math.abs(t.number(i, quantity.column)), quiet: true, lines: [
        `${setting(t.text(i, "knob"), t.number(i, "knob_value"))}, t = ${pretty(t.number(i, "t_s"))} s`,
        `${quantity.name}: ${pretty(t.number(i, quantity.column))}`,
        kind && (drift_words[kind]?.[1] || spaced(kind)),
      ].filter(Boolean) })).filter((point) => point.x > 0 && point.y > 0)
      .map((point, n) => ({ ...point, quiet: n % 6 !== 0 })) };
  }).filter((s) => s.points.length > 0);
  return {
    x: { title: "time / s" },
    y: { title: `|drift| of the ${quantity.name}${quantity.column.endsWith("_rad") ? " / rad" : ", relative"}`, cap: 1e3 },
    series, label: `Drift of the ${quantity.name} on ${scene_title(state.scene)}, ${counted(series.length, "solver")}`,
    fallback: [quantity.figure, state.scene],
  };
}

function verdicts(t, solvers, quantity) {
  const v = table("drift_verdict.csv");
  if (v.where("scene", state.scene).length === 0) return [];
  const cell = (solver, q) => verdict_rows(solver, q.id).map((i) => {
    const kind = v.text(i, "class"), [badge, words] = drift_words[kind] || ["", spaced(kind)];
    const exponent = v.number(i, "exponent"), largest = v.has("max_abs") ? v.number(i, "max_abs") : NaN;
    return [el("span", { class: `badge ${badge}` }, words), el("small", {}, [
      Number.isFinite(exponent) && (kind === "exponential" ? `rate ${pretty(exponent)}/s` : `exponent ${exponent.toFixed(2)}`),
      Number.isFinite(largest) && `up to ${pretty(largest)}`].filter(Boolean).join(", "))];
  });
  const others = quantities_of(t, state.scene).filter((q) => q !== quantity);
  return folded(`Classes of drift of the ${counted(solvers.length, "solver")} shown`, data_table([
    { title: "Solver", head: true, cell: named },
    ...[quantity, ...others].map((q) => ({ title: sentence_case(q.name), cell: (solver) => cell(solver, q) })),
  ], solvers, { label: "Classes of drift", tall: true }), true);
}
