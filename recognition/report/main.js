// Ties slider, view and panels together.
"use strict";

// Without the sign of a zero that is only rounded to.
function plain(value, digits) {
  return value.toFixed(digits).replace(/^-(?=[0.]*$)/, "");
}

function start() {
  const element = (id) => document.getElementById(id);
  let data = unpack(JSON.parse(element("data").textContent)), { frames } = data;
  const slider = element("moment"), play = element("play"), speed = element("speed");
  let theme = makeTheme(data), moment = 0, playing = 0;
  const scene = new Scene(element("view"), data, theme, drawCompass);
  if (!scene.gl) element("no-webgl").hidden = false;

  function show(index) {
    if (!frames.count) return;
    moment = Math.max(0, Math.min(frames.count - 1, Math.round(index)));
    slider.value = moment;
    scene.showMoment(moment);
    drawTaxels(element("taxels"), data, moment, theme);
    drawForce(element("force"), data, moment, theme);
    const pose = scene.padPose(), touch = frames.touch[moment];
    element("now-time").textContent = (frames.times[moment] - frames.times[0]).toFixed(2);
    element("now-force").textContent = plain(frames.forces[moment], 2);
    element("now-touch").textContent = touch < 0 ? "–" : touch + 1;
    element("now-pad").textContent = [12, 13, 14].map((i) => plain(pose[i], 1)).join(", ");
    if (data.belief) {
      drawBelief(element("beliefs"), data, moment, theme);
      showBelief(element("names"), data, moment, theme);
    }
    slider.setAttribute("aria-valuetext", `${(frames.times[moment] - frames.times[0]).toFixed(2)} seconds`);
  }

  function measure() {
    for (const place of document.querySelectorAll("[data-belief]")) place.hidden = !data.belief;
    for (const place of document.querySelectorAll("[data-frames]")) place.hidden = !frames.count;
    slider.max = Math.max(0, frames.count - 1);
    for (const id of ["moment", "play", "speed"]) element(id).disabled = !frames.count;
  }

  // A run that goes on has felt more; whoever looks at its last moment goes on with it.
  function adopt(next) {
    const follows = !playing && moment >= frames.count - 1;
    [data, frames] = [next, next.frames];
    scene.data = data;
    if (!scene.moved) scene.home();
    measure();
    theme = makeTheme(data);
    scene.build(theme);
    show(follows ? frames.count - 1 : moment);
  }

  // The key of the colors goes with what is colored.
  function shownLayers() {
    const ramp = element("off-ramp");
    if (ramp) ramp.hidden = !(scene.shown.off && scene.shown.model);
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
  for (const box of document.querySelectorAll("[data-layer]")) {
    scene.shown[box.dataset.layer] = box.checked;
    box.addEventListener("change", () => { scene.shown[box.dataset.layer] = box.checked; shownLayers(); scene.draw(); });
  }
  shownLayers();
  element("home").addEventListener("click", () => { scene.home(); scene.draw(); });
  markFacesOnHover(scene);
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
  measure();
  show(Math.max(0, frames.touch.findLastIndex((touch) => touch >= 0)));
  scene.render();
  window.palpate = { scene, show, data, adopt };
  document.documentElement.dataset.ready = "yes";
}

start();
