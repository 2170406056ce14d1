// Polhode and herpolhode: where the angular momentum goes in the body, on the sphere of its magnitude and the ellipsoid of
// its energy; and the path of the angular velocity in the invariable plane.

function polhode_section() {
  const scenes = table("motion.csv").values("scene").filter(has_motion);
  if (scenes.length === 0) return;
  const solvers = () => in_order(new Set(table("motion.csv").values("solver", table("motion.csv").where("scene", state.scene))))
    .filter((solver) => solver !== truth_solver() && motion_of(state.scene, solver).t.length > 1);
  state.polhode_solver = "";
  const chosen = () => (solvers().includes(state.polhode_solver) ? state.polhode_solver : solvers()[0]);
  place("polhode", "how", [], () => "In the body frame the angular momentum of a free body stays on a sphere, that of its magnitude, "
    + "and on an ellipsoid, that of its energy: it follows the curve in which both meet, the polhode. A solver that loses one of "
    + "them leaves its surface. In space the angular velocity draws the herpolhode on the plane at right angles to the momentum.");
  place("polhode", "controls", ["scene", "polhode_solver"], () => (has_motion(state.scene)
    ? pick("Beside the exact motion", solvers().map((s) => [s, s]), chosen(), (polhode_solver) => change({ polhode_solver }))
    : el("p", { class: "soft" }, "There is no rotation to show on this scene.")));
  clock_controls("polhode");
  const holder = el("div", { class: "pair" });
  document.getElementById("polhode").append(holder);
  let shown_now = null;
  const draw = () => {
    shown_now?.dispose();
    holder.hidden = !has_motion(state.scene);
    shown_now = holder.hidden ? null : polhode_pair(holder, motion_of(state.scene, truth_solver()),
      chosen() === undefined ? null : motion_of(state.scene, chosen()));
  };
  when_near(holder, () => {
    on_change(["scene", "theme", "polhode_solver"], draw);
    draw();
    follow_clock(holder, (part) => shown_now?.tick(part));
  });
}

// Work that costs something waits until its place comes near the window, or the page is printed.
function when_near(holder, work) {
  const watch = new IntersectionObserver(([entry]) => {
    if (!entry.isIntersecting) return;
    watch.disconnect();
    work();
  }, { rootMargin: "600px" });
  watch.observe(holder);
}

function polhode_pair(holder, exact, other) {
  const moments = moments_of(state.scene);
  const momentum = (w) => w.map((x, i) => x * moments[i]);
  const energy_of = (w) => w.reduce((sum, x, i) => sum + moments[i] * x * x / 2, 0);
  const start = momentum(exact.w[0]), energy = energy_of(exact.w[0]);
  const largest = Math.max(...exact.w.map((w) => norm3(momentum(w))));
  // Of a body under a torque neither surface holds what it does.
  const free = exact.w.every((w) => Math.abs(energy_of(w) - energy) < 1e-3 * energy
    && Math.abs(norm3(momentum(w)) - norm3(start)) < 1e-3 * norm3(start));
  const size = largest;
  const path = (motion) => motion.w.map((w) => scaled(momentum(w), 1 / size)).filter((p) => norm3(p) < 4);
  const ink = css("--ink-hex"), soft = css("--soft-hex"), colour = other && look(other.solver).colour;
  const at = { exact: { point: scaled(start, 1 / size) }, other: { point: scaled(start, 1 / size) } };
  const radii = moments.map((moment) => Math.sqrt(2 * energy * moment) / size);
  const items = [
    ...graticule([1, 1, 1], soft, free ? 0.35 : 0.15),
    ...(free ? [{ kind: "ball", radii: [1, 1, 1], colour: soft, opacity: 0.1 },
      ...(Math.max(...radii) < ellipsoid_reach ? [{ kind: "ball", radii, colour: css("--accent-hex"), opacity: 0.08 }] : []),
      ...graticule(radii, css("--accent-hex"), 0.3),
      ...separatrices(moments, soft)] : []),
    { kind: "line", points: path(exact), colour: ink, width: 2.4 },
    { kind: "dot", at: at.exact, colour: ink },
    ...(other ? [{ kind: "line", points: path(other), colour, width: 1.8 }, { kind: "dot", at: at.other, colour }] : []),
  ];
  const left = el("div", { class: "half" }), right = el("div", { class: "half" });
  holder.replaceChildren(left, right);
  const key = el("p", { class: "caption" }, el("b", {}, "Momentum in the body"), " — ", el("span", { class: "stroke", style: `color: ${ink}` }), "exact",
    other && [" ", el("span", { class: "stroke", style: `color: ${colour}` }), code(other.solver)], free ? " · grey: sphere, blue: ellipsoid, dashed: separatrices" : " · under a torque: no sphere, no ellipsoid");
  const reach = Math.min(1.8, Math.max(...items.filter((item) => item.kind === "line").flatMap((item) => item.points.map(norm3)))) * 1.05;
  const stage = new Stage(left, [{ caption: key, items }], { height: 380, label: "Polhode in three dimensions", reach });
  const flat = herpolhode(right, exact, other, start, ink, colour);
  stage.draw();
  const end = exact.t[exact.t.length - 1];
  return {
    tick(part) {
      at.exact.point = scaled(momentum(state_at(exact, part * end).w), 1 / size);
      if (other) at.other.point = scaled(momentum(state_at(other, part * end).w), 1 / size);
      stage.draw();
      flat(part * end);
    },
    dispose() { stage.dispose(); },
  };
}

