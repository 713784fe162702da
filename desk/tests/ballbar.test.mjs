// Circular tests: figures against the command line, every form of a record, changes to the machine, bad records.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, drop, numbers, openDesk, root, run, saved, shot, view } from "./harness.mjs";

const folder = fs.mkdtempSync(path.join(os.tmpdir(), "ballbar-"));
after(async () => {
  fs.rmSync(folder, { recursive: true });
  await closeBrowser();
});

/** Noise of ±0.1 µm, the same in every run. */
function noise(seed) {
  let state = seed;
  return () => {
    state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
    return 0.2 * (state / 2 ** 32 - 0.5);
  };
}

/** A record at 100 mm: C0Y of 50 µrad, a lost motion of 5 µm in X, and a pivot 20 µm off. */
function bar() {
  const [lines, um] = [["angle_deg,deviation_um,direction"], noise(7)];
  for (const d of [1, -1])
    for (let k = 0; k < 360; k++) {
      const t = ((k + 0.5) * Math.PI) / 180;
      const [x, y] = [100 * Math.cos(t), 100 * Math.sin(t)];
      const moved = x - 50e-6 * y + 0.0025 * Math.sign(d * Math.sin(t)) + 0.02;
      lines.push(`${k + 0.5},${1e3 * (Math.hypot(moved, y) - 100) + um()},${d}`);
    }
  return `${lines.join("\n")}\n`;
}

/** Commanded and actual positions on a circle of 40 mm in Z and X: a lost motion of 3 µm in X, 30 µrad. */
function places() {
  const rows = [];
  for (const d of [1, -1])
    for (let k = 0; k <= 1440; k++) {
      const t = ((0.25 * d * k + 0.1) * Math.PI) / 180;
      const [a, b] = [40 * Math.cos(t), 40 * Math.sin(t)];
      rows.push([7 + a, 7 + a - 30e-6 * b, -3 + b, -3 + b - 0.0015 * Math.sign(d * Math.cos(t))]);
    }
  return rows;
}

const record = path.join(folder, "record.csv");
fs.writeFileSync(record, bar());

/** The page computes with the browser's trigonometric functions, whose last bit may differ. */
function near(found, needed, what) {
  if (needed === null) return assert.equal(found, "–", what);
  assert.ok(Math.abs(found - needed) <= 1e-6 * Math.max(1, Math.abs(needed)), `${what}: found ${found}, the command line has ${needed}`);
}

async function figures(panel, found) {
  const iso = await numbers(panel.getByRole("table", { name: "ISO 230-4" }));
  near(iso["G, circular deviation"]["both directions"], found.g_b_um, "G(b)");
  for (const [column, way] of [["counterclockwise", "ccw"], ["clockwise", "cw"]])
    for (const [row, key] of [["G, circular deviation", "g_um"], ["F max", "f_max_um"], ["F min", "f_min_um"]]) near(iso[row][column], found[key][way], `${key} ${way}`);
  near(iso["H, hysteresis"]["both directions"], found.h_um, "H");
  const shares = await numbers(panel.getByRole("table", { name: "Causes in the order" }));
  assert.deepEqual(Object.keys(shares).slice(0, 3), found.shares.slice(0, 3).map(({ cause }) => cause));
  for (const { cause, share, rms_um } of found.shares) {
    near(shares[cause]["share, %"], 100 * share, cause);
    near(shares[cause]["RMS, µm"], rms_um, cause);
  }
  const fit = await numbers(panel.getByRole("table", { name: "Fit" }));
  const values = await numbers(panel.getByRole("table", { name: "Values of the causes" }));
  near(values[`centre ${found.plane[0]}`].value, found.centre_um[0], "centre");
  near(values[`squareness ${found.squareness}`].value, found.squareness_urad, "squareness");
  near(values[`squareness ${found.squareness}`]["± 95 %"], found.expanded_uncertainties.squareness_urad, "squareness, uncertainty");
  near(fit["sigma of a reading, µm"].value, found.sigma_um, "sigma");
}

