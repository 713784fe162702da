// Maps over (u, θ) and the flank in space, on plain canvases.

const NAMES = ["X", "Y", "Z", "A", "C"];
const UNITS = ["mm", "mm", "mm", "°", "°"];
const MINUS = "\u2212";
// Viridis, every eighth of its range.
const RAMP = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37]];

function colour(t) {
  const place = Math.min(Math.max(t, 0), 1) * (RAMP.length - 1);
  const i = Math.min(Math.floor(place), RAMP.length - 2);
  return RAMP[i].map((low, k) => Math.round(low + (RAMP[i + 1][k] - low) * (place - i)));
}

function show(value, digits) {
  const text = value.toFixed(digits);
  return (Number(text) === 0 ? text.replace("-", "") : text).replace("-", MINUS);
}

/** Round steps for a scale of about `count` ticks. */
function ticks(low, high, count) {
  const span = high - low;
  if (!(span > 0)) return [low];
  const power = 10 ** Math.floor(Math.log10(span / count));
  const step = [1, 2, 5, 10].map(d => d * power).find(s => span / s <= count);
  const out = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * span; k++) out.push(k * step);
  return out;
}

function label(value) {
  return String(Number(value.toPrecision(6))).replace("-", MINUS);
}

/** Fits a canvas to its place and the screen's resolution; its context then counts in CSS pixels. */
function context(canvas) {
  const scale = window.devicePixelRatio || 1;
  const width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const c = canvas.getContext("2d");
  c.setTransform(scale, 0, 0, scale, 0, 0);
  c.clearRect(0, 0, width, height);
  c.font = '12px "Segoe UI", "Helvetica Neue", Arial, "Liberation Sans", "DejaVu Sans", sans-serif';
  return { c, width, height };
}

const FRAME = { left: 52, right: 10, top: 6, bottom: 62 };

/** One displacement over the flank; `values[j][i]` at the i-th u and j-th θ. */
function drawMap(canvas, setup, values, index, at) {
  const { c, width, height } = context(canvas);
  const w = width - FRAME.left - FRAME.right, h = height - FRAME.top - FRAME.bottom;
  const flat = values.flat();
  const low = Math.min(...flat), high = Math.max(...flat);
  const constant = !(high - low > 1e-9 * Math.max(1, Math.abs(high)));
  const n = values.length, m = values[0].length;
  const image = document.createElement("canvas");
  image.width = 2 * m; image.height = 2 * n;
  const pixels = image.getContext("2d");
  const data = pixels.createImageData(2 * m, 2 * n);
  for (let y = 0; y < 2 * n; y++) for (let x = 0; x < 2 * m; x++) {
    const t = constant ? 0.45 : (bilinear(values, (x + 0.5) / (2 * m), 1 - (y + 0.5) / (2 * n)) - low) / (high - low);
    const [r, g, b] = colour(t);
    data.data.set([r, g, b, constant ? 90 : 255], 4 * (y * 2 * m + x));
  }
  pixels.putImageData(data, 0, 0);
  c.imageSmoothingEnabled = true;
  c.drawImage(image, FRAME.left, FRAME.top, w, h);
  const toX = u => FRAME.left + w * fraction(setup.u, u), toY = t => FRAME.top + h * (1 - fraction(setup.theta, t));
  if (!constant) contours(c, values, ticks(low, high, 9), FRAME.left, FRAME.top, w, h);

  c.strokeStyle = "#787e87"; c.lineWidth = 1;
  c.strokeRect(FRAME.left + 0.5, FRAME.top + 0.5, w - 1, h - 1);
  c.fillStyle = "#333840"; c.textAlign = "center"; c.textBaseline = "top";
  const [u0, u1] = ordered(setup.u), [t0, t1] = ordered(setup.theta);
  for (const u of ticks(u0, u1, 5)) {
    c.fillRect(Math.round(toX(u)), FRAME.top + h, 1, 4);
    c.fillText(label(u), toX(u), FRAME.top + h + 6);
  }
  c.textAlign = "right"; c.textBaseline = "middle";
  for (const t of ticks(t0, t1, 5)) {
    c.fillRect(FRAME.left - 4, Math.round(toY(t)), 4, 1);
    c.fillText(label(t), FRAME.left - 7, toY(t));
  }
  c.fillStyle = "#59606c"; c.textAlign = "right"; c.textBaseline = "top";
  c.fillText("u in rad", FRAME.left + w, FRAME.top + h + 21);
  c.save(); c.translate(4, FRAME.top); c.rotate(-Math.PI / 2); c.textAlign = "right"; c.fillText("θ in rad", 0, 0); c.restore();
  scaleBar(c, FRAME.left, height - 20, w, low, high, constant, UNITS[index]);

  const x = toX(at[0]), y = toY(at[1]);
  c.lineWidth = 1; c.strokeStyle = "rgba(255,255,255,.75)";
  c.beginPath(); c.moveTo(x, FRAME.top); c.lineTo(x, FRAME.top + h); c.moveTo(FRAME.left, y); c.lineTo(FRAME.left + w, y); c.stroke();
  c.beginPath(); c.arc(x, y, 4.5, 0, 2 * Math.PI); c.fillStyle = "#fff"; c.fill();
  c.strokeStyle = "#d55e00"; c.lineWidth = 2.5; c.stroke();
}

