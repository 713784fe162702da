// Vertices and normals of the shapes, three numbers each.

import type { Vector } from "./space";

/** Sides of a cone. */
export const SIDES = 6;

export interface Shape {
  at: Float32Array;
  normal: Float32Array;
}

/** Cones from each place along its vector times `magnification`. */
export function cones(places: ArrayLike<number>, vectors: ArrayLike<number>, count: number, magnification: number, width: number): Shape {
  const at = new Float32Array(count * SIDES * 9);
  const normal = new Float32Array(at.length);
  for (let i = 0; i < count; i++) {
    const from: Vector = [places[3 * i]!, places[3 * i + 1]!, places[3 * i + 2]!];
    const along: Vector = [vectors[3 * i]! * magnification, vectors[3 * i + 1]! * magnification, vectors[3 * i + 2]! * magnification];
    cone(from, along, width, at, normal, i * SIDES * 9);
  }
  return { at, normal };
}

/** A surface over a grid of points, `rows` times `columns`; `corners` gives the point of each vertex. */
export function surface(points: ArrayLike<number>, rows: number, columns: number): Shape & { corners: number[] } {
  const corners: number[] = [];
  for (let r = 0; r + 1 < rows; r++)
    for (let c = 0; c + 1 < columns; c++) {
      const [a, b] = [r * columns + c, (r + 1) * columns + c];
      corners.push(a, b, a + 1, a + 1, b, b + 1);
    }
  const at = new Float32Array(3 * corners.length);
  const normal = new Float32Array(at.length);
  const place = (i: number): Vector => [points[3 * i]!, points[3 * i + 1]!, points[3 * i + 2]!];
  for (let k = 0; k < corners.length; k += 3) {
    const [p, q, r] = [place(corners[k]!), place(corners[k + 1]!), place(corners[k + 2]!)];
    const across = cross(minus(q, p), minus(r, p));
    for (const [j, one] of [p, q, r].entries()) {
      at.set(one, 3 * (k + j));
      normal.set(across, 3 * (k + j));
    }
  }
  return { at, normal, corners };
}

function minus(p: Vector, q: Vector): Vector {
  return [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
}

function cross(p: Vector, q: Vector): Vector {
  return [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
}

/** One colour for `count` vertices. */
export function repeated(one: readonly number[], count: number): Float32Array {
  const all = new Float32Array(3 * count);
  for (let i = 0; i < count; i++) all.set(one, 3 * i);
  return all;
}

/** The sides of a cone from its base to its tip. */
function cone(from: Vector, along: Vector, width: number, at: Float32Array, normal: Float32Array, offset: number): void {
  const length = Math.hypot(...along) || 1e-9;
  const unit: Vector = [along[0] / length, along[1] / length, along[2] / length];
  const other: Vector = Math.abs(unit[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0];
  const across = cross(unit, other);
  const size = Math.hypot(...across);
  const p: Vector = [across[0] / size, across[1] / size, across[2] / size];
  const q = cross(unit, p);
  const tip: Vector = [from[0] + along[0], from[1] + along[1], from[2] + along[2]];
  const rim = (k: number): [Vector, Vector] => {
    const [c, s] = [Math.cos((2 * Math.PI * k) / SIDES), Math.sin((2 * Math.PI * k) / SIDES)];
    const out: Vector = [c * p[0] + s * q[0], c * p[1] + s * q[1], c * p[2] + s * q[2]];
    return [[from[0] + width * out[0], from[1] + width * out[1], from[2] + width * out[2]], out];
  };
  for (let k = 0; k < SIDES; k++) {
    const [[one, outward], [next, further]] = [rim(k), rim(k + 1)];
    for (const [j, [place, direction]] of ([[one, outward], [next, further], [tip, outward]] as const).entries()) {
      at.set(place, offset + 9 * k + 3 * j);
      normal.set(direction, offset + 9 * k + 3 * j);
    }
  }
}
