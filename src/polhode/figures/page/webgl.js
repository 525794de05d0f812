// Drawing in space: small matrices, solids as triangles, curves as ribbons of pixels; WebGL 2 alone.
"use strict";

// -- vectors, quaternions (scalar first), matrices (columns one after the other, as WebGL has them)

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scale = (s, a) => [s * a[0], s * a[1], s * a[2]];
const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const norm = a => Math.hypot(...a);
const unit = a => scale(1 / (norm(a) || 1), a);

// R(q) v of a quaternion of any length: body to space.
function rotate(q, v) {
  const u = [q[1], q[2], q[3]], square = q[0] * q[0] + dot(u, u), half = cross(u, v);
  return plus(v, scale(2 / square, plus(scale(q[0], half), cross(u, half))));
}

// The matrix whose columns are the images of the axes, and where the origin goes.
function frame(x, y, z, at = [0, 0, 0]) {
  return new Float32Array([...x, 0, ...y, 0, ...z, 0, ...at, 1]);
}

const IDENTITY = frame([1, 0, 0], [0, 1, 0], [0, 0, 1]);
const turned = q => frame(rotate(q, [1, 0, 0]), rotate(q, [0, 1, 0]), rotate(q, [0, 0, 1]));

function times(a, b) {
  const c = new Float32Array(16);
  for (let i = 0; i < 4; i++)
    for (let j = 0; j < 4; j++)
      for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

// Whether the processor draws, for want of a graphics card: then edges are not smoothed.
const SLOW = (() => {
  const gl = document.createElement("canvas").getContext("webgl2");
  const told = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = told ? gl.getParameter(told.UNMASKED_RENDERER_WEBGL) : "";
  const release = gl && gl.getExtension("WEBGL_lose_context");
  if (release) release.loseContext();  // a browser has few contexts for all its pages
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
})();

// -- what is drawn with

const SOLID_SHADERS = [`#version 300 es
  in vec3 place; in vec3 normal; in float tone;
  uniform mat4 seen, onto;
  out vec3 side; out float which; out vec3 from;
  void main() {
    vec4 there = seen * vec4(place, 1.0);
    side = mat3(seen) * normal; which = tone; from = there.xyz;
    gl_Position = onto * there;
  }`, `#version 300 es
  precision highp float;
  in vec3 side; in float which; in vec3 from;
  uniform vec4 colour;
  out vec4 pixel;
  void main() {
    vec3 n = normalize(side);
    if (dot(n, from) > 0.0) n = -n;
    float light = 0.42 + 0.5 * max(0.0, dot(n, normalize(vec3(-0.4, 0.75, 0.6))));
    float shine = 0.18 * pow(max(0.0, dot(n, normalize(vec3(-0.2, 0.5, 0.9)))), 24.0);
    vec3 mixed = mix(colour.rgb, vec3(0.93), 0.55 * which);
    pixel = vec4((mixed * light * 1.12 + shine) * colour.a, colour.a);
  }`];

// A curve is one strip, as wide as so many pixels: each point stands in it twice, once a side.
const CURVE_SHADERS = [`#version 300 es
  in vec3 place, tangent; in float side, index;
  uniform mat4 seen, onto; uniform vec2 size; uniform float width;
  out float at;
  void main() {
    vec4 p = onto * (seen * vec4(place, 1.0)), t = onto * (seen * vec4(tangent, 0.0));
    vec2 along = (t.xy * p.w - p.xy * t.w) * size;
    along = length(along) > 1e-7 ? normalize(along) : vec2(1.0, 0.0);
    p.xy += side * width * p.w * vec2(-along.y, along.x) / size;
    p.z -= 0.0015 * p.w;
    at = index;
    gl_Position = p;
  }`, `#version 300 es
  precision highp float;
  in float at;
  uniform vec4 colour, after; uniform float until;
  out vec4 pixel;
  void main() {
    vec4 mine = at > until ? after : colour;
    if (mine.a == 0.0) discard;
    pixel = vec4(mine.rgb * mine.a, mine.a);
  }`];

const CLEAR = [0, 0, 0, 0];

// One for all pictures of a page, each of which is copied: browsers have few contexts of WebGL.
class Painter {
  // detail: pixels drawn for each pixel of the screen, in each direction; 1 at most.
  constructor() {
    const canvas = document.createElement("canvas");
    const gl = canvas.getContext("webgl2", {antialias: !SLOW, premultipliedAlpha: true});
    if (!gl) throw new Error("this browser has no WebGL 2");
    Object.assign(this, {canvas, gl, detail: 1});
    this.solids = this.program(SOLID_SHADERS);
    this.curves = this.program(CURVE_SHADERS);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.enable(gl.BLEND);
  }

  program(texts) {
    const gl = this.gl, program = gl.createProgram();
    texts.forEach((text, k) => {
      const shader = gl.createShader(k ? gl.FRAGMENT_SHADER : gl.VERTEX_SHADER);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
        throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    });
    gl.linkProgram(program);
    // where its inputs are, asked once
    const names = (kind, info) => Array.from(
      {length: gl.getProgramParameter(program, kind)}, (_, k) => info.call(gl, program, k).name);
    const uniforms = names(gl.ACTIVE_UNIFORMS, gl.getActiveUniform);
    const attributes = names(gl.ACTIVE_ATTRIBUTES, gl.getActiveAttrib);
    const placed = (list, at) => Object.fromEntries(list.map(x => [x, at.call(gl, program, x)]));
    return {program, uniform: placed(uniforms, gl.getUniformLocation),
            attribute: placed(attributes, gl.getAttribLocation)};
  }

  // Something to draw: its numbers, and which of them a program reads; a frame then costs a few
  // calls a thing drawn.  parts: [name, how many numbers], in the order in which they stand.
  made(program, numbers, parts, mode) {
    const gl = this.gl, buffer = gl.createBuffer(), inputs = gl.createVertexArray();
    const stride = parts.reduce((sum, [, size]) => sum + size, 0);
    gl.bindVertexArray(inputs);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STATIC_DRAW);
    let offset = 0;
    for (const [name, size] of parts) {
      const place = program.attribute[name];
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 4 * stride, 4 * offset);
      offset += size;
    }
    return {inputs, buffer, mode, count: numbers.length / stride};
  }

  solid(solid) {
    return this.made(this.solids, solid.numbers, [["place", 3], ["normal", 3], ["tone", 1]],
                     this.gl.TRIANGLES);
  }

  // A curve through points, which are numbered from 0.
  curve(points) {
    const numbers = [], last = points.length - 1;
    points.forEach((point, k) => {
      const tangent = minus(points[Math.min(last, k + 1)], points[Math.max(0, k - 1)]);
      for (const side of [-1, 1]) numbers.push(...point, ...tangent, side, k);
    });
    return this.strip(numbers, this.gl.TRIANGLE_STRIP);
  }

  // Many thin lines at once.
  lines(curves) {
    const numbers = [];
    for (const points of curves)
      for (let k = 0; k + 1 < points.length; k++)
        for (const point of [points[k], points[k + 1]]) numbers.push(...point, 0, 0, 0, 0, 0);
    return this.strip(numbers, this.gl.LINES);
  }

  strip(numbers, mode) {
    return this.made(this.curves, numbers,
                     [["place", 3], ["tangent", 3], ["side", 1], ["index", 1]], mode);
  }

  free({inputs, buffer}) {
    this.gl.deleteVertexArray(inputs);
    this.gl.deleteBuffer(buffer);
  }

  // A clear picture as large as an element, from (azimuth, elevation, distance), of a point.
  begin({clientWidth, clientHeight}, {azimuth, elevation, distance}, middle) {
    const {gl, canvas} = this, ratio = (window.devicePixelRatio || 1) * this.detail;
    const [w, h] = [clientWidth, clientHeight].map(x => Math.round(x * ratio));
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    gl.viewport(0, 0, w, h);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const [ca, sa] = [Math.cos(azimuth), Math.sin(azimuth)];
    const [ce, se] = [Math.cos(elevation), Math.sin(elevation)];
    const right = [-sa, ca, 0], up = [-se * ca, -se * sa, ce], back = [ce * ca, ce * sa, se];
    const eye = plus(middle, scale(distance, back));
    this.view = new Float32Array([
      right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0,
      -dot(right, eye), -dot(up, eye), -dot(back, eye), 1]);
    const f = 3.2, near = 0.05, far = 40, wide = Math.min(1, w / h);
    this.onto = new Float32Array([
      f * wide * h / w, 0, 0, 0, 0, f * wide, 0, 0,
      0, 0, (far + near) / (near - far), -1, 0, 0, 2 * far * near / (near - far), 0]);
    this.size = [w, h];
    this.ratio = ratio;
  }

  // What was drawn since the beginning, onto a canvas.
  copy(onto) {
    const {canvas} = this;
    if (!canvas.width || !canvas.height) return;  // of a page that is hidden
    onto.width = canvas.width;  // which clears it
    onto.height = canvas.height;
    onto.getContext("2d").drawImage(canvas, 0, 0);
  }

  use(program, made, model, colour) {
    const gl = this.gl, {uniform} = program;
    gl.useProgram(program.program);
    gl.uniformMatrix4fv(uniform.seen, false, model === IDENTITY ? this.view
      : times(this.view, model));
    gl.uniformMatrix4fv(uniform.onto, false, this.onto);
    gl.uniform4fv(uniform.colour, colour);
    gl.depthMask(colour[3] >= 1);
    gl.bindVertexArray(made.inputs);
  }

  drawSolid(made, model, colour, first = 0, count = made.count) {
    const gl = this.gl;
    this.use(this.solids, made, model, colour);
    if (colour[3] < 1) {  // what is seen through: the far side first, then the near one
      gl.enable(gl.CULL_FACE);
      for (const side of [gl.FRONT, gl.BACK]) {
        gl.cullFace(side);
        gl.drawArrays(made.mode, first, count);
      }
      gl.disable(gl.CULL_FACE);
    } else {
      gl.drawArrays(made.mode, first, count);
    }
    gl.depthMask(true);
  }

  // A curve up to number `until` in one colour, the rest in another.
  drawCurve(made, model, colour, width = 1, until = Infinity, after = CLEAR) {
    const gl = this.gl, {uniform} = this.curves;
    this.use(this.curves, made, model, colour);
    gl.uniform4fv(uniform.after, after);
    gl.uniform2f(uniform.size, ...this.size);
    gl.uniform1f(uniform.width, Math.max(1, width * this.ratio));
    gl.uniform1f(uniform.until, Math.min(until, 1e9));
    gl.drawArrays(made.mode, 0, made.count);
    gl.depthMask(true);
  }
}
