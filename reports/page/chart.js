// Logarithmic charts: axes by decades, bands, guides, marks on the edge, keys to walk along the points, and a legend of
// our own. Without Chart.js the figure that gnuplot drew stands in.

// figure: {
//   x, y      {title, low?, high?}: limits where data alone would not do
//   series    [{solver, name?, dashed?, points: [{x, y, hollow?, edge?, lines}]}], lines being what the hover says;
//             dashed overrides the look of the solver, and what is dashed so is not in the legend
//   guides    [{points: [[x, y], [x, y]], label}], dotted lines behind the data
//   band      {axis: "x" | "y", to, label}: shaded from the lower end of an axis up to a value
//   label     what the chart shows, for those who cannot see it
//   fallback  [kind, scene] of the static figure
// }
function log_chart(holder, figure) {
  holder.chart?.destroy();
  holder.chart = null;
  if (typeof Chart === "undefined") {
    holder.replaceChildren(...static_figure(...figure.fallback));
    return;
  }
  if (figure.series.every((s) => s.points.length === 0)) {
    holder.replaceChildren(el("p", { class: "soft" }, "Nothing to draw here for the solvers shown."));
    return;
  }
  const canvas = el("canvas", { tabindex: "0", role: "img",
    "aria-label": `${figure.label}. Arrow keys walk along the points; the tables hold the same numbers.` });
  holder.replaceChildren(el("div", { class: "canvas" }, canvas), legend(holder, figure));
  const limits = { x: axis_limits(figure, "x"), y: axis_limits(figure, "y") };
  holder.chart = new Chart(canvas, {
    type: "scatter",
    data: { datasets: figure.series.map((s) => dataset(s, limits)) },
    options: chart_options(figure, limits),
    plugins: [backdrop(figure)],
  });
  canvas.addEventListener("keydown", (event) => walk(holder.chart, event));
}

function static_figure(kind, scene) {
  const found = (data.figures || []).filter((figure) => figure.kind === kind && figure.scene === scene);
  return found.length === 0 ? [el("p", { class: "soft" }, "No figure was drawn for this.")]
    : found.map((figure) => el("img", { class: "static", alt: figure.title,
      src: "data:image/svg+xml;charset=utf-8," + encodeURIComponent(figure.svg) }));
}

const least_shown = 1e-17;  // smaller relative errors mean nothing in double precision

function axis_limits(figure, axis) {
  let low = figure[axis].low ?? Infinity, high = figure[axis].high ?? 0;
  for (const s of figure.series)
    for (const point of s.points) {
      const value = point[axis];
      if (point.edge === axis || !(value > 0) || !Number.isFinite(value)) continue;
      low = Math.min(low, Math.max(value, least_shown));
      high = Math.max(high, value);
    }
  if (!(low <= high)) [low, high] = [0.1, 10];
  const cap = figure[axis].cap ?? Infinity;
  const floor10 = 10 ** Math.floor(Math.log10(low) + 1e-9);
  return { low: floor10, high: Math.max(10 * floor10, 10 ** Math.ceil(Math.log10(Math.min(high, cap)) - 1e-9)) };
}

function dataset(s, limits) {
  const { colour, shape, dashed } = look(s.solver);
  const clamped = (value, { low, high }) => Math.min(high, Math.max(low, value));
  const points = s.points.map((p) => ({ ...p,
    x: p.edge === "x" ? limits.x.high : clamped(p.x, limits.x), y: clamped(p.y, limits.y) }));
  return {
    label: s.name || s.solver, solver: s.solver, data: points, showLine: true, colour, clip: 8,
    borderColor: colour, borderWidth: 1.6, borderDash: s.dashed ?? dashed ? [5, 3] : [], tension: 0,
    pointStyle: points.map((p) => (p.edge ? "crossRot" : { circle: "circle", square: "rect", diamond: "rectRot",
      up: "triangle", down: "triangle", left: "triangle" }[shape])),
    rotation: { down: 180, left: -90 }[shape] || 0,
    pointRadius: points.map((p) => (p.quiet ? 0 : p.edge ? 5 : shape === "circle" || shape === "square" ? 3.2 : 4)),
    pointHitRadius: 8, pointHoverRadius: 6, pointBorderWidth: 1.4,
    pointBackgroundColor: points.map((p) => (p.hollow ? css("--card") : colour)),
    segment: { borderColor: (c) => (points[c.p0DataIndex]?.loose || points[c.p1DataIndex]?.loose ? "transparent" : undefined) },
  };
}

