// Attitudes and motions: quaternions (w, x, y, z), body to space, as in the tables; and the samples of motion.csv.

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm3 = (a) => Math.sqrt(dot(a, a));
const scaled = (a, s) => [a[0] * s, a[1] * s, a[2] * s];

function quaternion_product(p, q) {
  return [p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
    p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1], p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0]];
}
function unit(q) {
  const length = Math.hypot(...q);
  return length > 0 ? q.map((x) => x / length) : [1, 0, 0, 0];
}
function rotated(q, v) {
  const u = q.slice(1), t = scaled(cross(u, v), 2), c = cross(u, t);
  return [0, 1, 2].map((i) => v[i] + q[0] * t[i] + c[i]);
}
// The shortest turn that takes a direction to the z axis.
function turn_to_z(v) {
  const length = norm3(v);
  if (!(length > 0)) return [1, 0, 0, 0];
  const n = scaled(v, 1 / length);
  return n[2] < -0.999999 ? [0, 1, 0, 0] : unit([1 + n[2], n[1], -n[0], 0]);
}
function between(p, q, part) {
  const near = p[0] * q[0] + dot(p.slice(1), q.slice(1)) < 0 ? q.map((x) => -x) : q;
  return unit(p.map((x, i) => x + part * (near[i] - x)));
}
function attitude_error(p, q) {
  const d = quaternion_product([p[0], -p[1], -p[2], -p[3]], q);
  return 2 * Math.atan2(Math.hypot(d[1], d[2], d[3]), Math.abs(d[0]));
}

// One motion of motion.csv: {solver, words, t[], q[], w[]}, in the principal frame of the body.
const motions = new Map();
function motion_of(scene, solver) {
  const key = `${scene}\n${solver}`;
  if (!motions.has(key)) {
    const t = table("motion.csv"), rows = t.where("scene", scene).filter((i) => t.text(i, "solver") === solver
      && Number.isFinite(t.number(i, "qw")));
    const vector = (i, names) => names.map((name) => t.number(i, name));
    const [any] = t.where("scene", scene).filter((i) => t.text(i, "solver") === solver);
    motions.set(key, { solver, outcome: any === undefined ? "" : t.text(any, "outcome"),
      setting: any === undefined ? "" : setting(t.text(any, "knob"), t.number(any, "knob_value")),
      t: rows.map((i) => t.number(i, "t_s")), q: rows.map((i) => unit(vector(i, ["qw", "qx", "qy", "qz"]))),
      w: rows.map((i) => vector(i, ["wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"])) });
  }
  return motions.get(key);
}
// State at a time; a run that ended earlier stays where it was.
function state_at(motion, time) {
  const { t, q, w } = motion, last = t.length - 1;
  if (time >= t[last]) return { q: q[last], w: w[last], ended: time > t[last] * 1.0001 };
  let i = Math.min(last - 1, Math.max(0, Math.floor((time / t[last]) * last)));
  while (i > 0 && t[i] > time) --i;
  while (i < last - 1 && t[i + 1] <= time) ++i;
  const part = (time - t[i]) / (t[i + 1] - t[i]);
  return { q: between(q[i], q[i + 1], part), w: [0, 1, 2].map((k) => w[i][k] + part * (w[i + 1][k] - w[i][k])), ended: false };
}

// The truth is the row of the family that says so.
const truth_solver = () => [...family_of].find(([, family]) => family === "truth")?.[0] ?? "reference";
const moments_of = (scene) => {
  const t = table("scenes.csv"), [row] = t.where("scene", scene);
  return row === undefined ? [] : [1, 2, 3].map((k) => (t.has(`moment_${k}_kg_m2`) ? t.number(row, `moment_${k}_kg_m2`) : NaN));
};
// Scenes whose motion can be shown.
const has_motion = (scene) => table("motion.csv").where("scene", scene).length > 0
  && motion_of(scene, truth_solver()).t.length > 1 && moments_of(scene).every((moment) => moment > 0);

// Half sides of the box with these principal moments, the longest corner at one. A body that cannot be a box (a flat
// plate, or one that exists as mathematics alone) gets a thin side.
function box_of(moments) {
  const sum = moments[0] + moments[1] + moments[2];
  const squares = moments.map((moment) => Math.max(sum / 2 - moment, 0.004 * sum));
  const sides = squares.map(Math.sqrt), corner = Math.hypot(...sides);
  return sides.map((side) => side / corner);
}
