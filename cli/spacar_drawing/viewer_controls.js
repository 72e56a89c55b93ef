// Bar, panel, keys and pointer of a picture of `makeViewer`; the elements are those of stage_html (viewer_page.py).
"use strict";
function viewerControls(viewer) {
  const $ = (id) => document.getElementById(id), { state } = viewer, canvas = $("view");
  const pictures = () => viewer.model.times.length;
  const number = (v) => typeof v === "string" ? v : v === 0 ? "0"
    : Math.abs(v) >= 1e-3 && Math.abs(v) < 1e5 ? String(+v.toPrecision(6)) : v.toExponential(4);
  const controls = { load, show, play, curve: null }; // curve: is told the coordinate of a row that is clicked

  function load(model, keep) {
    play(false);
    viewer.load(model, keep);
    $("step").max = pictures() - 1;
    $("step").value = state.k = Math.max(0, Math.min(pictures() - 1, model.shown || 0));
    $("controls").hidden = pictures() < 2;
    $("fields").hidden = !model.field;
  }
  let panelOf = -1;
  viewer.drawn = () => {
    $("time").textContent = viewer.model.times[state.k];
    const rows = viewer.numbersOfChosen(), chosen = state.node;
    if (chosen >= 0 && chosen !== panelOf) // the panel stands away from the node that is chosen
      $("panel").classList.toggle("left", 2 * viewer.pixels(chosen)[0] > canvas.width);
    panelOf = chosen;
    $("picked").replaceChildren(...rows.map(([name, value, asked]) => {
      const [row, head, cell] = ["tr", "th", "td"].map((tag) => document.createElement(tag));
      head.textContent = name;
      cell.textContent = number(value);
      row.append(head, cell);
      if (asked && controls.curve) row.dataset.asked = asked;
      return row;
    }));
    $("hint").hidden = rows.length > 0;
  };
  $("picked").addEventListener("pointerdown", (e) => { // a click would end on the row of another picture
    const row = e.target.closest("[data-asked]");
    if (row && controls.curve) controls.curve(row.dataset.asked);
  });

  function show(k) {
    state.k = Math.max(0, Math.min(pictures() - 1, k));
    $("step").value = state.k;
    viewer.later();
  }
  let last = 0;
  function tick(now) {
    if (!state.playing) return;
    if (now - last >= 1000 / viewer.model.fps) {
      last = now;
      state.k = (state.k + 1) % pictures();
      $("step").value = state.k;
      viewer.draw();
    }
    requestAnimationFrame(tick);
  }
  function play(on) {
    state.playing = on && pictures() > 1;
    $("play").textContent = state.playing ? "pause" : "play";
    if (state.playing) requestAnimationFrame(tick);
  }

  let drag = null;
  canvas.addEventListener("pointerdown", (e) => {
    drag = { x: e.clientX, y: e.clientY, moved: false, pan: e.shiftKey || e.button !== 0,
      azimuth: state.azimuth, elevation: state.elevation, shift: state.shift.slice() };
    try { canvas.setPointerCapture(e.pointerId); } catch (error) { /* a pointer that is gone already */ }
  });
  canvas.addEventListener("pointermove", (e) => {
    if (!drag) return;
    const dx = e.clientX - drag.x, dy = e.clientY - drag.y;
    if (Math.hypot(dx, dy) > 3) drag.moved = true;
    if (!drag.moved) return;
    if (drag.pan) {
      const across = (2 * dx) / canvas.clientWidth, up = (2 * dy) / canvas.clientHeight;
      state.shift = [drag.shift[0] + across, drag.shift[1] - up];
    } else {
      state.azimuth = drag.azimuth - 0.4 * dx;
      state.elevation = Math.max(-90, Math.min(90, drag.elevation + 0.4 * dy));
    }
    viewer.later();
  });
  canvas.addEventListener("pointerup", (e) => {
    if (drag && !drag.moved) {
      const ratio = window.devicePixelRatio || 1, r = canvas.getBoundingClientRect();
      viewer.pick((e.clientX - r.left) * ratio, (e.clientY - r.top) * ratio);
    }
    drag = null;
  });
  canvas.addEventListener("pointercancel", () => { drag = null; });
  canvas.addEventListener("contextmenu", (e) => e.preventDefault());
  canvas.addEventListener("wheel", (e) => {
    e.preventDefault();
    const factor = Math.exp(-0.0012 * e.deltaY), r = canvas.getBoundingClientRect();
    const x = (2 * (e.clientX - r.left)) / r.width - 1, y = 1 - (2 * (e.clientY - r.top)) / r.height;
    // what is under the pointer stays
    state.shift = [x + (state.shift[0] - x) * factor, y + (state.shift[1] - y) * factor];
    state.zoom *= factor;
    viewer.later();
  }, { passive: false });
  canvas.addEventListener("dblclick", () => viewer.look(viewer.model.azimuth, viewer.model.elevation));
  $("play").addEventListener("click", () => play(!state.playing));
  $("step").addEventListener("input", () => { play(false); show(+$("step").value); });
  for (const name of ["numbers", "marks", "field"])
    $(name).addEventListener("change", () => { state[name] = $(name).checked; viewer.later(); });
  for (const button of document.querySelectorAll("[data-view]"))
    button.addEventListener("click", () => viewer.look(...button.dataset.view.split(",").map(Number)));
  document.addEventListener("keydown", (e) => {
    if (!viewer.model || e.target.isContentEditable || (e.target.tagName === "INPUT" && e.key !== " ")) return;
    if (e.key === " " && e.target.tagName !== "BUTTON") { e.preventDefault(); play(!state.playing); }
    else if (e.key === "ArrowRight") show(state.k + 1);
    else if (e.key === "ArrowLeft") show(state.k - 1);
  });
  return controls;
}
