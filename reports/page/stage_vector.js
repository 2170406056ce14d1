// The stage without WebGL: the same items, projected and drawn on a plain canvas, far ones first.

function vector_renderer(canvas, panels) {
  const ctx = canvas.getContext("2d");
  return {
    draw(width, height, rects, view) {
      const dpr = Math.min(2, devicePixelRatio);
      canvas.width = width * dpr;
      canvas.height = height * dpr;
      canvas.style.width = `${width}px`;
      canvas.style.height = `${height}px`;
      const axes = camera_axes(view);
      rects.forEach((rect, i) => {
        const size = (view.zoom * Math.min(rect.width, rect.height)) / (2 * view.reach);
        ctx.setTransform(dpr, 0, 0, dpr, (rect.left + rect.width / 2) * dpr, (rect.top + rect.height / 2) * dpr);
        ctx.save();
        ctx.beginPath();
        ctx.rect(-rect.width / 2, -rect.height / 2, rect.width, rect.height);
        ctx.clip();
        const project = (p) => [size * dot(p, axes.right), -size * dot(p, axes.up), dot(p, axes.eye)];
        const strokes = panels[i].items.flatMap((item) => vector_strokes(item, project, axes));
        strokes.sort((a, b) => a.depth - b.depth);
        for (const stroke of strokes) stroke.draw(ctx);
        ctx.restore();
      });
    },
    dispose() {},
  };
}

// What an item is made of: pieces with a depth, so that near ones cover far ones.
function vector_strokes(item, project, axes) {
  if (item.kind === "line") return vector_line(item, project);
  if (item.kind === "body") return vector_body(item, project);
  if (item.kind === "dot") {
    const [x, y, depth] = project(item.at.point);
    return [{ depth: depth + 0.05, draw: (ctx) => {
      ctx.fillStyle = item.colour;
      ctx.beginPath();
      ctx.arc(x, y, 5, 0, 2 * Math.PI);
      ctx.fill();
    } }];
  }
  return [{ depth: -10, draw: (ctx) => {
    // The outline of an ellipsoid with axes along x, y, z is an ellipse; sampled, it needs no algebra of its own.
    ctx.beginPath();
    for (let k = 0; k <= 90; ++k) {
      const a = (2 * Math.PI * k) / 90;
      const along = [0, 1, 2].map((i) => Math.cos(a) * axes.right[i] + Math.sin(a) * axes.up[i]);
      // The farthest point in a direction of the picture.
      const reach = Math.hypot(...along.map((c, i) => c * item.radii[i]));
      const [x, y] = project(along.map((c, i) => (c * item.radii[i] ** 2) / reach));
      ctx.lineTo(x, y);
    }
    ctx.globalAlpha = item.opacity * 0.8;
    ctx.fillStyle = ctx.strokeStyle = item.colour;
    ctx.fill();
    ctx.globalAlpha = Math.min(1, 4 * item.opacity);
    ctx.stroke();
    ctx.globalAlpha = 1;
  } }];
}

function vector_line({ points, colour, width = 1, dashed, opacity = 1 }, project) {
  const seen = points.map(project);
  return seen.slice(1).map((b, i) => {
    const a = seen[i], depth = (a[2] + b[2]) / 2;
    return { depth, draw: (ctx) => {
      ctx.globalAlpha = opacity * (depth < 0 ? 0.45 : 1);
      ctx.strokeStyle = colour;
      ctx.lineWidth = width > 1 ? 0.8 * width : width;
      ctx.setLineDash(dashed ? [4, 3] : []);
      ctx.beginPath();
      ctx.moveTo(a[0], a[1]);
      ctx.lineTo(b[0], b[1]);
      ctx.stroke();
      ctx.setLineDash([]);
      ctx.globalAlpha = 1;
    } };
  });
}

function vector_body({ sides, colour, ghost, pose }, project) {
  const corners = box_corners(sides).map((corner) => project(rotated(pose.q, corner)));
  if (ghost)
    return [{ depth: 10, draw: (ctx) => {
      ctx.strokeStyle = colour;
      ctx.lineWidth = 1;
      ctx.beginPath();
      for (const [a, b] of box_edges) {
        ctx.moveTo(corners[a][0], corners[a][1]);
        ctx.lineTo(corners[b][0], corners[b][1]);
      }
      ctx.stroke();
    } }];
  return box_faces.map((face, k) => ({ depth: face.reduce((sum, i) => sum + corners[i][2] / 4, 0), draw: (ctx) => {
    ctx.fillStyle = mixed(colour, css("--card-hex"), face_tints[k]);
    ctx.strokeStyle = mixed(colour, "#000000", 0.25);
    ctx.lineWidth = 1;
    ctx.beginPath();
    for (const i of face) ctx.lineTo(corners[i][0], corners[i][1]);
    ctx.closePath();
    ctx.fill();
    ctx.stroke();
  } }));
}
