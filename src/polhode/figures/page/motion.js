// The motion at any moment between its samples, and previews of others from another start.
"use strict";

// Cubic pieces that have the rates q' = q (0, w) / 2 at the samples.
class Motion {
  // data: what the page holds of the motion; numbers: attitude and omega a sample, seven of them.
  constructor(data, numbers) {
    Object.assign(this, data, {numbers});
    this.count = numbers.length / 7;
    this.step = (this.end - this.begin) / (this.count - 1);
    this.fastest = Math.max(...this.every(k => norm(this.w(k)))) || 1;
  }

  static of(data) {
    const bytes = Uint8Array.from(atob(data.samples), c => c.charCodeAt(0));
    return new Motion(data, new Float32Array(bytes.buffer));
  }

  q(k) { return this.numbers.subarray(7 * k, 7 * k + 4); }

  w(k) { return [...this.numbers.subarray(7 * k + 4, 7 * k + 7)]; }

  rate(k) { return quaternionRate(this.q(k), this.w(k)); }

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

  // Euler's angles of the axis that is followed, continuous in time.  Psi and phi are NaN at a pole,
  // and where they jump over one; behind it they are as near to their first value as can be.
  angles() {
    const [u, v] = across(this.apex), rows = [[], [], []], turn = 2 * Math.PI;
    const first = [], before = [];
    for (let k = 0; k < this.count; k++) {
      const q = this.q(k), [x, y, z] = rotate(q, this.apex);
      const g = rotate(conjugate(q), [0, 0, 1]), flat = Math.hypot(x, y);
      rows[0].push(Math.atan2(flat, z));
      [Math.atan2(x, -y), Math.atan2(dot(g, u), dot(g, v))].forEach((angle, i) => {
        let shown = NaN;
        if (flat > 1e-4) {
          if (first[i] === undefined) first[i] = before[i] = angle;
          const near = angle + turn * Math.round((before[i] - angle) / turn);
          const jumps = Math.abs(near - before[i]) > 2;
          const others = [near, near + turn, near - turn];
          others.sort((a, b) => Math.abs(a - first[i]) - Math.abs(b - first[i]));
          before[i] = jumps ? others[0] : near;
          if (!jumps) shown = near;
        }
        rows[i + 1].push(shown);
      });
    }
    return rows;
  }
}

function quaternionRate([a, b, c, d], [x, y, z]) {
  return [-b * x - c * y - d * z, a * x + c * z - d * y, a * y + d * x - b * z,
          a * z + b * y - c * x].map(v => v / 2);
}

const conjugate = q => [q[0], -q[1], -q[2], -q[3]];

// Two unit vectors across an axis, which make a right-handed frame with it; of z they are x and y.
function across(axis) {
  const u = unit(cross(Math.abs(axis[1]) < 0.9 ? [0, 1, 0] : [0, 0, 1], axis));
  return [u, cross(axis, u)];
}

// -- previews: I w' + w x I w = gamma x Mg r0, q' = q (0, w) / 2, by the classical Runge-Kutta method

const ANGLE = 0.04;        // radians a step, at the motion's own rate
const MOST_STEPS = 60000;
const DRIFT = 1e-5;        // of the energy, beyond which a preview is not shown

// A motion over the same times from another state at sample `start.sample`; null where that takes
// too many steps or keeps its energy too badly.
function preview(motion, attitude, omega) {
  const {inertia, inverse, weight, swing, count, begin, end, start} = motion;
  const apply = (rows, v) => rows.map(row => dot(row, v));
  const energy = y => dot(y.slice(4), apply(inertia, y.slice(4))) / 2
    + dot(weight, rotate(conjugate(y.slice(0, 4)), [0, 0, 1]));
  const field = y => {
    const q = y.slice(0, 4), w = y.slice(4), gamma = rotate(conjugate(q), [0, 0, 1]);
    const moment = minus(cross(gamma, weight), cross(w, apply(inertia, w)));
    return [...quaternionRate(q, w), ...apply(inverse, moment)];
  };
  const moved = (y, h, k) => y.map((x, i) => x + h * k[i]);
  const step = (y, h) => {
    const a = field(y), b = field(moved(y, h / 2, a)), c = field(moved(y, h / 2, b));
    const d = field(moved(y, h, c));
    const next = y.map((x, i) => x + h / 6 * (a[i] + 2 * b[i] + 2 * c[i] + d[i]));
    const size = Math.hypot(...next.slice(0, 4));
    return next.map((x, i) => i < 4 ? x / size : x);
  };
  const numbers = new Float32Array(7 * count), apart = (end - begin) / (count - 1);
  const first = [...attitude, ...omega], parts = y =>
    Math.ceil(apart * (norm(y.slice(4)) + swing) / ANGLE);
  const size = dot(omega, apply(inertia, omega)) / 2 + norm(weight);
  if (!(parts(first) * (count - 1) <= MOST_STEPS)) return null;
  let taken = 0;
  for (const sense of [1, -1]) {
    let y = first;
    for (let k = start.sample; ; k += sense) {
      numbers.set(y, 7 * k);
      if (k + sense < 0 || k + sense === count) break;
      const steps = parts(y);
      taken += steps;
      if (!(taken <= MOST_STEPS)) return null;
      for (let n = 0; n < steps; n++) y = step(y, sense * apart / steps);
    }
    if (!(Math.abs(energy(y) - energy(first)) <= DRIFT * size)) return null;
  }
  return new Motion(motion, numbers);
}

