// The motion: samples to any moment between, two views of it, and the controls under them.
"use strict";

const BLUE = [0, 0.447, 0.698, 1], ORANGE = [0.835, 0.369, 0, 1], GREEN = [0, 0.62, 0.451, 1];
const GREY = [0.5, 0.5, 0.5, 1], DARK = [0.3, 0.3, 0.33, 1];
const faint = (colour, alpha) => [...colour.slice(0, 3), alpha];

// -- the motion at any time: cubic pieces that have the rates q' = q (0, w) / 2 at the samples

class Motion {
  constructor(told) {
    Object.assign(this, told);
    const bytes = Uint8Array.from(atob(told.samples), c => c.charCodeAt(0));
    this.numbers = new Float32Array(bytes.buffer);
    this.count = this.numbers.length / 7;
    this.step = (this.end - this.begin) / (this.count - 1);
  }

  q(k) { return this.numbers.subarray(7 * k, 7 * k + 4); }

  w(k) { return [...this.numbers.subarray(7 * k + 4, 7 * k + 7)]; }

  rate(k) {
    const [a, b, c, d] = this.q(k), [x, y, z] = this.w(k);
    return [-b * x - c * y - d * z, a * x + c * z - d * y, a * y + d * x - b * z,
            a * z + b * y - c * x].map(v => v / 2);
  }

  // The number of samples before t, the part of a sample between them.
  place(t) {
    const k = Math.min(this.count - 2, Math.max(0, Math.floor((t - this.begin) / this.step)));
    return [k, Math.min(1, Math.max(0, (t - this.begin) / this.step - k))];
  }

  attitude(t) {
    const [k, s] = this.place(t), h = this.step;
    const [p, r] = [this.q(k), this.q(k + 1)], [dp, dr] = [this.rate(k), this.rate(k + 1)];
    const a = (1 + 2 * s) * (1 - s) ** 2, b = s * (1 - s) ** 2 * h;
    const c = s * s * (3 - 2 * s), d = s * s * (s - 1) * h;
    const q = [0, 1, 2, 3].map(i => a * p[i] + b * dp[i] + c * r[i] + d * dr[i]);
    const size = Math.hypot(...q);
    return q.map(x => x / size);
  }

  // omega in the body: the cubic through four samples.
  omega(t) {
    const [k, s] = this.place(t), last = this.count - 1;
    const [a, b, c, d] = [k - 1, k, k + 1, k + 2].map(i => this.w(Math.min(last, Math.max(0, i))));
    return [0, 1, 2].map(i => b[i] + s / 2 * (c[i] - a[i] + s * (2 * a[i] - 5 * b[i] + 4 * c[i]
      - d[i] + s * (3 * (b[i] - c[i]) + d[i] - a[i]))));
  }

  every(what) { return Array.from({length: this.count}, (_, k) => what(k)); }
}

// -- pieces of pictures

function ring(n, at) { return Array.from({length: n + 1}, (_, k) => at(2 * Math.PI * k / n)); }

function graticule(painter) {
  const lines = [];
  for (const lat of [-60, -30, 0, 30, 60].map(x => x * Math.PI / 180))
    lines.push(ring(72, a => [Math.cos(lat) * Math.cos(a), Math.cos(lat) * Math.sin(a),
                              Math.sin(lat)]));
  for (let k = 0; k < 6; k++) {
    const a = k * Math.PI / 6;
    lines.push(ring(72, b => [Math.cos(b) * Math.cos(a), Math.cos(b) * Math.sin(a), Math.sin(b)]));
  }
  return lines.map(line => painter.curve(line));
}

// A matrix that takes the third axis along a vector, for arrow heads and parts.
function along(direction, at = [0, 0, 0], size = 1) {
  const z = unit(direction), x = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z));
  return frame(scale(size, x), scale(size, cross(z, x)), scale(size, z), at);
}

