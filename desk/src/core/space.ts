// Vectors and matrices of the pictures, column-major for WebGL.

export type Vector = [number, number, number];
export type Matrix = Float32Array;

export function multiply(p: Matrix, q: Matrix): Matrix {
  const product = new Float32Array(16);
  for (let c = 0; c < 4; c++)
    for (let r = 0; r < 4; r++) {
      let sum = 0;
      for (let k = 0; k < 4; k++) sum += p[4 * k + r]! * q[4 * c + k]!;
      product[4 * c + r] = sum;
    }
  return product;
}

/** A perspective projection; `angle` from bottom to top, rad. */
export function perspective(angle: number, aspect: number, near: number, far: number): Matrix {
  const f = 1 / Math.tan(angle / 2);
  const depth = near - far;
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / depth, -1, 0, 0, (2 * far * near) / depth, 0]);
}

/** From the eye towards a place, z upward. */
export function lookAt(eye: Vector, at: Vector): Matrix {
  const back = unit([eye[0] - at[0], eye[1] - at[1], eye[2] - at[2]]);
  const right = unit([-back[1], back[0], 0]);
  const up: Vector = [back[1] * right[2] - back[2] * right[1], back[2] * right[0] - back[0] * right[2], back[0] * right[1] - back[1] * right[0]];
  const along = (v: Vector) => -(v[0] * eye[0] + v[1] * eye[1] + v[2] * eye[2]);
  return new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, along(right), along(up), along(back), 1]);
}

function unit(v: Vector): Vector {
  const size = Math.hypot(...v) || 1;
  return [v[0] / size, v[1] / size, v[2] / size];
}
