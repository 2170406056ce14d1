// Stability: the largest steps that a solver survives beside linear theory, and how large they may be for an accuracy.

function stability_section() {
  const t = table("stability.csv");
  if (t.rows > 0) stability_limits(t);
  heat_map_part();
  extremes_part();
  tolerance_part();
}

const heading = (section_id, text) => document.getElementById(section_id).append(el("h3", {}, text));

function stability_limits(t) {
  heading("stability", "Largest stable step");
  const scenes = t.values("scene");
  const candidates = () => new Set(t.values("solver", t.where("scene", state.scene)
    .filter((i) => was_run(t, i))));
  place("stability", "", ["scene"], () => (scenes.includes(state.scene) ? el("p", { class: "says" }, says("stability"))
    : el("p", { class: "soft" }, `“${scene_title(state.scene)}” has no stiff parameter to vary. `,
      "These have: ", scenes.map((scene) => el("button", { type: "button", class: "chip",
        on_click: () => change({ scene }) }, scene_title(scene))))));
  solver_picker("stability", candidates);
  const holder = el("div", { class: "figure" });
  document.getElementById("stability").append(holder);
  const draw = () => {
    holder.hidden = !scenes.includes(state.scene);
    if (!holder.hidden) log_chart(holder, stability_figure(t, shown(candidates())));
  };
  on_change(["scene", "norm", "bound", "families", "every", "pinned", "theme"], draw);
  draw();
  place("stability", "", ["scene"], () => (scenes.includes(state.scene)
    ? el("p", { class: "how" }, "Marks: measured. Dashed lines: linear theory, for solvers that have one.") : []));
  place("stability", "", ["scene", "families", "every", "pinned", "norm", "bound", "theme"],
    () => limits_table(t, shown(candidates())));
}

// One for each solver and value of the parameter: its first row with numbers.
function limits_of(t, solver) {
  const kept = new Map();
  for (const i of t.where("scene", state.scene)) {
    if (t.text(i, "solver") !== solver) continue;
    const key = t.text(i, "parameter_value");
    if (!kept.has(key) || !Number.isFinite(t.number(kept.get(key), "largest_stable_h_s"))) kept.set(key, i);
  }
  return [...kept.values()].sort((a, b) => t.number(a, "parameter_value") - t.number(b, "parameter_value"));
}

function stability_figure(t, solvers) {
  const [first] = t.where("scene", state.scene);
  const parameter = first === undefined ? "" : spaced(t.text(first, "parameter"));
  const series = solvers.flatMap((solver) => {
    const rows = limits_of(t, solver);
    const line = (column, name, dashed) => ({ solver, name, dashed, points: rows
      .filter((i) => t.number(i, column) > 0 && t.number(i, "parameter_value") > 0)
      .map((i) => ({ x: t.number(i, "parameter_value"), y: t.number(i, column), quiet: dashed, lines: [
        `${parameter} = ${pretty(t.number(i, "parameter_value"))}`,
        `largest stable step ${pretty_time(t.number(i, "largest_stable_h_s"))}`,
        `linear theory ${pretty_time(t.number(i, "theory_h_s"))}`] })) });
    return [line("largest_stable_h_s", solver, false), line("theory_h_s", `${solver}, theory`, true)];
  }).filter((s) => s.points.length > 0);
  return { x: { title: parameter }, y: { title: "largest stable step h / s" }, series,
    label: `Largest stable steps on ${scene_title(state.scene)}`, fallback: ["stability", state.scene] };
}

function limits_table(t, solvers) {
  const rows = solvers.flatMap((solver) => limits_of(t, solver));
  if (rows.length === 0) return [];
  const time = (title, column, hint) => t.has(column) && { title, hint, number: true, cell: (i) => pretty_time(t.number(i, column)) };
  const count = (title, column) => t.has(column) && { title, number: true, cell: (i) => pretty_count(t.number(i, column)) };
  return folded(`Limits of the ${counted(solvers.length, "solver")} shown`, data_table([
    { title: "Solver", head: true, cell: (i) => named(t.text(i, "solver")) },
    { title: sentence_case(spaced(t.text(rows[0], "parameter"))), number: true, cell: (i) => pretty(t.number(i, "parameter_value")) },
    time("Largest stable step", "largest_stable_h_s"),
    time("Next to rest", "largest_stable_near_rest_h_s", "what linear theory speaks of"),
    time("Linear theory", "theory_h_s"),
    { title: "Ratio", hint: "of the largest stable step next to rest, where there is rest, to theory", number: true, cell: (i) => {
      const near = t.has("largest_stable_near_rest_h_s") ? t.number(i, "largest_stable_near_rest_h_s") : NaN;
      const ratio = (near > 0 ? near : t.number(i, "largest_stable_h_s")) / t.number(i, "theory_h_s");
      return Number.isFinite(ratio) ? ratio.toFixed(3) : "–";
    } },
    time("Step for 10⁻³", "largest_accurate_h_1e3_s", "largest step with an error below 10⁻³"),
    count("Right-hand sides", "rhs_evals_1e3"),
    time("Step for 10⁻⁶", "largest_accurate_h_1e6_s", "largest step with an error below 10⁻⁶"),
    count("Right-hand sides", "rhs_evals_1e6"),
    t.has("order_while_stiff") && { title: "Order while stiff", number: true, hint: "beside the order that it claims where nothing is stiff",
      cell: (i) => [pretty(t.number(i, "order_while_stiff"), 2), el("small", {}, `claimed ${pretty(t.number(i, "claimed_order"))}`)] },
    { title: "First failure", cell: (i) => spaced(t.text(i, "outcome")) },
  ].filter(Boolean), rows, { label: "Stability limits", tall: true }), true);
}
