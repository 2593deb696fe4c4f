// What every page shares: unpacking its data, the colors of its theme, the compass, faces marked under the pointer.
"use strict";

const TYPES = { f4: Float32Array, u1: Uint8Array, i4: Int32Array };

function unpack(value) {
  if (value && value.base64 !== undefined) {
    const text = atob(value.base64), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return new TYPES[value.type](bytes.buffer);
  }
  if (Array.isArray(value)) return value;
  if (value && typeof value === "object")
    return Object.fromEntries(Object.entries(value).map(([key, item]) => [key, unpack(item)]));
  return value;
}

function makeTheme(data) {
  const style = getComputedStyle(document.documentElement);
  const read = (name) => {
    const hex = style.getPropertyValue("--" + name).trim().slice(1);
    return [0, 2, 4].map((i) => parseInt(hex.slice(i, i + 2), 16) / 255);
  };
  const dark = read("paper")[0] < 0.5, ramp = [0, 1, 2, 3, 4].map((i) => read("heat-" + i));
  const [under, over, even] = [read("off-under"), read("off-over"), read("off-0")];
  const shapes = Object.fromEntries(["plane", "cylinder", "cone", "sphere", "torus", "freeform"].map((s) => [s, read(s)]));
  const towards = (a, b, t) => a.map((x, i) => x + (b[i] - x) * t);
  const face = (id) => {
    const base = shapes[data.shapes[id]] || shapes.freeform, shift = (((id * 0.618) % 1) - 0.5) * 0.22;
    return towards(base, shift > 0 ? [1, 1, 1] : [0, 0, 0], Math.abs(shift));
  };
  return {
    ink: read("ink"), accent: read("accent"), now: read("now"), housing: read("housing"), ghost: read("ghost"),
    edge: [...read("edge"), 0.85], truthEdge: [...read("ghost"), 0.8], housingEdge: [...read("housing"), 0.9],
    trace: [...read("trace"), 1],
    pointSize: Math.max(2.6, Math.min(6, 130 / Math.sqrt(data.contacts.face.length + 1))), face,
    contact: (id) => towards(face(id), dark ? [1, 1, 1] : [0.05, 0.06, 0.08], 0.42),
    names: [0, 1, 2, 3, 4, 5].map((i) => read("name-" + i)),
    off: (t) => towards(even, t < 0 ? under : over, Math.min(1, Math.abs(t))),
    heat: (t) => {
      const k = Math.min(3.999, Math.max(0, t * 4)), i = Math.floor(k);
      return towards(ramp[i], ramp[i + 1], k - i);
    },
  };
}

function drawCompass({ right, up, millimetersPerPixel }) {
  ["x", "y", "z"].forEach((name, i) => {
    const [x, y] = [26 * right[i], -26 * up[i]], group = document.getElementById("axis-" + name);
    group.firstElementChild.setAttribute("x2", x);
    group.firstElementChild.setAttribute("y2", y);
    group.lastElementChild.setAttribute("x", x * 1.3);
    group.lastElementChild.setAttribute("y", y * 1.3 + 3.5);
  });
  const length = niceCeiling(millimetersPerPixel * 60);
  const scale = document.getElementById("scale");
  scale.style.width = `${length / millimetersPerPixel}px`;
  scale.textContent = `${+length.toPrecision(2)} mm`;
}

function markFacesOnHover(scene) {
  for (const place of document.querySelectorAll("[data-face]")) {
    const mark = (id) => () => {
      scene.marked = id;
      for (const other of document.querySelectorAll("[data-face]"))
        other.classList.toggle("marked", +other.dataset.face === id);
      scene.draw();
    };
    for (const on of ["mouseenter", "focus"]) place.addEventListener(on, mark(+place.dataset.face));
    for (const off of ["mouseleave", "blur"]) place.addEventListener(off, mark(-1));
  }
}