// What the path of a symmetric top looks like, by the constants of its motion (Lagrange's top): with
// u = cos theta, psi' = (F - n u) / (1 - u^2), and b, the u at which the axis would stand still.
function looks({inertia, weight, symmetric}, attitude, omega) {
  if (!symmetric) return "";
  const apply = v => inertia.map(row => dot(row, v)), axis = unit(weight), [x] = across(axis);
  const gamma = rotate(conjugate(attitude), [0, 0, 1]), A = dot(x, apply(x));
  const r = dot(omega, axis), n = dot(axis, apply(axis)) * r / A, a = 2 * norm(weight) / A;
  const u = dot(gamma, axis), w = minus(omega, scale(r, axis));
  const F = dot(w, gamma) + n * u, b = u + dot(w, w) / a, size = Math.abs(n) + Math.sqrt(a);
  const slope = 2 * n * dot(w, gamma) - a * (1 - u * u) - 2 * u * dot(w, w);
  const still = Math.abs(dot(cross(w, gamma), axis)) < 2e-3 * size;
  if (still && Math.abs(slope) < 5e-3 * (2 * n * n + a)) {  // which it nods by, about
    if (1 - u * u > 1e-5) return "The axis keeps its tilt, or nearly.";
    return u > 0 && n * n < 2 * a
      ? "The axis stands upright, but spins too slowly: the smallest push makes it fall."
      : "The axis stays vertical, or nearly.";
  }
  if (Math.abs(F) < 1e-3 * size && Math.abs(n) < 1e-3 * size) return "It swings in a plane.";
  if (Math.abs(F - n) < 2e-3 * size && b > 1 || Math.abs(F + n) < 2e-3 * size)
    return "The axis passes through the vertical, or close to it.";
  const ahead = Math.abs(F) < Math.abs(n) ? (F - n * b) * Math.sign(n) : Infinity;
  if (Math.abs(ahead) < 1e-3 * size) return "Its path has cusps, or nearly.";
  return ahead < 0 ? "Its path has loops." : "Its path is a wave.";
}

// Of a free body: the unit vector along its momentum, in space; the semi-axes of the ellipsoid of
// energy w.I w = 2T; and how far from the fixed point the plane is on which it rolls, 2T/|G|.
function poinsot(motion) {
  const w = motion.w(0), momentum = motion.inertia.map(row => dot(row, w));
  const twice = dot(w, momentum);
  return {upward: unit(rotate(motion.q(0), momentum)), height: twice / norm(momentum),
          semi: motion.moments.map(moment => Math.sqrt(twice / moment))};
}

// -- another start, by two numbers: of a heavy body the spin about the axis followed and its tilt
// from the vertical; of a free one the spin about an axis of inertia, and what is across it

class Start {
  constructor(motion) {
    this.motion = motion;
    const {free, attitude, omega} = Object.assign(this, motion.start);
    if (free) {
      const sizes = motion.axes.map(axis => Math.abs(dot(axis, omega)));
      const along = sizes.indexOf(Math.max(...sizes)), rest = minus(omega, scale(
        dot(motion.axes[along], omega), motion.axes[along]));
      this.axis = motion.axes[along];
      this.aside = norm(rest) > 1e-12 * norm(omega) ? unit(rest) : motion.axes[(along + 1) % 3];
      this.number = along + 1;
      this.second = dot(this.aside, omega);
    } else {
      this.axis = motion.apex;
      this.upward = rotate(attitude, this.axis);
      this.second = Math.atan2(Math.hypot(this.upward[0], this.upward[1]), this.upward[2]);
    }
    this.first = dot(this.axis, omega);
  }

  // Attitude and omega at that moment, for other values of the two numbers.
  at(first, second) {
    const w = plus(this.omega, scale(first - this.first, this.axis));
    if (this.free)
      return [this.attitude, plus(w, scale(second - this.second, this.aside))];
    const [x, y] = this.upward, flat = Math.hypot(x, y);
    const [c, s] = flat > 1e-12 ? [-y / flat, x / flat] : [1, 0];  // the horizontal line tilted about
    const half = (second - this.second) / 2, q = this.attitude;
    const [a, b, d] = [Math.cos(half), Math.sin(half) * c, Math.sin(half) * s];
    return [[a * q[0] - b * q[1] - d * q[2], a * q[1] + b * q[0] + d * q[3],
             a * q[2] - b * q[3] + d * q[0], a * q[3] + b * q[2] - d * q[1]], w];
  }
}
