// Tests with instruments: every table against the command line, changes to the machine, bad records.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, drop, expanded, numbers, openDesk, root, run, saved, shot, view } from "./harness.mjs";

const folder = fs.mkdtempSync(path.join(os.tmpdir(), "evaluate-"));
const sample = (name) => path.join(root, "compensation-tables", name);
after(async () => {
  fs.rmSync(folder, { recursive: true });
  await closeBrowser();
});

/** Noise of ±0.5, the same in every run. */
function noise(seed) {
  let state = seed;
  return () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0) / 2 ** 32 - 0.5);
}

const lines = (header, rows) => `${[header, ...rows.map((row) => row.join(","))].join("\n")}\n`;

/** A ball at 60, 20, 80 on the table of the trunnion of mill-5axis: it turns by the negative angle. */
function rTest() {
  const [rows, um] = [[], noise(3)];
  for (const a of [-90, -60, -30, 0, 20])
    for (let c = 0; c < 360; c += 45) {
      const [sa, ca, sc, cc] = [a, c].flatMap((deg) => [Math.sin((deg * Math.PI) / 180), Math.cos((deg * Math.PI) / 180)]);
      const [x, t] = [60 * cc + 20 * sc, 20 * cc - 60 * sc];
      rows.push([x, t * ca + 80 * sa, 80 * ca - t * sa, a, c, 4 * cc + um(), 3 * sa + um(), um()]);
    }
  return lines("x_mm,y_mm,z_mm,a_deg,c_deg,dx_um,dy_um,dz_um", rows);
}

/** Steps of 60, 40, 20 mm along four diagonals, away and back, twice; C0Y of 50 µrad and a wave of X. */
function steps() {
  const [rows, um] = [[], noise(5)];
  const signs = [[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]];
  signs.forEach((sign, k) => {
    const unit = sign.map((s, i) => (s * [3, 2, 1][i]) / Math.sqrt(14));
    const places = [[0, 0, 0]];
    for (let i = 0; i < 5; i++) for (const axis of [0, 1, 2]) places.push(places.at(-1).map((q, j) => q + (j === axis ? sign[j] * [60, 40, 20][j] : 0)));
    // Diagonals in either sense of an axis cover the same travel.
    const from = sign.map((s, i) => (s > 0 ? 0 : [300, 200, 100][i]));
    for (const run of [1, 2])
      for (const direction of [1, -1])
        for (const place of direction > 0 ? places : places.toReversed()) {
          const [x, y, z] = place.map((q, i) => q + from[i]);
          const error = [-0.05 * y + 2 * Math.sin(x / 60), 0, 0.01 * z];
          rows.push([k + 1, run, direction, x, y, z, (error[0] * unit[0] + error[2] * unit[2] + 0.2 * um()).toFixed(4)]);
        }
  });
  return lines("diagonal,run,direction,x_mm,y_mm,z_mm,deviation_um", rows);
}

/** Seven levels of X, six of Y, five of Z; C0Y of 40 µrad, a wave along X, the instrument turned. */
function points() {
  const [rows, um] = [[], noise(9)];
  for (let i = 0; i < 7; i++)
    for (let j = 0; j < 6; j++)
      for (let k = 0; k < 5; k++) {
        const [x, y, z] = [-240 + 80 * i, -150 + 60 * j, -300 + 75 * k];
        const [ex, ey, ez] = [-0.04 * y + 3 * Math.sin(x / 90) + um(), 0.02 * x + um(), 0.001 * z + um()];
        rows.push([x, y, z, x + 1e-3 * ex, y + 1e-3 * ey, z + 1e-3 * ez, 0.5]);
      }
  return lines("x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm,u_um", rows);
}

