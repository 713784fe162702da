// A three-dimensional picture: lines, points, arrows and surfaces in WebGL 2, rotated by pointer and keys.

import { el, unique } from "./dom";
import { build, upload, type Batch } from "./drawing";
import { cones, repeated, SIDES, surface } from "./shapes";
import { lookAt, multiply, perspective, type Matrix, type Vector } from "./space";
import { onTheme, rgb, scale, type ColourName } from "./theme";

export interface SceneOptions {
  /** Description of the picture for a screen reader. */
  label: string;
  height?: number;
}

/** A text at a place. */
interface Label {
  at: Vector;
  element: HTMLElement;
}

export class Scene {
  readonly root: HTMLElement;
  private readonly canvas: HTMLCanvasElement;
  private readonly labels: HTMLElement;
  private readonly gl: WebGL2RenderingContext | null;
  private program: WebGLProgram | undefined;
  private batches: Batch[] = [];
  private written: Label[] = [];
  private low: Vector = [0, 0, 0];
  private high: Vector = [1, 1, 1];
  private turn = -0.9;
  private rise = 0.45;
  private zoom = 1;
  private asked = false;
  /** Pictures that rotate together, including this one. */
  private together: Scene[] = [this];

  constructor(host: HTMLElement, options: SceneOptions) {
    const id = unique("scene");
    this.canvas = el("canvas", { tabindex: 0, role: "img", "aria-label": `${options.label}. Arrow keys turn it, plus and minus zoom.`, id });
    this.labels = el("div", { class: "labels", "aria-hidden": "true" });
    this.root = el("div", { class: "scene", style: `height:${options.height ?? 420}px` }, this.canvas, this.labels);
    host.append(this.root);
    this.gl = this.canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    if (!this.gl) this.root.append(el("p", { role: "status" }, "This browser has no WebGL 2: the numbers are in the tables."));
    this.pointer();
    this.canvas.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(this.root);
    onTheme(this, (scene) => {
      for (const batch of scene.batches) scene.free(batch);
      scene.draw();
    });
  }

  /** Couples the rotation of this picture and another one. */
  follow(other: Scene): void {
    this.together = other.together;
    this.together.push(this);
    this.orbit(0, 0);
  }

  /** Removes everything; the view stays. */
  clear(): void {
    for (const batch of this.batches) this.free(batch);
    this.batches = [];
    this.written = [];
    this.labels.replaceChildren();
  }

  /** Sets the displayed box, from corner to corner. */
  fit(low: Vector, high: Vector): void {
    [this.low, this.high] = [low, high];
  }

  /** Sets the direction of view: turned about z and raised from the plane, rad. */
  viewFrom(turn: number, rise: number): void {
    [this.turn, this.rise] = [turn, rise];
  }

  /** Pairs of points, each pair a line. */
  lines(at: Float32Array, name: ColourName): void {
    this.batches.push({ mode: "lines", at, tint: () => repeated(rgb(name), at.length / 3) });
  }

  /** One line through all points; values from 0 to 1 colour it by the scale. */
  polyline(points: Float32Array, name: ColourName, values?: ArrayLike<number>): void {
    const count = Math.max(0, points.length / 3 - 1);
    const at = new Float32Array(6 * count);
    for (let i = 0; i < count; i++) at.set(points.subarray(3 * i, 3 * i + 6), 6 * i);
    const own = () => {
      const tint = new Float32Array(6 * count);
      for (let i = 0; i < count; i++) for (const end of [0, 1]) tint.set(scale(values![i + end] ?? 0), 6 * i + 3 * end);
      return tint;
    };
    this.batches.push({ mode: "lines", at, tint: values ? own : () => repeated(rgb(name), 2 * count) });
  }

  /** Points, `size` px wide. */
  points(at: Float32Array, name: ColourName, size = 8): void {
    this.batches.push({ mode: "points", at, tint: () => repeated(rgb(name), at.length / 3), size });
  }

