"""The program of the viewer's page: plain JavaScript and WebGL 2, no library."""

from ._viewer_drawing import DRAWING, SIGHT

# Runs first, so that an error of the program is said in the page and not only in a console.
CATCH = r"""
window.addEventListener("error", (event) => {
  const root = document.documentElement;
  root.dataset.error = `${root.dataset.error || ""}${event.message}; `;
  const place = document.getElementById("message");
  if (place) { place.hidden = false; place.textContent = `This page failed: ${event.message}`; }
});
"""

_DATA = r"""
const UNKNOWN = 65535, STEPS = 65534, ZERO_CELSIUS = 273.15;
const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);
const bytes = (text) => {
  const raw = atob(text), found = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) found[i] = raw.charCodeAt(i);
  return found.buffer;
};
const place = new Float32Array(bytes(data.vertices));
const corner = new Uint32Array(bytes(data.triangles));
const vertices = place.length / 3, triangles = corner.length / 3;
const layers = data.layers.map((one) => ({ ...one, codes: new Uint16Array(bytes(one.codes)) }));
const maps = Object.fromEntries(
  Object.entries(data.maps).map(([kind, one]) => [kind, new Uint8Array(bytes(one))]));
const readings = data.readings && { ...data.readings,
  points: new Float32Array(bytes(data.readings.points)),
  codes: new Uint16Array(bytes(data.readings.codes)) };
const samples = readings ? readings.points.length / 3 : 0;

const START = { azimuth: -60, elevation: 28 };
// `time` leads: it stays while a layer without one is shown.
const state = { layer: 0, frame: 0, time: (layers[0].time || [0])[data.frame],
  celsius: false, dots: samples > 0 && samples <= 150, light: true, ...START, zoom: 1,
  shift: [0, 0], pointer: null };
const layer = () => layers[state.layer];
const frames = (one) => (one.time ? one.time.length : 1);
const now = () => (layer().time ? layer().time[state.frame] : null);
const nearest = (times, time) => {
  let best = 0;
  times.forEach((one, i) => { if (Math.abs(one - time) < Math.abs(times[best] - time)) best = i; });
  return best;
};
const valueOf = (one, share) => one.log
  ? one.low * (one.high / one.low) ** share : one.low + (one.high - one.low) * share;
const codesAt = (one, frame, count) => one.codes.subarray(frame * count, (frame + 1) * count);
const reading = () => nearest(readings.time, state.time);
"""

_WORDS = r"""
const RAISED = { "-": "\u207b", 0: "\u2070", 1: "\u00b9", 2: "\u00b2", 3: "\u00b3", 4: "\u2074",
  5: "\u2075", 6: "\u2076", 7: "\u2077", 8: "\u2078", 9: "\u2079" };
// A number without its unit; `step` is the difference that must still be seen.
const number = (value, step) => {
  const size = Math.abs(value);
  if (size >= 1e6 || (size > 0 && step < 1e-6)) {
    const digits = Math.min(8, Math.max(1, Math.ceil(Math.log10(size / step))));
    const [head, tail] = value.toExponential(digits).split("e");
    return `${head} \u00d7 10${[...String(Number(tail))].map((one) => RAISED[one]).join("")}`
      .replace("-", "\u2212");
  }
  const places = Math.min(8, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9)));
  const text = value.toFixed(places);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", "\u2212");
};
const inCelsius = (one) => state.celsius && one.kind === "temperature";
const unitOf = (one) => (inCelsius(one) ? "\u00b0C" : one.unit === "1" ? "" : one.unit);
const moved = (one, value) => (inCelsius(one) ? value - ZERO_CELSIUS : value);
const amount = (one, value) => {
  const step = one.log ? Math.abs(value) / 200 : (one.high - one.low) / 300;
  return `${number(moved(one, value), step)} ${unitOf(one)}`.trim();
};
const seconds = (time) => `${Number(time.toPrecision(6))} s`.replace("-", "\u2212");
const spoken = (one) => one.name.charAt(0).toUpperCase() + one.name.slice(1);
const rangeNow = () => {
  let low = UNKNOWN, high = -1;
  for (const code of codesAt(layer(), state.frame, vertices)) {
    if (code === UNKNOWN) continue;
    if (code < low) low = code;
    if (code > high) high = code;
  }
  return high < 0 ? null : [low, high].map((code) => valueOf(layer(), code / STEPS));
};
const ticks = (one) => {
  const low = moved(one, one.low), high = moved(one, one.high), found = [];
  if (one.log) {
    const wide = high / low > 1e4;
    for (let power = Math.floor(Math.log10(low)); 10 ** power <= high; power++)
      for (const first of wide ? [1] : [1, 2, 5]) {
        const value = first * 10 ** power;
        if (value >= low && value <= high)
          found.push([Math.log(value / low) / Math.log(high / low), number(value, value / 2)]);
      }
    return found;
  }
  const rough = (high - low) / 6, power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((first) => first * power >= rough * 0.999);
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++)
    found.push([(i * step - low) / (high - low), number(i * step, step)]);
  return found;
};
"""