/** A lattice of X and Y with a scale of X, and a waviness of Y over X that tables follow. */
function plate(scale, seed) {
  const [rows, um] = [[], noise(seed)];
  for (let i = 0; i < 9; i++)
    for (let j = 0; j < 7; j++) {
      const [x, y] = [-160 + 40 * i, -120 + 40 * j];
      rows.push([x, y, -60, x + 1e-3 * (scale * x + um()), y + 1e-3 * (6 * Math.sin(1.7 * i) + um()), -60]);
    }
  return lines("x_mm,y_mm,z_mm,actual_x_mm,actual_y_mm,actual_z_mm", rows);
}

/** 36 points in each of four runs, the spindle turned by 90°, the tip 4 µm off. */
function ring() {
  const [rows, um] = [[], noise(11)];
  for (let run = 1; run <= 4; run++)
    for (let k = 0; k < 36; k++) {
      const [t, s] = [(10 * k * Math.PI) / 180, (Math.PI / 2) * (run - 1)];
      const r = 22 + 1e-3 * (Math.cos(3 * t) + um());
      rows.push([100 + r * Math.cos(t) + 4e-3 * Math.cos(s), 50 + r * Math.sin(t) + 4e-3 * Math.sin(s), -20, run, 90 * (run - 1)]);
    }
  return lines("x_mm,y_mm,z_mm,run,spindle_deg", rows);
}

/** Two hours of a warming spindle. */
function warming() {
  const [rows, um] = [[], noise(13)];
  for (let t = 0; t <= 7200; t += 30) {
    const warm = 1 - Math.exp(-t / 1800);
    rows.push([t, 5 * warm + 0.2 * um(), 20 * warm + 0.2 * um(), 7 * warm + 0.2 * um(), (20 + t / 3600 + 0.05 * um()).toFixed(3), (20 + 12 * warm).toFixed(3)]);
  }
  return lines("t_s,x1_um,z_um,x2_um,ambient_c,spindle_c", rows);
}

const records = { "bk.csv": rTest(), "steps.csv": steps(), "points.csv": points(), "plate.csv": plate(0.04, 3), "again.csv": plate(0.04, 4), "other.csv": plate(-0.04, 5), "ring.csv": ring(), "warming.csv": warming() };
for (const [name, text] of Object.entries(records)) fs.writeFileSync(path.join(folder, name), text);

const near = (found, needed, what) => assert.ok(Math.abs(found - needed) <= 1e-9 * Math.max(1, Math.abs(needed)), `${what}: found ${found}, the command line has ${needed}`);
const evaluate = (given) => cli(["evaluate", ...given, "--json"], { cwd: folder });

async function opened(machine) {
  const desk = await openDesk();
  if (machine)
    await desk.page.evaluate(async (name) => {
      const { bench, machine } = globalThis.trueaxisDesk;
      machine.set(name, JSON.parse(await bench.call("machine_sample", name)));
    }, machine);
  return { ...desk, panel: await view(desk.page, "Tests") };
}

/** Drops a record and waits for the first words of its status. */
async function dropped(panel, name, title) {
  await drop(panel, { [name]: records[name] });
  await panel.getByText(`${title}, ${name}`).waitFor();
}

const shownTable = (panel, name) => numbers(panel.getByRole("table", { name, exact: true }));
const code = (panel) => panel.locator("code").first().textContent();

/** Saves a picture of the whole view. */
async function pictured(page, name) {
  await page.evaluate(() => scrollTo(0, 0));
  await page.setViewportSize({ width: 1400, height: await page.evaluate(() => document.body.scrollHeight) });
  await page.waitForTimeout(300);
  assert.ok(await page.evaluate(() => document.documentElement.scrollWidth <= innerWidth), `${name}: wider than the page`);
  await shot(page, name);
}

/** Puts the results into the machine and compares its files with those that the command line wrote into a folder. */
async function put(page, panel, written) {
  await panel.getByRole("button", { name: "Put into the machine" }).click();
  await panel.getByText(/^In .* now\.$/).waitFor();
  const files = await page.evaluate(() => globalThis.trueaxisDesk.machine.files);
  for (const name of fs.readdirSync(path.join(folder, written))) assert.equal(files[name], fs.readFileSync(path.join(folder, written, name), "utf8"), name);
}