function scaleBar(c, x, y, w, low, high, constant, unit) {
  c.fillStyle = "#333840"; c.textBaseline = "top"; c.textAlign = "left";
  if (constant) {
    c.fillText(`the same everywhere: ${show(low, 4)} ${unit}`, x, y + 3);
    return;
  }
  for (let i = 0; i < w; i++) {
    c.fillStyle = `rgb(${colour(i / (w - 1)).join(",")})`;
    c.fillRect(x + i, y - 4, 1.5, 6);
  }
  c.fillStyle = "#333840";
  c.fillText(`${show(low, 3)} ${unit}`, x, y + 6);
  c.textAlign = "right"; c.fillText(`${show(high, 3)} ${unit}`, x + w, y + 6);
}

function ordered([a, b]) { return a <= b ? [a, b] : [b, a]; }
function fraction([a, b], value) {
  const [low, high] = ordered([a, b]);
  return high > low ? (value - low) / (high - low) : 0.5;
}

function bilinear(values, s, t) {
  const x = s * (values[0].length - 1), y = t * (values.length - 1);
  const i = Math.min(Math.floor(x), Math.max(values[0].length - 2, 0)), j = Math.min(Math.floor(y), Math.max(values.length - 2, 0));
  const row = k => { const r = values[Math.min(k, values.length - 1)]; return r[i] + (r[Math.min(i + 1, r.length - 1)] - r[i]) * (x - i); };
  return row(j) + (row(j + 1) - row(j)) * (y - j);
}

