// The stage by three.js: one canvas, one scene for each panel, drawn into its rectangle.

function webgl_renderer(canvas, panels) {
  if (typeof THREE === "undefined") return null;
  // Asked of another canvas: one that has failed to give WebGL can give nothing else.
  const probe = document.createElement("canvas");
  const found = probe.getContext("webgl");
  if (!found) return null;
  found.getExtension("WEBGL_lose_context")?.loseContext();
  const renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true });
  renderer.setPixelRatio(Math.min(2, devicePixelRatio));
  const moving = [];
  const scenes = panels.map((panel) => {
    const scene = new THREE.Scene();
    for (const item of panel.items) scene.add(webgl_item(item, moving));
    return scene;
  });
  const camera = new THREE.OrthographicCamera(-1, 1, 1, -1, 0.1, 40);
  camera.up.set(0, 0, 1);
  return {
    draw(width, height, rects, view) {
      const size = renderer.getSize(new THREE.Vector2());
      if (size.x !== width || size.y !== height) renderer.setSize(width, height, false);
      for (const move of moving) move();
      camera.position.set(...scaled(camera_axes(view).eye, 10));
      camera.lookAt(0, 0, 0);
      renderer.setScissorTest(true);
      renderer.setClearColor(0, 0);
      rects.forEach((rect, i) => {
        const reach = view.reach / view.zoom / Math.min(rect.width, rect.height);
        camera.left = -(camera.right = rect.width * reach);
        camera.bottom = -(camera.top = rect.height * reach);
        camera.updateProjectionMatrix();
        const at = [rect.left, height - rect.top - rect.height, rect.width, rect.height];
        renderer.setViewport(...at);
        renderer.setScissor(...at);
        renderer.render(scenes[i], camera);
      });
    },
    dispose() { renderer.dispose(); },
  };
}

function webgl_item(item, moving) {
  if (item.kind === "line") return webgl_line(item);
  if (item.kind === "ball") {
    const ball = new THREE.Mesh(new THREE.SphereBufferGeometry(1, 64, 48), new THREE.MeshBasicMaterial({ color: item.colour,
      transparent: true, opacity: item.opacity, depthWrite: false, side: THREE.DoubleSide }));
    ball.scale.set(...item.radii);
    return ball;
  }
  if (item.kind === "dot") {
    const ball = new THREE.Mesh(new THREE.SphereBufferGeometry(0.035, 20, 16), new THREE.MeshBasicMaterial({ color: item.colour }));
    moving.push(() => ball.position.set(...item.at.point));
    return ball;
  }
  const body = webgl_body(item);
  moving.push(() => body.quaternion.set(item.pose.q[1], item.pose.q[2], item.pose.q[3], item.pose.q[0]));
  return body;
}

function webgl_line({ points, colour, width = 1, dashed, opacity = 1 }) {
  const vectors = points.map((p) => new THREE.Vector3(...p));
  const look = { color: colour, transparent: opacity < 1, opacity };
  if (width > 1) {
    const curve = new THREE.CatmullRomCurve3(vectors);
    // WebGL draws lines one pixel wide: wider ones are tubes.
    return new THREE.Mesh(new THREE.TubeBufferGeometry(curve, Math.min(1600, 4 * points.length), 0.0045 * width, 6, false),
      new THREE.MeshBasicMaterial(look));
  }
  const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(vectors), dashed
    ? new THREE.LineDashedMaterial({ ...look, dashSize: 0.04, gapSize: 0.03 }) : new THREE.LineBasicMaterial(look));
  return dashed ? line.computeLineDistances() : line;
}

function webgl_body({ sides, colour, ghost }) {
  const group = new THREE.Group(), corners = box_corners(sides);
  box_faces.forEach((face, k) => {
    if (ghost) return;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(
      new Float32Array([0, 1, 2, 0, 2, 3].flatMap((i) => corners[face[i]])), 3));
    group.add(new THREE.Mesh(geometry, new THREE.MeshBasicMaterial({ side: THREE.DoubleSide,
      color: mixed(colour, css("--card-hex"), face_tints[k]), polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 })));
  });
  const edges = new THREE.BufferGeometry();
  edges.setAttribute("position", new THREE.BufferAttribute(
    new Float32Array(box_edges.flatMap(([a, b]) => [...corners[a], ...corners[b]])), 3));
  group.add(new THREE.LineSegments(edges, new THREE.LineBasicMaterial(ghost
    ? { color: colour, depthTest: false, transparent: true } : { color: mixed(colour, "#000000", 0.25) })));
  return group;
}