test("before a record the page shows the columns of records", async () => {
  const { page, panel, close } = await opened();
  const rows = await shownTable(panel, "Columns of a record");
  assert.equal(Object.keys(rows).length, 5);
  await panel.getByText("Diagonal displacement test, step-diagonal.csv").waitFor();
  await pictured(page, "tests");
  // A selected test without a sample shows its options and its command line before the user drops a record.
  await panel.getByLabel("Kind of test").selectOption("r-test");
  assert.equal(await code(panel), "trueaxis evaluate r-test record.csv --machine mill-3axis -o mill-3axis");
  await close();
});

test("an R-test has the location errors of the command line, and writes none if it does not fit the machine", async () => {
  const { page, panel, close } = await opened("mill-5axis");
  await dropped(panel, "bk.csv", "R-test");
  const found = await evaluate(["r-test", "bk.csv", "--machine", sample("mill-5axis"), "-o", "five"]);
  const terms = await shownTable(panel, "Location errors");
  assert.deepEqual(Object.keys(terms), found.terms.map(({ name }) => name));
  expanded(found.terms.map(({ name, standard_error }) => [terms[name]["± 95 %"], standard_error]));
  for (const { name, value, before, unit } of found.terms) {
    near(terms[name].found, value, name);
    near(terms[name]["machine has"], before, name);
    assert.equal(terms[name].unit, unit === "um" ? "µm" : "µrad");
  }
  const fit = await shownTable(panel, "Fit");
  near(fit["left, RMS, µm"].value, found.left_rms_um, "left");
  assert.equal(fit["in line"].value, found.left_max_line);
  assert.deepEqual(await panel.getByRole("list", { name: "Notes" }).getByRole("listitem").allTextContents(), found.notes);
  assert.equal(await code(panel), "trueaxis evaluate r-test bk.csv --machine mill-5axis -o mill-5axis");
  const plot = panel.getByRole("img", { name: "Residuals of the location errors" });
  await plot.focus();
  await page.keyboard.press("Home");
  assert.match(await plot.locator("xpath=following-sibling::output").textContent(), /reading: 1\.0000\s+along X \S+ µm\s+along Y/);
  await pictured(page, "tests-r-test");

  await panel.getByLabel("The nest was not calibrated").check();
  await panel.getByLabel("Location errors that keep").fill("EY0A EZ0A EX0C");
  await panel.getByLabel("Centre of the nest").fill("0 0 -50");
  await panel.getByRole("row", { name: /^zero of the nest/ }).waitFor();
  const options = ["--tool-mm", "0,0,-50", "--without", "EY0A,EZ0A,EX0C", "--free-sensor"];
  assert.equal(await code(panel), `trueaxis evaluate r-test bk.csv ${options.join(" ")} --machine mill-5axis -o mill-5axis`);
  const other = await evaluate(["r-test", "bk.csv", "--machine", sample("mill-5axis"), ...options]);
  await panel.getByText(`rank ${other.rank}`).waitFor();
  const places = await shownTable(panel, "Places");
  near(places["zero of the nest, tool's frame"].X, other.sensor_um[0], "zero of the nest");
  assert.equal(Object.keys(await shownTable(panel, "Location errors")).length, other.terms.length);
  await panel.getByLabel("Location errors that keep").fill("");
  await panel.getByLabel("The nest was not calibrated").uncheck();
  await panel.getByLabel("Centre of the nest").fill("");
  await panel.locator("code").getByText("trueaxis evaluate r-test bk.csv --machine mill-5axis -o mill-5axis", { exact: true }).waitFor();
  await panel.getByRole("rowheader", { name: "EX0C", exact: true }).waitFor();
  // No machine with the sample's tables moves the ball like this: neither the page nor the command line writes anything.
  await panel.getByText(/^location\.EX0C_um: found .*misfit: /).waitFor();
  assert.ok(await panel.getByRole("button", { name: "Put into the machine" }).isDisabled());
  for (const name of fs.readdirSync(path.join(folder, "five"))) assert.equal(fs.readFileSync(path.join(folder, "five", name), "utf8"), fs.readFileSync(path.join(sample("mill-5axis"), name), "utf8"), name);
  await close();
});