// The solid of a part of the body, and where it is; lengths in units of `size`.
function partOf(part, size) {
  const k = 1 / size, r = (part.radius || 0) * k, h = (part.height || 0) * k;
  const inner = (part.inner || 0) * k, solid = new Solid();
  const tube = (inside, outside, low, high) => solid.revolve(
    [[inside, low], [outside, low], [outside, high], [inside, high], [inside, low]]);
  if (part.shape === "box") solid.box(part.size.map(x => x * k));
  else if (part.shape === "ellipsoid") solid.ellipsoid(part.semi_axes.map(x => x * k));
  else if (part.shape === "sphere") solid.ellipsoid([r, r, r]);
  else if (part.shape === "cone") solid.revolve([[0, 0], [r, h], [0, h]]);
  else if (part.shape === "rod") tube(0, 0.012, -h / 2, h / 2);
  else if (part.shape === "point") solid.ellipsoid([0.05, 0.05, 0.05], 12);
  else { const thick = Math.max(h, 0.02); tube(Math.min(inner, r - 0.008), r, -thick / 2, thick / 2); }
  const place = scale(k, part.at), axis = part.axis;
  const set = /x|y/.test(axis) || axis.startsWith("-") ? along(part.direction, place)
    : frame([1, 0, 0], [0, 1, 0], [0, 0, 1], place);
  return {solid, place: set};
}

class View {
  constructor(canvas, camera) {
    this.canvas = canvas;
    this.painter = new Painter(canvas);
    this.home = camera;
    this.camera = {...camera};
    const painter = this.painter;
    this.tip = painter.solid(new Solid().revolve([[0, 0], [0.032, 0], [0, 0.11]], 24, 1));
    this.dot = painter.solid(new Solid().ellipsoid([0.028, 0.028, 0.028], 10, 1));
    this.segment = painter.curve([[0, 0, 0], [0, 0, 1]]);
    this.listen();
  }

  arrow(vector, colour, width = 2.5) {
    const size = norm(vector);
    if (size < 1e-6) return;
    const head = Math.min(0.11, size), shaft = along(vector, [0, 0, 0], size - head * 0.8);
    this.painter.drawCurve(this.segment, shaft, colour, width);
    const at = scale((size - head) / size, vector);
    this.painter.drawSolid(this.tip, along(vector, at, head / 0.11), colour);
  }

  mark(place, colour) {
    this.painter.drawSolid(this.dot, frame([1, 0, 0], [0, 1, 0], [0, 0, 1], place), colour);
  }

  // Drag to turn, wheel or two fingers to come nearer, double click to go back.
  listen() {
    const fingers = new Map();
    let apart = 0;
    const spread = () => {
      const [a, b] = [...fingers.values()];
      return Math.hypot(a[0] - b[0], a[1] - b[1]);
    };
    const nearer = factor => {
      this.camera.distance = Math.min(20, Math.max(2, this.camera.distance * factor));
    };
    this.canvas.addEventListener("pointerdown", event => {
      this.canvas.setPointerCapture(event.pointerId);
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      apart = fingers.size === 2 ? spread() : 0;
    });
    this.canvas.addEventListener("pointermove", event => {
      const before = fingers.get(event.pointerId);
      if (!before) return;
      fingers.set(event.pointerId, [event.clientX, event.clientY]);
      if (fingers.size === 2) {
        const now = spread();
        nearer(apart / now);
        apart = now;
      } else {
        this.camera.azimuth -= 0.008 * (event.clientX - before[0]);
        const risen = this.camera.elevation + 0.008 * (event.clientY - before[1]);
        this.camera.elevation = Math.min(1.55, Math.max(-1.55, risen));
      }
      redraw();
    });
    for (const name of ["pointerup", "pointercancel"])
      this.canvas.addEventListener(name, event => fingers.delete(event.pointerId));
    this.canvas.addEventListener("wheel", event => {
      event.preventDefault();
      nearer(Math.exp(0.001 * event.deltaY));
      redraw();
    }, {passive: false});
    this.canvas.addEventListener("dblclick", () => { this.camera = {...this.home}; redraw(); });
  }
}

// The body, the vertical, and the apex' path on the sphere about the fixed point.
class BodyView extends View {
  constructor(canvas, motion) {
    super(canvas, {azimuth: 0.9, elevation: 0.32, distance: 5.0});
    this.motion = motion;
    const painter = this.painter;
    this.lines = graticule(painter);
    this.globe = painter.solid(new Solid().ellipsoid([1, 1, 1], 32, 1));
    this.path = painter.curve(motion.every(k => rotate(motion.q(k), motion.apex)));
    const axes = frame(...motion.axes);
    this.parts = motion.parts.length
      ? motion.parts.map(part => partOf(part, motion.size))
      : [{solid: new Solid().ellipsoid(motion.semi), place: axes}];
    this.parts = this.parts.map(({solid, place}) => ({made: painter.solid(solid), place}));
  }

