// The right side of the page: picture, freedoms and releases, results, log and curves.
"use strict";
async function call(name, given = {}) {
  const answer = await fetch(`call/${name}`, { method: "POST", headers: { "Content-Type": "application/json" },
    body: JSON.stringify(given) });
  if (!answer.ok) throw new Error((await answer.text()).trim());
  const { result, error, code } = await answer.json();
  if (error !== undefined) throw Object.assign(new Error(error), { code });
  return result;
}
const task = (name, given = {}) => call("task", { task: name, arguments: given });

// `page`: text(), change(text), insert(line), picked({node} or {element}); the picture is null without WebGL 2.
function makeResults(page) {
  const $ = (id) => document.getElementById(id);
  const viewer = makeViewer($("view"), $("over"));
  const controls = viewer && viewerControls(viewer);
  const results = { start, freedom, finished, shown: "", select, stale, place, make, tab };
  const curves = { names: [], data: null };
  if (!viewer) $("note").textContent = "This browser has no WebGL 2: no picture.";

  function make(tag, text, does) {
    const made = document.createElement(tag);
    made.textContent = text;
    if (does) {
      made.type = "button";
      made.addEventListener("click", () => does().catch((error) => { $("note").textContent = error.message; }));
    }
    return made;
  }
  function show(what, model, keep) {
    results.shown = what;
    $("note").textContent = "";
    $("shown").textContent = what;
    document.body.dataset.shown = what;
    if (!viewer) return;
    controls.load(model, keep);
    viewer.draw();
    document.body.dataset.pictures = String(+(document.body.dataset.pictures || 0) + 1);
  }
  function start(model) { show("start position", model, Boolean(viewer && viewer.model)); }
  function stale() { // the text is wrong: the last state that could be drawn stays
    $("shown").textContent = results.shown ? `${results.shown}, before the error` : "";
    $("freedom").classList.add("stale");
  }
  async function play(what, model) {
    show(what, await model, true);
    if (controls) controls.play(true);
  }

  function select({ node, element }) {
    if (!viewer || !viewer.model) return;
    const names = viewer.model.nodes.map((name) => name.match(/\d+/g).map(Number));
    const i = node ? names.findIndex((all) => all.includes(node)) : -1;
    Object.assign(viewer.state, { node: i, element: element || 0 });
    document.body.dataset.chosen = node ? `node ${node}` : `element ${element}`;
    viewer.later();
  }
  if (viewer) viewer.picked = () => {
    const { node, element } = viewer.state;
    if (node >= 0) page.picked({ node: parseInt(viewer.model.nodes[node], 10) });
    else if (element) page.picked({ element });
  };

  function place(node) { // of a node in the window
    const box = $("view").getBoundingClientRect(), ratio = window.devicePixelRatio || 1;
    const i = viewer.model.nodes.findIndex((name) => parseInt(name, 10) === node), [x, y] = viewer.pixels(i);
    return [box.left + x / ratio, box.top + y / ratio];
  }

  // Degrees of freedom, over- and under-constraints, releases
  function freedom(found) {
    const text = page.text(), rows = [], plural = (n, name) => `${n} ${name}${n === 1 ? "" : "s"}`;
    const row = (words, ...more) => { const p = make("p", words); p.append(...more); rows.push(p); return p; };
    row(`${plural(found.nx, "coordinate")}, ${plural(found.ne, "deformation")}, ` +
      `${found.ndof} degree${found.ndof === 1 ? "" : "s"} of freedom`);
    if (!found.over && !found.under) {
      rows[0].append(", neither over- nor under-constrained");
      rows[0].className = "fine";
      if (found.names.length) row("Play: ", ...found.names.map((name) =>
        make("button", name, () => play(`motion of ${name}`, task("motion", { text, name })))));
    }
    if (found.over) {
      row(`${plural(found.over, "over-constraint")}: ${found.deformations.slice(0, 8)
        .map((d) => `${d.name} ${(100 * d.share).toFixed(0)} %`).join(", ")}`).className = "error";
      if (found.releasable) row("", make("button", "Release what keeps the physics", async () => {
        const done = await task("released", { text });
        page.change(done.text);
        if (done.left) $("note").textContent = `${plural(done.left, "over-constraint")} left`;
      }));
      found.insert.filter((one) => !one.keeps).forEach((one) =>
        row("", make("button", `Insert ${one.line}`, async () => page.insert(one.line)), one.text));
    }
    if (found.under) {
      row(`${plural(found.under, "under-constraint")}: ${found.coordinates.slice(0, 8).map((c) => c.name).join(", ")}`,
        found.freedoms.length ? `; DYNX, INPUTX or FIX for ${found.freedoms.join(", ")}` : "").className = "error";
      row("Play: ", ...Array.from({ length: Math.min(found.under, 12) }, (_, i) =>
        make("button", `free motion ${i + 1}`, () => play("free motion", task("motion", { text, under: i + 1 })))));
    }
    $("freedom").replaceChildren(...rows);
    $("freedom").classList.remove("stale");
    document.body.dataset.freedom = `${found.ndof} ${found.over} ${found.under}`;
  }

  // What a run gave
  async function finished(playing) {
    const log = await call("log");
    $("log").textContent = log;
    curves.data = null;
    const found = await task("result");
    show("result", found.model, true);
    const old = $("shapes");
    if (old) old.remove();
    if (found.shapes.length) {
      const line = make("p", "Modes: ");
      line.id = "shapes";
      const shape = (label, i) => make("button", label, () => play(label, task("shape", { number: i })));
      line.append(...found.shapes.map(shape));
      $("freedom").prepend(line);
    }
    if (controls && playing && !found.stationary) controls.play(true);
    if (curves.names.length) await plot();
    return found;
  }
  function tab(name) {
    for (const button of document.querySelectorAll("[data-tab]")) {
      const chosen = button.dataset.tab === name;
      button.setAttribute("aria-pressed", String(chosen));
      $(button.dataset.tab).hidden = !chosen;
    }
    if (name === "curves") redraw();
  }
  for (const button of document.querySelectorAll("[data-tab]"))
    button.addEventListener("click", () => tab(button.dataset.tab));

  async function plot() {
    curves.data = await task("curve", { expressions: curves.names });
    tab("curves");
    document.body.dataset.curves = curves.names.join(" ");
  }
  function redraw() {
    $("curves").firstElementChild.hidden = Boolean(curves.data);
    if (!curves.data) return;
    const { names, columns } = curves.data;
    $("plots").replaceChildren(...names.slice(1).map(() => document.createElement("canvas")));
    const pictures = viewer ? viewer.model.times.length : 0;
    const now = viewer && results.shown === "result" && pictures > 1 && columns[0].length > 1
      ? columns[0][Math.round((viewer.state.k / (pictures - 1)) * (columns[0].length - 1))] : NaN;
    [...$("plots").children].forEach((canvas, i) =>
      drawCurve(canvas, columns[0], columns[i + 1], names[0], names[i + 1], now));
  }
  if (controls) controls.curve = (asked) => {
    const { names } = curves;
    curves.names = names.includes(asked) ? names.filter((name) => name !== asked) : [...names, asked];
    const work = curves.names.length ? plot() : ($("plots").replaceChildren(), Promise.resolve());
    work.catch((error) => { curves.names = []; $("note").textContent = `${error.message}`; });
  };
  tab("freedom");
  return results;
}