  /** Cones from each place along its vector times `magnification`, coloured by values from 0 to 1. */
  arrows(places: ArrayLike<number>, vectors: ArrayLike<number>, values: ArrayLike<number>, magnification: number, width: number): void {
    const count = values.length;
    const { at, normal } = cones(places, vectors, count, magnification, width);
    const tint = () => {
      const all = new Float32Array(at.length);
      for (let i = 0; i < count; i++) {
        const own = scale(values[i]!);
        for (let k = 0; k < SIDES * 3; k++) all.set(own, (i * SIDES * 3 + k) * 3);
      }
      return all;
    };
    this.batches.push({ mode: "triangles", at, normal, tint });
  }

  /** Cones like those of `arrows`, in one colour. */
  cones(places: ArrayLike<number>, vectors: ArrayLike<number>, name: ColourName, magnification: number, width: number): void {
    const { at, normal } = cones(places, vectors, Math.floor(vectors.length / 3), magnification, width);
    this.batches.push({ mode: "triangles", at, normal, tint: () => repeated(rgb(name), at.length / 3) });
  }

  /** A surface over a grid of points, `rows` times `columns`; values from 0 to 1 colour it by the scale. */
  mesh(points: ArrayLike<number>, rows: number, columns: number, name: ColourName, values?: ArrayLike<number>): void {
    const { at, normal, corners } = surface(points, rows, columns);
    const own = () => {
      const tint = new Float32Array(at.length);
      for (const [k, corner] of corners.entries()) tint.set(scale(values![corner]!), 3 * k);
      return tint;
    };
    this.batches.push({ mode: "triangles", at, normal, tint: values ? own : () => repeated(rgb(name), corners.length) });
  }

  /** A box from corner to corner, with the letters of its axes and the ends in mm. */
  box([x0, y0, z0]: Vector, [x1, y1, z1]: Vector, letters: readonly [string, string, string] = ["X", "Y", "Z"]): void {
    const edges: number[] = [];
    for (const y of [y0, y1]) for (const z of [z0, z1]) edges.push(x0, y, z, x1, y, z);
    for (const x of [x0, x1]) for (const z of [z0, z1]) edges.push(x, y0, z, x, y1, z);
    for (const x of [x0, x1]) for (const y of [y0, y1]) edges.push(x, y, z0, x, y, z1);
    this.lines(new Float32Array(edges), "servo");
    const least = 1e-6 * Math.max(x1 - x0, y1 - y0, z1 - z0);
    const number = (value: number) => String(Math.abs(value) < least ? 0 : Number(value.toPrecision(4))).replace("-", "−");
    const middle = [(x0 + x1) / 2, (y0 + y1) / 2, (z0 + z1) / 2] as const;
    this.label([middle[0], y0, z0], `${letters[0]} ${number(x0)}…${number(x1)}`);
    this.label([x1, middle[1], z0], `${letters[1]} ${number(y0)}…${number(y1)}`);
    this.label([x0, y0, middle[2]], `${letters[2]} ${number(z0)}…${number(z1)}`);
  }

  /** Adds a text at a place. */
  label(at: Vector, text: string): void {
    const element = el("span", {}, text);
    this.labels.append(element);
    this.written.push({ at, element });
  }