async function opened() {
  const desk = await openDesk();
  return { ...desk, panel: await view(desk.page, "Ballbar") };
}

const code = (panel) => panel.locator("code").first().textContent();

test("a bar's record has the figures of trueaxis ballbar, and the machine gets the changes that it writes", async () => {
  const { page, panel, close } = await opened();
  await drop(panel, { "record.csv": fs.readFileSync(record) });
  await panel.getByText("record.csv: 720 readings, plane XY, radius 100").waitFor();
  assert.equal(await code(panel), "trueaxis ballbar record.csv --radius-mm 100 --axes X,Y --machine mill-3axis -o mill-3axis");
  const found = await cli(["ballbar", record, "--radius-mm", "100", "--json"]);
  await figures(panel, found);
  // The texts of the values equal those that the command line prints.
  const { stdout } = await run("trueaxis", ["ballbar", record, "--radius-mm", "100"]);
  const rows = await panel.getByRole("table", { name: "Values of the causes" }).locator("tbody tr").all();
  const printed = new Set(stdout.split("\n").map((line) => line.trim().replace(/\s+/g, " ")));
  for (const row of rows) assert.ok(printed.has((await row.locator("th, td").allTextContents()).join(" ").trim().replace(/\s+/g, " ")));

  // The two polar plots react to the keyboard.
  const polar = panel.getByRole("img", { name: "Seen from the circle's centre" });
  await polar.focus();
  await page.keyboard.press("Home");
  await page.keyboard.press("Shift+ArrowRight");
  assert.match(await polar.locator("xpath=following-sibling::output").textContent(), /20\.5°\s+counterclockwise .* µm\s+clockwise .* µm/);
  await page.evaluate(() => scrollTo(0, 0));
  await page.setViewportSize({ width: 1400, height: await page.evaluate(() => document.body.scrollHeight) });
  await shot(page, "ballbar");

  // Changed settings, first without `--compensated`, then with it.
  const settings = await numbers(panel.getByRole("table", { name: "Settings that change" }));
  assert.deepEqual(Object.keys(settings), ["axis.X.backlash_um", "axis.Y.backlash_um", "location.C0Y_urad"]);
  near(settings["location.C0Y_urad"].before, 38, "C0Y before");
  assert.ok(Math.abs(settings["location.C0Y_urad"].after - 50) < 1, "C0Y after");
  await panel.getByText("axis.Y.backlash_um: found").waitFor();
  for (const more of [[], ["--compensated"]]) {
    if (more.length > 0) {
      await view(page, "Machine");
      await panel.page().getByLabel("Sample machine").selectOption("grinder");
      await panel.page().getByLabel("Sample machine").selectOption("mill-3axis");
      await view(page, "Ballbar");
      await drop(panel, { "record.csv": fs.readFileSync(record) });
      await panel.getByLabel("tables corrected it").check();
    }
    const to = path.join(folder, `new${more.length}`);
    const { code, stderr } = await run("trueaxis", ["ballbar", record, "--radius-mm", "100", "--machine", path.join(root, "compensation-tables/mill-3axis"), "-o", to, ...more]);
    assert.equal(code, 0, stderr);
    const put = panel.getByRole("button", { name: "Put into the machine" });
    await put.click();
    await panel.getByText("In mill-3axis now.").waitFor();
    const toml = await page.evaluate(() => globalThis.trueaxisDesk.machine.files["machine.toml"]);
    assert.equal(toml, fs.readFileSync(path.join(to, "machine.toml"), "utf8"));
    // The page offers the changes only once.
    assert.ok(await put.isDisabled());
  }
  await close();
});