const ellipsoid_reach = 1.4;  // farther out it says nothing about the sphere, and would hide it

// Lines of an ellipsoid, every 30 degrees, as far as they stay near the sphere.
function graticule(radii, colour, opacity) {
  const lines = [];
  const line = (point) => {
    let points = [];
    const end = () => {
      if (points.length > 1) lines.push({ kind: "line", colour, opacity, width: 0.7, points });
      points = [];
    };
    for (let k = 0; k <= 144; ++k) {
      const p = point((2 * Math.PI * k) / 144).map((x, i) => x * radii[i]);
      if (norm3(p) < ellipsoid_reach) points.push(p);
      else end();
    }
    end();
  };
  for (let k = 0; k < 6; ++k) {
    const a = (Math.PI * k) / 6;
    line((s) => [Math.cos(a) * Math.sin(s), Math.sin(a) * Math.sin(s), Math.cos(s)]);
    const z = Math.sin(a - Math.PI / 2 + Math.PI / 12), r = Math.sqrt(1 - z * z);
    line((s) => [r * Math.cos(s), r * Math.sin(s), z]);
  }
  return lines;
}

// Through the middle axis, on the sphere: two great circles part the motions about the least and the greatest axis.
function separatrices(moments, colour) {
  const [least, middle, greatest] = [0, 1, 2].sort((a, b) => moments[a] - moments[b]);
  const a = 1 / moments[least] - 1 / moments[middle], c = 1 / moments[middle] - 1 / moments[greatest];
  if (!(a > 1e-9 / moments[middle]) || !(c > 1e-9 / moments[middle])) return [];
  const slope = Math.atan2(Math.sqrt(a), Math.sqrt(c));
  return [1, -1].map((side) => ({ kind: "line", colour, dashed: true, width: 1, points: Array.from({ length: 97 }, (_, k) => {
    const s = (2 * Math.PI * k) / 96, p = [0, 0, 0];
    p[middle] = Math.cos(s) * 1.002;
    p[least] = Math.sin(s) * Math.cos(slope) * 1.002;
    p[greatest] = side * Math.sin(s) * Math.sin(slope) * 1.002;
    return p;
  }) }));
}

// Returns what draws the herpolhode up to a time.
function herpolhode(holder, exact, other, start, ink, colour) {
  const up = turn_to_z(rotated(exact.q[0], start));
  const flat = (motion) => motion.w.map((w, i) => rotated(up, rotated(motion.q[i], w)));
  const paths = [[flat(exact), exact, ink, 1.8], ...(other ? [[flat(other), other, colour, 1.4]] : [])];
  const reach = 1.08 * Math.max(1e-12, ...paths[0][0].map((p) => Math.hypot(p[0], p[1])));
  const canvas = el("canvas", { class: "flat", role: "img", "aria-label": "Herpolhode: the angular velocity in the invariable plane" });
  holder.replaceChildren(el("p", { class: "caption" }, el("b", {}, "Angular velocity in the invariable plane"),
    ` — width ${pretty(2 * reach)} rad/s`), canvas);
  let now = 0;
  const draw = (time) => {
    now = time;
    const size = canvas.clientWidth, dpr = Math.min(2, devicePixelRatio);
    if (size === 0) return;
    canvas.width = canvas.height = size * dpr;
    const ctx = canvas.getContext("2d");
    ctx.setTransform(dpr, 0, 0, dpr, (size / 2) * dpr, (size / 2) * dpr);
    ctx.strokeStyle = css("--line");
    ctx.beginPath();
    ctx.moveTo(-size / 2, 0); ctx.lineTo(size / 2, 0); ctx.moveTo(0, -size / 2); ctx.lineTo(0, size / 2);
    ctx.stroke();
    for (const [points, motion, line_colour, width] of paths) {
      ctx.strokeStyle = ctx.fillStyle = line_colour;
      ctx.lineWidth = width;
      ctx.lineJoin = "round";
      smooth_path(ctx, points.map((p) => [(p[0] * size) / (2 * reach), (-p[1] * size) / (2 * reach)]));
      ctx.stroke();
      const { q, w } = state_at(motion, time), p = rotated(up, rotated(q, w));
      ctx.beginPath();
      ctx.arc((p[0] * size) / (2 * reach), (-p[1] * size) / (2 * reach), 4.5, 0, 2 * Math.PI);
      ctx.fill();
    }
  };
  new ResizeObserver(() => draw(now)).observe(canvas);
  return draw;
}

// A curve through points: Catmull and Rom's, as cubic pieces.
function smooth_path(ctx, points) {
  ctx.beginPath();
  ctx.moveTo(...points[0]);
  for (let i = 1; i < points.length; ++i) {
    const [before, a, b, after] = [points[Math.max(0, i - 2)], points[i - 1], points[i], points[Math.min(points.length - 1, i + 1)]];
    ctx.bezierCurveTo(a[0] + (b[0] - before[0]) / 6, a[1] + (b[1] - before[1]) / 6,
      b[0] - (after[0] - a[0]) / 6, b[1] - (after[1] - a[1]) / 6, b[0], b[1]);
  }
}
