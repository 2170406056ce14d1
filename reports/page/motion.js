// The tumbling body: several solvers side by side on one clock, each with the exact motion as a ghost.

function motion_section() {
  const t = table("motion.csv");
  if (!t.values("scene").some(has_motion)) return;
  place("motion", "how", ["scene"], () => {
    if (!has_motion(state.scene)) return "There is no rotation to show on this scene.";
    const { t: times } = motion_of(state.scene, truth_solver());
    return `The box has the moments of the body; its ghost moves exactly. Every solver runs over ${pretty_time(times[times.length - 1])} `
      + "at a setting coarse enough to show what it does wrong. Up is the direction of the angular momentum at the start.";
  });
  clock_controls("motion");
  const holder = el("div", {});
  document.getElementById("motion").append(holder);
  let now = null;
  const draw = () => {
    now?.stage.dispose();
    holder.hidden = !has_motion(state.scene);
    now = holder.hidden ? null : tumbling(holder);
    now?.tick(clock.part);
  };
  when_near(holder, () => {
    on_change(["scene", "theme"], draw);
    draw();
    follow_clock(holder, (part) => now?.tick(part));
  });
}

// The tables of the page have five digits.
const off_by = (error) => (error < 1e-4 ? "off by less than 10⁻⁴ rad" : `off by ${pretty(error, 2)} rad`);

function tumbling(holder) {
  const t = table("motion.csv"), exact = motion_of(state.scene, truth_solver()), moments = moments_of(state.scene);
  const solvers = in_order(new Set(t.values("solver", t.where("scene", state.scene))))
    .filter((solver) => solver !== truth_solver() && motion_of(state.scene, solver).t.length > 0);
  const up = turn_to_z(rotated(exact.q[0], exact.w[0].map((x, i) => x * moments[i])));
  const sides = box_of(moments), ghost = { q: [1, 0, 0, 0] };
  const bodies = solvers.map((solver) => {
    const motion = motion_of(state.scene, solver);
    const says_error = el("small", {}, "");
    return { motion, pose: { q: [1, 0, 0, 0] }, says_error,
      caption: el("div", { class: "caption" }, named(solver), says_error) };
  });
  const stage = new Stage(holder, bodies.map((body) => ({ caption: body.caption, items: [
    { kind: "body", sides, colour: look(body.motion.solver).colour, pose: body.pose },
    { kind: "body", sides, colour: css("--ink-hex"), ghost: true, pose: ghost },
  ] })), { height: 180, label: "The tumbling body, one view for each solver", reach: 0.98 });
  const end = exact.t[exact.t.length - 1];
  return { stage, tick(part) {
    const truth = state_at(exact, part * end);
    ghost.q = quaternion_product(up, truth.q);
    for (const body of bodies) {
      const { q, ended } = state_at(body.motion, part * end);
      body.pose.q = quaternion_product(up, q);
      const words = `${body.motion.setting}, ` + (ended ? spaced(body.motion.outcome === "ok" ? "ended" : body.motion.outcome)
        : off_by(attitude_error(truth.q, q)));
      if (body.says_error.textContent !== words) body.says_error.textContent = words;
    }
    stage.draw();
  } };
}