test("diagonals have the figures of the command line, and the machine their squareness", async () => {
  const { page, panel, close } = await opened();
  await dropped(panel, "steps.csv", "Diagonal displacement test");
  await panel.getByLabel("Standard uncertainty of the mirror").fill("20");
  await panel.getByLabel("Standard uncertainty of the mirror").press("Tab");
  await panel.getByRole("row", { name: /^scale X .*\d/ }).first().waitFor();
  const found = await evaluate(["step-diagonal", "steps.csv", "--alignment-urad", "20", "--machine", sample("mill-3axis"), "-o", "squared"]);
  await panel.getByRole("rowheader", { name: "scale X", exact: true }).waitFor();
  const figures = await shownTable(panel, "Figures of ISO 230-6");
  for (const { diagonal, e_um, b_um, m_um, r_um } of found.diagonals) {
    const own = figures[`diagonal ${diagonal}`];
    for (const [name, um] of [["E", e_um], ["B", b_um], ["M", m_um], ["R", r_um]]) near(own[`${name}(D), µm`], um, `${name}(${diagonal})`);
  }
  near(figures.largest["E(D), µm"], found.e_d_um, "E_d");
  const terms = await shownTable(panel, "Results of the diagonals");
  near(terms["squareness C0Y"].value, found.c0y_urad.value, "C0Y");
  expanded([[terms["squareness C0Y"]["± 95 %"], found.c0y_urad.standard_error]]);
  near(terms["scale Z"].value, found.steps.scales_ppm[2].value, "scale Z");
  assert.ok(Math.abs(terms["squareness C0Y"].value - 50) < 3);
  assert.equal(await panel.getByRole("img", { name: /^Errors of [XYZ], slopes removed/ }).count(), 3);
  assert.equal(await code(panel), "trueaxis evaluate step-diagonal steps.csv --alignment-urad 20 --machine mill-3axis -o mill-3axis");
  await pictured(page, "tests-diagonal");
  await put(page, panel, "squared");
  await close();
});

test("measured points have the 21 errors of the command line, and become a machine", async () => {
  const { page, panel, close } = await opened();
  await dropped(panel, "points.csv", "Measured points");
  const found = await evaluate(["points", "points.csv", "--machine", sample("mill-3axis"), "-o", "measured"]);
  const errors = await shownTable(panel, "All errors");
  assert.equal(Object.keys(errors).length, found.functions.length + 3);
  expanded(found.functions.map(({ name, standard_error }) => [errors[name]["± 95 %"], standard_error]));
  for (const { name, range } of found.functions) {
    near(errors[name].from, range[0], name);
    near(errors[name].to, range[1], name);
  }
  const left = await shownTable(panel, "Residuals of the points");
  near(left["held out"].RMS, found.held_out.rms_um, "held out");
  // The map's cells are root mean squares: the largest lies between the RMS of all residuals and the largest residual.
  const map = panel.getByRole("table", { name: /^Root mean square of the residuals over X and Y/ });
  const cells = await map.locator("td[data-value]").evaluateAll((all) => all.map((cell) => Number(cell.dataset.value)));
  assert.ok(cells.length > 20 && Math.max(...cells) <= found.left.max_um && Math.max(...cells) >= found.left.rms_um);
  assert.equal(await code(panel), "trueaxis evaluate points points.csv --machine mill-3axis -o mill-3axis-measured");
  await pictured(page, "tests-points");
  await put(page, panel, "measured");
  await close();
});

