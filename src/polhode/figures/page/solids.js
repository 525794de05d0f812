// Solids as triangles: seven numbers a corner, its place, its normal, and which of two tones.
"use strict";

class Solid {
  constructor() { this.numbers = []; }

  corner(place, normal, tone) { this.numbers.push(...place, ...unit(normal), tone); }

  // Four corners with their normals as two triangles.
  patch(places, normals, tone) {
    for (const k of [0, 1, 2, 0, 2, 3]) this.corner(places[k], normals[k], tone);
  }

  // An ellipsoid of these semi-axes, its octants in two tones, unless they are to be one.
  ellipsoid(semi, n = SLOW ? 14 : 24, tones = 2) {
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
  revolve(line, n = SLOW ? 24 : 48, tones = 2) {
    const on = ([r, z], j) => {
      const a = 2 * Math.PI * j / n;
      return [r * Math.cos(a), r * Math.sin(a), z];
    };
    for (let k = 0; k + 1 < line.length; k++) {
      const [[r0, z0], [r1, z1]] = [line[k], line[k + 1]];
      const outward = [z1 - z0, r0 - r1];
      for (let j = 0; j < n; j++)
        this.patch([on(line[k], j), on(line[k], j + 1), on(line[k + 1], j + 1), on(line[k + 1], j)],
                   [j, j + 1, j + 1, j].map(i => on(outward, i)), Math.floor(4 * j / n) % tones);
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

// A solid as the page's data have it, and the matrix that places it in the body.
function solidOf({kind, numbers, place}) {
  const solid = new Solid();
  if (kind === "box") solid.box(numbers);
  else if (kind === "ellipsoid") solid.ellipsoid(numbers);
  else solid.revolve(numbers);
  return {solid, place: frame(...place)};
}
