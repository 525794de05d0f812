// Two views of a motion: the body about the fixed point, and the cones of omega that roll.
"use strict";

const BLUE = [0, 0.447, 0.698, 1], ORANGE = [0.835, 0.369, 0, 1], GREEN = [0, 0.62, 0.451, 1];
const GREY = [0.5, 0.5, 0.5, 1];
const DARK = matchMedia("(prefers-color-scheme: dark)").matches
  ? [0.75, 0.75, 0.78, 1] : [0.3, 0.3, 0.33, 1];
const faint = (colour, alpha) => [...colour.slice(0, 3), alpha];

function ring(n, at) { return Array.from({length: n + 1}, (_, k) => at(2 * Math.PI * k / n)); }

function graticule() {
  const lines = [];
  for (const lat of [-60, -30, 0, 30, 60].map(x => x * Math.PI / 180))
    lines.push(ring(60, a => [Math.cos(lat) * Math.cos(a), Math.cos(lat) * Math.sin(a),
                              Math.sin(lat)]));
  for (let k = 0; k < 6; k++) {
    const a = k * Math.PI / 6;
    lines.push(ring(60, b => [Math.cos(b) * Math.cos(a), Math.cos(b) * Math.sin(a), Math.sin(b)]));
  }
  return lines;
}

// A matrix that takes the third axis along a vector, for arrow heads and shafts.
function along(direction, at = [0, 0, 0], size = 1) {
  const z = unit(direction), x = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z));
  return frame(scale(size, x), scale(size, cross(z, x)), scale(size, z), at);
}

class View {
  constructor(canvas, painter, camera) {
    Object.assign(this, {canvas, painter});
    this.home = camera;
    this.camera = {...camera};
    this.tip = painter.solid(new Solid().revolve([[0, 0], [0.032, 0], [0, 0.11]], 16, 1));
    this.dot = painter.solid(new Solid().ellipsoid([0.028, 0.028, 0.028], 10, 1));
    this.segment = painter.curve([[0, 0, 0], [0, 0, 1]]);
    this.drawn = {};
    this.listen();
  }