function chart_options(figure, limits) {
  const ink = css("--soft"), line = css("--line");
  const axis = (name) => {
    const { low, high } = limits[name];
    const decades = Math.round(Math.log10(high / low));
    return {
      type: "logarithmic", min: low, max: high,
      title: { display: true, text: figure[name].title, color: ink, font: { size: 13 } },
      grid: { color: line, borderColor: ink, tickLength: 4 },
      ticks: { color: ink, maxRotation: 0, font: { size: 12 }, callback: (value) => power_of_ten(Math.round(Math.log10(value))) },
      afterBuildTicks: (scale) => {
        const room = name === "x" ? Math.max(3, Math.floor(scale.chart.width / 75)) : 9;
        const every = Math.ceil((decades + 1) / room);
        scale.ticks = [];
        for (let k = 0; k <= decades; k += every) scale.ticks.push({ value: low * 10 ** k });
      },
    };
  };
  return {
    animation: false, maintainAspectRatio: false, responsive: true,
    interaction: { mode: "nearest", intersect: true },
    layout: { padding: { top: 8, right: 12 } },
    scales: { x: axis("x"), y: axis("y") },
    plugins: {
      legend: { display: false },
      tooltip: {
        backgroundColor: css("--tip"), titleColor: css("--tip-ink"), bodyColor: css("--tip-ink"), padding: 10,
        displayColors: false, titleFont: { size: 13 }, bodyFont: { size: 12 }, caretSize: 5,
        filter: (item, i) => i < 3,
        callbacks: { title: (items) => items[0]?.dataset.label, label: (item) => item.raw.lines },
      },
    },
  };
}

// Floor band and order guides, behind the data.
function backdrop(figure) {
  return {
    id: "backdrop",
    beforeDatasetsDraw(chart) {
      const { ctx, chartArea: area, scales: { x, y } } = chart;
      ctx.save();
      ctx.beginPath();
      ctx.rect(area.left, area.top, area.width, area.height);
      ctx.clip();
      ctx.font = `11px ${css("--sans")}`;
      if (figure.band && figure.band.to > (figure.band.axis === "x" ? x.min : y.min)) {
        ctx.fillStyle = css("--band");
        const { axis, to, label } = figure.band;
        if (axis === "x") ctx.fillRect(area.left, area.top, x.getPixelForValue(to) - area.left, area.height);
        else ctx.fillRect(area.left, y.getPixelForValue(to), area.width, area.bottom - y.getPixelForValue(to));
        ctx.fillStyle = css("--soft");
        ctx.textAlign = axis === "x" ? "left" : "right";
        ctx.fillText(label, axis === "x" ? area.left + 6 : area.right - 6,
          axis === "x" ? area.bottom - 8 : y.getPixelForValue(to) + 14);
      }
      ctx.strokeStyle = ctx.fillStyle = css("--guide");
      ctx.setLineDash([2, 4]);
      for (const { points: [from, to], label } of figure.guides || []) {
        const a = [x.getPixelForValue(from[0]), y.getPixelForValue(from[1])];
        const b = [x.getPixelForValue(to[0]), y.getPixelForValue(to[1])];
        ctx.beginPath();
        ctx.moveTo(...a);
        ctx.lineTo(...b);
        ctx.stroke();
        const [lx, ly] = inside(a, b, area);
        ctx.textAlign = lx > area.right - 40 ? "right" : "left";
        ctx.fillText(label, lx + (lx > area.right - 40 ? -4 : 5), Math.max(ly, area.top + 12) - 3);
      }
      ctx.restore();
    },
  };
}

// Where a line from a to b leaves the area, seen from a.
function inside(a, b, area) {
  let part = 1;
  const limit = (from, to, low, high) => {
    if (to < low) part = Math.min(part, (low - from) / (to - from));
    if (to > high) part = Math.min(part, (high - from) / (to - from));
  };
  limit(a[0], b[0], area.left, area.right);
  limit(a[1], b[1], area.top, area.bottom);
  return [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])];
}

function walk(chart, event) {
  const steps = { ArrowRight: [0, 1], ArrowLeft: [0, -1], ArrowUp: [1, 0], ArrowDown: [-1, 0] };
  const step = steps[event.key];
  if (!step || chart.data.datasets.length === 0) return;
  event.preventDefault();
  const sets = chart.data.datasets;
  const [at] = chart.getActiveElements();
  let set = at ? at.datasetIndex : 0, index = at ? at.index : -1;
  set = (set + step[0] + sets.length) % sets.length;
  const size = sets[set].data.length;
  if (size === 0) return;
  index = step[0] ? Math.min(Math.max(index, 0), size - 1) : (index + step[1] + size) % size;
  chart.setActiveElements([{ datasetIndex: set, index }]);
  chart.tooltip.setActiveElements([{ datasetIndex: set, index }], { x: 0, y: 0 });
  chart.update("none");
}

// Names with marks; the one under the pointer or the focus stands out of the others.
function legend(holder, figure) {
  const emphasise = (solver) => {
    for (const set of holder.chart?.data.datasets || []) {
      const faint = solver && set.solver !== solver;
      set.borderColor = faint ? set.colour + "22" : set.colour;
      set.pointBorderColor = faint ? set.colour + "22" : set.colour;
      set.borderWidth = solver && !faint ? 2.6 : 1.6;
      set.order = faint ? 1 : 0;
    }
    holder.chart?.update("none");
  };
  const entry = (s) => el("li", { tabindex: "0", on_mouseenter: () => emphasise(s.solver), on_mouseleave: () => emphasise(null),
    on_focus: () => emphasise(s.solver), on_blur: () => emphasise(null) }, glyph(s.solver), code(s.name || s.solver));
  return el("ul", { class: "legend-list", "aria-label": "Solvers in the chart" }, figure.series.filter((s) => !s.dashed).map(entry));
}