  draw(t, shown) {
    const {painter, motion} = this, q = motion.attitude(t), turn = turned(q);
    const apex = rotate(q, motion.apex), now = (t - motion.begin) / motion.step;
    painter.begin(this.camera, [0, 0, 0.06]);
    for (const {made, place} of this.parts) painter.drawSolid(made, times(turn, place), BLUE);
    this.arrow([0, 0, 1.3], DARK, 1.8);
    this.mark([0, 0, 0], DARK);
    painter.drawCurve(this.segment, along(apex), ORANGE, 2.2);
    this.mark(apex, ORANGE);
    if (motion.centre) this.mark(rotate(q, motion.centre), DARK);
    if (shown.omega) this.arrow(scale(1.15 / motion.fastest, rotate(q, motion.omega(t))), GREEN);
    if (shown.sphere)
      for (const line of this.lines) painter.drawCurve(line, IDENTITY, faint(GREY, 0.28), 1);
    if (shown.path) {
      painter.drawCurve(this.path, IDENTITY, faint(ORANGE, 0.3), 1.6);
      painter.drawCurve(this.path, IDENTITY, ORANGE, 2.6, now);
    }
    if (shown.sphere) painter.drawSolid(this.globe, IDENTITY, faint(GREY, 0.07));
  }
}

// Poinsot: what omega describes in the body rolls upon what it describes in space.
class RollingView extends View {
  constructor(canvas, motion) {
    super(canvas, {azimuth: 0.7, elevation: motion.free ? 0.4 : 0.35, distance: 5.0});
    this.motion = motion;
    const painter = this.painter, small = 1 / motion.fastest;
    this.level = IDENTITY;
    if (motion.free) {  // the momentum downwards, so that the body rolls upon the plane
      const z = scale(-1, motion.momentum);
      const x = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z)), y = cross(z, x);
      this.level = frame([x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]);
      this.ellipsoid = painter.solid(new Solid().ellipsoid(scale(small, motion.energy)));
      const wide = 1.15 * Math.max(...motion.every(k => this.across(motion.w(k))), 0.35);
      this.rim = painter.curve(ring(96, a => [wide * Math.cos(a), wide * Math.sin(a), 0]));
      this.plane = painter.solid(new Solid().revolve([[0, 0], [wide, 0]], 64, 1));
      this.floor = frame([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -motion.height * small]);
    }
    const inBody = motion.every(k => scale(small, motion.w(k)));
    const inSpace = motion.every(k => scale(small, rotate(motion.q(k), motion.w(k))));
    this.body = painter.curve(inBody);
    this.space = painter.curve(inSpace);
    this.cones = motion.free ? []
      : [inBody, inSpace].map(points => painter.solid(new Solid().fan(points)));
  }

  // The cones about this moment, which touch along omega: as far as half a turn each way.
  drawCones(now, turn) {
    const {painter, motion} = this, count = motion.count - 1;
    const far = Math.ceil(3 / (motion.fastest * motion.step));
    const first = Math.max(0, Math.floor(now) - far), last = Math.min(count, Math.floor(now) + far);
    [[turn, BLUE], [this.level, ORANGE]].forEach(([model, colour], k) =>
      painter.drawSolid(this.cones[k], model, faint(colour, 0.22), 3 * first, 3 * (last - first)));
  }

  // How far from the momentum's axis omega is, in units of the largest.
  across(w) {
    const {fastest, height} = this.motion;
    return Math.sqrt(Math.max(0, dot(w, w) - height * height)) / fastest;
  }

  draw(t) {
    const {painter, motion} = this, q = motion.attitude(t);
    const turn = times(this.level, turned(q)), now = (t - motion.begin) / motion.step;
    painter.begin(this.camera, [0, 0, motion.free ? -0.25 : 0]);
    const axes = frame(...motion.axes);
    const w = scale(1 / motion.fastest, rotate(q, motion.omega(t)));
    const [x, y, z] = [0, 1, 2].map(i => dot([0, 1, 2].map(j => this.level[4 * j + i]), w));
    this.mark([0, 0, 0], DARK);
    this.arrow([x, y, z], GREEN);
    this.mark([x, y, z], GREEN);
    if (!motion.free) this.arrow([0, 0, 1.25], DARK, 1.8);
    painter.drawCurve(this.space, this.level, faint(ORANGE, 0.3), 1.6);
    painter.drawCurve(this.space, this.level, ORANGE, 2.6, now);
    painter.drawCurve(this.body, turn, BLUE, 2.2);
    if (motion.free) {
      painter.drawSolid(this.ellipsoid, times(turn, axes), faint(BLUE, 0.5));
      painter.drawSolid(this.plane, this.floor, faint(GREY, 0.3));
      painter.drawCurve(this.rim, this.floor, faint(GREY, 0.8), 1.2);
    } else {
      this.drawCones(now, turn);
    }
  }
}