_CONTROLS = r"""
const tellPointer = () => {
  const words = $("here"), hit = state.pointer && pick(...state.pointer), one = layer();
  $("mark").hidden = true;
  if (!hit) { words.textContent = "Point at the object to read a value."; return; }
  const codes = codesAt(one, state.frame, vertices);
  const among = (get) => hit.corners.reduce((sum, v, k) => sum + hit.shares[k] * get(v), 0);
  const at = [0, 1, 2].map((k) => 1e3 * (among((v) => place[3 * v + k]) + data.centre[k]));
  const where = at.map((value) => number(value, 1e3 * radius / 500)).join(", ");
  const missing = hit.corners.some((v) => codes[v] === UNKNOWN);
  const share = among((v) => codes[v]) / STEPS, dot = pickDot(...state.pointer, hit);
  const said = missing ? "not known" : amount(one, valueOf(one, share));
  const code = dot === null ? UNKNOWN : codesAt(readings, reading(), samples)[dot];
  const hot = layers.find((other) => other.kind === "temperature") || readings;
  const read = dot === null ? "" : ` Reading of sample ${dot}: ` + (code === UNKNOWN ? "none"
    : amount({ ...readings, kind: "temperature", unit: "K", low: hot.low, high: hot.high },
      valueOf(readings, code / STEPS)))
    + (readings.time[reading()] === now() ? "." : ` at ${seconds(readings.time[reading()])}.`);
  words.textContent = `${spoken(one)} under the pointer: ${said}, at (${where}) mm.${read}`;
  $("mark").hidden = missing;
  $("mark").style.bottom = `${100 * share}%`;
};
const tell = () => {
  const one = layer(), range = rangeNow(), count = frames(one);
  const steady = !one.time, slider = $("frame");
  slider.max = count - 1;
  slider.value = state.frame;
  slider.disabled = $("play").disabled = count < 2;
  const at = steady ? "does not change in time"
    : `${seconds(now())} (${state.frame + 1} of ${count})`;
  $("when").textContent = at;
  slider.setAttribute("aria-valuetext", at);
  $("said").textContent = spoken(one) + (steady ? "" : ` at ${seconds(now())}`)
    + (range ? `: from ${amount(one, range[0])} to ${amount(one, range[1])}.` : ": not known.");
  Object.assign($("viewer").dataset, { layer: one.name, frame: state.frame, frames: count,
    time: steady ? "" : now(), unit: unitOf(one) });
};
const tellLayer = () => {
  const one = layer(), unit = unitOf(one);
  document.querySelectorAll('[name="layer"]').forEach((input, i) => {
    input.checked = i === state.layer;
  });
  document.querySelectorAll('[name="unit"]').forEach((input) => {
    input.checked = (input.value === "C") === state.celsius;
  });
  $("units").hidden = one.kind !== "temperature";
  $("dots").checked = state.dots;
  $("unit").textContent = unit;
  const map = maps[one.kind], stops = [];
  for (let i = 0; i < 256; i += 5)
    stops.push(`rgb(${map[3 * i]} ${map[3 * i + 1]} ${map[3 * i + 2]})`);
  $("colours").style.background = `linear-gradient(to top, ${stops.join(",")})`;
  $("ticks").replaceChildren(...ticks(one).map(([share, word]) => {
    const mark = document.createElement("span");
    mark.className = "tick";
    mark.style.bottom = `${100 * share}%`;
    mark.textContent = word;
    return mark;
  }));
  $("bar").setAttribute("aria-label",
    `Colours from ${amount(one, one.low)} to ${amount(one, one.high)}`);
  const half = one.log ? (Math.log(one.high / one.low) / STEPS * 50).toPrecision(2) + " %"
    : `${Number(((one.high - one.low) / STEPS / 2).toPrecision(2))} ${unitOf(one)}`;
  $("rounding").textContent = `Values of this layer are rounded: they are off by at most ${half}.`;
  $("colouring").textContent = { field: "", temperature: readings
    ? "The dots are readings, in the same colours: one that cannot be told from its surroundings "
      + "is met by the simulation." : "",
  residual: "A residual is simulation less reading: above zero the simulation is too warm." }[
    one.kind];
};
let waiting = 0;
const later = () => { waiting ||= requestAnimationFrame(refresh); };
const refresh = () => { waiting = 0; draw(); tellPointer(); };
let noting = 0;
const note = () => {
  clearTimeout(noting);
  noting = setTimeout(() => {
    const view = [state.azimuth, state.elevation, state.zoom].map((one) => Number(one.toFixed(2)));
    const words = new URLSearchParams({ layer: layer().name, frame: state.frame,
      unit: state.celsius ? "C" : "K", view: view.join(",") });
    // Some browsers refuse to change the address of a page that was opened from disk.
    try { history.replaceState(null, "", `#${words}`); } catch { /* the view is not kept */ }
  }, 300);
};
const show = (frame) => {
  state.frame = Math.min(Math.max(0, frame), frames(layer()) - 1);
  if (layer().time) state.time = now();
  tell();
  later();
  note();
};
const choose = (index) => {
  state.layer = index;
  tellLayer();
  show(layer().time ? nearest(layer().time, state.time) : 0);
};
const look = (azimuth, elevation, zoom) => {
  state.azimuth = ((azimuth + 180) % 360 + 360) % 360 - 180;
  state.elevation = Math.min(90, Math.max(-90, elevation));
  state.zoom = Math.min(50, Math.max(0.2, zoom));
  later();
  note();
};
const fromAddress = () => {
  const given = new URLSearchParams(location.hash.slice(1));
  const named = layers.findIndex((one) => one.name === given.get("layer"));
  if (given.has("unit")) state.celsius = given.get("unit") === "C";
  choose(named < 0 ? state.layer : named);
  const frame = Number(given.get("frame") || state.frame);
  if (Number.isInteger(frame)) show(frame);
  const view = (given.get("view") || "").split(",").map(Number);
  if (view.length === 3 && view.every(Number.isFinite)) look(...view);
};
"""