test("points of a plate have the models of the command line, and a second record tests them", async () => {
  const { page, panel, close } = await opened();
  const both = async (second) => {
    await drop(panel, { "plate.csv": records["plate.csv"], [second]: records[second] });
    await panel.getByRole("rowheader", { name: second, exact: true }).waitFor();
  };
  await both("again.csv");
  const found = await evaluate(["points", "plate.csv", "--machine", sample("mill-3axis"), "--against", "again.csv", "-o", "plate"]);
  assert.ok(found.transfer.transfers && found.model.startsWith("tables"), found.model);
  const models = await shownTable(panel, "Models, by their errors at held-out points");
  for (const { model, held_out_um, rank } of found.models) {
    if (held_out_um === null) assert.equal(models[model]["held out, µm"], "–", model);
    else near(models[model]["held out, µm"], held_out_um, model);
    near(models[model].rank, rank, model);
  }
  near((await shownTable(panel, "Terms in another record"))["again.csv"]["with these terms"], found.transfer.after_um, "transfer");
  assert.equal(await code(panel), "trueaxis evaluate points plate.csv --against again.csv --machine mill-3axis -o mill-3axis-measured");
  await pictured(page, "tests-plate");
  await both("other.csv");
  await panel.getByText(/^the terms do not transfer to other\.csv.*nothing is written$/).first().waitFor();
  assert.equal(await panel.getByRole("button", { name: "Put into the machine" }).count(), 0);
  await both("again.csv");
  await put(page, panel, "plate");
  await close();
});

test("probing and thermal tests have the figures of the command line, and change no machine", async () => {
  const { page, panel, close } = await opened();
  await dropped(panel, "ring.csv", "Probing test");
  await panel.getByLabel("Calibrated diameter / mm").fill("50.0012");
  await panel.getByLabel("Calibrated diameter / mm").press("Tab");
  await panel.getByRole("rowheader", { name: "effective diameter of the tip" }).waitFor();
  const given = ["probing", "ring.csv", "--feature", "ring", "--diameter-mm", "50.0012"];
  assert.equal(await code(panel), `trueaxis evaluate ${given.join(" ")}`);
  const found = await evaluate(given);
  const runs = await shownTable(panel, "Runs");
  for (const { run, points, diameter_mm, form_um, centre_mm } of found.runs) {
    const own = runs[`run ${run}`];
    assert.equal(own.points, points);
    near(own["diameter, mm"], diameter_mm, "diameter");
    near(own["P_FTU, µm"], form_um, "form");
    near(own["X, mm"], centre_mm[0], "centre");
  }
  const figures = await shownTable(panel, "Figures of ISO 230-10");
  near(figures["P_FTU,2D"].value, found.p_ftu_um, "P_FTU");
  near(figures["offset of the stylus tip, X"].value, found.tip_offset.x_um.value, "offset");
  expanded(["x", "y"].map((axis) => [figures[`offset of the stylus tip, ${axis.toUpperCase()}`]["± 95 %"], found.tip_offset[`${axis}_um`].standard_error]));
  near(figures["effective diameter of the tip"].value, found.effective_tip_diameter_mm, "diameter of the tip");
  await pictured(page, "tests-probing");

  await dropped(panel, "warming.csv", "Thermal test");
  await panel.getByLabel("Distance of the probes").fill("100");
  await panel.getByLabel("Distance of the probes").press("Tab");
  await panel.getByRole("rowheader", { name: "B", exact: true }).waitFor();
  const thermal = await evaluate(["thermal", "warming.csv", "--distance-mm", "100"]);
  const drifts = await shownTable(panel, "Figures of ISO 230-3");
  for (const { name, range, first_period, worst_period, end } of thermal.positions[0].channels) {
    near(drifts[name].range, range, name);
    near(drifts[name]["first period"], first_period, name);
    near(drifts[name]["worst period"], worst_period, name);
    near(drifts[name].end, end, name);
  }
  assert.equal(await code(panel), "trueaxis evaluate thermal warming.csv --test spindle --period-min 60 --distance-mm 100");
  assert.ok(await panel.getByRole("button", { name: "Put into the machine" }).isHidden());
  await pictured(page, "tests-thermal");
  await close();
});

