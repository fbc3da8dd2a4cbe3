"use strict";
// Shows the scene of this page with WebGL 2 and nothing else. Lengths are millimetres.

const scene = JSON.parse(document.getElementById("scene").textContent);
const byId = (id) => document.getElementById(id);

// ---- data ------------------------------------------------------------------------------------

function unpacked(text, kind) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new kind(bytes.buffer);
}

for (const model of scene.models) {
  const steps = unpacked(model.positions, Int16Array);
  const shapes = model.titles.length, length = 3 * model.nodes;
  model.shapes = Array.from({ length: shapes }, (_, k) =>
    Float32Array.from(steps.subarray(k * length, (k + 1) * length), (s) => s * model.scale));
  model.triangles = unpacked(model.faces, Uint32Array);
  model.flatPoints = unpacked(model.flat, Float32Array);
  model.normals = model.shapes.map((points) => normalsOf(points, model.triangles));
  model.meshEdges = edgesOf(model.triangles);
  model.outlines = outlinesOf(model);
  for (const field of model.fields) field.steps = unpacked(field.values, Int16Array);
  model.regions.forEach((region, k) => {
    region.first = k ? model.regions[k - 1].first + model.regions[k - 1].count : 0;
    region.shown = true;
  });
}

function normalsOf(points, triangles) {
  const normals = new Float32Array(points.length);
  for (let f = 0; f < triangles.length; f += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => 3 * triangles[f + k]);
    const u = [0, 1, 2].map((k) => points[b + k] - points[a + k]);
    const v = [0, 1, 2].map((k) => points[c + k] - points[a + k]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const at of [a, b, c]) for (let k = 0; k < 3; k++) normals[at + k] += n[k];
  }
  return normals; // the shader makes them unit vectors
}

function edgesOf(triangles) {
  const seen = new Set(), edges = [];
  for (let f = 0; f < triangles.length; f += 3) {
    for (let k = 0; k < 3; k++) {
      const a = triangles[f + k], b = triangles[f + (k + 1) % 3];
      const key = a < b ? a * 4294967296 + b : b * 4294967296 + a;
      if (!seen.has(key)) { seen.add(key); edges.push(a, b); }
    }
  }
  return Uint32Array.from(edges);
}

function outlinesOf(model) { // edges of the sheet and between its regions
  const home = new Map();
  let face = 0;
  model.regions.forEach((region, number) => {
    for (let k = 0; k < region.count; k++, face++) {
      for (let c = 0; c < 3; c++) {
        const a = model.triangles[3 * face + c], b = model.triangles[3 * face + (c + 1) % 3];
        const key = Math.min(a, b) + "," + Math.max(a, b);
        home.set(key, home.has(key) ? [...home.get(key), number] : [number]);
      }
    }
  });
  const edges = [];
  for (const [key, numbers] of home) {
    if (numbers.length !== 2 || numbers[0] !== numbers[1]) edges.push(...key.split(",").map(Number));
  }
  return Uint32Array.from(edges);
}

// ---- state -----------------------------------------------------------------------------------

const first = { azimuth: -Math.PI / 4, elevation: 0.62, zoom: 1, x: 0, y: 0 };
const state = { ...first, milestone: 0, colour: -1, edges: false, playing: false };
const count = scene.models[0].titles.length;
const radius = Math.max(...scene.models.flatMap((model) => model.shapes.map(
  (points) => points.reduce((most, value) => Math.max(most, Math.abs(value)), 0))));

// ---- WebGL -----------------------------------------------------------------------------------

const canvas = byId("view");
const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
if (!gl) {
  byId("failed").hidden = false;
  byId("failed").textContent = "This browser has no WebGL 2, which the view needs.";
}

const VERTEX = `#version 300 es
in vec3 point; in vec3 normal; in float value;
uniform mat3 turn; uniform vec3 centre; uniform vec4 window; uniform float depth, nearer;
out vec3 n; out float v;
void main() {
  vec3 seen = turn * (point - centre);
  n = turn * normal; v = value;
  gl_Position = vec4(seen.xy * window.xy + window.zw, -seen.z * depth - nearer, 1.0);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 n; in float v;
uniform vec3 colour; uniform float field, light, opacity; uniform sampler2D ramp;
out vec4 pixel;
void main() {
  vec3 base = colour;
  if (field > 0.5) base = v < 0.0 ? vec3(0.7) : texture(ramp, vec2(v, 0.5)).rgb;
  if (light > 0.5) {
    vec3 m = normalize(n);
    if (m.z < 0.0) m = -m; // both sides are lit: the normal is turned to the viewer
    float l = dot(m, normalize(vec3(-0.35, 0.45, 0.85)));
    base *= 0.35 + 0.65 * pow((1.0 + l) / 2.0, 1.3);
    base += 0.12 * pow(max(0.0, dot(m, normalize(vec3(-0.18, 0.23, 0.96)))), 40.0);
  }
  pixel = vec4(base, opacity);
}`;

