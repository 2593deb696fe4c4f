// What was believed: lines over time under the force, and bars for the moment.
"use strict";

const nameColor = (theme, k) => theme.names[k % theme.names.length];

function beliefAt({ belief, frames }, moment) {
  const ended = moment >= frames.count - 1; // the last touch is told after the last frame that is shown
  const now = ended ? Infinity : frames.times[moment] - frames.times[0];
  let step = -1;
  while (step < belief.times.length - 1 && belief.times[step + 1] <= now + 1e-6) step++;
  return step;
}

function drawBelief(canvas, data, moment, theme) {
  const { belief, frames } = data, [context, w, h] = sized(canvas), top = 12, base = h - 4;
  const span = frames.count ? frames.times[frames.count - 1] - frames.times[0] : belief.times[belief.times.length - 1];
  const x = (t) => (Math.min(t, span) / (span || 1)) * w, y = (share) => base - share * (base - top);
  context.font = `11px ${getComputedStyle(document.body).fontFamily}`;
  context.lineWidth = 1;
  for (const level of [0, 0.5, 1]) {
    context.strokeStyle = css(theme.ink, level ? 0.1 : 0.35);
    context.beginPath();
    context.moveTo(0, Math.round(y(level)) + 0.5);
    context.lineTo(w, Math.round(y(level)) + 0.5);
    context.stroke();
    context.fillStyle = css(theme.ink, 0.7);
    if (level) context.fillText(`${100 * level} %`, 2, y(level) - 3);
  }
  for (let k = belief.names.length - 1; k >= 0; k--) {
    context.beginPath();
    let before = 0;
    context.moveTo(x(belief.times[0]), y(0));
    belief.times.forEach((t, i) => {
      context.lineTo(x(t), y(before));
      before = belief.shares[i][k];
      context.lineTo(x(t), y(before));
    });
    context.lineTo(w, y(before));
    context.strokeStyle = css(nameColor(theme, k));
    context.lineWidth = k ? 1.5 : 2.25;
    context.setLineDash(k < theme.names.length / 2 ? [] : [5, 3]);
    context.lineJoin = "round";
    context.stroke();
  }
  context.setLineDash([]);
  if (!frames.count) return;
  const now = x(frames.times[moment] - frames.times[0]);
  context.strokeStyle = css(theme.now);
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(now, 0);
  context.lineTo(now, base);
  context.stroke();
}

function showBelief(list, data, moment, theme) {
  const { belief } = data, step = beliefAt(data, moment);
  list.replaceChildren(...belief.names.map((name, k) => {
    const item = document.createElement("li"), share = step < 0 ? 0 : belief.shares[step][k];
    const label = document.createElement("span"), value = document.createElement("span"), bar = document.createElement("i");
    label.textContent = name;
    value.textContent = step < 0 ? "–" : share > 0 && share < 0.005 ? "< 1 %" : `${Math.round(100 * share)} %`;
    bar.style.background = css(nameColor(theme, k));
    bar.style.width = `${100 * share}%`;
    item.append(label, value, bar);
    return item;
  }));
  document.getElementById("felt").textContent = step < 0 ? "nothing felt yet"
    : `touch ${belief.touches[step]}: ${belief.felt[step]}`;
}
