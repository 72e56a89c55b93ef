// The picture of `spacar view` and `spacar edit`: one mesh whose frames move from picture to picture (viewer_mesh.py),
// drawn with WebGL 2. A model comes as numbers and as text that only becomes text content.
"use strict";
function makeViewer(canvas, over) {
  const SHADES = 9; // of the palette of stresses
  const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) return null;
  const pen = over.getContext("2d");
  const state = { k: 0, playing: false, azimuth: 0, elevation: 0, zoom: 1, shift: [0, 0], node: -1, element: 0,
    numbers: false, marks: true, field: true };
  const viewer = { state, gl, model: null, load, draw, later, pick, look, numbersOfChosen, pixels,
    drawn: () => {}, picked: () => {} }; // are called after a picture, and after a choice by the pointer
  let model, scene; // scene: typed arrays, buffers and sizes of the model that is shown

  function program(vertex, fragment) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    return { made, at: (name) => gl.getUniformLocation(made, name) };
  }
  const CAMERA = `
    uniform mat3 u_turn; uniform vec2 u_scale, u_shift; uniform float u_depth;
    vec4 seen(vec3 at) { vec3 v = u_turn * at; return vec4(v.xy * u_scale + u_shift, -v.z * u_depth, 1.0); }`;
  const solids = program(`#version 300 es
    precision highp float; precision highp int; precision highp sampler2D;
    layout(location = 0) in uint a_frame; layout(location = 1) in vec3 a_place;
    layout(location = 2) in vec3 a_normal; layout(location = 3) in vec3 a_colour;
    layout(location = 4) in uint a_element;
    uniform sampler2D u_frames; uniform int u_width; uniform uint u_chosen;
    uniform vec3 u_palette[${SHADES}]; uniform bool u_field;
    out vec3 v_at; out vec3 v_normal; out vec3 v_colour;
    ${CAMERA}
    vec4 four(int i) { return texelFetch(u_frames, ivec2(i % u_width, i / u_width), 0); }
    vec3 texel(int i) { return four(i).xyz; }
    vec3 shade(float part) {
      float s = clamp(part, 0.0, 1.0) * ${SHADES - 1}.0;
      int k = min(int(s), ${SHADES - 2});
      return mix(u_palette[k], u_palette[k + 1], s - float(k));
    }
    void main() {
      int i = 3 * int(a_frame);
      vec3 p = texel(i), y = texel(i + 1), z = texel(i + 2), x = cross(y, z);
      vec3 at = p + a_place.x * x + a_place.y * y + a_place.z * z;
      v_normal = u_turn * (a_normal.x * x + a_normal.y * y + a_normal.z * z);
      v_at = u_turn * at;
      float part = four(i).w;
      v_colour = a_element == u_chosen && u_chosen != 0u ? vec3(0.93, 0.55, 0.12)
        : u_field && part >= 0.0 ? shade(part) : a_colour;
      gl_Position = seen(at);
    }`, `#version 300 es
    precision highp float;
    in vec3 v_at; in vec3 v_normal; in vec3 v_colour; out vec4 colour;
    void main() {
      vec3 n = length(v_normal) > 0.1 ? normalize(v_normal) : normalize(cross(dFdx(v_at), dFdy(v_at)));
      if (n.z < 0.0) n = -n;
      float light = 0.55 + 0.45 * pow(clamp(dot(n, normalize(vec3(-0.35, 0.65, 0.68))), 0.0, 1.0), 0.8);
      colour = vec4(v_colour * light, 1.0);
    }`);
  const marks = program(`#version 300 es
    precision highp float;
    layout(location = 0) in vec3 a_at; uniform float u_size; uniform vec3 u_colour; out vec3 v_colour;
    ${CAMERA}
    void main() { gl_Position = seen(a_at); gl_Position.z -= 0.002; gl_PointSize = u_size; v_colour = u_colour; }`,
    `#version 300 es
    precision highp float;
    in vec3 v_colour; out vec4 colour; uniform bool u_round;
    void main() {
      if (u_round && length(gl_PointCoord - 0.5) > 0.5) discard;
      colour = vec4(v_colour, 1.0);
    }`);

  function bytes(text) {
    const raw = atob(text), out = new Uint8Array(raw.length);
    for (let i = 0; i < raw.length; i++) out[i] = raw.charCodeAt(i);
    return out.buffer;
  }
  function kept(buffer) { scene.made.push(() => gl.deleteBuffer(buffer)); return buffer; }
  function vertices() {
    const made = gl.createVertexArray();
    scene.made.push(() => gl.deleteVertexArray(made));
    gl.bindVertexArray(made);
    return made;
  }
  function attribute(where, data, size, type, whole, norm, stride) {
    gl.bindBuffer(gl.ARRAY_BUFFER, kept(gl.createBuffer()));
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(where);
    if (whole) gl.vertexAttribIPointer(where, size, type, stride, 0);
    else gl.vertexAttribPointer(where, size, type, norm, stride, 0);
  }
  function points(data) {
    const made = vertices(), buffer = kept(gl.createBuffer());
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 12, 0);
    return { made, buffer };
  }

  // Show another model; `keep`: from where it is seen, and what is chosen, stay.
  function load(given, keep) {
    if (scene) scene.made.forEach((free) => free());
    const chosen = state.node >= 0 ? parseInt(model.nodes[state.node], 10) : 0, { fit } = state;
    viewer.model = model = given;
    const a = model.arrays;
    const field = model.field ? new Uint16Array(bytes(a.field)) : null; // 65535: the frame has no stress
    scene = { made: [], loaded: -1, frames: model.frames, pictures: model.times.length, nodes: model.nodes.length,
      P: new Float32Array(bytes(a.p)), AXES: new Int16Array(bytes(a.axes)), nodeP: new Float32Array(bytes(a.nodes)),
      field, values: a.values ? new Float32Array(bytes(a.values)) : null };
    const corner = new Uint32Array(bytes(a.frame)), element = new Uint32Array(bytes(a.element));
    const triangles = new Uint32Array(bytes(a.triangles));
    scene.elementOfFrame = new Uint32Array(scene.frames);
    for (let i = 0; i < corner.length; i++) scene.elementOfFrame[corner[i]] = element[i];
    scene.mesh = vertices();
    attribute(0, corner, 1, gl.UNSIGNED_INT, true, false, 4);
    attribute(1, new Float32Array(bytes(a.place)), 3, gl.FLOAT, false, false, 12);
    attribute(2, new Int8Array(bytes(a.normal)), 3, gl.BYTE, false, true, 4);
    attribute(3, new Uint8Array(bytes(a.colour)), 3, gl.UNSIGNED_BYTE, false, true, 4);
    attribute(4, element, 1, gl.UNSIGNED_INT, true, false, 4);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, kept(gl.createBuffer()));
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, triangles, gl.STATIC_DRAW);
    scene.corners = triangles.length;
    scene.dots = points(scene.nodeP.subarray(0, 3 * scene.nodes));
    scene.trails = points(new Float32Array(bytes(a.paths)));
    const { low, high } = model, edges = [];
    for (let k = 0; k < 3; k++) for (const u of [0, 1]) for (const v of [0, 1]) for (const w of [0, 1]) {
      const one = [0, 0, 0];
      one[k] = w; one[(k + 1) % 3] = u; one[(k + 2) % 3] = v;
      edges.push(...one.map((on, i) => (on ? high : low)[i]));
    }
    scene.box = points(new Float32Array(edges));
    // the frames of one picture as a texture: three texels a frame
    scene.width = Math.min(2048, gl.getParameter(gl.MAX_TEXTURE_SIZE));
    scene.height = Math.max(1, Math.ceil((3 * scene.frames) / scene.width));
    scene.texels = new Float32Array(4 * scene.width * scene.height);
    const texture = gl.createTexture();
    scene.made.push(() => gl.deleteTexture(texture));
    gl.bindTexture(gl.TEXTURE_2D, texture);
    for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.NEAREST], [gl.TEXTURE_MAG_FILTER, gl.NEAREST],
      [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE], [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]])
      gl.texParameteri(gl.TEXTURE_2D, name, value);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, scene.width, scene.height, 0, gl.RGBA, gl.FLOAT, null);
    scene.middle = low.map((v, i) => 0.5 * (v + high[i]));
    scene.reach = 0.5 * Math.hypot(...low.map((v, i) => high[i] - v)) || 1;
    state.k = 0;
    if (keep) {
      state.node = chosen ? model.nodes.findIndex((name) => parseInt(name, 10) === chosen) : -1;
      if (!model.elements[state.element]) state.element = 0;
      state.fit = fit;
      if (scene.reach < 0.8 * state.reach || scene.reach > 1.25 * state.reach) measureView();
    } else {
      Object.assign(state, { azimuth: model.azimuth, elevation: model.elevation, zoom: 1, shift: [0, 0], node: -1,
        element: 0 });
      measureView();
    }
    later();
  }

  function pose() {
    const { frames, nodes, P, AXES, nodeP, field, texels, width, height, dots } = scene;
    if (scene.loaded === state.k) return;
    const p = 3 * frames * state.k, q = 6 * frames * state.k, unit = 1 / 32767;
    for (let i = 0; i < frames; i++) {
      const t = 12 * i, r = p + 3 * i, s = q + 6 * i;
      const stress = field ? field[frames * state.k + i] : 65535;
      texels[t + 3] = stress === 65535 ? -1 : stress / 65534;
      texels[t] = P[r]; texels[t + 1] = P[r + 1]; texels[t + 2] = P[r + 2];
      for (let c = 0; c < 3; c++) {
        texels[t + 4 + c] = AXES[s + c] * unit;
        texels[t + 8 + c] = AXES[s + 3 + c] * unit;
      }
    }
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, width, height, gl.RGBA, gl.FLOAT, texels);
    gl.bindBuffer(gl.ARRAY_BUFFER, dots.buffer);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, nodeP.subarray(3 * nodes * state.k, 3 * nodes * (state.k + 1)));
    scene.loaded = state.k;
  }

  // half of the width and height [m] of the box as it is seen now: what has to fit at zoom 1
  function measureView() {
    const view = axes(), half = model.low.map((v, i) => 0.5 * (model.high[i] - v)), { reach } = scene;
    state.reach = reach;
    const along = (u) => half.reduce((sum, h, i) => sum + h * Math.abs(u[i]), 0);
    state.fit = [view.right, view.up].map((u) => Math.max(along(u), 0.05 * reach));
  }

  function axes() {
    const A = (state.azimuth * Math.PI) / 180, B = (state.elevation * Math.PI) / 180;
    const near = [Math.cos(B) * Math.cos(A), Math.cos(B) * Math.sin(A), Math.sin(B)];
    const right = [-Math.sin(A), Math.cos(A), 0];
    const turned = (i, j) => near[i] * right[j] - near[j] * right[i], up = [turned(1, 2), turned(2, 0), turned(0, 1)];
    return { right, up, near };
  }

  function camera() {
    const { middle, reach } = scene;
    const { right, up, near } = axes();
    const s = state.zoom * Math.min((0.46 * canvas.width) / state.fit[0], (0.46 * canvas.height) / state.fit[1]);
    const scale = [(2 * s) / canvas.width, (2 * s) / canvas.height];
    const dot = (u) => u[0] * middle[0] + u[1] * middle[1] + u[2] * middle[2];
    const shift = [state.shift[0] - dot(right) * scale[0], state.shift[1] - dot(up) * scale[1]];
    // depth is counted from the middle, in a range that holds the whole box
    return { right, up, near, scale, shift, depth: 0.45 / (reach + Math.abs(dot(near))), pixels: s };
  }

  function project(view, data, i) {
    const along = (u) => u[0] * data[i] + u[1] * data[i + 1] + u[2] * data[i + 2];
    return [(along(view.right) * view.scale[0] + view.shift[0] + 1) / 2 * canvas.width,
      (1 - along(view.up) * view.scale[1] - view.shift[1]) / 2 * canvas.height, along(view.near)];
  }

  function use(kind, view) {
    gl.useProgram(kind.made);
    const { right: r, up: u, near: n } = view;
    gl.uniformMatrix3fv(kind.at("u_turn"), false, [r[0], u[0], n[0], r[1], u[1], n[1], r[2], u[2], n[2]]);
    gl.uniform2fv(kind.at("u_scale"), view.scale);
    gl.uniform2fv(kind.at("u_shift"), view.shift);
    gl.uniform1f(kind.at("u_depth"), view.depth);
  }

  function draw() {
    if (!model) return;
    const { nodes, dots, trails, box, mesh, field, width, corners } = scene;
    const ratio = window.devicePixelRatio || 1;
    const [w, h] = [canvas.clientWidth, canvas.clientHeight].map((size) => Math.max(1, Math.round(size * ratio)));
    if (canvas.width !== w || canvas.height !== h) { canvas.width = over.width = w; canvas.height = over.height = h; }
    pose();
    const view = camera();
    gl.viewport(0, 0, w, h);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    use(marks, view);
    const line = (what, mode, first, count, rgb, size, round) => {
      gl.bindVertexArray(what.made);
      gl.uniform3fv(marks.at("u_colour"), rgb);
      gl.uniform1f(marks.at("u_size"), size);
      gl.uniform1i(marks.at("u_round"), round ? 1 : 0);
      gl.drawArrays(mode, first, count);
    };
    if (!model.planar) line(box, gl.LINES, 0, 24, [0.82, 0.85, 0.87], 1, false);
    for (const [first, count] of model.paths) line(trails, gl.LINE_STRIP, first, count, [0.82, 0.51, 0.16], 1, false);
    if (state.marks) line(dots, gl.POINTS, 0, nodes, [0.11, 0.15, 0.18], 5 * ratio, true);
    use(solids, view);
    gl.bindVertexArray(mesh);
    gl.uniform1i(solids.at("u_frames"), 0);
    gl.uniform1i(solids.at("u_width"), width);
    gl.uniform1ui(solids.at("u_chosen"), state.element);
    gl.uniform1i(solids.at("u_field"), state.field && field ? 1 : 0);
    if (field) gl.uniform3fv(solids.at("u_palette"), model.field.palette.flat().map((c) => c / 255));
    gl.drawElements(gl.TRIANGLES, corners, gl.UNSIGNED_INT, 0);
    overlay(view, ratio);
  }

  // what the colours mean: a strip with the range, above the axes
  function legend(ratio) {
    const { low, high, name, unit, palette } = model.field;
    const x = 20 * ratio, wide = 12 * ratio, tall = Math.min(180 * ratio, 0.4 * over.height);
    const top = 0.5 * (over.height - tall);
    const strip = pen.createLinearGradient(0, top + tall, 0, top);
    palette.forEach((c, i) => strip.addColorStop(i / (palette.length - 1), `rgb(${c.join(",")})`));
    pen.fillStyle = strip;
    pen.fillRect(x, top, wide, tall);
    pen.fillStyle = "#33414d";
    pen.fillText(`${name} (${unit})`, x, top - 8 * ratio);
    for (const part of [0, 0.5, 1]) {
      const value = low + part * (high - low), size = Math.abs(value);
      const text = size >= 1e5 || (size && size < 1e-3) ? value.toExponential(3) : `${+value.toPrecision(4)}`;
      pen.fillText(text.replace(/-/g, "\u2212"), x + wide + 6 * ratio, top + (1 - part) * tall + 4 * ratio);
    }
  }

  function overlay(view, ratio) {
    const { nodes, nodeP } = scene;
    pen.clearRect(0, 0, over.width, over.height);
    pen.font = `${12 * ratio}px sans-serif`;
    pen.lineWidth = 1.5 * ratio;
    const at = [46 * ratio, over.height - 46 * ratio], long = 30 * ratio;
    for (let k = 0; k < 3; k++) {
      const x = at[0] + long * view.right[k], y = at[1] - long * view.up[k];
      if (Math.hypot(x - at[0], y - at[1]) < 2 * ratio) continue;
      pen.strokeStyle = pen.fillStyle = ["#b3372f", "#2f8f4e", "#2f6fb5"][k];
      pen.beginPath(); pen.moveTo(at[0], at[1]); pen.lineTo(x, y); pen.stroke();
      pen.fillText("xyz"[k], x + 3 * ratio, y - 3 * ratio);
    }
    let length = Math.pow(10, Math.floor(Math.log10((160 * ratio) / view.pixels)));
    for (const m of [5, 2]) if (length * m * view.pixels <= 160 * ratio) { length *= m; break; }
    const x1 = over.width - 24 * ratio, x0 = x1 - length * view.pixels, y0 = over.height - 20 * ratio;
    pen.strokeStyle = pen.fillStyle = "#4d565e";
    pen.beginPath(); pen.moveTo(x0, y0 - 4 * ratio); pen.lineTo(x0, y0);
    pen.lineTo(x1, y0); pen.lineTo(x1, y0 - 4 * ratio); pen.stroke();
    pen.textAlign = "center";
    pen.fillText(`${+(length / model.metre).toPrecision(3)} ${model.unit}`, 0.5 * (x0 + x1), y0 - 6 * ratio);
    pen.textAlign = "left";
    if (state.field && scene.field) legend(ratio);
    if (state.numbers) {
      pen.fillStyle = "#33414d";
      const step = Math.max(1, Math.ceil(nodes / 300));
      for (let i = 0; i < nodes; i += step) {
        const [x, y] = project(view, nodeP, 3 * (nodes * state.k + i));
        pen.fillText(model.nodes[i], x + 5 * ratio, y - 5 * ratio);
      }
    }
    if (state.node >= 0) {
      const [x, y] = project(view, nodeP, 3 * (nodes * state.k + state.node));
      pen.strokeStyle = "#e07b1a";
      pen.lineWidth = 2.5 * ratio;
      pen.beginPath(); pen.arc(x, y, 9 * ratio, 0, 2 * Math.PI); pen.stroke();
    }
    viewer.drawn();
  }

  function pixels(i) { return project(camera(), scene.nodeP, 3 * (scene.nodes * state.k + i)); }

  function pick(x, y) {
    const { frames, nodes, nodeP, P, elementOfFrame } = scene;
    const view = camera(), ratio = window.devicePixelRatio || 1;
    state.node = -1;
    state.element = 0;
    let best = 12 * ratio;
    for (let i = 0; i < nodes; i++) {
      const [u, v] = project(view, nodeP, 3 * (nodes * state.k + i)), d = Math.hypot(u - x, v - y);
      if (d < best) { best = d; state.node = i; }
    }
    if (state.node < 0) {
      best = 14 * ratio;  // distance from the lines between successive frames of one element
      for (let i = 0; i + 1 < frames; i++) {
        if (!elementOfFrame[i]) continue;
        const p = project(view, P, 3 * (frames * state.k + i));
        let q = p;
        if (elementOfFrame[i + 1] === elementOfFrame[i]) q = project(view, P, 3 * (frames * state.k + i + 1));
        const dx = q[0] - p[0], dy = q[1] - p[1], long = dx * dx + dy * dy;
        const t = long ? Math.min(1, Math.max(0, ((x - p[0]) * dx + (y - p[1]) * dy) / long)) : 0;
        const d = Math.hypot(p[0] + t * dx - x, p[1] + t * dy - y);
        if (d < best) { best = d; state.element = elementOfFrame[i]; }
      }
    }
    viewer.picked();
    draw();
  }

  let asked = false;
  function later() {
    if (!asked) { asked = true; requestAnimationFrame(() => { asked = false; draw(); }); }
  }
  function look(azimuth, elevation) {
    Object.assign(state, { azimuth, elevation, zoom: 1, shift: [0, 0] });
    measureView();
    later();
  }
  // rows of [name, value, name of the coordinate] about the chosen node or element, as it is in this picture
  function numbersOfChosen() {
    const { nodes, nodeP, values } = scene, rows = [];
    // coordinates are kept with 24 bits: nothing smaller than that is shown
    const grain = Math.pow(10, Math.floor(Math.log10(scene.reach)) - 6);
    const e = model.elements[state.element];
    if (state.node >= 0) {
      const number = parseInt(model.nodes[state.node], 10);
      rows.push(["node", model.nodes[state.node], ""]);
      for (let c = 0; c < (model.planar ? 2 : 3); c++) {
        const [now, first] = [nodes * state.k + state.node, state.node].map((i) =>
          (Math.round((nodeP[3 * i + c] + model.centre[c]) / grain) * grain) / model.metre);
        rows.push([`${"xyz"[c]} (${model.unit})`, now, `x[${number},${c + 1}]`]);
        rows.push([`\u0394${"xyz"[c]}`, now - first, ""]);
      }
    } else if (e) {
      const [keyword, ends, places] = e, names = model.modes[keyword], first = model.columns * state.k - 1;
      rows.push(["element", `${keyword} ${state.element}`, ""], ["nodes", ends, ""]);
      if (values) places.forEach((column, m) => {
        if (!column) return;
        rows.push([`e${m + 1} ${names[m]}`, values[first + column], `e[${state.element},${m + 1}]`]);
        rows.push([`\u03c3${m + 1}`, values[first + model.ne + column], `sig[${state.element},${m + 1}]`]);
      });
    }
    return rows;
  }
  window.addEventListener("resize", later);
  return viewer;
}
