// The 3-D view: an orbiting camera, the layers that can be shown, and the pad at the chosen moment.
"use strict";

const FIELD_OF_VIEW = 0.5;

class Scene {
  constructor(canvas, data, theme, onMove) {
    this.canvas = canvas; this.data = data; this.onMove = onMove;
    this.shown = { model: true, off: false, truth: false, contacts: true, traces: true, pad: true };
    this.marked = -1; this.moment = 0;
    this.gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    this.home();
    this.listen();
    if (!this.gl) return;
    this.mesh = new Program(this.gl, MESH);
    this.line = new Program(this.gl, LINE);
    this.point = new Program(this.gl, POINT);
    this.build(theme);
  }

  build(theme) {
    this.theme = theme;
    if (!this.gl) return;
    const d = this.data, faceColor = (face) => theme.face(face);
    this.layers = {
      model: d.model && this.mesh.table(...meshColumns(d.model, faceColor)),
      modelEdges: d.model && this.line.table(...segmentColumns(d.model.edges)),
      truth: d.truth && this.mesh.table(...meshColumns(d.truth, () => theme.ghost)),
      truthEdges: d.truth && this.line.table(...segmentColumns(d.truth.edges)),
      contacts: this.point.table({
        position: [d.contacts.points, 3],
        color: [colorRows(d.contacts.face, (face) => theme.contact(face)), 3],
      }, d.contacts.face.length),
      off: d.off && this.mesh.table(...offColumns(d.off, theme)),
      traces: this.line.table(...segmentColumns(d.traces.segments)),
      ...this.padTables(),
    };
    this.draw();
  }

  padTables() {
    const { pad, housing, frames } = this.data, [hx, hy] = [housing[0] / 2, housing[1] / 2];
    const [top, bottom] = [-0.02 * housing[2], -housing[2]], c = [];
    for (const z of [bottom, top]) for (const [x, y] of [[-hx, -hy], [hx, -hy], [hx, hy], [-hx, hy]]) c.push([x, y, z]);
    const quads = [[0, 1, 2, 3], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    const box = quads.flatMap(([i, j, k, l]) => [i, j, k, i, k, l]).flatMap((i) => c[i]);
    const rim = [0, 1, 2, 3, 4, 5, 6, 7].flatMap((i) => {
      const next = i % 4 === 3 ? i - 3 : i + 1;
      return i < 4 ? [c[i], c[next], c[i], c[i + 4]] : [c[i], c[next]];
    }).flat();
    const [, rows, columns] = frames.shape, skin = [];
    const dx = pad[0] / columns, dy = pad[1] / rows;
    for (let r = 0; r < rows; r++) for (let q = 0; q < columns; q++) {
      const x = -pad[0] / 2 + (q + 0.04) * dx, y = -pad[1] / 2 + (r + 0.04) * dy, X = x + 0.92 * dx, Y = y + 0.92 * dy;
      skin.push(x, y, 0, X, y, 0, X, Y, 0, x, y, 0, X, Y, 0, x, Y, 0);
    }
    const plain = (values) => {
      const n = values.length / 3;
      return [{ position: [new Float32Array(values), 3], normal: [new Float32Array(n * 3).fill(0.577), 3],
        color: [colorRows(new Float32Array(n), () => this.theme.housing), 3], face: [new Float32Array(n).fill(-9), 1] }, n];
    };
    return {
      housing: this.mesh.table(...plain(box)),
      housingRim: this.line.table(...segmentColumns(new Float32Array(rim))),
      skin: this.mesh.table(...plain(skin)),
    };
  }

  showMoment(index) {
    this.moment = index;
    const { frames } = this.data, gl = this.gl;
    if (gl && frames.count) {
      const [, rows, columns] = frames.shape, colors = new Float32Array(rows * columns * 18);
      for (let i = 0; i < rows * columns; i++) {
        const rgb = this.theme.heat(frames.counts[index * rows * columns + i] / 255);
        for (let k = 0; k < 6; k++) colors.set(rgb, i * 18 + k * 3);
      }
      gl.bindBuffer(gl.ARRAY_BUFFER, this.layers.skin.buffers.color);
      gl.bufferSubData(gl.ARRAY_BUFFER, 0, colors);
    }
    this.draw();
  }

  // How many of a layer's things, which are in order of time, are felt by now.
  felt(from, table, vertices) {
    if (!this.data.frames.count) return table.count / vertices;
    let low = 0, high = from.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (from[middle] <= this.moment) low = middle + 1; else high = middle;
    }
    return low;
  }

