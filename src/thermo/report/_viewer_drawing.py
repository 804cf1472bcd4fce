"""How the viewer's page draws: its WebGL, its view, and what is under the pointer."""

SIGHT = r"""
const dpr = () => Math.min(window.devicePixelRatio || 1, 2);
const radius = place.reduce((most, _, i) => (i % 3 ? most
  : Math.max(most, Math.hypot(place[i], place[i + 1], place[i + 2]))), 1e-12);
// Rows: right, up and towards the reader; z of the object is up.
const turnOf = (azimuth, elevation) => {
  const [a, e] = [azimuth, elevation].map((angle) => angle * Math.PI / 180);
  const ca = Math.cos(a), sa = Math.sin(a), ce = Math.cos(e), se = Math.sin(e);
  return [-sa, ca, 0, -se * ca, -se * sa, ce, ce * ca, ce * sa, se];
};
const along = (turn, row, at, from = place) =>
  turn[3 * row] * from[at] + turn[3 * row + 1] * from[at + 1] + turn[3 * row + 2] * from[at + 2];
// How far the object reaches to the side and up, as it is seen first [m].
const reach = [0, 1].map((row) => {
  const turn = turnOf(START.azimuth, START.elevation);
  let most = 0.05 * radius;
  for (let i = 0; i < place.length; i += 3) most = Math.max(most, Math.abs(along(turn, row, i)));
  return most;
});
const aspect = () => Math.max(1, canvas.clientWidth) / Math.max(1, canvas.clientHeight);
// Half the height of the picture [m].
const halfHeight = () => 1.12 * Math.max(reach[0] / aspect(), reach[1]) / state.zoom;
const sightNow = () => {
  const half = halfHeight(), ratio = aspect();
  return { turn: turnOf(state.azimuth, state.elevation), shift: state.shift,
    stretch: [1 / (half * ratio), 1 / half] };
};
const size = () => 2 * halfHeight() / Math.max(1, canvas.clientHeight);
const guide = () => {
  const most = 100 * size(), power = 10 ** Math.floor(Math.log10(most));
  const long = power * [5, 2, 1].find((first) => first * power <= most * (1 + 1e-9));
  const name = long >= 1 ? `${number(long, long)} m` : `${number(long * 1e3, long * 1e3)} mm`;
  const wide = long / size(), turn = turnOf(state.azimuth, state.elevation);
  const parts = [["x", "#c0392b"], ["y", "#2f8f46"], ["z", "#3f6fd8"]].map(([word, colour], i) => {
    const [x, y] = [turn[i], -turn[3 + i]];
    return `<path d="M36 52l${28 * x} ${28 * y}" stroke="${colour}" stroke-width="2"/>`
      + `<text x="${36 + 38 * x}" y="${56 + 38 * y}" text-anchor="middle">${word}</text>`;
  });
  $("guide").innerHTML = parts.join("")
    + `<path d="M100 62v6h${wide}v-6" fill="none" stroke-width="1.5"/>`
    + `<text x="${100 + wide / 2}" y="58" text-anchor="middle">${name}</text>`;
};
// The nearest triangle under a place of the canvas [px], with the shares of its corners.
const pick = (x, y) => {
  const turn = turnOf(state.azimuth, state.elevation), unit = size();
  const px = (x - canvas.clientWidth / 2) * unit + state.shift[0];
  const py = (canvas.clientHeight / 2 - y) * unit + state.shift[1];
  const flat = new Float32Array(2 * vertices);
  for (let i = 0; i < vertices; i++) {
    flat[2 * i] = along(turn, 0, 3 * i) - px;
    flat[2 * i + 1] = along(turn, 1, 3 * i) - py;
  }
  let best = null;
  for (let i = 0; i < corner.length; i += 3) {
    const [a, b, c] = [corner[i], corner[i + 1], corner[i + 2]];
    const [ax, ay, bx, by, cx, cy] = [flat[2 * a], flat[2 * a + 1], flat[2 * b], flat[2 * b + 1],
      flat[2 * c], flat[2 * c + 1]];
    const u = bx * cy - by * cx, v = cx * ay - cy * ax, w = ax * by - ay * bx, sum = u + v + w;
    if (!sum || u * sum < 0 || v * sum < 0 || w * sum < 0) continue;
    const shares = [u / sum, v / sum, w / sum], corners = [a, b, c];
    const near = corners.reduce((depth, one, k) => depth + shares[k] * along(turn, 2, 3 * one), 0);
    if (!best || near > best.near) best = { near, corners, shares };
  }
  return best;
};
const pickDot = (x, y, hit) => {
  if (!state.dots || !readings) return null;
  const turn = turnOf(state.azimuth, state.elevation), unit = size();
  let best = null, least = 9 * unit, near = 0;
  for (let i = 0; i < samples; i++) {
    const dx = along(turn, 0, 3 * i, readings.points) - state.shift[0]
      - (x - canvas.clientWidth / 2) * unit;
    const dy = along(turn, 1, 3 * i, readings.points) - state.shift[1]
      - (canvas.clientHeight / 2 - y) * unit;
    near = along(turn, 2, 3 * i, readings.points);
    if (Math.hypot(dx, dy) < least && near > hit.near - 0.05 * radius) {
      least = Math.hypot(dx, dy);
      best = i;
    }
  }
  return best;
};
"""
"""The view, the scale beside the object and picking, as JavaScript."""