  // Curves and solids made of a motion, in place of those made before.
  make(made) {
    for (const [name, thing] of Object.entries(made)) {
      if (this.drawn[name]) this.painter.free(this.drawn[name]);
      this.drawn[name] = thing;
    }
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

// The body, the vertical, and the path on the sphere about the fixed point; behind a preview, in
// grey, the path and the axis of polhode's own motion.
class BodyView extends View {
  constructor(canvas, painter, motion) {
    super(canvas, painter, {azimuth: 0.9, elevation: 0.32, distance: 5.0});
    this.own = motion;
    this.lines = painter.lines(graticule());
    this.globe = painter.solid(new Solid().ellipsoid([1, 1, 1], SLOW ? 12 : 24));
    this.parts = motion.solids.map(told => {
      const {solid, place} = solidOf(told);
      return {made: painter.solid(solid), place};
    });
    this.ownPath = this.pathOf(motion);
    this.show(motion);
  }

  pathOf(motion) {
    return this.painter.curve(motion.every(k => rotate(motion.q(k), motion.apex)));
  }

  show(motion) {
    this.motion = motion;
    this.make({path: this.pathOf(motion)});
  }

  draw(t, shown) {
    const {painter, motion} = this, q = motion.attitude(t), turn = turned(q);
    const apex = rotate(q, motion.apex), now = (t - motion.begin) / motion.step;
    painter.begin(this.canvas, this.camera, [0, 0, 0.06]);
    for (const {made, place} of this.parts) painter.drawSolid(made, times(turn, place), BLUE);
    this.arrow([0, 0, 1.3], DARK, 1.8);
    this.mark([0, 0, 0], DARK);
    if (motion !== this.own) {
      const other = rotate(this.own.attitude(t), motion.apex);
      painter.drawCurve(this.ownPath, IDENTITY, faint(GREY, 0.75), 1.6, now, faint(GREY, 0.25));
      painter.drawCurve(this.segment, along(other), faint(GREY, 0.9), 1.8);
      this.mark(other, GREY);
    }
    painter.drawCurve(this.segment, along(apex), ORANGE, 2.2);
    this.mark(apex, ORANGE);
    if (motion.centre) this.mark(rotate(q, motion.centre), DARK);
    if (shown.omega) this.arrow(scale(1.15 / motion.fastest, rotate(q, motion.omega(t))), GREEN);
    if (shown.sphere) painter.drawCurve(this.lines, IDENTITY, faint(GREY, 0.28));
    if (shown.path)
      painter.drawCurve(this.drawn.path, IDENTITY, ORANGE, 2.6, now, faint(ORANGE, 0.3));
    if (shown.sphere) painter.drawSolid(this.globe, IDENTITY, faint(GREY, 0.07));
    painter.copy(this.canvas);
  }
}

// Poinsot: what omega describes in the body rolls upon what it describes in space.
class RollingView extends View {
  constructor(canvas, painter, motion) {
    super(canvas, painter, {azimuth: 0.7, elevation: motion.poinsot ? 0.4 : 0.35, distance: 5.0});
    this.show(motion);
  }

  show(motion) {
    this.motion = motion;
    const {painter} = this, small = 1 / motion.fastest, free = motion.poinsot;
    this.level = IDENTITY;
    if (free) {
      // the momentum downwards, so that the body rolls upon the plane
      const {upward, height, semi} = poinsot(motion), z = scale(-1, upward);
      const x = unit(cross(Math.abs(z[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0], z)), y = cross(z, x);
      this.level = frame([x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]);
      this.height = height;
      const wide = 1.15 * Math.max(...motion.every(k => this.across(motion.w(k))), 0.35);
      this.floor = frame([1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -this.height * small]);
      this.make({
        ellipsoid: painter.solid(new Solid().ellipsoid(scale(small, semi))),
        rim: painter.curve(ring(96, a => [wide * Math.cos(a), wide * Math.sin(a), 0])),
        plane: painter.solid(new Solid().revolve([[0, 0], [wide, 0]], 48, 1)),
      });
    }
    const inBody = motion.every(k => scale(small, motion.w(k)));
    const inSpace = motion.every(k => scale(small, rotate(motion.q(k), motion.w(k))));
    this.make({body: painter.curve(inBody), space: painter.curve(inSpace)});
    if (!free)
      this.make({bodyCone: painter.solid(new Solid().fan(inBody)),
                 spaceCone: painter.solid(new Solid().fan(inSpace))});
  }

  // The cones about this moment, which touch along omega: as far as half a turn each way.
  drawCones(now, turn) {
    const {painter, motion, drawn} = this, count = motion.count - 1;
    const far = Math.ceil(3 / (motion.fastest * motion.step));
    const first = Math.max(0, Math.floor(now) - far), last = Math.min(count, Math.floor(now) + far);
    for (const [cone, model, colour] of
         [[drawn.bodyCone, turn, BLUE], [drawn.spaceCone, this.level, ORANGE]])
      painter.drawSolid(cone, model, faint(colour, 0.22), 3 * first, 3 * (last - first));
  }

  // How far from the momentum's axis omega is, in units of the largest.
  across(w) {
    return Math.sqrt(Math.max(0, dot(w, w) - this.height * this.height)) / this.motion.fastest;
  }

  draw(t) {
    const {painter, motion, drawn} = this, free = motion.poinsot;
    const q = motion.attitude(t), turn = times(this.level, turned(q));
    const now = (t - motion.begin) / motion.step;
    painter.begin(this.canvas, this.camera, [0, 0, free ? -0.25 : 0]);
    const w = scale(1 / motion.fastest, rotate(q, motion.omega(t)));
    const [x, y, z] = [0, 1, 2].map(i => dot([0, 1, 2].map(j => this.level[4 * j + i]), w));
    this.mark([0, 0, 0], DARK);
    this.arrow([x, y, z], GREEN);
    this.mark([x, y, z], GREEN);
    if (!free) this.arrow([0, 0, 1.25], DARK, 1.8);
    painter.drawCurve(drawn.space, this.level, ORANGE, 2.6, now, faint(ORANGE, 0.3));
    painter.drawCurve(drawn.body, turn, BLUE, 2.2);
    if (free) {
      painter.drawSolid(drawn.ellipsoid, times(turn, frame(...motion.axes)), faint(BLUE, 0.5));
      painter.drawSolid(drawn.plane, this.floor, faint(GREY, 0.3));
      painter.drawCurve(drawn.rim, this.floor, faint(GREY, 0.8), 1.2);
    } else {
      this.drawCones(now, turn);
    }
    painter.copy(this.canvas);
  }
}