/** Lines of equal value, triangle by triangle. */
function contours(c, values, levels, x0, y0, w, h) {
  const n = values.length - 1, m = values[0].length - 1;
  c.strokeStyle = "rgba(255,255,255,.55)"; c.lineWidth = 1;
  c.beginPath();
  for (let j = 0; j < n; j++) for (let i = 0; i < m; i++) {
    const corner = (a, b) => [x0 + w * (i + a) / m, y0 + h * (1 - (j + b) / n), values[j + b][i + a]];
    for (const triangle of [[corner(0, 0), corner(1, 0), corner(1, 1)], [corner(0, 0), corner(1, 1), corner(0, 1)]]) {
      for (const level of levels) {
        const cut = [];
        for (let k = 0; k < 3; k++) {
          const a = triangle[k], b = triangle[(k + 1) % 3];
          if ((a[2] < level) !== (b[2] < level)) {
            const t = (level - a[2]) / (b[2] - a[2]);
            cut.push([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
          }
        }
        if (cut.length === 2) { c.moveTo(...cut[0]); c.lineTo(...cut[1]); }
      }
    }
  }
  c.stroke();
}

/** The flank with the tool on it; `frame` "gear" holds the gear still, "machine" turns it with the table. */
function drawSpace(canvas, setup, at, camera, frame) {
  const { c, width, height } = context(canvas);
  const { table, head } = stand(setup, ...at);
  const machine = frame === "machine";
  const world = v => machine ? aboutZ(table, v.map((value, i) => value + setup.w[i])) : v;
  const lines = 28;
  const us = between(setup.u, lines), ts = between(setup.theta, lines);
  const tip = world(surfacePoint(setup, ...at));
  const normal = machine ? [0, -Math.sin(head), Math.cos(head)] : surfaceNormal(setup, ...at);
  const grid = ts.map(t => us.map(u => world(surfacePoint(setup, u, t))));

  // The picture holds the flank and a length of tool; the base cylinder goes beyond it.
  const zs = ordered(setup.theta.map(t => setup.p * t));
  const corners = grid.flat();
  const bounds = [0, 1, 2].map(i => [Math.min(...corners.map(v => v[i])), Math.max(...corners.map(v => v[i]))]);
  const centre = bounds.map(([low, high]) => (low + high) / 2);
  const reach = Math.max(0.5 * Math.hypot(...bounds.map(([low, high]) => high - low)), 0.15 * setup.rb);
  const toolLength = Math.min(Math.max(setup.pivot, 0.2 * reach), 0.9 * reach);
  const size = 0.38 * Math.min(width, height) / reach * camera.zoom;
  // Seen from the outer side of the flank's middle.
  const [um, tm] = [setup.u, setup.theta].map(([low, high]) => (low + high) / 2);
  const yaw = camera.yaw + (machine ? (setup.branch === 1 ? 0 : Math.PI) : um + tm);
  const [sy, cy, sp, cp] = [Math.sin(yaw), Math.cos(yaw), Math.sin(camera.pitch), Math.cos(camera.pitch)];
  const view = v => {
    const [x, y, z] = v.map((value, i) => value - centre[i]);
    const a = cy * x + sy * y, b = -sy * x + cy * y;
    return [width / 2 + size * a, height / 2 - size * (cp * z + sp * b), cp * b - sp * z];
  };
  const path = points => { c.beginPath(); points.map(view).forEach(([x, y], i) => i ? c.lineTo(x, y) : c.moveTo(x, y)); };

  c.strokeStyle = "#cdd2d8"; c.lineWidth = 1;
  for (const z of zs) {
    path(between([0, 2 * Math.PI], 181).map(a => world([setup.rb * Math.cos(a), setup.rb * Math.sin(a), z]))); c.stroke();
    // The same flank of all other teeth, at both ends.
    const teeth = setup.gear ? setup.gear.teeth : 0;
    for (let k = 0; k < Math.min(teeth, 400); k++) {
      path(between(setup.u, 10).map(u => world(aboutZ(2 * Math.PI * k / teeth, surfacePoint(setup, u, z / setup.p)))));
      c.stroke();
    }
  }
  c.setLineDash([8, 4, 2, 4]);
  path([world([0, 0, zs[0] - 0.25 * reach]), world([0, 0, zs[1] + 0.25 * reach])]); c.stroke();
  c.setLineDash([]);

  const faces = [];
  for (let j = 0; j + 1 < lines; j++) for (let i = 0; i + 1 < lines; i++) {
    const corners = [grid[j][i], grid[j][i + 1], grid[j + 1][i + 1], grid[j + 1][i]].map(view);
    const n = surfaceNormal(setup, (us[i] + us[i + 1]) / 2, (ts[j] + ts[j + 1]) / 2);
    const m = machine ? aboutZ(table, n) : n;
    // Towards the eye: the view's depth axis is [−s_y c_p, c_y c_p, −s_p].
    const facing = m[0] * sy * cp - m[1] * cy * cp + m[2] * sp;
    faces.push({ corners, depth: corners.reduce((sum, p) => sum + p[2], 0), facing });
  }
  const tool = () => drawTool(c, view, tip, normal, toolLength, reach);
  // The tool stands outside: it hides the flank where its outer side faces the eye.
  const n = machine ? normal : surfaceNormal(setup, ...at);
  const before = n[0] * sy * cp - n[1] * cy * cp + n[2] * sp > 0;
  if (!before) tool();
  for (const { corners, facing } of faces.sort((one, other) => other.depth - one.depth)) {
    const light = 0.35 + 0.65 * Math.abs(facing);
    const base = facing > 0 ? [120, 170, 214] : [206, 212, 220];
    c.fillStyle = `rgba(${base.map(v => Math.round(v * light + 255 * (1 - light) * 0.45)).join(",")},.94)`;
    c.strokeStyle = facing > 0 ? "rgba(0,60,120,.55)" : "rgba(90,96,106,.5)"; c.lineWidth = 0.7;
    c.beginPath(); corners.forEach(([x, y], i) => i ? c.lineTo(x, y) : c.moveTo(x, y)); c.closePath(); c.fill(); c.stroke();
  }
  c.strokeStyle = "rgba(213,94,0,.9)"; c.lineWidth = 1.6;
  path(between(setup.u, 60).map(u => world(surfacePoint(setup, u, at[1])))); c.stroke();
  path(between(setup.theta, 60).map(t => world(surfacePoint(setup, at[0], t)))); c.stroke();
  if (before) tool();
  triad(c, view, centre, size, width, height, machine);
}

function drawTool(c, view, tip, normal, length, reach) {
  const at = d => view(tip.map((value, i) => value + d * normal[i]));
  const [x0, y0] = at(0), [x1, y1] = at(length), [xc, yc] = at(0.32 * length);
  c.lineCap = "round";
  c.strokeStyle = "#1f2430"; c.lineWidth = 3; c.beginPath(); c.moveTo(x0, y0); c.lineTo(xc, yc); c.stroke();
  c.strokeStyle = "#59606c"; c.lineWidth = 8; c.beginPath(); c.moveTo(xc, yc); c.lineTo(x1, y1); c.stroke();
  c.lineCap = "butt"; c.setLineDash([6, 4]); c.strokeStyle = "#59606c"; c.lineWidth = 1;
  const [x2, y2] = at(length + 0.25 * reach);
  c.beginPath(); c.moveTo(x1, y1); c.lineTo(x2, y2); c.stroke(); c.setLineDash([]);
  c.beginPath(); c.arc(x0, y0, 4, 0, 2 * Math.PI); c.fillStyle = "#d55e00"; c.fill();
}

function triad(c, view, centre, size, width, height, machine) {
  const [ox, oy] = view(centre), x = 40, y = height - 38;
  c.lineWidth = 1.5; c.textAlign = "center"; c.textBaseline = "middle";
  [["x", "#a01428"], ["y", "#008c64"], ["z", "#005aaa"]].forEach(([name, ink], i) => {
    const [px, py] = view(centre.map((value, k) => value + (k === i ? 26 / size : 0)));
    const dx = px - ox, dy = py - oy;
    c.strokeStyle = c.fillStyle = ink;
    c.beginPath(); c.moveTo(x, y); c.lineTo(x + dx, y + dy); c.stroke();
    c.fillText(machine ? name.toUpperCase() : name, x + 1.38 * dx, y + 1.38 * dy);
  });
}