  padPose() {
    return this.data.frames.poses.subarray(this.moment * 16, this.moment * 16 + 16);
  }

  home() {
    this.moved = false;
    const { center, radius } = this.data.bounds, { clientWidth, clientHeight } = this.canvas;
    const narrow = Math.min(1, clientWidth / clientHeight || 1);
    this.camera = { yaw: -0.9, pitch: 0.45, distance: (radius * 1.22) / Math.sin(FIELD_OF_VIEW / 2) / narrow, target: [...center] };
  }

  orbit(dx, dy) {
    this.moved = true;
    this.camera.yaw -= dx;
    this.camera.pitch = Math.max(-1.55, Math.min(1.55, this.camera.pitch + dy));
    this.draw();
  }

  zoom(factor) {
    this.moved = true;
    const { radius } = this.data.bounds;
    this.camera.distance = Math.max(radius * 0.5, Math.min(radius * 60, this.camera.distance * factor));
    this.draw();
  }

  pan(dx, dy) {
    this.moved = true;
    const { right, up } = this.axes(), scale = (2 * this.camera.distance * Math.tan(FIELD_OF_VIEW / 2)) / this.canvas.clientHeight;
    for (let i = 0; i < 3; i++) this.camera.target[i] += (up[i] * dy - right[i] * dx) * scale;
    this.draw();
  }

  axes() {
    const { yaw, pitch } = this.camera, [s, c, t, u] = [Math.sin(yaw), Math.cos(yaw), Math.sin(pitch), Math.cos(pitch)];
    return { back: [u * c, u * s, t], right: [-s, c, 0], up: [-t * c, -t * s, u] };
  }

  draw() {
    if (!this.pending) this.pending = requestAnimationFrame(() => { this.pending = 0; this.render(); });
  }

  render() {
    this.pending = 0;
    const { canvas, gl, camera, shown, layers, theme } = this, { radius } = this.data.bounds;
    const { back, right, up } = this.axes();
    this.onMove({ right, up, millimetersPerPixel: (2 * camera.distance * Math.tan(FIELD_OF_VIEW / 2)) / canvas.clientHeight });
    if (!gl) return;
    const ratio = window.devicePixelRatio || 1, view = [canvas.clientWidth * ratio, canvas.clientHeight * ratio].map(Math.round);
    if (canvas.width !== view[0] || canvas.height !== view[1]) [canvas.width, canvas.height] = view;
    const eye = back.map((b, i) => camera.target[i] + b * camera.distance);
    const dot = (a) => -(a[0] * eye[0] + a[1] * eye[1] + a[2] * eye[2]);
    const look = new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
      dot(right), dot(up), dot(back), 1]);
    const around = (this.data.frames.count ? 12 : 1.5) * radius;
    const near = Math.max(camera.distance - around, camera.distance / 50);
    const clip = multiply(perspective(FIELD_OF_VIEW, view[0] / view[1], near, camera.distance + around + 2 * radius), look);
    gl.viewport(0, 0, ...view);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    const common = { clip, place: IDENTITY, eye, marked: this.marked, lit: 1 };
    const stroke = (table, ink, width, place = IDENTITY, count = undefined) =>
      this.line.draw(table, gl.TRIANGLES, { clip, place, view, width: width * ratio, ink }, count);
    if (shown.model) {
      gl.enable(gl.POLYGON_OFFSET_FILL);
      gl.polygonOffset(1, 1);
      this.mesh.draw(shown.off ? layers.off : layers.model, gl.TRIANGLES, { ...common, alpha: 1 });
      gl.disable(gl.POLYGON_OFFSET_FILL);
      stroke(layers.modelEdges, theme.edge, 1.6);
    }
    if (shown.traces) stroke(layers.traces, theme.trace, 2.6, IDENTITY, 6 * this.felt(this.data.traces.from, layers.traces, 6));
    if (shown.contacts)
      this.point.draw(layers.contacts, gl.POINTS, { clip, size: theme.pointSize * ratio },
        this.felt(this.data.contacts.from, layers.contacts, 1));
    if (shown.pad && this.data.frames.count) {
      this.mesh.draw(layers.skin, gl.TRIANGLES, { ...common, place: this.padPose(), alpha: 1, lit: 0 });
      stroke(layers.housingRim, theme.housingEdge, 1.2, this.padPose());
      gl.depthMask(false);
      this.mesh.draw(layers.housing, gl.TRIANGLES, { ...common, place: this.padPose(), alpha: 0.16, lit: 0 });
      gl.depthMask(true);
    }
    if (shown.truth) {
      gl.depthMask(false);
      this.mesh.draw(layers.truth, gl.TRIANGLES, { ...common, marked: -1, alpha: 0.22 });
      gl.depthMask(true);
      stroke(layers.truthEdges, theme.truthEdge, 1.2);
    }
  }

  listen() {
    const { canvas } = this, fingers = new Map();
    canvas.addEventListener("pointerdown", (e) => {
      canvas.focus({ preventScroll: true });
      canvas.setPointerCapture(e.pointerId);
      fingers.set(e.pointerId, [e.clientX, e.clientY]);
    });
    for (const gone of ["pointerup", "pointercancel"]) canvas.addEventListener(gone, (e) => fingers.delete(e.pointerId));
    canvas.addEventListener("pointermove", (e) => {
      const last = fingers.get(e.pointerId);
      if (!last) return;
      const [dx, dy] = [e.clientX - last[0], e.clientY - last[1]];
      if (fingers.size === 2) {
        const still = [...fingers].find(([id]) => id !== e.pointerId)[1];
        const span = (p) => Math.hypot(p[0] - still[0], p[1] - still[1]) || 1;
        this.zoom(span(last) / span([e.clientX, e.clientY]));
        this.pan(dx / 2, dy / 2);
      } else if (e.shiftKey || e.buttons & 6) this.pan(dx, dy);
      else this.orbit(dx * 0.008, dy * 0.008);
      fingers.set(e.pointerId, [e.clientX, e.clientY]);
    });
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("wheel", (e) => {
      if (document.activeElement !== canvas && !e.ctrlKey) return;
      e.preventDefault();
      this.zoom(Math.exp(e.deltaY * 0.0012));
    }, { passive: false });
    canvas.addEventListener("keydown", (e) => {
      const steps = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
      if (e.key in steps) {
        const [x, y] = steps[e.key];
        if (e.shiftKey) this.pan(-30 * x, 30 * y); else this.orbit(-0.1 * x, 0.1 * y);
      } else if (e.key === "+" || e.key === "=") this.zoom(0.85);
      else if (e.key === "-") this.zoom(1 / 0.85);
      else if (e.key === "Home" || e.key === "0") { this.home(); this.draw(); } else return;
      e.preventDefault();
    });
    new ResizeObserver(() => this.draw()).observe(canvas);
  }
}