// viridis at nine places (Smith and van der Walt, CC0)
const RAMP = ["#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962",
  "#addc30", "#fde725"];
const numbersOf = (hex) => [1, 3, 5].map((k) => parseInt(hex.slice(k, k + 2), 16) / 255);

let program, places, uniforms;
function prepare() {
  program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) {
      throw new Error(gl.getShaderInfoLog(shader));
    }
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  places = Object.fromEntries(["point", "normal", "value"].map(
    (name) => [name, gl.getAttribLocation(program, name)]));
  uniforms = Object.fromEntries(["turn", "centre", "window", "depth", "nearer", "colour", "field",
    "light", "opacity", "ramp"].map((name) => [name, gl.getUniformLocation(program, name)]));
  const texture = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, texture);
  const pixels = Uint8Array.from(RAMP.flatMap((hex) => [...numbersOf(hex).map((x) => 255 * x), 255]));
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, RAMP.length, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  for (const [name, value] of [[gl.TEXTURE_MIN_FILTER, gl.LINEAR],
    [gl.TEXTURE_MAG_FILTER, gl.LINEAR], [gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE],
    [gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE]]) gl.texParameteri(gl.TEXTURE_2D, name, value);
  gl.enable(gl.DEPTH_TEST);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  gl.clearColor(1, 1, 1, 1);
  for (const model of scene.models) {
    model.buffers = { point: gl.createBuffer(), normal: gl.createBuffer(), value: gl.createBuffer() };
    for (const name of ["triangles", "meshEdges", "outlines"]) {
      model.buffers[name] = gl.createBuffer();
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, model.buffers[name]);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, model[name], gl.STATIC_DRAW);
    }
  }
}

function placeOf(model) { // which of its shapes is shown; -1: it has none at this prestretch
  return model.places ? model.places[state.milestone] : state.milestone;
}

function fill(model) { // the buffers of the milestone that is shown
  const k = placeOf(model);
  const field = model.fields[state.colour];
  const values = new Float32Array(model.nodes);
  if (field) {
    for (let i = 0; i < model.nodes; i++) {
      const step = field.steps[k * model.nodes + i];
      values[i] = step < 0 ? -1 : step / 32767;
    }
  }
  for (const [name, data, size] of [["point", model.shapes[k], 3], ["normal", model.normals[k], 3],
    ["value", values, 1]]) {
    gl.bindBuffer(gl.ARRAY_BUFFER, model.buffers[name]);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
    if (places[name] < 0) continue;
    gl.enableVertexAttribArray(places[name]);
    gl.vertexAttribPointer(places[name], size, gl.FLOAT, false, 0, 0);
  }
}

function turned() { // rows: right, up, toward the eye
  const [ca, sa] = [Math.cos(state.azimuth), Math.sin(state.azimuth)];
  const [ce, se] = [Math.cos(state.elevation), Math.sin(state.elevation)];
  return [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
}

function perPixel() { return 2.2 * radius / (state.zoom * Math.min(canvas.width, canvas.height)); }

function centreOf(points) { // of the box around the shape, across; the apex stays in the middle
  let low = Infinity, high = -Infinity;
  for (let i = 2; i < points.length; i += 3) {
    low = Math.min(low, points[i]);
    high = Math.max(high, points[i]);
  }
  return [0, 0, (low + high) / 2];
}

function draw() {
  if (!gl) return;
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.round(ratio * x));
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  gl.viewport(0, 0, width, height);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  const rows = turned(), size = perPixel();
  gl.uniformMatrix3fv(uniforms.turn, true, rows.flat());
  gl.uniform4f(uniforms.window, 2 / (size * width), 2 / (size * height), state.x, state.y);
  gl.uniform1f(uniforms.depth, 1 / (4 * radius));
  const lead = scene.models[0];
  gl.uniform3fv(uniforms.centre, centreOf(lead.shapes[state.milestone]));
  scene.models.forEach((model, number) => {
    if (placeOf(model) < 0 || model.hidden) return;
    fill(model);
    const over = number > 0;
    gl[over ? "enable" : "disable"](gl.BLEND);
    gl.uniform1f(uniforms.opacity, over ? 0.45 : 1);
    gl.uniform1f(uniforms.light, 1);
    gl.uniform1f(uniforms.field, !over && state.colour >= 0 ? 1 : 0);
    gl.uniform1f(uniforms.nearer, 0);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, model.buffers.triangles);
    for (const region of model.regions) {
      if (!region.shown) continue;
      gl.uniform3fv(uniforms.colour, over ? [0.55, 0.55, 0.6] : numbersOf(region.colour));
      gl.drawElements(gl.TRIANGLES, 3 * region.count, gl.UNSIGNED_INT, 12 * region.first);
    }
    gl.uniform1f(uniforms.light, 0);
    gl.uniform1f(uniforms.field, 0);
    gl.uniform1f(uniforms.nearer, 0.0015);
    for (const [name, shown, colour] of [["meshEdges", state.edges, [0.35, 0.35, 0.35]],
      ["outlines", true, over ? [0.3, 0.3, 0.4] : [0.1, 0.1, 0.1]]]) {
      if (!shown) continue;
      gl.uniform3fv(uniforms.colour, colour);
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, model.buffers[name]);
      gl.drawElements(gl.LINES, model[name].length, gl.UNSIGNED_INT, 0);
    }
  });
  drawScale(size * ratio);
}

