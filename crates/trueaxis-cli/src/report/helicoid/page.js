// Fields, mouse and what follows from them.

const run = JSON.parse(document.getElementById("run").textContent);
const field = name => document.querySelector(`[name="${name}"]`);
const fields = [...document.querySelectorAll("#inputs [name]")];
const camera = { yaw: 0.75, pitch: 0.4, zoom: 1 };
const CELLS = 48;
let setup = null, grid = null, at = null;

function fill(inputs, surface) {
  const values = {
    ...inputs, ...surface,
    source: inputs.module_mm === null ? "base" : "gear",
    pivot_source: inputs.edge_finder_mm === null ? "length" : "finder",
    wx: inputs.work_offset_mm[0], wy: inputs.work_offset_mm[1], wz: inputs.work_offset_mm[2],
    u_start: inputs.u_rad.start, u_stop: inputs.u_rad.stop, u_count: inputs.u_rad.count,
    theta_start: inputs.theta_rad.start, theta_stop: inputs.theta_rad.stop, theta_count: inputs.theta_rad.count,
  };
  for (const input of fields) if (values[input.name] !== null && values[input.name] !== undefined) input.value = values[input.name];
}

function number(name) {
  const text = field(name).value.trim();
  return text === "" ? NaN : Number(text);
}

function read() {
  const next = {
    form: field("form").value, flank: field("flank").value, branch: Number(field("branch").value),
    directionA: Number(field("direction_a").value), directionC: Number(field("direction_c").value),
    pivot: field("pivot_source").value === "finder" ? number("edge_finder_mm") + number("edge_finder_radius_mm") : number("pivot_mm"),
    w: [number("wx"), number("wy"), number("wz")],
    u: [number("u_start"), number("u_stop")], theta: [number("theta_start"), number("theta_stop")],
    rb: number("base_radius_mm"), p: number("lead_parameter_mm_per_rad"),
  };
  // A count of one is its first value alone.
  if (number("u_count") === 1) next.u[1] = next.u[0];
  if (number("theta_count") === 1) next.theta[1] = next.theta[0];
  if (field("source").value === "gear") {
    next.gear = {};
    for (const name of ["module_mm", "teeth", "pressure_angle_deg", "helix_angle_deg"]) next.gear[name] = number(name);
    const data = gearData(next.gear);
    Object.assign(next, { rb: data.rb, p: data.p, data });
  }
  return next;
}

function recompute() {
  document.querySelectorAll("[data-when]").forEach(block => {
    const [name, value] = block.dataset.when.split("=");
    block.hidden = field(name).value !== value;
  });
  const next = read();
  const counts = [number("u_count"), number("theta_count")];
  const countable = counts.every(n => Number.isInteger(n) && n >= 1) && counts[0] * counts[1] <= 1e6;
  const bad = countable ? refusal(next) : "Points: whole numbers from 1, at most a million in all.";
  document.getElementById("refused").textContent = bad ?? "";
  document.body.classList.toggle("stale", bad !== null);
  if (bad !== null) return;
  setup = next;
  const inside = (value, range) => { const [low, high] = ordered(range); return Math.min(Math.max(value, low), high); };
  at = at === null ? [0, 1].map(i => [setup.u, setup.theta][i].reduce((a, b) => a + b) / 2) : [inside(at[0], setup.u), inside(at[1], setup.theta)];
  const us = between(ordered(setup.u), CELLS), ts = between(ordered(setup.theta), CELLS);
  const all = ts.map(t => us.map(u => place(setup, u, t)));
  grid = NAMES.map((_, k) => all.map(row => row.map(values => values[k])));
  derived();
  draw();
}

function derived() {
  const rows = [["base radius", show(setup.rb, 6), "mm"], ["lead parameter", show(setup.p, 6), "mm/rad"], ["lead", show(2 * Math.PI * setup.p, 4), "mm"], ["tilt γ of the normal", show(Math.atan2(setup.p, setup.rb) / RAD, 6), "°"], ["pivot length L", show(setup.pivot, 4), "mm"]];
  if (setup.data) rows.unshift(["transverse module", show(setup.data.transverseModule, 6), "mm"], ["transverse pressure angle", show(setup.data.alphaT / RAD, 6), "°"], ["reference radius", show(setup.data.r, 6), "mm"], ["base helix angle", show(setup.data.betaB / RAD, 6), "°"], ["u at the reference radius", show(Math.sign(setup.p) * setup.data.roll, 6), "rad"]);
  document.getElementById("derived").replaceChildren(...rows.map(cells => row(cells)));
}

