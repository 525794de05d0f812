// Drawing in space: small matrices, solids as triangles, curves as ribbons of pixels; WebGL 2 alone.
"use strict";

// -- vectors, quaternions (scalar first), matrices (columns one after the other, as WebGL has them)

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const scale = (s, a) => [s * a[0], s * a[1], s * a[2]];
const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
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

// -- solids: triangles, seven numbers a corner: place, normal, and which of two tones

class Solid {
  constructor() { this.numbers = []; }

  corner(place, normal, tone) { this.numbers.push(...place, ...unit(normal), tone); }

  // Four corners with their normals as two triangles.
  patch(places, normals, tone) {
    for (const k of [0, 1, 2, 0, 2, 3]) this.corner(places[k], normals[k], tone);
  }

  // An ellipsoid of these semi-axes, its octants in two tones, unless they are to be one.
  ellipsoid(semi, n = 24, tones = 2) {
    const at = (i, j) => {
      const lat = Math.PI * (i / n - 0.5), lon = Math.PI * j / n;
      return [Math.cos(lat) * Math.cos(lon), Math.cos(lat) * Math.sin(lon), Math.sin(lat)];
    };
    for (let i = 0; i < n; i++)
      for (let j = 0; j < 2 * n; j++) {
        const u = [at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
        const tone = (Math.floor(2 * i / n) + Math.floor(2 * j / n)) % tones;
        this.patch(u.map(x => x.map((c, k) => c * semi[k])),
                   u.map(x => x.map((c, k) => c / semi[k])), tone);
      }
    return this;
  }

  // The solid that a closed line of points (radius, height) sweeps about the third axis.
  revolve(line, n = 48, tones = 2) {
    const on = ([r, z], j) => {
      const a = 2 * Math.PI * j / n;
      return [r * Math.cos(a), r * Math.sin(a), z];
    };
    for (let k = 0; k + 1 < line.length; k++) {
      const [[r0, z0], [r1, z1]] = [line[k], line[k + 1]];
      const outward = [z1 - z0, r0 - r1];
      for (let j = 0; j < n; j++)
        this.patch([on(line[k], j), on(line[k], j + 1), on(line[k + 1], j + 1), on(line[k + 1], j)],
                   [j, j + 1, j + 1, j].map(i => on(outward, i)), Math.floor(8 * j / n) % tones);
    }
    return this;
  }

  // The cone from the origin to a curve; a triangle for each of its pieces.
  fan(points) {
    for (let k = 0; k + 1 < points.length; k++) {
      const normal = cross(points[k], points[k + 1]);
      for (const place of [[0, 0, 0], points[k], points[k + 1]]) this.corner(place, normal, 0);
    }
    return this;
  }

  box(size) {
    const half = size.map(x => x / 2);
    for (let axis = 0; axis < 3; axis++)
      for (const side of [1, -1]) {
        const [i, j] = [(axis + 1) % 3, (axis + 2) % 3], normal = [0, 0, 0];
        normal[axis] = side;
        const places = [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => {
          const place = [0, 0, 0];
          place[axis] = side * half[axis]; place[i] = a * half[i]; place[j] = b * half[j];
          return place;
        });
        this.patch(places, [normal, normal, normal, normal], axis % 2);
      }
    return this;
  }
}

// -- what is drawn with

const SOLID_SHADERS = [`#version 300 es
  in vec3 place; in vec3 normal; in float tone;
  uniform mat4 model, view, onto;
  out vec3 side; out float which; out vec3 from;
  void main() {
    vec4 seen = view * model * vec4(place, 1.0);
    side = mat3(view) * mat3(model) * normal; which = tone; from = seen.xyz;
    gl_Position = onto * seen;
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

// A piece of a curve is a strip between two points, as wide as so many pixels.
const CURVE_SHADERS = [`#version 300 es
  in vec3 a, b; in vec2 corner; in float index;
  uniform mat4 model, view, onto; uniform vec2 size; uniform float width;
  out float at;
  void main() {
    vec4 p = onto * view * model * vec4(a, 1.0), q = onto * view * model * vec4(b, 1.0);
    vec2 along = (q.xy / q.w - p.xy / p.w) * size;
    along = length(along) > 1e-4 ? normalize(along) : vec2(1.0, 0.0);
    vec4 place = corner.x > 0.0 ? q : p;
    vec2 moved = (corner.y * vec2(-along.y, along.x) + 0.5 * corner.x * along) * width / size;
    place.xy += moved * place.w;
    place.z -= 0.0015 * place.w;
    at = index + 0.5 + 0.5 * corner.x;
    gl_Position = place;
  }`, `#version 300 es
  precision highp float;
  in float at;
  uniform vec4 colour; uniform float until;
  out vec4 pixel;
  void main() {
    if (at > until) discard;
    pixel = vec4(colour.rgb * colour.a, colour.a);
  }`];

class Painter {
  constructor(canvas) {
    const gl = canvas.getContext("webgl2", {antialias: true, premultipliedAlpha: true});
    if (!gl) throw new Error("this browser has no WebGL 2");
    Object.assign(this, {canvas, gl});
    this.solids = this.program(SOLID_SHADERS);
    this.curves = this.program(CURVE_SHADERS);
    this.corners = this.buffer([-1, -1, 1, -1, 1, 1, -1, -1, 1, 1, -1, 1]);
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

  buffer(numbers) {
    const gl = this.gl, made = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, made);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(numbers), gl.STATIC_DRAW);
    return made;
  }

  // What a drawing reads is told once, here: a frame then costs a few calls a thing drawn.
  solid(solid) {
    const numbers = this.buffer(solid.numbers), inputs = this.inputs();
    this.attribute(this.solids, "place", numbers, 3, 28, 0, 0);
    this.attribute(this.solids, "normal", numbers, 3, 28, 12, 0);
    this.attribute(this.solids, "tone", numbers, 1, 28, 24, 0);
    return {inputs, count: solid.numbers.length / 7};
  }

  // A curve through points; its pieces are numbered from 0.
  curve(points) {
    const count = Math.max(0, points.length - 1), places = this.buffer(points.flat());
    const order = this.buffer(Array.from({length: count}, (_, k) => k)), inputs = this.inputs();
    this.attribute(this.curves, "a", places, 3, 12, 0, 1);
    this.attribute(this.curves, "b", places, 3, 12, 12, 1);
    this.attribute(this.curves, "index", order, 1, 4, 0, 1);
    this.attribute(this.curves, "corner", this.corners, 2, 8, 0, 0);
    return {inputs, count};
  }

  inputs() {
    const made = this.gl.createVertexArray();
    this.gl.bindVertexArray(made);
    return made;
  }

  // A clear page, seen from (azimuth, elevation, distance), looking at a point.
  begin({azimuth, elevation, distance}, middle) {
    const {gl, canvas} = this, ratio = window.devicePixelRatio || 1;
    const [w, h] = [canvas.clientWidth, canvas.clientHeight].map(x => Math.round(x * ratio));
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

  use(program, model, colour) {
    const gl = this.gl;
    const {uniform} = program;
    gl.useProgram(program.program);
    gl.uniformMatrix4fv(uniform.model, false, model);
    gl.uniformMatrix4fv(uniform.view, false, this.view);
    gl.uniformMatrix4fv(uniform.onto, false, this.onto);
    gl.uniform4fv(uniform.colour, colour);
    gl.depthMask(colour[3] >= 1);
  }

  attribute(program, name, buffer, size, stride, offset, divisor) {
    const gl = this.gl, place = program.attribute[name];
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, size, gl.FLOAT, false, stride, offset);
    gl.vertexAttribDivisor(place, divisor);
  }

  drawSolid(made, model, colour, first = 0, count = made.count) {
    const gl = this.gl, program = this.solids;
    this.use(program, model, colour);
    gl.bindVertexArray(made.inputs);
    if (colour[3] < 1) {  // what is seen through: the far side first, then the near one
      gl.enable(gl.CULL_FACE);
      for (const side of [gl.FRONT, gl.BACK]) {
        gl.cullFace(side);
        gl.drawArrays(gl.TRIANGLES, first, count);
      }
      gl.disable(gl.CULL_FACE);
    } else {
      gl.drawArrays(gl.TRIANGLES, first, count);
    }
    gl.depthMask(true);
  }

  // The pieces of a curve up to number `to`.
  drawCurve(made, model, colour, width, to = Infinity) {
    const gl = this.gl, program = this.curves, last = Math.min(made.count, Math.ceil(to));
    if (last <= 0) return;
    this.use(program, model, colour);
    gl.uniform2f(program.uniform.size, ...this.size);
    gl.uniform1f(program.uniform.width, width * this.ratio);
    gl.uniform1f(program.uniform.until, Math.min(to, 1e9) + 0.001);
    gl.bindVertexArray(made.inputs);
    gl.drawArraysInstanced(gl.TRIANGLES, 0, 6, last);
    gl.depthMask(true);
  }
}
