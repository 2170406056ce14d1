// What was asked, of whom, on which machine; and the tables to take away.

function scenes_section() {
  const t = table("scenes.csv");
  if (t.rows === 0) return;
  place("scenes", "", ["scene"], () => {
    const [i] = t.where("scene", state.scene);
    if (i === undefined) return [];
    const number = (name, unit) => t.has(name) && Number.isFinite(t.number(i, name)) && `${pretty(t.number(i, name))} ${unit}`;
    const moments = moments_of(state.scene);
    const facts = [["Title", t.text(i, "title")], ["Id", t.text(i, "scene")], ["Duration", number("duration_s", "s")],
      ["Principal moments", moments.every(Number.isFinite) && moments.length > 0 && `${moments.map((m) => pretty(m)).join(", ")} kg m²`],
      ["Unknowns", t.text(i, "unknowns")], ["Truth", t.text(i, "truth")],
      ["Truth known to", number("truth_uncertainty_rad", "rad")], ["Rounding floor", number("floor_attitude_rad", "rad")],
      ["Growth of a disturbance", number("conditioning", "")]];
    const left_out = t.text(i, "left_out").split("; ").filter(Boolean);
    return [el("dl", { class: "facts" }, facts.filter(([, value]) => value).map(([name, value]) =>
      el("div", {}, el("dt", {}, name), el("dd", {}, value)))),
      left_out.length > 0 && el("div", {}, el("h3", {}, "Left out"), el("p", { class: "how" },
        "Nothing is integrated that this scene does not have:"), el("ul", {}, left_out.map((part) => el("li", {}, part))))];
  });
}

const claim_words = { unit_attitude: "|q| = 1", momentum_magnitude: "|L| kept", space_momentum: "L kept in space",
  energy_bounded: "energy bounded", reversible: "reversible" };

function solvers_section() {
  const t = table("solvers.csv");
  if (t.rows === 0) return;
  place("solvers", "how", [], () => "What each claims. A claim is measured by a test of polhode, the negative ones too; the orders "
    + "measured in this study stand under “Convergence”, the drifts under “What is lost over time”.");
  place("solvers", "", ["theme"], () => {
    const claims = Object.keys(claim_words).filter((name) => t.has(name));
    const answer = (i, name) => ({ yes: el("span", { title: "yes" }, "✓"), no: el("span", { class: "soft", title: "no" }, "✗") })[t.text(i, name)] || "";
    const families = t.values("family");
    return families.map((family) => {
      const rows = t.where("family", family);
      return folded(el("span", {}, `${sentence_case(family)} `, el("small", {}, rows.length)), data_table([
        { title: "Solver", head: true, cell: (i) => named(t.text(i, "solver")) },
        { title: "What it is", cell: (i) => el("div", { class: "words" }, t.text(i, "summary"), el("small", {},
          [t.text(i, "source"), t.text(i, "version")].filter(Boolean).join(" · "))) },
        { title: "Order", number: true, cell: (i) => t.text(i, "order") || "–" },
        ...claims.map((name) => ({ title: claim_words[name], cell: (i) => answer(i, name) })),
      ], rows, { label: `Solvers: ${family}`, narrow_heads: true }));
    });
  });
}

function source_section() {
  const facts = data.provenance || [];
  const download = (name) => el("button", { type: "button", class: "chip", on_click: () => {
    const link = el("a", { href: URL.createObjectURL(new Blob([tables.get(name).csv], { type: "text/csv" })), download: name });
    link.click();
    URL.revokeObjectURL(link.href);
  } }, code(name), el("small", {}, `${pretty_count(tables.get(name).csv.length / 1000)} kB`));
  place("source", "", [], () => [
    tables.size > 0 && el("p", { class: "how" }, "Tables inside this page, with numbers of five digits; the result folder has all of them, "
      + "and each figure as SVG and PDF with the gnuplot script that draws it."),
    el("div", { class: "chips" }, [...tables.keys()].map(download)),
    facts.length === 0 ? el("p", {}, "This folder has no run.json, so nothing is known about the machine and the versions.")
      : el("dl", { class: "provenance" }, facts.flatMap(([name, value]) => [el("dt", {}, spaced(name)), el("dd", {}, value)])),
  ]);
}
