// Starts the page: reads its data, fills the sections, hides those that have nothing to say.

function start() {
  read_families();
  state.scene = (data.scenes || [])[0]?.id || "";
  state.families = new Set([...family_of.values()].filter((family) => family !== "truth"));
  const keep_norm = () => {
    const there = norms_of(state.scene);
    if (there.length > 0 && !there.some((norm) => norm.column === state.norm)) state.norm = there[0].column;
  };
  keep_norm();
  on_change(["scene"], keep_norm);  // told first, so that everybody else sees a norm that the scene has

  document.getElementById("summary").textContent = data.summary;
  const fact = (name) => (data.provenance || []).find(([key]) => key === name)?.[1];
  document.getElementById("where-from").textContent = [fact("cpu"), fact("date"), fact("version") && `polhode ${fact("version")}`]
    .filter(Boolean).join(" · ");
  const notes = [...(data.notes || []), data.missing_packages && `When polhode was built, ${data.missing_packages} was not `
    + "installed: charts are still pictures and bodies are drawn as vectors. Install it, build again, and make the report again."];
  document.getElementById("notes").append(...notes.filter(Boolean).map((note) => el("p", { class: "note" }, note)));
  if (data.missing_packages) document.getElementById("notices").hidden = data.missing_packages.includes(" ");

  const scene_pick = document.getElementById("scene");
  scene_pick.append(...(data.scenes || []).map((scene) => el("option", { value: scene.id }, scene.title || scene.id)));
  scene_pick.addEventListener("change", () => change({ scene: scene_pick.value }));
  on_change(["scene"], () => { scene_pick.value = state.scene; });
  scene_pick.closest("label").hidden = (data.scenes || []).length < 2;
  start_theme();

  for (const section of [choose_section, work_section, convergence_section, drift_section, stability_section, engines_section,
    polhode_section, motion_section, scenes_section, solvers_section, source_section]) section();

  const contents = document.getElementById("contents");
  for (const section of document.querySelectorAll("main > section")) {
    section.hidden = section.children.length < 2;
    if (!section.hidden) contents.append(el("a", { href: `#${section.id}` }, section.dataset.short));
  }
  if (!(data.scenes || []).length)
    document.getElementById("notes").append(el("p", { class: "note" }, "The tables of this folder are empty or missing: no run has been kept."));
  document.documentElement.dataset.ready = "yes";
}

function start_theme() {
  const button = document.getElementById("theme");
  const show = () => {
    document.documentElement.dataset.theme = is_dark() ? "dark" : "light";
    button.textContent = is_dark() ? "Light" : "Dark";
  };
  button.addEventListener("click", () => {
    document.documentElement.dataset.theme = is_dark() ? "light" : "dark";
    change({ theme: is_dark() ? "light" : "dark" });
  });
  on_change(["theme"], show);
  show();
}

read_data().then(start).catch((error) => {
  document.getElementById("notes").append(el("p", { class: "note" }, `This page could not start: ${error.message}`));
  throw error;
});