function row([name, ...cells]) {
  const tr = document.createElement("tr");
  [["th", name], ...cells.map(text => ["td", text])].forEach(([tag, text]) => { const cell = document.createElement(tag); cell.textContent = text; tr.append(cell); });
  return tr;
}

function draw() {
  if (setup === null) return;
  drawSpace(document.getElementById("space"), setup, at, camera, document.getElementById("frame").value);
  NAMES.forEach((name, k) => drawMap(document.getElementById(`map-${name}`), setup, grid[k], k, at));
  const values = place(setup, ...at), normal = surfaceNormal(setup, ...at);
  document.getElementById("where").textContent = `u = ${show(at[0], 4)} rad, θ = ${show(at[1], 4)} rad`;
  document.getElementById("readout").replaceChildren(...NAMES.map((name, k) => row([name, show(values[k], 6), UNITS[k]])));
  document.getElementById("foot").textContent = `F = [${surfacePoint(setup, ...at).map(v => show(v, 4)).join(", ")}] mm,  n = [${normal.map(v => show(v, 6)).join(", ")}]`;
}

function selfCheck() {
  const [mm, deg] = largestDifference(setup, run.points);
  const fine = mm < 1e-9 && deg < 1e-9;
  const element = document.getElementById("check");
  element.textContent = `${fine ? "✓" : "✗"} This page against trueaxis at ${run.points.length} points of the run: largest difference ${mm.toExponential(1).replace("-", MINUS)} mm, ${deg.toExponential(1).replace("-", MINUS)}°.`;
  element.className = fine ? "fine" : "wrong";
}

function csv() {
  const lines = ["u_rad,theta_rad,x_mm,y_mm,z_mm,a_deg,c_deg"];
  let before = null;
  for (const u of between(setup.u, number("u_count"))) for (const t of between(setup.theta, number("theta_count"))) {
    const values = place(setup, u, t);
    if (before !== null && Math.abs(values[4] - before) > 180 + 1e-9) values[4] -= 360 * Math.round((values[4] - before) / 360);
    before = values[4];
    lines.push([u, t, ...values].join(","));
  }
  return lines.join("\n") + "\n";
}

// The other flank is the mirror image: u changes its sign with it.
field("flank").addEventListener("input", () => {
  const sign = field("flank").value === "right" ? 1 : -1;
  for (const name of ["u_start", "u_stop"]) if (number(name) * sign < 0) field(name).value = -number(name);
});
for (const input of fields) input.addEventListener("input", recompute);
document.getElementById("frame").addEventListener("change", draw);
document.getElementById("inputs").addEventListener("submit", event => event.preventDefault());
document.getElementById("back").addEventListener("click", () => { fill(run.inputs, run.surface); at = null; recompute(); });
document.getElementById("save").addEventListener("click", () => {
  if (document.body.classList.contains("stale")) return;
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([csv()], { type: "text/csv" }));
  link.download = "helicoid.csv";
  link.click();
  URL.revokeObjectURL(link.href);
});
for (const name of NAMES) {
  const canvas = document.getElementById(`map-${name}`);
  const follow = event => {
    if (setup === null) return;
    const box = canvas.getBoundingClientRect();
    const s = (event.clientX - box.left - FRAME.left) / (box.width - FRAME.left - FRAME.right);
    const t = 1 - (event.clientY - box.top - FRAME.top) / (box.height - FRAME.top - FRAME.bottom);
    if (s < 0 || s > 1 || t < 0 || t > 1) return;
    const [u0, u1] = ordered(setup.u), [t0, t1] = ordered(setup.theta);
    at = [u0 + s * (u1 - u0), t0 + t * (t1 - t0)];
    draw();
  };
  canvas.addEventListener("pointermove", follow);
  canvas.addEventListener("pointerdown", follow);
}
const space = document.getElementById("space");
space.addEventListener("pointerdown", event => space.setPointerCapture(event.pointerId));
space.addEventListener("pointermove", event => {
  if (event.buttons === 0) return;
  camera.yaw -= event.movementX * 0.008;
  camera.pitch = Math.min(Math.max(camera.pitch + event.movementY * 0.008, -1.5), 1.5);
  draw();
});
space.addEventListener("wheel", event => {
  event.preventDefault();
  camera.zoom = Math.min(Math.max(camera.zoom * Math.exp(-event.deltaY * 0.001), 0.3), 8);
  draw();
}, { passive: false });
window.addEventListener("resize", draw);

fill(run.inputs, run.surface);
recompute();
selfCheck();
