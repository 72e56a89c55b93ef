// Curves of coordinates: a small picture for each, on canvases; the numbers come from the server.
"use strict";
function drawCurve(canvas, across, values, xName, yName, at) {
  const ratio = window.devicePixelRatio || 1, w = canvas.clientWidth * ratio, h = canvas.clientHeight * ratio;
  if (!w) return;
  canvas.width = w; canvas.height = h;
  const pen = canvas.getContext("2d"), [left, right, top, bottom] = [64, 12, 20, 30].map((v) => v * ratio);
  const points = values.map((v, i) => [across[i], v]).filter(([x, y]) => x !== null && y !== null);
  const range = (c) => {
    const all = points.map((p) => p[c]), low = Math.min(...all), high = Math.max(...all);
    const pad = c && high > low ? 0.06 * (high - low) : high > low ? 0 : Math.abs(high) * 0.1 || 1;
    return [low - pad, high + pad];
  };
  const [x0, x1] = range(0), [y0, y1] = range(1);
  const X = (x) => left + ((x - x0) / (x1 - x0)) * (w - left - right);
  const Y = (y) => h - bottom - ((y - y0) / (y1 - y0)) * (h - top - bottom);
  const steps = (low, high) => { // round numbers
    const raw = (high - low) / 4, size = 10 ** Math.floor(Math.log10(raw));
    const unit = [1, 2, 5, 10].find((m) => m * size >= raw) * size, first = Math.ceil(low / unit), found = [];
    for (let k = first; k * unit <= high * (1 + 1e-9); k++) found.push(k * unit);
    return found;
  };
  pen.font = `${11 * ratio}px sans-serif`;
  pen.strokeStyle = "#e3e7ea"; pen.fillStyle = "#4d565e"; pen.lineWidth = ratio;
  const text = (v) => String(+v.toPrecision(5)).replace("-", "\u2212");
  for (const x of steps(x0, x1)) {
    pen.beginPath(); pen.moveTo(X(x), top); pen.lineTo(X(x), h - bottom); pen.stroke();
    pen.textAlign = "center"; pen.fillText(text(x), X(x), h - bottom + 13 * ratio);
  }
  for (const y of steps(y0, y1)) {
    pen.beginPath(); pen.moveTo(left, Y(y)); pen.lineTo(w - right, Y(y)); pen.stroke();
    pen.textAlign = "right"; pen.fillText(text(y), left - 5 * ratio, Y(y) + 4 * ratio);
  }
  pen.textAlign = "left"; pen.fillText(yName, left, 13 * ratio);
  pen.textAlign = "right"; pen.fillText(xName, w - right, h - 4 * ratio);
  pen.strokeStyle = "#2f74b5"; pen.lineWidth = 1.6 * ratio;
  pen.beginPath();
  points.forEach(([x, y], i) => (i ? pen.lineTo(X(x), Y(y)) : pen.moveTo(X(x), Y(y))));
  pen.stroke();
  const dot = 4 * ratio;
  if (points.length < 3) for (const [x, y] of points) pen.fillRect(X(x) - dot / 2, Y(y) - dot / 2, dot, dot);
  if (at >= x0 && at <= x1) {
    pen.strokeStyle = "#d0812a";
    pen.beginPath(); pen.moveTo(X(at), top); pen.lineTo(X(at), h - bottom); pen.stroke();
  }
}