  /** Draws at the next frame, once even after several calls. */
  draw(): void {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.render();
    });
  }

  private render(): void {
    const { gl, canvas } = this;
    const { clientWidth: width, clientHeight: height } = this.root;
    if (!gl || width === 0) return;
    const ratio = Math.min(2, devicePixelRatio);
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    this.program ??= build(gl);
    const [view, eye] = this.camera(width / height);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...rgb("paper"), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);
    gl.useProgram(this.program);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.program, "view"), false, view);
    gl.uniform3fv(gl.getUniformLocation(this.program, "eye"), eye);
    for (const batch of this.batches) {
      batch.buffers ??= upload(gl, this.program, batch);
      gl.uniform1f(gl.getUniformLocation(this.program, "size"), (batch.size ?? 1) * ratio);
      gl.bindVertexArray(batch.buffers.array);
      gl.drawArrays({ lines: gl.LINES, points: gl.POINTS, triangles: gl.TRIANGLES }[batch.mode], 0, batch.buffers.count);
    }
    this.place(view, width, height);
  }

  private camera(aspect: number): [Matrix, Vector] {
    const { low, high } = this;
    const middle: Vector = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2];
    const reach = Math.max(1e-6, Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / 2);
    const distance = (reach * 3.1 * Math.max(1, 1.25 / aspect)) / this.zoom;
    const eye: Vector = [
      middle[0] + distance * Math.cos(this.rise) * Math.cos(this.turn),
      middle[1] + distance * Math.cos(this.rise) * Math.sin(this.turn),
      middle[2] + distance * Math.sin(this.rise),
    ];
    const lens = perspective(0.6, aspect, Math.max(reach * 0.01, distance - 3 * reach), distance + 3 * reach);
    return [multiply(lens, lookAt(eye, middle)), eye];
  }

  private place(view: Matrix, width: number, height: number): void {
    for (const { at, element } of this.written) {
      const [x, y, , w] = [0, 1, 2, 3].map((k) => view[k]! * at[0] + view[4 + k]! * at[1] + view[8 + k]! * at[2] + view[12 + k]!) as [number, number, number, number];
      element.hidden = w <= 0;
      // Within the picture: a label cut at its edge cannot be read.
      const [half, high] = [element.offsetWidth / 2, element.offsetHeight / 2];
      const inside = (at: number, end: number, room: number) => Math.max(room, Math.min(end - room, at));
      const [left, top] = [inside(((x / w + 1) / 2) * width, width, half), inside(((1 - y / w) / 2) * height, height, high)];
      element.style.transform = `translate(${left}px, ${top}px) translate(-50%, -50%)`;
    }
  }

  private free(batch: Batch): void {
    if (!batch.buffers || !this.gl) return;
    this.gl.deleteVertexArray(batch.buffers.array);
    for (const buffer of batch.buffers.held) this.gl.deleteBuffer(buffer);
    delete batch.buffers;
  }

  private pointer(): void {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      if (!canvas.hasPointerCapture(event.pointerId)) return;
      this.orbit(-event.movementX * 0.008, event.movementY * 0.008);
    });
    canvas.addEventListener(
      "wheel",
      (event) => {
        // Without Ctrl the wheel scrolls the page, as elsewhere.
        if (!event.ctrlKey) return;
        event.preventDefault();
        this.nearer(Math.exp(-event.deltaY * 0.002));
      },
      { passive: false },
    );
  }

  private key(event: KeyboardEvent): void {
    const turns: Record<string, [number, number]> = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
    const turned = turns[event.key];
    if (turned) this.orbit(...turned);
    else if (event.key === "+" || event.key === "=") this.nearer(1.15);
    else if (event.key === "-") this.nearer(1 / 1.15);
    else return;
    event.preventDefault();
  }

  private orbit(turn: number, rise: number): void {
    this.turn += turn;
    this.rise = Math.min(1.5, Math.max(-1.5, this.rise + rise));
    this.moved();
  }

  private nearer(factor: number): void {
    this.zoom = Math.min(20, Math.max(0.2, this.zoom * factor));
    this.moved();
  }

  private moved(): void {
    for (const scene of this.together) {
      [scene.turn, scene.rise, scene.zoom] = [this.turn, this.rise, this.zoom];
      scene.draw();
    }
  }
}

/** A colour scale for sizes. */
export function colourBar(host: HTMLElement, label: string): (largest: string) => void {
  const canvas = el("canvas", { width: 160, height: 12, role: "img", "aria-label": `Colours from 0 to the largest ${label}` });
  const end = el("span");
  host.append(el("div", { class: "colour-bar" }, el("span", {}, "0"), canvas, end));
  const paint = (canvas: HTMLCanvasElement) => {
    const context = canvas.getContext("2d");
    for (let x = 0; context && x < 160; x++) {
      context.fillStyle = `rgb(${scale(x / 159).map((part) => Math.round(255 * part)).join(" ")})`;
      context.fillRect(x, 0, 1, 12);
    }
  };
  paint(canvas);
  onTheme(canvas, paint);
  return (largest) => {
    end.textContent = largest;
  };
}
