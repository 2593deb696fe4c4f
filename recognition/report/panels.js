// The flat panels: the taxel image with its detected lines, and force over time.
"use strict";

function sized(canvas) {
  const ratio = window.devicePixelRatio || 1, [w, h] = [canvas.clientWidth, canvas.clientHeight];
  canvas.width = Math.round(w * ratio);
  canvas.height = Math.round(h * ratio);
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, w, h);
  return [context, w, h];
}

const css = (rgb, alpha = 1) => `rgb(${rgb.slice(0, 3).map((x) => Math.round(255 * x)).join(" ")} / ${alpha})`;

// x to the right and y up, seen from behind the pad's skin as in the sensor's frame.
function drawTaxels(canvas, data, index, theme) {
  const [, rows, columns] = data.frames.shape, [px, py] = data.pad;
  canvas.style.aspectRatio = `${px} / ${py}`;
  const [context, w, h] = sized(canvas), gap = Math.min(1.5, w / columns / 8);
  for (let r = 0; r < rows; r++) for (let c = 0; c < columns; c++) {
    context.fillStyle = css(theme.heat(data.frames.counts[(index * rows + r) * columns + c] / 255));
    context.fillRect((c * w) / columns, ((rows - 1 - r) * h) / rows, w / columns - gap, h / rows - gap);
  }
  context.lineWidth = 2;
  context.strokeStyle = css(theme.now);
  const scale = w / px, reach = Math.hypot(w, h);
  for (const [angle, offset] of linesOf(data, index)) {
    const [dx, dy] = [Math.cos(angle), Math.sin(angle)];
    const [x, y] = [w / 2 - dy * offset * scale, h / 2 - dx * offset * scale];
    context.beginPath();
    context.moveTo(x - dx * reach, y + dy * reach);
    context.lineTo(x + dx * reach, y - dy * reach);
    context.stroke();
  }
}

function linesOf({ frames }, index) {
  const out = [];
  for (let i = frames.lineStart[index]; i < frames.lineStart[index + 1]; i++)
    out.push([frames.lines[2 * i], frames.lines[2 * i + 1]]);
  return out;
}

function drawForce(canvas, data, index, theme) {
  const { times, forces, touch, count } = data.frames, [context, w, h] = sized(canvas);
  if (!count) return;
  const top = niceCeiling(forces.reduce((a, b) => Math.max(a, b), 0.1)), base = h - 18, rise = base - 14;
  const span = times[count - 1] - times[0] || 1;
  const x = (i) => ((times[i] - times[0]) / span) * w, y = (force) => base - (Math.max(force, 0) / top) * rise;
  context.fillStyle = css(theme.ink, 0.045);
  for (let i = 0; i < count;) {
    let j = i;
    while (j < count && touch[j] === touch[i]) j++;
    if (touch[i] >= 0 && touch[i] % 2 === 0) context.fillRect(x(i), 0, Math.max(1, x(Math.min(j, count - 1)) - x(i)), base);
    i = j;
  }
  context.font = `11px ${getComputedStyle(document.body).fontFamily}`;
  context.lineWidth = 1;
  for (const level of [0, top / 2, top]) {
    context.strokeStyle = css(theme.ink, level ? 0.1 : 0.35);
    context.beginPath();
    context.moveTo(0, Math.round(y(level)) + 0.5);
    context.lineTo(w, Math.round(y(level)) + 0.5);
    context.stroke();
    context.fillStyle = css(theme.ink, 0.6);
    if (level) context.fillText(`${+level.toPrecision(3)} N`, 2, y(level) - 3);
  }
  const step = niceCeiling(span / Math.max(2, Math.floor(w / 110)));
  for (let t = 0; t < span; t += step) {
    const place = (t / span) * w;
    if (place < w - 28) context.fillText(`${+t.toPrecision(6)} s`, place, h - 4);
  }
  context.beginPath();
  context.moveTo(0, base);
  for (let i = 0; i < count; i++) context.lineTo(x(i), y(forces[i]));
  context.lineTo(w, base);
  context.fillStyle = css(theme.accent, 0.16);
  context.fill();
  context.beginPath();
  for (let i = 0; i < count; i++) context.lineTo(x(i), y(forces[i]));
  context.strokeStyle = css(theme.accent);
  context.lineWidth = 1.25;
  context.lineJoin = "round";
  context.stroke();
  context.strokeStyle = context.fillStyle = css(theme.now);
  context.lineWidth = 1.5;
  context.beginPath();
  context.moveTo(x(index), 0);
  context.lineTo(x(index), base);
  context.stroke();
  context.beginPath();
  context.arc(x(index), y(forces[index]), 3.5, 0, 7);
  context.fill();
}

function niceCeiling(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 2.5, 5, 10].find((m) => m * power >= value * 0.999) * power;
}
