// Unpacks the data, builds the theme, and ties slider, view and panels together.
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
    heat: (t) => {
      const k = Math.min(3.999, Math.max(0, t * 4)), i = Math.floor(k);
      return towards(ramp[i], ramp[i + 1], k - i);
    },
  };
}

function start() {
  const element = (id) => document.getElementById(id);
  const data = unpack(JSON.parse(element("data").textContent)), { frames } = data;
  const slider = element("moment"), play = element("play"), speed = element("speed");
  let theme = makeTheme(data), moment = 0, playing = 0;
  const scene = new Scene(element("view"), data, theme, drawCompass);
  if (!scene.gl) element("no-webgl").hidden = false;

  function drawCompass({ right, up, millimetersPerPixel }) {
    ["x", "y", "z"].forEach((name, i) => {
      const [x, y] = [26 * right[i], -26 * up[i]], group = element("axis-" + name);
      group.firstElementChild.setAttribute("x2", x);
      group.firstElementChild.setAttribute("y2", y);
      group.lastElementChild.setAttribute("x", x * 1.3);
      group.lastElementChild.setAttribute("y", y * 1.3 + 3.5);
    });
    const length = niceCeiling(millimetersPerPixel * 60);
    element("scale").style.width = `${length / millimetersPerPixel}px`;
    element("scale").textContent = `${+length.toPrecision(2)} mm`;
  }

  function show(index) {
    if (!frames.count) return;
    moment = Math.max(0, Math.min(frames.count - 1, Math.round(index)));
    slider.value = moment;
    scene.showMoment(moment);
    drawTaxels(element("taxels"), data, moment, theme);
    drawForce(element("force"), data, moment, theme);
    const pose = scene.padPose(), touch = frames.touch[moment];
    element("now-time").textContent = (frames.times[moment] - frames.times[0]).toFixed(2);
    element("now-force").textContent = frames.forces[moment].toFixed(2);
    element("now-touch").textContent = touch < 0 ? "–" : touch + 1;
    element("now-pad").textContent = [12, 13, 14].map((i) => pose[i].toFixed(1)).join(", ");
    slider.setAttribute("aria-valuetext", `${(frames.times[moment] - frames.times[0]).toFixed(2)} seconds`);
  }

  function setPlaying(on) {
    cancelAnimationFrame(playing);
    playing = 0;
    play.textContent = on ? "Pause" : "Play";
    play.setAttribute("aria-pressed", on);
    if (!on) return;
    if (moment >= frames.count - 1) show(0);
    let last = performance.now(), clock = frames.times[moment];
    const tick = (now) => {
      clock += ((now - last) / 1000) * speed.value;
      last = now;
      let next = moment;
      while (next < frames.count - 1 && frames.times[next + 1] <= clock) next++;
      if (next !== moment) show(next);
      if (next >= frames.count - 1) setPlaying(false); else playing = requestAnimationFrame(tick);
    };
    playing = requestAnimationFrame(tick);
  }

  slider.max = Math.max(0, frames.count - 1);
  slider.addEventListener("input", () => { setPlaying(false); show(+slider.value); });
  play.addEventListener("click", () => setPlaying(!playing));
  const force = element("force"), scrub = (e) => {
    const t = frames.times[0] + (e.offsetX / force.clientWidth) * (frames.times[frames.count - 1] - frames.times[0]);
    setPlaying(false);
    let low = 0;
    while (low < frames.count - 1 && frames.times[low] < t) low++;
    show(low);
  };
  force.addEventListener("pointerdown", (e) => { force.setPointerCapture(e.pointerId); scrub(e); });
  force.addEventListener("pointermove", (e) => { if (e.buttons) scrub(e); });
  for (const box of document.querySelectorAll("[data-layer]"))
    box.addEventListener("change", () => { scene.shown[box.dataset.layer] = box.checked; scene.draw(); });
  element("home").addEventListener("click", () => { scene.home(); scene.draw(); });
  for (const row of document.querySelectorAll("tr[data-face]")) {
    const mark = (id) => () => { scene.marked = id; scene.draw(); };
    for (const on of ["mouseenter", "focus"]) row.addEventListener(on, mark(+row.dataset.face));
    for (const off of ["mouseleave", "blur"]) row.addEventListener(off, mark(-1));
  }
  document.addEventListener("keydown", (e) => {
    if (e.key === " " && !["BUTTON", "INPUT", "SELECT"].includes(e.target.tagName)) {
      e.preventDefault();
      setPlaying(!playing);
    }
  });

  const redraw = () => { theme = makeTheme(data); scene.build(theme); show(moment); };
  const repaint = () => { redraw(); scene.render(); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("resize", () => show(moment));
  addEventListener("beforeprint", () => { document.documentElement.classList.add("printing"); repaint(); });
  addEventListener("afterprint", () => { document.documentElement.classList.remove("printing"); repaint(); });

  const seconds = frames.count ? frames.times[frames.count - 1] - frames.times[0] : 0;
  speed.value = [1, 2, 5, 10, 20].find((x) => seconds / x <= 40) || 20;
  if (!frames.count) for (const id of ["moment", "play", "speed"]) element(id).disabled = true;
  show(Math.round(frames.count * 0.4));
  scene.render();
  window.palpate = { scene, show, data };
  document.documentElement.dataset.ready = "yes";
}

start();