// -- controls

const part = id => document.getElementById(id);
let motion, views, time, playing, before = 0, wanted = true;
const shown = {};

function redraw() { wanted = true; }

function tell() {
  const q = motion.attitude(time), w = norm(motion.omega(time));
  const tilt = Math.acos(Math.min(1, Math.max(-1, rotate(q, motion.apex)[2])));
  part("now").textContent = `t = ${time.toFixed(motion.places)}`;
  part("state").textContent =
    `|ω| = ${w.toPrecision(4)},  ${motion.tilted} ${(tilt * 180 / Math.PI).toFixed(1)}°`;
  part("time").value = time;
}

function speed() { return motion.pace * 2 ** Number(part("speed").value); }

function tellSpeed() { part("pace").textContent = `1 s shows ${speed().toPrecision(2)} of t`; }

function play(on) {
  playing = on;
  part("play").textContent = on ? "❚❚" : "▶";
  part("play").setAttribute("aria-label", on ? "pause" : "play");
  redraw();
}

function draw() {
  wanted = false;
  for (const view of views) view.draw(time, shown);
  tell();
}

let frames = 0, since = 0;

function tick(now) {
  const passed = Math.min(0.1, (now - before) / 1000);
  before = now;
  if (playing) {
    time += passed * speed();
    if (time > motion.end) time = motion.begin;
    wanted = true;
  }
  if (wanted) draw();
  frames += 1;
  if (now - since > 1000) {  // for whoever asks how smooth it is
    document.documentElement.dataset.frames = Math.round(1000 * frames / (now - since));
    frames = 0;
    since = now;
  }
  requestAnimationFrame(tick);
}

function start() {
  motion = new Motion(JSON.parse(part("motion").textContent));
  try {
    views = [new BodyView(part("body"), motion), new RollingView(part("rolling"), motion)];
  } catch (fault) {
    part("fault").textContent = `Nothing can be drawn here: ${fault.message}.`;
    part("fault").hidden = false;
    return;
  }
  const hash = new URLSearchParams(location.hash.slice(1));  // #t=3&play=0: a moment to link to
  time = hash.has("t") ? Number(hash.get("t")) : motion.begin;
  const slider = part("time");
  Object.assign(slider, {min: motion.begin, max: motion.end, step: "any"});
  slider.addEventListener("input", () => { time = Number(slider.value); redraw(); });
  part("speed").addEventListener("input", tellSpeed);
  part("play").addEventListener("click", () => play(!playing));
  for (const name of ["path", "omega", "sphere"]) {
    shown[name] = part(name).checked;
    part(name).addEventListener("change", () => { shown[name] = part(name).checked; redraw(); });
  }
  document.addEventListener("keydown", event => {
    if (event.key !== " " || event.target.tagName === "BUTTON") return;
    event.preventDefault();
    play(!playing);
  });
  window.addEventListener("resize", redraw);
  tellSpeed();
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  play(hash.get("play") !== "0" && !still);
  draw();  // the first moment does not wait for a frame, which a hidden page may never have
  requestAnimationFrame(now => { before = since = now; tick(now); });
}

start();
