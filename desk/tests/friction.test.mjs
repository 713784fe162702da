// Friction: figures against the command line, bad records, the closed loop, the keyboard.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, before, test } from "node:test";
import { cli, closeBrowser, drop, expanded, numbers, openDesk, run, saved, shot, sim, view } from "./harness.mjs";

const CIRCLES = ["--radius-mm", "10.0037", "--feeds", "1500,700", "--turns", "1"];
const folder = fs.mkdtempSync(path.join(os.tmpdir(), "friction-"));
const record = path.join(folder, "record.csv");
let simulated;

before(async () => {
  simulated = await sim(["friction", "--json", ...CIRCLES, "-o", record]);
});
after(async () => {
  fs.rmSync(folder, { recursive: true });
  await closeBrowser();
});

/**
 * Compares to a tenth of the last printed digit: the last bit of the exponential function differs between browser and host.
 * `slack`: additional tolerance for simulated records, where an encoder count may differ for the same reason.
 */
function near(found, needed, digits, what, slack = 0) {
  if (needed === null || needed === found) return;
  const unit = 10 ** (Math.floor(Math.log10(Math.abs(needed))) + 1 - digits);
  assert.ok(Math.abs(found - needed) <= Math.max(0.1 * unit, slack), `${what}: found ${found}, the command line has ${needed}`);
}

const ROWS = {
  "Coulomb friction F_c/K_vp, mm/s": "coulomb_mm_per_s",
  "pre-sliding z, µm": "presliding_um",
  "Stribeck share s": "stribeck_share",
  "Stribeck velocity v_s, mm/s": "stribeck_velocity_mm_per_s",
  "viscous friction d/K_vp": "viscous",
  "position gain K_v, 1/s": "position_gain_per_s",
  "velocity gain K_vp, 1/s": "velocity_gain_per_s",
  "reset time τ, s": "reset_time_s",
  "velocity feed-forward k_ff": "velocity_feed_forward",
};