test("a record that cannot be used is refused in the command line's words, and nothing of before stays", async () => {
  const { page, panel, close } = await opened();
  const cut = (name, from, to) => records[name].split("\n").toSpliced(from, to).join("\n");
  const changed = (name, line, from, to) => records[name].split("\n").map((row, i) => (i === line - 1 ? row.replace(from, to) : row)).join("\n");
  const mill = ["--machine", sample("mill-3axis")];
  const cases = [
    ["number.csv", changed("warming.csv", 9, /,[^,]*$/, ",warm"), ["thermal"]],
    ["column.csv", changed("bk.csv", 1, "dz_um", "dz"), ["r-test", ...mill]],
    ["angle.csv", records["bk.csv"], ["r-test", ...mill]],
    ["short.csv", cut("steps.csv", 200, 400), ["step-diagonal"]],
    ["twice.csv", changed("points.csv", 3, /^[^,]*,[^,]*,[^,]*/, "-240,-150,-300"), ["points", ...mill]],
    ["open.csv", cut("ring.csv", 4, 200), ["probing", "--feature", "ring"]],
  ];
  for (const [name, content, given] of cases) {
    await dropped(panel, "warming.csv", "Thermal test");
    fs.writeFileSync(path.join(folder, name), content);
    const refused = await run("trueaxis", ["evaluate", given[0], name, ...given.slice(1)], { cwd: folder });
    assert.equal(refused.code, 2, name);
    await drop(panel, { [name]: content });
    const alert = page.getByRole("alert").filter({ hasText: name });
    await alert.waitFor();
    assert.equal(await alert.locator("span").textContent(), refused.stderr.trim().split("\n").at(-1).replace(/^error: /, ""));
    assert.ok(await panel.getByRole("table", { name: "Figures of ISO 230-3" }).isHidden());
  }
  // Columns of no test; a selected test that does not match the columns; an option out of its range.
  await drop(panel, { "other.csv": "angle_deg,deviation\n0,1\n" });
  await page.getByRole("alert").filter({ hasText: "other.csv:1: found columns angle_deg, deviation, needed those of one of step-diagonal (diagonal" }).waitFor();
  await panel.getByLabel("Kind of test").selectOption("probing");
  await drop(panel, { "warming.csv": records["warming.csv"] });
  await page.getByRole("alert").filter({ hasText: "warming.csv:1: column t_s: found t_s, needed one of x_mm, y_mm" }).waitFor();
  await panel.getByLabel("Kind of test").selectOption("");
  await panel.getByText("Thermal test, warming.csv").waitFor();
  await panel.getByLabel("Period / min").fill("0");
  await panel.getByLabel("Period / min").press("Tab");
  await page.getByRole("alert").filter({ hasText: "--period-min: found 0, needed 0.1 to 100000 min" }).waitFor();
  await close();
});

test("a file opens test and options again", async () => {
  const { page, panel, close } = await opened();
  await panel.getByLabel("Kind of test").selectOption("thermal");
  await panel.getByLabel("Period / min").fill("30");
  await panel.getByLabel("Period / min").press("Tab");
  await panel.getByText("--period-min 30").waitFor();
  assert.equal(await code(panel), "trueaxis evaluate thermal spindle.csv --test spindle --period-min 30");
  await drop(panel, { "warming.csv": records["warming.csv"] });
  await panel.getByText("Thermal test, warming.csv").waitFor();
  const kept = await saved(page, page.getByRole("button", { name: "Save", exact: true }));
  await close();
  const second = await opened();
  await second.page.getByLabel("Open", { exact: true }).setInputFiles({ name: "trueaxis.desk.json", mimeType: "application/json", buffer: kept.bytes });
  await second.panel.getByText("drop it again").waitFor();
  assert.equal(await code(second.panel), "trueaxis evaluate thermal record.csv --test spindle --period-min 30");
  await second.close();
});