_EVENTS = r"""
let playing = 0;
const stop = () => {
  clearInterval(playing);
  playing = 0;
  $("play").textContent = "Play";
  $("said").setAttribute("aria-live", "polite");
};
const play = () => {
  if (playing) return stop();
  const count = frames(layer());
  if (count < 2) return undefined;
  if (state.frame === count - 1) show(0);
  $("play").textContent = "Pause";
  $("said").setAttribute("aria-live", "off");
  playing = setInterval(() => {
    show(state.frame + 1);
    if (state.frame >= frames(layer()) - 1) stop();
  }, Math.min(400, Math.max(60, 8000 / count)));
  return undefined;
};
layers.forEach((one, i) => {
  const label = document.createElement("label"), input = document.createElement("input");
  Object.assign(input, { type: "radio", name: "layer", value: String(i) });
  input.addEventListener("change", () => { stop(); choose(i); });
  label.append(input, spoken(one));
  $("layers").append(label);
});
document.querySelectorAll('[name="unit"]').forEach((input) => {
  input.addEventListener("change", () => {
    state.celsius = input.value === "C";
    choose(state.layer);
  });
});
$("dotted").hidden = !readings;
$("dots").addEventListener("change", (event) => { state.dots = event.target.checked; later(); });
$("light").addEventListener("change", (event) => { state.light = event.target.checked; later(); });
$("reset").addEventListener("click", () => {
  state.shift = [0, 0];
  look(START.azimuth, START.elevation, 1);
});
$("frame").addEventListener("input", (event) => { stop(); show(Number(event.target.value)); });
$("play").addEventListener("click", play);
const TURNS = { ArrowLeft: [-10, 0], ArrowRight: [10, 0], ArrowUp: [0, 10], ArrowDown: [0, -10] };
document.addEventListener("keydown", (event) => {
  const inside = event.target.closest("fieldset, details, button, [type=checkbox]");
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const turn = TURNS[event.key], one = state;
  if (turn && event.shiftKey) look(one.azimuth + turn[0], one.elevation + turn[1], one.zoom);
  else if (event.key === "+" || event.key === "-")
    look(one.azimuth, one.elevation, one.zoom * (event.key === "+" ? 1.2 : 1 / 1.2));
  else if (turn && turn[0] && !event.target.closest("fieldset")) {
    stop();
    show(one.frame + Math.sign(turn[0]));
  } else if (event.key === " " && !inside) play();
  else return;
  event.preventDefault();
});
const held = new Map();
const middle = () => {
  const all = [...held.values()];
  const mean = (k) => all.reduce((sum, one) => sum + one[k], 0) / all.length;
  const [x, y] = [mean(0), mean(1)];
  return { x, y, wide: Math.hypot(all[0][0] - x, all[0][1] - y) };
};
canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  held.set(event.pointerId, [event.offsetX, event.offsetY]);
});
canvas.addEventListener("pointermove", (event) => {
  state.pointer = [event.offsetX, event.offsetY];
  if (held.has(event.pointerId)) {
    const before = middle();
    held.set(event.pointerId, state.pointer);
    const after = middle(), dx = after.x - before.x, dy = after.y - before.y;
    if (held.size > 1 || event.shiftKey || event.buttons & 2) {
      state.shift = [state.shift[0] - dx * size(), state.shift[1] + dy * size()];
      if (held.size > 1 && before.wide > 0)
        look(state.azimuth, state.elevation, state.zoom * after.wide / before.wide);
    } else look(state.azimuth - 0.4 * dx, state.elevation + 0.4 * dy, state.zoom);
  }
  later();
});
for (const name of ["pointerup", "pointercancel"])
  canvas.addEventListener(name, (event) => held.delete(event.pointerId));
canvas.addEventListener("pointerleave", (event) => {
  // A finger that was lifted leaves what it showed.
  if (event.pointerType !== "touch") state.pointer = null;
  later();
});
canvas.addEventListener("contextmenu", (event) => event.preventDefault());
canvas.addEventListener("wheel", (event) => {
  event.preventDefault();
  look(state.azimuth, state.elevation, state.zoom * Math.exp(-0.0015 * event.deltaY));
}, { passive: false });
canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
canvas.addEventListener("webglcontextrestored", () => { begin(); later(); });
window.addEventListener("hashchange", fromAddress);
// At once, for a canvas of a new size is empty or stretched until it is drawn.
new ResizeObserver(refresh).observe(canvas);
if (!begin()) {
  $("viewer").classList.add("undrawn");
  $("message").hidden = false;
  $("message").textContent = "This browser offers no WebGL 2, so the object is not drawn. "
    + "The smallest and the largest value at each time are told below.";
}
fromAddress();
draw();
document.documentElement.dataset.ready = "true";
"""

SCRIPT = f'"use strict";\n(() => {{{_DATA}{_WORDS}{SIGHT}{DRAWING}{_CONTROLS}{_EVENTS}}})();'
"""The whole program; it reads the data from the element `data` of the page."""
