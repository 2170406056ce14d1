// Which solvers the charts show: families as chips, the best of each or every member, and any solver by name. The same
// choice holds in all sections, so each of these controls shows it; after the first they are folded.

let pickers = 0;
function solver_picker(section_id, candidates) {
  const id = `solvers-${++pickers}`, first = pickers === 1;
  let open = first;
  place(section_id, "picker", ["scene", "families", "every", "pinned", "theme", "norm", "bound"], () => {
    const here = candidates();
    if (here.size === 0) return [];
    const families = [...new Set([...family_of.keys()].filter((s) => here.has(s)).map((s) => family_of.get(s)))];
    const chip = (family) => {
      const best = best_of(family, here);
      return el("button", { type: "button", class: "chip", "data-family": family,
        "aria-pressed": String(state.families.has(family)), on_click: () => toggle("families", family, section_id) },
        glyph(best), family, el("small", {}, [...here].filter((s) => family_of.get(s) === family).length));
    };
    const all_on = families.every((family) => state.families.has(family));
    const add = el("input", { type: "text", list: id, placeholder: "Add a solver", "aria-label": "Add a solver by name",
      on_change: (event) => {
        if (here.has(event.target.value)) change({ pinned: new Set([...state.pinned, event.target.value]) });
        else event.target.value = "";
      } });
    const controls = [
      el("div", { class: "chips", role: "group", "aria-label": "Families" }, families.map(chip),
        el("button", { type: "button", class: "chip plain",
          on_click: () => change({ families: new Set(all_on ? [] : families) }) }, all_on ? "None" : "All families")),
      el("div", { class: "controls" },
        choice("Of each family", [["best", "the best"], ["every", "every solver"]], state.every ? "every" : "best",
          (which) => change({ every: which === "every" })),
        el("div", { class: "add" }, add,
          el("datalist", { id }, [...here].map((solver) => el("option", { value: solver }))),
          [...state.pinned].filter((solver) => here.has(solver)).map((solver) =>
            el("button", { type: "button", class: "chip", title: "Remove", "aria-label": `Remove ${solver}`,
              on_click: () => toggle("pinned", solver) }, glyph(solver), code(solver), " ×")))),
    ];
    if (first) return controls;
    return el("details", { open, on_toggle: (event) => { open = event.target.open; } },
      el("summary", {}, `Solvers shown: ${shown(here).length} of ${here.size}`), controls);
  });
}

// Puts a member into one of the sets of the state, or takes it out; the focus stays on the chip that did it.
function toggle(part, member, section_id) {
  const set = new Set(state[part]);
  if (!set.delete(member)) set.add(member);
  change({ [part]: set });
  if (section_id)
    document.querySelector(`#${section_id} .chip[data-family="${CSS.escape(member)}"]`)?.focus({ preventScroll: true });
}
