// The page of `spacar view`: the model stands in the page as text of the element "data".
"use strict";
(function () {
  const $ = (id) => document.getElementById(id), canvas = $("view");
  const viewer = makeViewer(canvas, $("over"));
  if (!viewer) {
    $("note").textContent = "This browser has no WebGL 2; use spacar draw for pictures.";
    document.body.dataset.state = "no-webgl";
    return;
  }
  const { state, gl } = viewer, model = JSON.parse($("data").textContent), pictures = model.times.length;
  const controls = viewerControls(viewer);
  controls.load(model, false);
  viewer.draw();

  const wanted = new URLSearchParams(location.hash.slice(1)); // #step=3&node=5&measure=30: for tests and links
  if (wanted.has("step")) controls.show(+wanted.get("step") || 0);
  if (wanted.has("node")) state.node = model.nodes.findIndex((name) => parseInt(name, 10) === +wanted.get("node"));
  if (wanted.has("at")) { viewer.draw(); viewer.pick(...wanted.get("at").split(",").map(Number)); }
  viewer.draw();
  if (wanted.has("ink")) { // share of the picture that is not white
    const all = new Uint8Array(4 * canvas.width * canvas.height);
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, all);
    let dark = 0;
    for (let i = 0; i < all.length; i += 4) if (all[i] + all[i + 1] + all[i + 2] < 600) dark++;
    document.body.dataset.ink = ((4 * dark) / all.length).toFixed(5);
  }
  if (wanted.has("measure")) {
    const count = Math.max(1, +wanted.get("measure") || 1), begun = performance.now(), probe = new Uint8Array(4);
    let script = 0;
    for (let i = 0; i < count; i++) {
      state.k = i % pictures; state.azimuth += 1;
      const start = performance.now();
      viewer.draw();
      script += performance.now() - start;
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, probe); // waits until the picture is there
    }
    document.body.dataset.script = (script / count).toFixed(2);
    document.body.dataset.ms = ((performance.now() - begun) / count).toFixed(2);
  }
  document.body.dataset.state = gl.getError() === gl.NO_ERROR ? "ready" : "gl-error";
})();
