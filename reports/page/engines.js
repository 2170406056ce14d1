// Physics engines beside our own solvers of the same order: errors over the step, what a step costs, and a verdict.

const engine_errors = [["attitude_error_max_rad", "attitude", "rad"], ["rate_error_max_rel", "rate", ""],
  ["energy_error_max_rel", "energy", ""], ["momentum_error_max_rel", "momentum", ""],
  ["momentum_direction_error_max_rad", "direction of the momentum", "rad"]];

const engine_groups = [["modes", "Bullet's four modes"], ["bullet", "all of Bullet"], ["others", "other engines"], ["all", "everything"]];

/// Does the group hold this engine? Our own solvers are in each.
function in_engine_group(group, solver, is_engine) {
  if (!is_engine || group === "all") return true;
  if (group === "others") return !solver.startsWith("bullet-");
  return group === "bullet" ? solver.startsWith("bullet-") : /^bullet-(none|explicit|implicit-world|implicit-body)(-f32)?$/.test(solver);
}

function engines_section() {
  const t = table("engines.csv");
  if (t.rows === 0) return;
  const scenes = t.values("scene");
  state.engine_error = "energy_error_max_rel";
  state.engine_steps = "";
  state.engine_group = "modes";
  const here = () => t.where("scene", state.scene)
    .filter((i) => in_engine_group(state.engine_group, t.text(i, "solver"), t.text(i, "mode") !== ""));
  place("engines", "controls", ["scene"], () => (scenes.includes(state.scene) ? [] : el("p", { class: "soft" },
    `The engines were not asked about “${scene_title(state.scene)}”, but about: `, scenes.map((scene) =>
      el("button", { type: "button", class: "chip", on_click: () => change({ scene }) }, scene_title(scene))))));
  place("engines", "controls", ["scene", "engine_error"], () => here().length > 0 && choice("Error in",
    engine_errors.map(([column, name]) => [column, name]), state.engine_error, (engine_error) => change({ engine_error })));
  place("engines", "controls", ["scene", "engine_group"], () => here().length > 0 && choice("Engines", engine_groups,
    state.engine_group, (engine_group) => change({ engine_group })));
  const holder = el("div", { class: "figure" });
  document.getElementById("engines").append(holder);
  const draw = () => {
    holder.hidden = here().length === 0 || typeof Chart === "undefined";
    if (!holder.hidden) log_chart(holder, engines_figure(t, here()));
  };
  on_change(["scene", "engine_error", "engine_group", "theme"], draw);
  draw();
  // One rung of the ladder at a time; a solver that chooses its own steps shows the finest that it was asked for.
  const rungs = () => t.values("knob_value", here().filter((i) => t.text(i, "knob") === "steps")).filter(Boolean);
  const rung = () => (rungs().includes(state.engine_steps) ? state.engine_steps : rungs()[0]);
  place("engines", "controls", ["scene", "engine_group", "engine_steps"], () => rungs().length > 0 && pick("Steps over the duration",
    rungs().map((value) => [value, pretty_count(Number(value))]), rung(), (engine_steps) => change({ engine_steps })));
  place("engines", "", ["scene", "engine_steps", "engine_group", "theme"], () => engines_table(t, t.values("solver", here()).map((solver) => {
    const mine = here().filter((i) => t.text(i, "solver") === solver);
    return mine.find((i) => t.text(i, "knob_value") === rung()) ?? mine[mine.length - 1];
  })));
}

function engines_figure(t, rows) {
  const [column, name, unit] = engine_errors.find(([id]) => id === state.engine_error);
  return {
    x: { title: "step h / s" }, y: { title: `largest ${name} error${unit ? ` / ${unit}` : ", relative"}`, cap: 1e3 },
    series: in_order(new Set(t.values("solver", rows))).map((solver) => ({ solver, points: rows
      .filter((i) => t.text(i, "solver") === solver && t.number(i, column) >= 0 && t.number(i, "h_s") > 0)
      .map((i) => ({ x: t.number(i, "h_s"), y: t.number(i, column), lines: [
        `h = ${pretty_time(t.number(i, "h_s"))}, ${pretty_count(t.number(i, "steps"))} steps`,
        ...engine_errors.filter(([id]) => Number.isFinite(t.number(i, id)))
          .map(([id, what, its_unit]) => `${what} ${pretty(t.number(i, id))} ${its_unit}`),
        `${pretty_time(t.number(i, "ns_per_step") * 1e-9)} a step, ${pretty_factor(t.number(i, "real_time_factor"))} × real time`,
      ] })) })).filter((s) => s.points.length > 0),
    label: `Errors of physics engines over the step on ${scene_title(state.scene)}`, fallback: ["engines", state.scene],
  };
}

function engines_table(t, rows) {
  if (rows.length === 0) return [];
  const orders = (i) => ["attitude", "energy", "momentum"].map((what) => t.number(i, `${what}_order`))
    .map((order) => (Number.isFinite(order) ? order.toFixed(1) : "–")).join("\u00a0·\u00a0");
  const error = (title, column, hint) => ({ title, hint, number: true, cell: (i) => pretty(t.number(i, column), 2) });
  return data_table([
    { title: "Engine", head: true, cell: (i) => [named(t.text(i, "solver")),
      el("small", {}, [t.text(i, "precision"), t.text(i, "mode")].filter(Boolean).map(spaced).join(", "))] },
    { title: "Verdict", cell: (i) => el("div", { class: "words" }, spaced(t.text(i, "verdict"))) },
    { title: "Step", number: true, cell: (i) => (t.text(i, "outcome") === "ok" ? pretty_time(t.number(i, "h_s"))
      : el("span", { class: "badge bad" }, spaced(t.text(i, "outcome")))) },
    error("Attitude / rad", "attitude_error_max_rad"),
    error("Energy", "energy_error_max_rel", "relative"),
    error("Momentum", "momentum_error_max_rel", "relative"),
    error("Its direction / rad", "momentum_direction_error_max_rad"),
    { title: "Orders", hint: "of attitude, energy, momentum", cell: (i) => el("span", { class: "nowrap" }, orders(i)) },
    { title: "A step", number: true, cell: (i) => pretty_time(t.number(i, "ns_per_step") * 1e-9) },
    { title: "× real time", number: true, cell: (i) => pretty_factor(t.number(i, "real_time_factor")) },
  ], rows, { label: "Engines", tall: true, narrow_heads: true });
}