test("positions come in another plane and in other forms", async () => {
  const { panel, close } = await opened();
  await panel.getByLabel("Nominal radius / mm").fill("40");
  await panel.getByLabel("Nominal radius / mm").press("Tab");
  await panel.getByLabel("Axes of the plane").selectOption("Z,X");
  const rows = places();
  const files = {
    "grid.csv": `z_cmd_mm,z_mm,x_cmd_mm,x_mm\n${rows.map((row) => row.join(",")).join("\n")}\n`,
    "samples.txt": rows.map((row, k) => `${k} ${row.join(" ")}\n`).join(""),
  };
  for (const [name, text] of Object.entries(files)) {
    const file = path.join(folder, name);
    fs.writeFileSync(file, text);
    await drop(panel, { [name]: text });
    await panel.getByText(`${name}: `).waitFor();
    await figures(panel, await cli(["ballbar", file, "--radius-mm", "40", "--axes", "Z,X", "--json"]));
    await panel.getByText("computed from positions").waitFor();
  }
  // The user states a pitch.
  await panel.getByLabel("Pitch of X / mm").fill("10");
  await panel.getByLabel("Pitch of X / mm").press("Tab");
  assert.match(await code(panel), /samples\.txt --radius-mm 40 --axes Z,X --pitch-x-mm 10 /);
  // The status names the record again once it has been evaluated.
  await panel.getByText("samples.txt: ").waitFor();
  await figures(panel, await cli(["ballbar", path.join(folder, "samples.txt"), "--radius-mm", "40", "--axes", "Z,X", "--pitch-x-mm", "10", "--json"]));
  await close();
});

test("a record that cannot be used is refused in the command line's words", async () => {
  const { panel, page, close } = await opened();
  const good = fs.readFileSync(record, "utf8").split("\n");
  const cases = {
    "direction.csv": good.with(9, "8.5,1.0,0").join("\n"),
    "number.csv": good.with(4, "3.5,one,1").join("\n"),
    "gap.csv": good.slice(0, 150).join("\n"),
    "other.csv": good.with(0, "angle_deg,p1_um,direction").join("\n"),
    "zeros.bin": Buffer.alloc(40),
  };
  for (const [name, content] of Object.entries(cases)) {
    fs.writeFileSync(path.join(folder, name), content);
    const refused = await run("trueaxis", ["ballbar", name, "--radius-mm", "100"], { cwd: folder });
    assert.equal(refused.code, 2);
    await drop(panel, { [name]: content });
    const alert = page.getByRole("alert").filter({ hasText: name });
    await alert.waitFor();
    assert.equal(await alert.locator("span").textContent(), refused.stderr.trim().replace(/^error: /, ""));
    assert.ok(await panel.getByRole("table", { name: "ISO 230-4" }).isHidden());
  }
  await drop(panel, { "record.csv": good.join("\n") });
  await panel.getByText("record.csv: 720 readings").waitFor();
  await panel.getByLabel("Nominal radius / mm").fill("0");
  await panel.getByLabel("Nominal radius / mm").press("Tab");
  await page.getByRole("alert").filter({ hasText: "--radius-mm: found 0, needed 0.001 to 100000 mm" }).waitFor();
  await close();
});

test("a file opens what belongs to a record again", async () => {
  const { panel, page, close } = await opened();
  await drop(panel, { "record.csv": fs.readFileSync(record) });
  await panel.getByText("record.csv: 720 readings").waitFor();
  await panel.getByLabel("Nominal radius / mm").fill("150");
  await panel.getByLabel("Nominal radius / mm").press("Tab");
  await panel.getByLabel("Pitch of Y / mm").fill("5");
  await panel.getByLabel("Pitch of Y / mm").press("Tab");
  const kept = await saved(page, page.getByRole("button", { name: "Save", exact: true }));
  await close();
  const second = await opened();
  await second.page.getByLabel("Open", { exact: true }).setInputFiles({ name: "trueaxis.desk.json", mimeType: "application/json", buffer: kept.bytes });
  await second.panel.getByText("drop it again").waitFor();
  assert.match(await code(second.panel), /--radius-mm 150 --axes X,Y --pitch-y-mm 5 /);
  assert.equal(await second.panel.getByLabel("Nominal radius / mm").inputValue(), "150");
  await second.close();
});