function drawScale(perCssPixel) { // a length of 1, 2 or 5 times a power of ten, below 140 pixels
  const longest = 140 * perCssPixel;
  const power = 10 ** Math.floor(Math.log10(longest));
  const length = [5, 2, 1].map((k) => k * power).find((x) => x <= longest);
  byId("scale").firstElementChild.style.width = `${length / perCssPixel}px`;
  byId("scale").lastElementChild.textContent = `${Number(length.toPrecision(3))} mm`;
}

let asked = false;
function redraw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => { asked = false; draw(); });
}

// ---- the flat sheet --------------------------------------------------------------------------

function drawFlat() {
  const model = scene.models[0], pen = byId("flat").getContext("2d");
  const { width, height } = byId("flat");
  const most = model.flatPoints.reduce((m, x) => Math.max(m, Math.abs(x)), 0) * 1.04;
  const at = (node) => [width / 2 * (1 + model.flatPoints[2 * node] / most),
    height / 2 * (1 - model.flatPoints[2 * node + 1] / most)];
  pen.clearRect(0, 0, width, height);
  for (const region of model.regions) {
    if (!region.shown) continue;
    pen.fillStyle = pen.strokeStyle = region.colour;
    pen.beginPath();
    for (let f = region.first; f < region.first + region.count; f++) {
      const [a, b, c] = [0, 1, 2].map((k) => at(model.triangles[3 * f + k]));
      pen.moveTo(...a); pen.lineTo(...b); pen.lineTo(...c); pen.closePath();
    }
    pen.fill(); pen.stroke();
  }
  pen.strokeStyle = "#111";
  pen.beginPath();
  for (let e = 0; e < model.outlines.length; e += 2) {
    pen.moveTo(...at(model.outlines[e])); pen.lineTo(...at(model.outlines[e + 1]));
  }
  pen.stroke();
}

// ---- controls --------------------------------------------------------------------------------

function show(milestone) {
  state.milestone = Math.max(0, Math.min(count - 1, milestone));
  byId("milestone").value = state.milestone;
  const model = scene.models[0];
  const k = state.milestone;
  byId("title").textContent = model.titles[k] + (model.notes[k] ? ` (${model.notes[k]})` : "");
  redraw();
}

function showLegend() {
  const field = scene.models[0].fields[state.colour];
  const legend = byId("legend");
  legend.replaceChildren();
  if (!field) return;
  const ramp = document.createElement("div");
  ramp.className = "ramp";
  ramp.style.background = `linear-gradient(to right, ${RAMP.join(",")})`;
  const ends = document.createElement("div");
  ends.className = "ends";
  for (const value of [field.low, field.high]) {
    const end = document.createElement("span");
    end.textContent = `${Number(value.toPrecision(3))} ${field.unit}`;
    ends.append(end);
  }
  legend.append(ramp, ends);
}

function play(on) {
  state.playing = on;
  byId("play").textContent = on ? "\u23F8" : "\u25B6";
  if (on) setTimeout(step, 600);
}
function step() {
  if (!state.playing) return;
  show((state.milestone + 1) % count);
  setTimeout(step, 600);
}

