// Physics engines: what each does to a free body at its own step, and what a step costs.

function engines_section() {
  const t = table("engines.csv");
  if (t.rows === 0) return;
  const scenes = t.values("scene");
  place("engines", "controls", ["scene"], () => (scenes.includes(state.scene) ? [] : el("p", { class: "soft" },
    `The engines were not asked about “${scene_title(state.scene)}”, but about: `, scenes.map((scene) =>
      el("button", { type: "button", class: "chip", on_click: () => change({ scene }) }, scene_title(scene))))));
  place("engines", "", ["scene", "theme"], () => {
    const rows = t.where("scene", state.scene);
    if (rows.length === 0) return [];
    const orders = (i) => ["attitude", "energy", "momentum"].map((what) => t.number(i, `${what}_order`))
      .map((order) => (Number.isFinite(order) ? order.toFixed(1) : "–")).join(" · ");
    const error = (title, column, hint) => ({ title, hint, number: true, cell: (i) => pretty(t.number(i, column), 2) });
    return data_table([
      { title: "Engine", head: true, cell: (i) => [named(t.text(i, "solver")),
        el("small", {}, [t.text(i, "precision"), t.text(i, "mode")].filter(Boolean).map(spaced).join(", "))] },
      { title: "Step", number: true, cell: (i) => pretty_time(t.number(i, "h_s")) },
      error("Attitude / rad", "attitude_error_max_rad"),
      error("Energy", "energy_error_max_rel", "relative"),
      error("Momentum", "momentum_error_max_rel", "relative"),
      error("Its direction / rad", "momentum_direction_error_max_rad"),
      { title: "Orders", hint: "of attitude, energy, momentum", cell: orders },
      { title: "A step", number: true, cell: (i) => pretty_time(t.number(i, "ns_per_step") * 1e-9) },
      { title: "× real time", number: true, cell: (i) => pretty_factor(t.number(i, "real_time_factor")) },
      { title: "Verdict", cell: (i) => (t.text(i, "outcome") !== "ok" ? el("span", { class: "badge bad" }, spaced(t.text(i, "outcome")))
        : spaced(t.text(i, "verdict"))) },
    ], rows, { label: "Engines", tall: true });
  });
}
