// What the page's buttons and sliders do, and the clock.
"use strict";

const part = id => document.getElementById(id);
const SMOOTH = 25;    // frames a second below which less is drawn
const COARSE = 0.5;   // pixels drawn for one of the screen, in each direction, at the least
let own, motion, start, views, curves, time, playing, before = 0, wanted = true;
const shown = {};

function redraw() { wanted = true; }

function tell() {
  part("now").textContent = `t = ${time.toFixed(motion.places)}${own.si ? " s" : ""}`;
  part("state").textContent = `|ω| = ${norm(motion.omega(time)).toPrecision(4)}${rate()}`;
  part("time").value = time;
  curves.at(time);
}

function speed() { return motion.pace * 2 ** Number(part("speed").value); }

const rate = () => own.si ? " rad/s" : "";

function tellSpeed() {
  part("pace").textContent = `1 s shows ${speed().toPrecision(2)} ${own.si ? "s" : "of t"}`;
}

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

// -- another start

function show(next) {
  motion = next;
  for (const view of views) view.show(motion);
  curves.show(motion, own);
  redraw();
}

const degrees = angle => `${(angle * 180 / Math.PI).toFixed(1)}°`;

function tellStart() {
  const [first, second] = ["first", "second"].map(id => Number(part(id).value));
  part("first-now").textContent = first.toPrecision(4) + rate();
  part("second-now").textContent = start.free ? second.toPrecision(4) + rate() : degrees(second);
  for (const id of ["first", "second"])
    part(id).setAttribute("aria-valuetext", part(`${id}-now`).textContent);
  return [first, second];
}

function tryStart() {
  const [first, second] = tellStart(), [attitude, omega] = start.at(first, second);
  const next = preview(own, attitude, omega);
  part("preview").hidden = false;
  part("shown").hidden = next === null;
  part("refused").hidden = next !== null;
  const seen = looks(own, attitude, omega);
  part("explained").textContent = next === null ? own.words : `A preview of another start. ${seen}`;
  const row = numbers => numbers.map(x => Number(x.toPrecision(12))).join(", ");
  const turn = attitude.map(x => Number(x.toFixed(12)));
  part("numbers").textContent = (start.t === 0 ? "" : `# at t = ${start.t}\n`)
    + `omega = [${row(omega)}]\nquaternion = [${turn.join(", ")}]\nnormalise = true`;
  show(next === null ? own : next);
}

function backToScene() {
  part("first").value = start.first;
  part("second").value = start.second;
  tellStart();
  part("preview").hidden = true;
  part("explained").textContent = own.words;
  show(own);
}

// -- the clock

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
  if (now - since > 1000) {
    const smooth = 1000 * frames / (now - since);
    document.documentElement.dataset.frames = Math.round(smooth);  // for whoever asks
    if (playing && smooth < SMOOTH) less();
    frames = 0;
    since = now;
  }
  requestAnimationFrame(tick);
}

// Fewer pixels where frames come slowly.
function less() {
  if (!views.length) return;
  const [{painter}] = views;
  painter.detail = Math.max(COARSE, 0.7 * painter.detail);
}

function begin() {
  own = motion = Motion.of(JSON.parse(part("motion").textContent));
  start = new Start(own);
  curves = new Curves(part("angles"));
  try {
    const painter = new Painter();
    views = [["body", BodyView], ["rolling", RollingView]].map(
      ([name, View]) => new View(part(name), painter, own));
    painter.canvas.addEventListener("webglcontextlost", () => {
      part("fault").textContent = "The browser gave this page's pictures up; load it again.";
      part("fault").hidden = false;
    });
  } catch (fault) {
    part("fault").textContent = `Nothing can be drawn here: ${fault.message}.`;
    part("fault").hidden = false;
    views = [];
  }
  const hash = new URLSearchParams(location.hash.slice(1));  // #t=3&play=0: a moment to link to
  const asked = hash.has("t") ? Number(hash.get("t")) : own.begin;
  time = Number.isFinite(asked) ? Math.min(own.end, Math.max(own.begin, asked)) : own.begin;
  const slider = part("time");
  Object.assign(slider, {min: own.begin, max: own.end, step: "any"});
  slider.addEventListener("input", () => { time = Number(slider.value); redraw(); });
  part("speed").addEventListener("input", tellSpeed);
  part("play").addEventListener("click", () => play(!playing));
  for (const name of ["path", "omega", "sphere"]) {
    shown[name] = part(name).checked;
    part(name).addEventListener("change", () => { shown[name] = part(name).checked; redraw(); });
  }
  beginStart();
  beginCurves();
  document.addEventListener("keydown", event => {
    if (event.key !== " " || event.target.matches("button, summary, [type=checkbox]")) return;
    event.preventDefault();
    play(!playing);
  });
  window.addEventListener("resize", () => { curves.draw(); redraw(); });
  tellSpeed();
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  play(hash.get("play") !== "0" && !still);
  draw();  // the first moment does not wait for a frame, which a hidden page may never have
  requestAnimationFrame(now => { before = since = now; tick(now); });
}

// The two sliders of the start, and the way back.
function beginStart() {
  const most = 2 * Math.max(norm(start.omega), own.swing) || 1;
  Object.assign(part("first"), {min: -most, max: most, step: "any", value: start.first});
  const ends = start.free ? [-most / 2, most / 2] : [0, Math.PI];
  Object.assign(part("second"), {min: ends[0], max: ends[1], step: "any", value: start.second});
  tellStart();
  for (const id of ["first", "second"]) part(id).addEventListener("input", tryStart);
  part("back").addEventListener("click", backToScene);
}

// A finger on the curves moves the time.
function beginCurves() {
  const canvas = curves.canvas, to = event => {
    const at = (event.clientX - canvas.getBoundingClientRect().left) / curves.width;
    const s = Math.min(1, Math.max(0, at));
    time = own.begin + s * (own.end - own.begin);
    redraw();
  };
  canvas.addEventListener("pointerdown", event => {
    canvas.setPointerCapture(event.pointerId);
    to(event);
  });
  canvas.addEventListener("pointermove", event => { if (event.buttons) to(event); });
  curves.show(own, own);
}

begin();