DRAWING = r"""
const SURFACE = [`#version 300 es
in vec3 place; in float code; uniform mat3 turn; uniform vec2 shift, stretch; uniform float deep;
out vec3 eye; out float share, known;
void main() {
  eye = turn * place;
  known = code > 0.999995 ? 0.0 : 1.0;
  share = code * 65535.0 / 65534.0;
  gl_Position = vec4((eye.xy - shift) * stretch, -eye.z * deep, 1.0);
}`, `#version 300 es
precision highp float;
in vec3 eye; in float share, known; uniform sampler2D map; uniform float light; out vec4 colour;
void main() {
  vec3 normal = normalize(cross(dFdx(eye), dFdy(eye)));
  vec3 found = texture(map, vec2((clamp(share, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (known < 0.999)
    found = vec3(mod(gl_FragCoord.x + gl_FragCoord.y, 12.0) < 4.0 ? 0.45 : 0.68);
  float lit = max(dot(normal, normalize(vec3(-0.35, 0.45, 0.8))), 0.0);
  colour = vec4(found * (1.0 - light * (1.0 - lit)), 1.0);
}`];
const DOTS = [`#version 300 es
in vec3 place; in float code; uniform mat3 turn; uniform vec2 shift, stretch, ends;
uniform float deep, size, front; out float share, known;
void main() {
  vec3 eye = turn * place;
  known = code > 0.999995 ? 0.0 : 1.0;
  share = ends.x + (ends.y - ends.x) * code * 65535.0 / 65534.0;
  gl_Position = vec4((eye.xy - shift) * stretch, -(eye.z + front) * deep, 1.0);
  gl_PointSize = size;
}`, `#version 300 es
precision highp float;
in float share, known; uniform sampler2D map; uniform float plain; out vec4 colour;
void main() {
  float far = length(gl_PointCoord - 0.5) * 2.0;
  if (far > 1.0) discard;
  vec3 found = texture(map, vec2((clamp(share, 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (known < 0.5 || plain > 0.5) found = vec3(0.5);
  colour = vec4(far > 0.82 ? vec3(0.1) : far > 0.6 ? vec3(1.0) : found, 1.0);
}`];
const canvas = $("canvas");
let gl = null, surface = null, dots = null;
const program = (sources) => {
  const made = gl.createProgram();
  sources.forEach((source, i) => {
    const shader = gl.createShader(i ? gl.FRAGMENT_SHADER : gl.VERTEX_SHADER);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(made, shader);
  });
  ["place", "code"].forEach((name, i) => gl.bindAttribLocation(made, i, name));
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS) && !gl.isContextLost())
    throw new Error(gl.getProgramInfoLog(made) || "the drawing program is refused");
  return made;
};
const prepare = (sources, places, order) => {
  const made = { program: program(sources), holder: gl.createVertexArray(), held: null };
  gl.bindVertexArray(made.holder);
  [places, null].forEach((values, i) => {
    made.codes = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, made.codes);
    if (values) gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(i);
    gl.vertexAttribPointer(i, i ? 1 : 3, i ? gl.UNSIGNED_SHORT : gl.FLOAT, i === 1, 0, 0);
  });
  if (order) {
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, order, gl.STATIC_DRAW);
  }
  return made;
};
const begin = () => {
  gl = canvas.getContext("webgl2", { antialias: true });
  if (!gl) return false;
  surface = prepare(SURFACE, place, corner);
  dots = readings && prepare(DOTS, readings.points, null);
  gl.enable(gl.DEPTH_TEST);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  for (const key of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
    gl.texParameteri(gl.TEXTURE_2D, key, gl.LINEAR);
  for (const key of [gl.TEXTURE_WRAP_S, gl.TEXTURE_WRAP_T])
    gl.texParameteri(gl.TEXTURE_2D, key, gl.CLAMP_TO_EDGE);
  return true;
};
const use = (made, codes, sight) => {
  gl.useProgram(made.program);
  gl.bindVertexArray(made.holder);
  gl.bindBuffer(gl.ARRAY_BUFFER, made.codes);
  gl.bufferData(gl.ARRAY_BUFFER, codes, gl.DYNAMIC_DRAW);
  const at = (name) => gl.getUniformLocation(made.program, name);
  gl.uniformMatrix3fv(at("turn"), true, sight.turn);
  gl.uniform2fv(at("shift"), sight.shift);
  gl.uniform2fv(at("stretch"), sight.stretch);
  gl.uniform1f(at("deep"), 0.98 / radius);
  return at;
};
const draw = () => {
  const [wide, tall] = [canvas.clientWidth, canvas.clientHeight].map(
    (one) => Math.max(1, Math.round(one * dpr())));
  if (canvas.width !== wide || canvas.height !== tall) Object.assign(canvas,
    { width: wide, height: tall });
  guide();
  if (!gl || gl.isContextLost()) return;
  const one = layer(), sight = sightNow();
  gl.viewport(0, 0, wide, tall);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, maps[one.kind]);
  let at = use(surface, codesAt(one, state.frame, vertices), sight);
  gl.uniform1f(at("light"), state.light ? 0.18 : 0);
  gl.drawElements(gl.TRIANGLES, corner.length, gl.UNSIGNED_INT, 0);
  if (state.dots && readings) {
    at = use(dots, codesAt(readings, reading(), samples), sight);
    const share = (value) => (value - one.low) / (one.high - one.low);
    gl.uniform2f(at("ends"), share(readings.low), share(readings.high));
    gl.uniform1f(at("plain"), one.kind === "temperature" ? 0 : 1);
    // A dot stands before the surface by its width, so that a slope does not cut it.
    const wide = samples > 150 ? 8 : 13;
    gl.uniform1f(at("size"), wide * dpr());
    gl.uniform1f(at("front"), wide * size());
    gl.drawArrays(gl.POINTS, 0, samples);
  }
  const fault = gl.getError();
  Object.assign($("viewer").dataset, { triangles: fault ? 0 : triangles, fault });
};
"""
"""Programs for the graphics card and how they are fed, as JavaScript."""
