// Batches of vertices on the graphics card.

const VERTEX = `#version 300 es
in vec3 at; in vec3 tint; in vec3 normal;
uniform mat4 view; uniform vec3 eye; uniform float size;
out vec3 colour;
void main() {
  gl_Position = view * vec4(at, 1.0);
  gl_PointSize = size;
  float shade = dot(normal, normal) > 0.0 ? 0.55 + 0.45 * abs(dot(normalize(normal), normalize(eye - at))) : 1.0;
  colour = tint * shade;
}`;
const FRAGMENT = `#version 300 es
precision mediump float;
in vec3 colour; out vec4 pixel;
void main() { pixel = vec4(colour, 1.0); }`;

/** A batch drawn in one call: positions, colours and normals, three numbers per vertex. */
export interface Batch {
  mode: "lines" | "points" | "triangles";
  at: Float32Array;
  tint: () => Float32Array;
  normal?: Float32Array;
  size?: number;
  buffers?: { array: WebGLVertexArrayObject; held: WebGLBuffer[]; count: number };
}

/** The one program that draws everything. */
export function build(gl: WebGL2RenderingContext): WebGLProgram {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, VERTEX], [gl.FRAGMENT_SHADER, FRAGMENT]] as const) {
    const shader = gl.createShader(kind)!;
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  return program;
}

/** Puts a batch on the card. */
export function upload(gl: WebGL2RenderingContext, program: WebGLProgram, batch: Batch): NonNullable<Batch["buffers"]> {
  const array = gl.createVertexArray()!;
  gl.bindVertexArray(array);
  const held: WebGLBuffer[] = [];
  const parts: [string, Float32Array | undefined][] = [["at", batch.at], ["tint", batch.tint()], ["normal", batch.normal]];
  for (const [name, numbers] of parts) {
    const place = gl.getAttribLocation(program, name);
    if (place < 0) continue;
    if (!numbers) {
      gl.vertexAttrib3f(place, 0, 0, 0);
      continue;
    }
    const buffer = gl.createBuffer()!;
    held.push(buffer);
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, numbers, gl.STATIC_DRAW);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
  }
  return { array, held, count: batch.at.length / 3 };
}
