// Who reaches an error cheapest: of each solver the quickest run that ended well with an error of at most the bound;
// solvers by the least time of that run. `polhode advise` ranks by the same rule.

const norms = [
  ["attitude_error_max_rad", "attitude", "rad", "floor_attitude_rad"],
  ["rate_error_max_rel", "rate", "", "floor_rate_rel"],
  ["energy_error_max_rel", "energy", "", ""],
  ["momentum_error_max_rel", "momentum", "", ""],
  ["position_error_max_m", "position", "m", ""],
].map(([column, name, unit, floor]) => ({ column, name, unit, floor }));
const norm_of = (column) => norms.find((norm) => norm.column === column) || norms[0];
const with_unit = (norm, value) => pretty(value) + (norm.unit && ` ${norm.unit}`);

// Norms that a scene has any number of.
function norms_of(scene) {
  const t = table("work_precision.csv");
  const rows = t.where("scene", scene);
  return norms.filter((norm) => rows.some((i) => Number.isFinite(t.number(i, norm.column))));
}

// What rounding makes of any error on a scene; NaN where nobody knows.
function floor_of(scene, norm) {
  const t = table("scenes.csv");
  const [row] = t.where("scene", scene);
  return row === undefined || !norm.floor ? NaN : t.number(row, norm.floor);
}

// {ranked: [{solver, row, time, spread, place, tied}], missed: [{solver, least, why}]}
const rankings = new Map();
function ranking(scene, column, bound) {
  const key = `${scene}\n${column}\n${bound}`;
  if (!rankings.has(key)) rankings.set(key, rank(scene, column, bound));
  return rankings.get(key);
}

function rank(scene, column, bound) {
  const t = table("work_precision.csv");
  const best = new Map(), least = new Map(), outcomes = new Map();
  for (const i of t.where("scene", scene)) {
    const solver = t.text(i, "solver"), error = t.number(i, column), time = t.number(i, "time_min_s");
    outcomes.set(solver, t.text(i, "outcome"));
    if (t.text(i, "outcome") !== "ok" || !Number.isFinite(error)) continue;
    if (!(error >= least.get(solver))) least.set(solver, error);
    if (error <= bound && time > 0 && !(time >= best.get(solver)?.time))
      best.set(solver, { solver, row: i, error, time, spread: t.number(i, "time_mad_s") || 0 });
  }
  const ranked = [...best.values()].sort((a, b) => a.time - b.time);
  let leader = null;
  ranked.forEach((entry, i) => {
    // A tie: the difference to the first of the group is within both spreads together.
    entry.tied = leader !== null && entry.time - leader.time <= entry.spread + leader.spread;
    if (!entry.tied) leader = entry;
    else leader.shared = true;
    entry.place = entry.tied ? leader.place : i + 1;
  });
  const missed = [...outcomes].filter(([solver]) => !best.has(solver))
    .map(([solver, outcome]) => ({ solver, least: least.get(solver) ?? NaN, why: outcome }))
    .sort((a, b) => (Number.isNaN(a.least) ? Infinity : a.least) - (Number.isNaN(b.least) ? Infinity : b.least));
  return { ranked, missed };
}

// The member of a family that a chart shows first: the cheapest at the reader's bound, else the one with the least
// error, else the first.
function best_of(family, candidates) {
  const { ranked, missed } = ranking(state.scene, state.norm, state.bound);
  const mine = (entry) => family_of.get(entry.solver) === family && candidates.has(entry.solver);
  return (ranked.find(mine) || missed.find((entry) => mine(entry) && Number.isFinite(entry.least)))?.solver
    ?? [...candidates].find((solver) => family_of.get(solver) === family);
}

// Which of the candidates the charts show now.
function shown(candidates) {
  const out = new Set([...state.pinned].filter((solver) => candidates.has(solver)));
  for (const family of state.families)
    if (state.every) {
      for (const solver of candidates) if (family_of.get(solver) === family) out.add(solver);
    } else {
      const best = best_of(family, candidates);
      if (best !== undefined) out.add(best);
    }
  return in_order(out);
}