/** Compares the page's table with figures by axis. `share`: tolerance as a share of the standard error. */
async function figures(panel, axes, value, share = 0) {
  const shown = await numbers(panel.getByRole("table", { name: "Figures found" }));
  for (const own of axes) {
    const pairs = [];
    for (const [name, key] of Object.entries(ROWS)) {
      const error = own.standard_errors[key];
      const uncertainty = shown[name][`± 95 %, ${own.axis}`];
      near(shown[name][own.axis], value(own, key), 4, `${own.axis} ${key}`, share * error);
      if (error === null) assert.match(uncertainty, /held|the machine's/);
      else pairs.push([uncertainty, error]);
    }
    // One unit of the second printed digit between browser and host.
    expanded(pairs, 0.02);
  }
}

async function circles(panel) {
  await panel.getByLabel("Radius / mm").fill("10.0037");
  await panel.getByLabel("First feed / mm/min").fill("1500");
  await panel.getByLabel("Second feed / mm/min").fill("700");
  await panel.getByLabel("Second feed / mm/min").press("Tab");
}

async function opened() {
  const desk = await openDesk();
  const panel = await view(desk.page, "Friction");
  // The page opens with a record.
  await panel.getByRole("button", { name: "Find friction" }).and(panel.locator(":enabled")).waitFor({ timeout: 300_000 });
  return { ...desk, panel };
}

test("the round in simulation has the figures of firmware-sim friction", async () => {
  const { page, panel, close } = await opened();
  await circles(panel);
  await panel.getByRole("button", { name: "Simulate a record" }).click();
  await panel.getByText("samples at 10000 Hz").waitFor({ timeout: 300_000 });
  const command = await panel.locator("code").textContent();
  assert.equal(command, `firmware-sim friction --machine mill-3axis ${CIRCLES.join(" ")}`);

  await panel.getByRole("button", { name: "Find friction" }).click();
  await panel.getByText(/^Fitting axis X, step \d+$/).waitFor();
  await panel.getByText(/^Found\./).waitFor({ timeout: 300_000 });
  await figures(panel, simulated.axes, (own, key) => own.identified[key], 1e-3);
  const spikes = await numbers(panel.getByRole("table", { name: "Spikes at the reversals" }));
  for (const { axis, glitch_um } of simulated.axes) {
    near(spikes[`${axis} before, recorded`]["largest, µm"], glitch_um.before.max, 3, "before");
    near(spikes[`${axis} after, expected`]["RMS, µm"], glitch_um.expected.rms, 3, "expected");
  }

  await panel.getByRole("button", { name: "Simulate with these figures" }).click();
  await panel.getByText("Simulated with the figures found.").waitFor({ timeout: 300_000 });
  const again = await numbers(panel.getByRole("table", { name: "Spikes, simulated again" }));
  for (const { axis, glitch_um } of simulated.axes) {
    near(again[`${axis} before`]["largest, µm"], glitch_um.before.max, 3, "before");
    near(again[`${axis} after`]["largest, µm"], glitch_um.after.max, 3, "after");
    near(again[`${axis} after`]["RMS, µm"], glitch_um.after.rms, 3, "after");
    assert.ok(again[`${axis} after`]["largest, µm"] < 0.25 * again[`${axis} before`]["largest, µm"]);
  }
  const error = await numbers(panel.getByRole("table", { name: "Contour error of the tip" }));
  near(error.before["largest, µm"], simulated.contour_error_um.before.max, 3, "contour error before");
  near(error.after["RMS, µm"], simulated.contour_error_um.after.rms, 3, "contour error after");

  // The polar plots react to the keyboard; a readout states the numbers.
  const polar = panel.getByRole("img", { name: /counterclockwise/ }).first();
  await polar.focus();
  await page.keyboard.press("Home");
  await page.keyboard.press("Shift+ArrowRight");
  assert.match(await polar.locator("xpath=following-sibling::output").textContent(), /°\s+before, recorded .* µm/);

  // Puts the result into the machine, then undoes it.
  await panel.getByRole("button", { name: "Put into the machine" }).click();
  await panel.getByText("In mill-3axis's machine.toml now.").waitFor();
  const toml = await page.evaluate(() => globalThis.trueaxisDesk.machine.files["machine.toml"]);
  assert.match(toml, /\[axis\.Y\.friction\]/);
  const settings = await saved(page, panel.getByRole("button", { name: "Save friction.toml" }));
  assert.equal(settings.name, "friction.toml");
  assert.match(settings.bytes.toString(), /coulomb_mm_per_s = 0\.\d+ {2}# ± /);
  await page.evaluate(() => scrollTo(0, 0));
  await page.setViewportSize({ width: 1400, height: await page.evaluate(() => document.body.scrollHeight) });
  await page.waitForTimeout(300);
  await shot(page, "friction");
  await close();
});

test("a record that is dropped has the figures of trueaxis friction", async () => {
  const { panel, page, close } = await opened();
  await drop(panel, { "record.csv": fs.readFileSync(record) });
  await panel.getByText(/^record\.csv: \d+ samples/).waitFor({ timeout: 300_000 });
  await panel.getByLabel("Figures of the drives").selectOption({ label: "those that the machine states" });
  assert.equal(await panel.locator("code").textContent(), "trueaxis friction record.csv --axes X,Y --machine mill-3axis -o friction.toml");
  await panel.getByRole("button", { name: "Find friction" }).click();
  await panel.getByText(/^Found\./).waitFor({ timeout: 300_000 });
  const document = await cli(["friction", record, "--axes", "X,Y", "--machine", "compensation-tables/mill-3axis", "--json", "-o", path.join(folder, "friction.toml")]);
  await figures(panel, document.axes, (own, key) => own.friction[key] ?? own.drive[key]);
  const fit = await numbers(panel.getByRole("table", { name: "Fit" }));
  for (const own of document.axes) {
    near(fit[own.axis]["residual, µm"], own.residual_um, 3, "residual");
    near(fit[own.axis]["condition number"], own.condition, 3, "condition");
    near(fit[own.axis]["explained, %"], 100 * own.explained, 4, "explained");
  }
  const settings = await saved(page, panel.getByRole("button", { name: "Save friction.toml" }));
  assert.equal(settings.bytes.toString(), fs.readFileSync(path.join(folder, "friction.toml"), "utf8"));
  await close();
});

test("a record that cannot be used is refused in the command line's words", async () => {
  const { panel, page, close } = await opened();
  const good = fs.readFileSync(record, "utf8").split("\n");
  const cases = {
    "gap.csv": [...good.slice(0, 3000), ...good.slice(3100)].join("\n"),
    "number.csv": good.with(10, good[10].replace(/^[\d.]+/, "0.0o1")).join("\n"),
    "short.csv": good.slice(0, 1000).join("\n"),
    "other.csv": ["angle_deg,p1_um", ...good.slice(1)].join("\n"),
  };
  for (const [name, text] of Object.entries(cases)) {
    fs.writeFileSync(path.join(folder, name), text);
    const refused = await run("trueaxis", ["friction", name, "--axes", "X,Y"], { cwd: folder });
    assert.equal(refused.code, 2);
    await drop(panel, { [name]: text });
    const alert = page.getByRole("alert").filter({ hasText: name });
    await alert.waitFor({ timeout: 300_000 });
    assert.equal(await alert.locator("span").textContent(), refused.stderr.trim().replace(/^error: /, ""));
  }
  // The page still shows the earlier record.
  assert.ok(await panel.getByRole("button", { name: "Find friction" }).isEnabled());
  await panel.getByLabel("Radius / mm").fill("0");
  await panel.getByLabel("Radius / mm").press("Tab");
  await panel.getByRole("button", { name: "Simulate a record" }).click();
  await page.getByRole("alert").filter({ hasText: "radius_mm: found 0, needed 1 to 1000" }).waitFor();
  await close();
});

test("a file opens the same circles again, in another plane", async () => {
  const { panel, page, close } = await opened();
  await circles(panel);
  await panel.getByLabel("Plane", { exact: true }).selectOption("ZX");
  await panel.getByLabel("Coulomb friction / mm/s²").fill("600");
  await panel.getByLabel("Coulomb friction / mm/s²").press("Tab");
  await panel.getByRole("button", { name: "Simulate a record" }).focus();
  await page.keyboard.press("Enter");
  await panel.getByRole("button", { name: "Stop" }).and(panel.locator(":enabled")).waitFor();
  await panel.getByText("samples at 10000 Hz").waitFor({ timeout: 300_000 });
  const command = await panel.locator("code").textContent();
  assert.match(command, /--plane ZX .* --set drive\.coulomb_mm_per_s2=600$/);
  const csv = await saved(page, panel.getByRole("button", { name: "Save the record" }));
  assert.match(csv.bytes.toString().slice(0, 60), /^t_s,z_cmd_mm,z_mm,x_cmd_mm,x_mm\n/);
  const kept = await saved(page, page.getByRole("button", { name: "Save", exact: true }));
  await close();

  const second = await opened();
  await second.page.getByLabel("Open", { exact: true }).setInputFiles({ name: "trueaxis.desk.json", mimeType: "application/json", buffer: kept.bytes });
  await second.panel.getByText("samples at 10000 Hz").waitFor({ timeout: 300_000 });
  await second.page.waitForFunction((command) => document.querySelector(".friction code").textContent === command, command);
  assert.equal(await second.panel.getByLabel("Plane", { exact: true }).inputValue(), "ZX");
  assert.equal(await second.panel.getByLabel("Coulomb friction / mm/s²").inputValue(), "600");
  await second.close();
});