function turn(right, up) {
  state.azimuth -= right;
  state.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, state.elevation + up));
  redraw();
}
function zoom(factor) {
  state.zoom = Math.max(0.2, Math.min(40, state.zoom * factor));
  redraw();
}
function move(dx, dy) { // CSS pixels
  state.x += 2 * dx / canvas.clientWidth;
  state.y -= 2 * dy / canvas.clientHeight;
  redraw();
}

const fingers = new Map();
canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, event);
});
for (const end of ["pointerup", "pointercancel"]) {
  canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
}
canvas.addEventListener("pointermove", (event) => {
  const before = fingers.get(event.pointerId);
  if (!before) return;
  const [dx, dy] = [event.clientX - before.clientX, event.clientY - before.clientY];
  if (fingers.size === 2) {
    const other = [...fingers.values()].find((finger) => finger.pointerId !== event.pointerId);
    const apart = (finger) => Math.hypot(finger.clientX - other.clientX, finger.clientY - other.clientY);
    zoom(apart(event) / Math.max(1, apart(before)));
    move(dx / 2, dy / 2);
  } else if (event.shiftKey || event.buttons === 4 || event.buttons === 2) {
    move(dx, dy);
  } else {
    turn(dx * 0.008, dy * 0.008);
  }
  fingers.set(event.pointerId, event);
});
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  zoom(Math.exp(-event.deltaY * 0.001));
}, { passive: false });

const KEYS = {
  ArrowLeft: () => turn(-0.1, 0), ArrowRight: () => turn(0.1, 0), ArrowUp: () => turn(0, -0.1),
  ArrowDown: () => turn(0, 0.1), "+": () => zoom(1.15), "-": () => zoom(1 / 1.15),
  ",": () => show(state.milestone - 1), ".": () => show(state.milestone + 1),
  " ": () => play(!state.playing), Home: () => reset(),
};
document.addEventListener("keydown", (event) => {
  const ownKeys = event.target.matches("input, select, button");
  if (ownKeys || !(event.key in KEYS)) return;
  event.preventDefault();
  KEYS[event.key]();
});

function reset() { Object.assign(state, first); redraw(); }

function build() {
  const names = byId("names");
  scene.models.forEach((model, number) => {
    const line = document.createElement(number ? "label" : "div");
    line.append(number ? `over it: ${model.name}` : model.name);
    if (number) {
      const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: true });
      box.addEventListener("change", () => { model.hidden = !box.checked; redraw(); });
      line.className = "row";
      line.prepend(box);
    }
    names.append(line);
  });
  const colour = byId("colour");
  ["layers", ...scene.models[0].fields.map((field) => field.name)].forEach((name, k) =>
    colour.add(new Option(name, String(k - 1))));
  colour.addEventListener("change", () => {
    state.colour = Number(colour.value);
    showLegend();
    redraw();
  });
  scene.models[0].regions.forEach((region) => {
    const label = document.createElement("label");
    label.className = "row";
    const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: true });
    const swatch = document.createElement("span");
    swatch.className = "swatch";
    swatch.style.background = region.colour;
    box.addEventListener("change", () => {
      for (const model of scene.models) {
        for (const own of model.regions) if (own.name === region.name) own.shown = box.checked;
      }
      drawFlat();
      redraw();
    });
    label.append(box, swatch, region.name);
    byId("regions").append(label);
  });
  byId("edges").addEventListener("change", (event) => {
    state.edges = event.target.checked;
    redraw();
  });
  byId("milestone").max = count - 1;
  byId("milestone").addEventListener("input", (event) => show(Number(event.target.value)));
  byId("play").addEventListener("click", () => play(!state.playing));
  byId("reset").addEventListener("click", reset);
  window.addEventListener("resize", redraw);
}

function time(frames) { // for scripts/check_viewer: #frames=20 turns the shape that often
  const pixel = new Uint8Array(4), times = [];
  for (let k = 0; k < frames; k += 1) {
    const begin = performance.now();
    turn(0.1, 0);
    draw();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel); // waits for the picture
    times.push(performance.now() - begin);
  }
  times.sort((a, b) => a - b);
  const [least, median] = [times[0], times[Math.floor(frames / 2)]].map((t) => t.toFixed(1));
  console.log(`frame: ${least} ms at least, ${median} ms in the middle`);
}

build();
if (gl) prepare();
drawFlat();
const asked_for = new URLSearchParams(location.hash.slice(1));
show(Number(asked_for.get("milestone") ?? count - 1));
if (gl && asked_for.has("frames")) time(Number(asked_for.get("frames")));
