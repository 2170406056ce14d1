// A stage shows bodies and curves in space: a grid of panels that share a camera, drawn by WebGL where there is any and
// as vectors on a plain canvas elsewhere. Dragging or the arrow keys turn the view, + and - make it larger.
//
// An item of a panel is one of
//   {kind: "line", points, colour, width?, dashed?, opacity?}
//   {kind: "body", sides, colour, ghost?, pose: {q}}   a box with half sides, its pose may change between drawings
//   {kind: "ball", radii, colour, opacity}             an ellipsoid
//   {kind: "dot", at: {point}, colour}

class Stage {
  // panels: [{caption: element, items}]; height in CSS pixels of each
  constructor(holder, panels, { height, label, reach = 1.12, azimuth = 0.6, elevation = 0.38 }) {
    this.panels = panels;
    this.camera = { azimuth, elevation, zoom: 1, reach };
    this.views = panels.map(() => el("div", { class: "view", style: `height: ${height}px` }));
    this.canvas = el("canvas", { "aria-hidden": "true" });
    this.grid = el("div", { class: "stage", tabindex: "0", role: "application",
      "aria-label": `${label}. Arrow keys turn the view, plus and minus make it larger or smaller.` }, this.canvas,
      panels.map((panel, i) => el("div", { class: "panel" }, panel.caption, this.views[i])));
    holder.replaceChildren(this.grid);
    this.renderer = webgl_renderer(this.canvas, panels) || vector_renderer(this.canvas, panels);
    this.listen();
    new ResizeObserver(() => this.draw()).observe(this.grid);
  }
  listen() {
    let from = null;
    this.grid.addEventListener("pointerdown", (event) => {
      if (!event.target.classList.contains("view")) return;
      from = event;
      event.target.setPointerCapture(event.pointerId);
    });
    this.grid.addEventListener("pointermove", (event) => {
      if (!from) return;
      this.turn((event.clientX - from.clientX) * -0.01, event.pointerType === "touch" ? 0 : (event.clientY - from.clientY) * 0.01);
      from = event;
    });
    for (const end of ["pointerup", "pointercancel"]) this.grid.addEventListener(end, () => { from = null; });
    const keys = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    this.grid.addEventListener("keydown", (event) => {
      if (keys[event.key]) this.turn(...keys[event.key]);
      else if (event.key === "+" || event.key === "-") this.camera.zoom *= event.key === "+" ? 1.1 : 1 / 1.1;
      else return;
      event.preventDefault();
      this.draw();
    });
  }
  turn(azimuth, elevation) {
    this.camera.azimuth += azimuth;
    this.camera.elevation = Math.min(1.5, Math.max(-1.5, this.camera.elevation + elevation));
    this.draw();
  }
  draw() {
    const outer = this.grid.getBoundingClientRect();
    if (outer.width === 0) return;
    const rects = this.views.map((view) => {
      const box = view.getBoundingClientRect();
      return { left: box.left - outer.left - this.grid.clientLeft, top: box.top - outer.top - this.grid.clientTop,
        width: box.width, height: box.height };
    });
    this.renderer.draw(this.grid.clientWidth, this.grid.clientHeight, rects, this.camera);
  }
  dispose() { this.renderer.dispose(); }
}

// Right, up and towards the eye, in space; z is up.
function camera_axes({ azimuth, elevation }) {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  return { right: [-sa, ca, 0], up: [-ca * se, -sa * se, ce], eye: [ca * ce, sa * ce, se] };
}

// Corners and faces of a box; corner k has signs of the bits of k.
const box_corners = (sides) => Array.from({ length: 8 }, (_, k) => sides.map((side, i) => (k >> i & 1 ? side : -side)));
const box_faces = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]]; // -x +x -y +y -z +z
const box_edges = [[0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [0, 4], [1, 5], [2, 6], [3, 7]];
// How much of the paper's colour a face takes: opposite faces differ, so that a turn by half is seen.
const face_tints = [0.72, 0, 0.6, 0.16, 0.8, 0.3];

function mixed(colour, other, part) {
  const channels = (c) => [1, 3, 5].map((i) => parseInt(c.slice(i, i + 2), 16));
  const a = channels(colour), b = channels(other);
  return "#" + a.map((c, i) => Math.round(c + (b[i] - c) * part).toString(16).padStart(2, "0")).join("");
}
