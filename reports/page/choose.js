// "Which integrator should I use?": the reader picks a bound and a norm, and sees who gets there cheapest.

const table_rows = 10;  // before "all"

function choose_section() {
  if (table("work_precision.csv").rows === 0) return;
  const exponent = () => Math.round(-Math.log10(state.bound));
  const slider = el("input", { type: "range", id: "bound", min: "1", max: "14", step: "1", value: exponent(),
    "aria-label": "Error bound, power of ten",
    on_input: (event) => change({ bound: Number(`1e-${event.target.value}`) }) });
  const exact = el("input", { type: "text", id: "bound-text", size: "8", inputmode: "decimal", value: state.bound.toExponential(),
    "aria-label": "Error bound as a number",
    on_change: (event) => {
      const value = Number(event.target.value);
      if (event.target.value.trim() !== "" && value > 0 && value < 10) change({ bound: value });
      else event.target.value = state.bound.toExponential();
    } });
  on_change(["bound"], () => {
    slider.value = exponent();
    exact.value = state.bound.toExponential();
  });
  place("choose", "controls", ["scene", "norm"], () => [
    choice("Error in", norms_of(state.scene).map((norm) => [norm.column, norm.name]), state.norm,
      (norm) => change({ norm })),
    el("div", { class: "bound" }, el("span", { class: "legend" }, "no larger than"),
      el("div", {}, slider, exact, el("span", { class: "soft" }, norm_of(state.norm).unit || "relative"))),
  ]);
  place("choose", "answer", ["scene", "norm", "bound"], draw_answer);
}

function draw_answer() {
  const t = table("work_precision.csv"), norm = norm_of(state.norm), bound = with_unit(norm, state.bound);
  const floor = floor_of(state.scene, norm);
  const title = scene_title(state.scene);
  if (state.bound < floor)
    return el("p", { class: "verdict" }, `${bound} lies below ${with_unit(norm, floor)}, which is what rounding alone does `
      + `to “${title}” in double precision: nobody is ranked there.`);
  const { ranked, missed } = ranking(state.scene, state.norm, state.bound);
  if (ranked.length === 0)
    return [el("p", { class: "verdict" }, `No solver of this study reaches ${bound} on “${title}”.`), draw_missed(missed, norm)];
  const [best] = ranked;
  const tied = ranked.filter((entry) => entry.place === 1 && entry !== best);
  const next = ranked.find((entry) => entry.place > 1);
  const verdict = el("p", { class: "verdict" }, named(best.solver), ` reaches ${bound} on “${title}” with `,
    setting(t.text(best.row, "knob"), t.number(best.row, "knob_value")), " in ", el("strong", {}, pretty_time(best.time)),
    tied.length > 0 && [", within the spread of the clock no quicker than ",
      tied.slice(0, 3).flatMap((entry, i) => [i ? ", " : "", named(entry.solver)]),
      tied.length > 3 && ` and ${tied.length - 3} more`],
    next && ["; ", named(next.solver), ` needs ${pretty_factor(next.time / best.time)} times that`], ".");
  const list = el("div", {});
  const draw_list = (all) => list.replaceChildren(ranked_table(all ? ranked : ranked.slice(0, table_rows), best, norm),
    ranked.length > table_rows && el("button", { type: "button", class: "quiet", on_click: () => draw_list(!all) },
      all ? `The first ${table_rows}` : `All ${ranked.length} that reach it`) || "");
  draw_list(false);
  return [verdict, list, draw_missed(missed, norm)];
}

function ranked_table(rows, best, norm) {
  const t = table("work_precision.csv");
  return data_table([
    { title: "", number: true, cell: (e) => `${e.place}${e.tied || e.shared ? "=" : ""}`,
      hint: "=: no difference beyond the spread of the clock" },
    { title: "Solver", head: true, cell: (e) => [named(e.solver), el("small", {}, family_of.get(e.solver))] },
    { title: "Setting", cell: (e) => setting(t.text(e.row, "knob"), t.number(e.row, "knob_value")) },
    { title: `Error${norm.unit && ` / ${norm.unit}`}`, number: true, cell: (e) => pretty(e.error) },
    { title: "Time", number: true, cell: (e) => el("strong", {}, pretty_time(e.time)), hint: "CPU time of one run, least of the repeats" },
    { title: "Median", number: true, cell: (e) => pretty_time(t.number(e.row, "time_median_s")) },
    { title: "Spread", number: true, cell: (e) => "± " + pretty_time(e.spread), hint: "median absolute deviation" },
    { title: "× first", number: true, cell: (e) => pretty_factor(e.time / best.time) },
    { title: "Right-hand sides", number: true, cell: (e) => pretty_count(t.number(e.row, "rhs_evals")) },
  ], rows, { label: "Solvers that reach the bound, cheapest first" });
}

function draw_missed(missed, norm) {
  if (missed.length === 0) return el("p", { class: "soft" }, "Every solver of the study reaches it.");
  const item = (entry) => el("li", {}, named(entry.solver), " ", el("small", {},
    Number.isFinite(entry.least) ? with_unit(norm, entry.least) : spaced(entry.why)));
  return folded(`${counted(missed.length, "solver")} not among them, with the least error that ${missed.length === 1 ? "it" : "each"} came to`,
    el("ul", { class: "names" }, missed.map(item)));
}