function colorRows(values, colorOf) {
  const out = new Float32Array(values.length * 3);
  values.forEach((value, i) => out.set(colorOf(value), i * 3));
  return out;
}

// A model's surface in the colors of its distance from the truth.
function offColumns(off, theme) {
  const [columns, count] = meshColumns(off, () => theme.ghost), values = new Float32Array(count);
  off.triangles.forEach((vertex, i) => { values[i] = off.distance[vertex] / off.scale; });
  return [{ ...columns, color: [colorRows(values, theme.off), 3] }, count];
}

// Corners share a normal where they share both vertex and face: smooth within a face, sharp between two.
function meshColumns({ vertices, triangles, face }, colorOf) {
  const n = triangles.length, position = new Float32Array(n * 3), normal = new Float32Array(n * 3);
  const faces = new Float32Array(n), sums = new Map();
  const keyOf = (i) => triangles[i] * 4096 + face[Math.floor(i / 3)] + 1;
  for (let i = 0; i < n; i++) position.set(vertices.subarray(triangles[i] * 3, triangles[i] * 3 + 3), i * 3);
  for (let t = 0; t < n; t += 3) {
    const p = position.subarray(t * 3, t * 3 + 9);
    const [a, b] = [[p[3] - p[0], p[4] - p[1], p[5] - p[2]], [p[6] - p[0], p[7] - p[1], p[8] - p[2]]];
    const cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    for (let i = t; i < t + 3; i++) {
      const sum = sums.get(keyOf(i)) || [0, 0, 0];
      for (let k = 0; k < 3; k++) sum[k] += cross[k];
      sums.set(keyOf(i), sum);
    }
  }
  for (let i = 0; i < n; i++) {
    normal.set(sums.get(keyOf(i)), i * 3);
    faces[i] = face[Math.floor(i / 3)];
  }
  return [{ position: [position, 3], normal: [normal, 3], face: [faces, 1],
    color: [colorRows(faces, colorOf), 3] }, n];
}
