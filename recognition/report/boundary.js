// A boundary's page: the view, its theme, and faces marked alike in view, graph and table.
"use strict";

function start() {
  const data = unpack(JSON.parse(document.getElementById("data").textContent));
  const scene = new Scene(document.getElementById("view"), data, makeTheme(data), drawCompass);
  if (!scene.gl) document.getElementById("no-webgl").hidden = false;
  document.getElementById("home").addEventListener("click", () => { scene.home(); scene.draw(); });
  markFacesOnHover(scene);
  const redraw = () => scene.build(makeTheme(data));
  const repaint = () => { redraw(); scene.render(); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  addEventListener("beforeprint", () => { document.documentElement.classList.add("printing"); repaint(); });
  addEventListener("afterprint", () => { document.documentElement.classList.remove("printing"); repaint(); });
  scene.render();
  window.palpate = { scene, data };
  document.documentElement.dataset.ready = "yes";
}

start();
