// Error against step size, and the orders that were fitted to it beside those that are claimed.

function convergence_section() {
  const t = table("convergence.csv");
  if (t.rows === 0) return;
  const candidates = () => new Set(t.values("solver", t.where("scene", state.scene)
    .filter((i) => was_run(t, i))));
  place("convergence", "", ["scene"], () => el("p", { class: "says" }, says("orders")));
  solver_picker("convergence", candidates);
  const holder = el("div", { class: "figure" });
  document.getElementById("convergence").append(holder);
  const draw = () => log_chart(holder, convergence_figure(shown(candidates())));
  on_change(["scene", "norm", "bound", "families", "every", "pinned", "theme"], draw);
  draw();
  document.getElementById("convergence").append(el("p", { class: "how" },
    "The slope of a line is the order of the solver. Hollow marks: rounding decides the error."));
  place("convergence", "", ["scene", "theme"], orders_table);
}

function convergence_figure(solvers) {
  const t = table("convergence.csv");
  const norm = t.has(state.norm) ? norm_of(state.norm) : norms[0];
  const rows = t.where("scene", state.scene);
  const order_column = norm.column.replace(/_error_max.*/, "_order");
  const series = solvers.map((solver) => ({ solver, points: rows
    .filter((i) => t.text(i, "solver") === solver && Number.isFinite(t.number(i, norm.column)))
    .map((i) => ({ x: t.number(i, "h_s"), y: t.number(i, norm.column), hollow: !t.flag(i, "above_floor"), lines: [
      `h = ${pretty_time(t.number(i, "h_s"))}, ${pretty_count(t.number(i, "steps"))} steps`,
      `${norm.name} error ${with_unit(norm, t.number(i, norm.column))}`,
      `slope to the run before ${pretty(t.number(i, order_column))}`,
    ] })) })).filter((s) => s.points.length > 0);
  const points = series.flatMap((s) => s.points);
  const x0 = Math.max(...points.map((point) => point.x)), y0 = Math.min(10, Math.max(...points.map((point) => point.y)));
  const x1 = Math.min(...points.map((point) => point.x));
  const floor = floor_of(state.scene, norm);
  return {
    x: { title: "step h / s" },
    y: { title: `largest ${norm.name} error${norm.unit ? ` / ${norm.unit}` : ", relative"}`, cap: 10 },
    series,
    guides: points.length < 2 ? [] : [1, 2, 4, 8].map((p) => ({ points: [[x0, y0], [x1, y0 * (x1 / x0) ** p]], label: `order ${p}` })),
    band: floor > 0 ? { axis: "y", to: floor, label: "rounding floor" } : null,
    label: `Error against step on ${scene_title(state.scene)}, ${counted(series.length, "solver")}`,
    fallback: ["convergence", state.scene],
  };
}

// The fitted orders of a scene: a row for each solver, a column for each quantity.
function orders_table() {
  const t = table("orders.csv"), rows = t.where("scene", state.scene);
  if (rows.length === 0) return [];
  const quantities = t.values("quantity", rows), solvers = t.values("solver", rows);
  const at = (solver, quantity) => rows.find((i) => t.text(i, "solver") === solver && t.text(i, "quantity") === quantity);
  const cell = (i) => {
    if (i === undefined) return "–";
    const claimed = t.number(i, "claimed"), order = t.number(i, "order"), error = t.number(i, "order_error");
    const claim = el("small", {}, Number.isFinite(claimed) ? `claimed ${claimed}` : "no claim");
    if (!Number.isFinite(order)) return ["–", claim];
    // Met within 0.15, or within twice its own error if that is more.
    const met = Math.abs(order - claimed) <= Math.max(0.15, 2 * error || 0);
    const kind = !Number.isFinite(claimed) ? "" : met ? "good" : order > claimed ? "fair" : "bad";
    const mark = { good: "✓ ", fair: "↑ ", bad: "✗ " }[kind] || "";
    return [el("span", { class: `badge ${kind}` }, `${mark}${order.toFixed(2)}${error > 0 ? ` ± ${pretty(error, 2)}` : ""}`), claim];
  };
  return folded(`Measured orders of ${counted(solvers.length, "solver")}`, data_table([
    { title: "Solver", head: true, cell: named },
    ...quantities.map((quantity) => ({ title: sentence_case(spaced(quantity)), cell: (solver) => cell(at(solver, quantity)) })),
  ], solvers, { label: "Measured orders", tall: true }));
}
