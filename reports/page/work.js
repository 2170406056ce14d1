// Error against run time or right-hand sides: one line a solver, from its coarsest run to its finest.

function work_section() {
  const t = table("work_precision.csv");
  if (t.rows === 0) return;
  const candidates = () => new Set(t.values("solver", t.where("scene", state.scene)));
  place("work", "", ["scene", "cost"], () => el("p", { class: "says" }, says(state.cost)));
  solver_picker("work", candidates);
  place("work", "controls", ["scene", "norm", "cost"], () => [
    choice("Up", [["time_min_s", "run time"], ["rhs_evals", "right-hand sides"]], state.cost, (cost) => change({ cost })),
    choice("Across: error in", norms_of(state.scene).map((norm) => [norm.column, norm.name]), state.norm,
      (norm) => change({ norm })),
  ]);
  const holder = el("div", { class: "figure" });
  document.getElementById("work").append(holder);
  const draw = () => log_chart(holder, work_figure(shown(candidates())));
  on_change(["scene", "norm", "cost", "bound", "families", "every", "pinned", "theme"], draw);
  draw();
  document.getElementById("work").append(el("p", { class: "how" }, "Lower left is better. Hollow marks: rounding decides the "
    + "error. × at the right edge: the run failed; it stands where its number of steps would put it."));
  place("work", "", ["scene"], () => failures_table(t, state.scene));
}

function run_lines(t, i) {
  const number = (name) => t.number(i, name);
  const lines = [setting(t.text(i, "knob"), number("knob_value"))];
  if (t.text(i, "outcome") !== "ok") return [...lines, `failed: ${spaced(t.text(i, "outcome"))}`];
  for (const norm of norms)
    if (t.has(norm.column) && Number.isFinite(number(norm.column)))
      lines.push(`${norm.name} error ${with_unit(norm, number(norm.column))}`);
  if (Number.isFinite(number("unit_defect_max"))) lines.push(`unit defect ${pretty(number("unit_defect_max"))}`);
  if (Number.isFinite(number("time_min_s")))
    lines.push(`time ${pretty_time(number("time_min_s"))} (median ${pretty_time(number("time_median_s"))}`
      + ` ± ${pretty_time(number("time_mad_s"))}, ${number("repeats")} repeats)`);
  lines.push(`${pretty_count(number("steps"))} steps, ${pretty_count(number("rejected_steps"))} rejected`,
    `${pretty_count(number("rhs_evals"))} right-hand sides, ${pretty_count(number("jacobian_evals"))} Jacobians`);
  if (!t.flag(i, "above_floor")) lines.push("at the rounding floor");
  return lines;
}

function work_figure(solvers) {
  const t = table("work_precision.csv"), norm = norm_of(state.norm);
  const rows = t.where("scene", state.scene);
  const series = solvers.map((solver) => {
    const mine = rows.filter((i) => t.text(i, "solver") === solver);
    const points = [], failed = [];
    for (const i of mine) {
      const cost = t.number(i, state.cost), error = t.number(i, state.norm);
      if (t.text(i, "outcome") !== "ok") failed.push(i);
      else if (cost > 0 && Number.isFinite(error))
        points.push({ x: error, y: cost, steps: t.number(i, "steps"), hollow: !t.flag(i, "above_floor"),
          lines: run_lines(t, i) });
    }
    const [first] = points;
    const edge = failed.filter((i) => was_run(t, i)).map((i) => {
      // A failed run was not timed; time goes with the number of steps, so the first good run tells its place.
      const steps = t.text(i, "knob") === "steps" ? t.number(i, "knob_value") : NaN;
      return { x: NaN, edge: "x", loose: true, lines: run_lines(t, i),
        y: first ? first.y * (steps > 0 && first.steps > 0 ? steps / first.steps : 1) : 0 };
    });
    return { solver, points: [...points, ...edge.filter((point) => point.y > 0)] };
  }).filter((s) => s.points.length > 0);
  const floor = floor_of(state.scene, norm);
  return {
    x: { title: `largest ${norm.name} error${norm.unit ? ` / ${norm.unit}` : ", relative"}`, cap: 10 },
    y: { title: state.cost === "time_min_s" ? "run time / s" : "right-hand-side evaluations" },
    series, guides: work_guides(series),
    band: floor > 0 ? { axis: "x", to: floor, label: "rounding floor" } : null,
    label: `Error against cost on ${scene_title(state.scene)}, ${counted(series.length, "solver")}`,
    fallback: [state.cost === "time_min_s" ? "work-precision" : "evaluations", state.scene],
  };
}

// Slopes of orders 1, 2, 4 and 8 from one point: a run of order p costs error^(-1/p).
function work_guides(series) {
  const points = series.flatMap((s) => s.points).filter((point) => !point.edge && point.x > least_shown);
  if (points.length < 2) return [];
  const x0 = Math.min(1, Math.max(...points.map((point) => point.x)));
  const y0 = Math.min(...points.map((point) => point.y));
  const x1 = Math.max(least_shown, Math.min(...points.map((point) => point.x)) / 10);
  return [1, 2, 4, 8].map((p) => ({ points: [[x0, y0], [x1, y0 * (x0 / x1) ** (1 / p)]], label: `order ${p}` }));
}

// Runs that did not end well, of one kind in a row.
function failures_table(t, scene) {
  const kinds = new Map();
  for (const i of t.where("scene", scene)) {
    const outcome = t.text(i, "outcome");
    if (outcome === "ok") continue;
    const key = `${t.text(i, "solver")}\n${outcome}`;
    if (!kinds.has(key)) kinds.set(key, { solver: t.text(i, "solver"), outcome, rows: [] });
    if (Number.isFinite(t.number(i, "knob_value"))) kinds.get(key).rows.push(i);
  }
  if (kinds.size === 0) return el("p", { class: "soft" }, "No run failed on this scene.");
  return folded(`${counted(kinds.size, "solver")} with runs that did not end well`, data_table([
    { title: "Solver", head: true, cell: (kind) => named(kind.solver) },
    { title: "Outcome", cell: (kind) => spaced(kind.outcome) },
    { title: "At", cell: (kind) => kind.rows.map((i) => setting(t.text(i, "knob"), t.number(i, "knob_value"))).join(", ") || "–" },
  ], [...kinds.values()], { label: "Runs that failed", tall: true }));
}
