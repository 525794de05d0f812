// Three angles over the time, one below the other, with a line at the moment shown.
"use strict";

const TURNS = 4;   // more turns than these are counted in turns, fewer in degrees
const ASIDE = 72;  // pixels to the right of the curves, for their ranges

class Curves {
  // place: the element with a canvas, a line for the moment, and a label for each angle.
  constructor(place) {
    this.canvas = place.querySelector("canvas");
    this.line = place.querySelector(".moment");
    this.labels = [...place.querySelectorAll(".angle span")];
  }

  show(motion, own) {
    this.motion = motion;
    this.rows = motion.angles();
    this.others = motion === own ? null : own.angles();
    this.ranges = this.rows.map((row, i) => {
      const seen = [...row, ...(this.others ? this.others[i] : [])].filter(Number.isFinite);
      const [low, high] = [Math.min(...seen, Infinity), Math.max(...seen, -Infinity)];
      const least = 0.02, gap = Math.max(0, least - (high - low)) / 2;  // what stands still is a line
      return seen.length ? [low - gap, high + gap] : [0, 1];
    });
    this.draw();
  }

  get width() { return this.canvas.clientWidth - ASIDE; }

  draw() {
    const {canvas, motion, width: wide} = this, ratio = window.devicePixelRatio || 1;
    const [w, h] = [canvas.clientWidth, canvas.clientHeight];
    canvas.width = Math.round(w * ratio);
    canvas.height = Math.round(h * ratio);
    const pen = canvas.getContext("2d"), style = getComputedStyle(canvas);
    pen.scale(ratio, ratio);
    this.rows.forEach((row, i) => {
      const [low, high] = this.ranges[i], tall = h / 3, top = i * tall + 20, deep = tall - 26;
      const y = angle => top + deep * (high - angle) / (high - low);
      pen.strokeStyle = style.getPropertyValue("--line");
      pen.lineWidth = 1;
      pen.strokeRect(0.5, i * tall + 0.5, w - 1, tall - 1);
      const curve = (values, colour, width) => {
        pen.beginPath();
        let on = false;
        values.forEach((angle, k) => {
          const x = wide * k / (motion.count - 1);
          if (Number.isFinite(angle)) pen[on ? "lineTo" : "moveTo"](x, y(angle));
          on = Number.isFinite(angle);
        });
        pen.strokeStyle = colour;
        pen.lineWidth = width;
        pen.stroke();
      };
      if (this.others) curve(this.others[i], "#888888", 1);
      curve(row, i ? (i === 1 ? "#0072b2" : "#009e73") : "#d55e00", 1.5);
      pen.fillStyle = style.getPropertyValue("--quiet");
      pen.font = "11px system-ui, sans-serif";
      pen.textAlign = "right";
      pen.fillText(told(high, i, low, high), w - 6, i * tall + 14);
      pen.fillText(told(low, i, low, high), w - 6, (i + 1) * tall - 6);
    });
  }

  at(t) {
    const {motion} = this, k = motion.place(t).reduce((n, s) => n + s), near = Math.round(k);
    this.line.style.transform = `translateX(${k / (motion.count - 1) * this.width}px)`;
    this.labels.forEach((label, i) => {
      label.textContent = told(this.rows[i][near], i, ...this.ranges[i]);
    });
  }
}

// An angle as it is printed: the tilt in degrees, what goes round in turns where these are many.
function told(angle, row, low, high) {
  if (!Number.isFinite(angle)) return "not shown: at a pole, or rows too far apart";
  const turns = row > 0 && high - low > 2 * Math.PI * TURNS;
  return turns ? `${(angle / 2 / Math.PI).toFixed(2)} turns` : `${(angle * 180 / Math.PI).toFixed(1)}°`;
}
