// Thermal growth: a recorded warm-up against the command line, its messages, refusals.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, drop, numbers, openDesk, root, run, saved, shot, view } from "./harness.mjs";

const mill = path.join(root, "compensation-tables/mill-3axis");
const folder = fs.mkdtempSync(path.join(os.tmpdir(), "thermal-"));
after(async () => {
  fs.rmSync(folder, { recursive: true });
  await closeBrowser();
});

/** A warm-up: X grows by 12 µm/(m K) from position 0, Z by 3 µm/K; the second sensor is unrelated to the growth. */
function warmUp() {
  const lines = ["t_s,cycle,x_mm,ex_um,ez_um,T1_c,T2_c"];
  let state = 5;
  const noise = () => ((state = (state * 48271) % 2147483647) / 2147483647 - 0.5) * 0.1;
  for (let i = 0; i < 192; i++)
    for (const x of [0, 250]) {
      const t = 300 * i;
      const warm = 6 * Math.sin(t / 7000) + 3 * Math.cos(t / 2300);
      lines.push([t, Math.floor(i / 48), x, (0.012 * warm * x + noise()).toFixed(4), (3 * warm + noise()).toFixed(4), (20 + warm).toFixed(3), (20 + 2 * Math.sin(t / 1234)).toFixed(3)].join(","));
    }
  return `${lines.join("\n")}\n`;
}
const record = warmUp();
const file = (name, text) => fs.writeFileSync(path.join(folder, name), text);

async function opened() {
  const desk = await openDesk();
  return { ...desk, panel: await view(desk.page, "Thermal growth") };
}

function near(found, needed, what) {
  assert.ok(Math.abs(found - needed) <= 1e-5 * Math.max(1, Math.abs(needed)), `${what}: found ${found}, the command line has ${needed}`);
}

test("a record has the figures and texts of trueaxis thermal fit", async () => {
  const { page, panel, close } = await opened();
  await panel.getByLabel("Cycles held out of the fit").fill("2");
  await panel.getByLabel("Sensors to leave out").fill("T2");
  await drop(panel, { "record.csv": record });
  await panel.getByText(/^record\.csv: 384 rows, .*, on mill-3axis\.$/).waitFor();
  file("record.csv", record);
  const found = await cli(["thermal", "fit", "record.csv", "--machine", mill, "--hold-out", "2", "--without", "T2", "--json", "-o", "thermal.toml"], { cwd: folder });
  const cycles = await numbers(panel.getByRole("table", { name: "Drift and remainder" }));
  for (const { axis, cycle, held_out, drift_um, left_um } of found.cycles) {
    const shown = cycles[`E${axis}${axis}, cycle ${cycle}`];
    near(shown["largest drift, µm"], drift_um, "drift");
    near(shown["left, µm"], left_um, "left");
    assert.equal(shown.use, held_out ? "held out" : "fitted");
  }
  const lags = await numbers(panel.getByRole("table", { name: "Lags" }));
  for (const { name, lag_s } of found.sensors) near(lags[name]["lag, s"], lag_s, name);
  const drifts = panel.getByRole("img", { name: /^Drift of [XZ] in cycle 2/ });
  await drifts.nth(1).waitFor();
  assert.equal(await drifts.count(), 2);
  assert.equal(await panel.locator("code").first().textContent(), "trueaxis thermal fit record.csv --machine mill-3axis --hold-out 2 --without T2 -o thermal.toml");

  const text = await saved(page, panel.getByRole("button", { name: "Save thermal.toml" }));
  assert.equal(text.bytes.toString(), fs.readFileSync(path.join(folder, "thermal.toml"), "utf8"));
  const compiled = await saved(page, panel.getByRole("button", { name: "Save the controller's file" }));
  assert.equal(compiled.name, "mill-3axis.ttherm");
  const said = await run("trueaxis", ["thermal", "compile", "thermal.toml", "--machine", mill, "-o", "mill.ttherm"], { cwd: folder });
  assert.equal(said.code, 0, said.stderr);
  assert.deepEqual(compiled.bytes, fs.readFileSync(path.join(folder, "mill.ttherm")));
  await page.evaluate(() => scrollTo(0, 0));
  await shot(page, "thermal");
  await close();
});

test("a useless record is refused in the command line's words, and no earlier result stays", async () => {
  const { page, panel, close } = await opened();
  await drop(panel, { "record.csv": record });
  await panel.getByText("384 rows").waitFor();
  const lines = record.split("\n");
  const bad = {
    "hot.csv": lines.with(100, lines[100].replace(/,[^,]+,([^,]+)$/, ",400,$1")),
    "short.csv": lines.slice(0, 90),
    "column.csv": [lines[0].replace("t_s", "time"), ...lines.slice(1)],
  };
  for (const [name, of] of Object.entries(bad)) {
    file(name, of.join("\n"));
    const refused = await run("trueaxis", ["thermal", "fit", name, "--machine", mill], { cwd: folder });
    assert.equal(refused.code, 2, name);
    await drop(panel, { [name]: of.join("\n") });
    const alert = page.getByRole("alert").filter({ hasText: name });
    await alert.waitFor();
    assert.equal(await alert.locator("span").textContent(), refused.stderr.trim().split("\n").at(-1).replace(/^error: /, ""));
    assert.ok(await panel.getByRole("button", { name: "Save thermal.toml" }).isDisabled());
    assert.ok(await panel.getByRole("table", { name: "Lags" }).isHidden());
  }
  await panel.getByLabel("Sensors to leave out").fill("T7");
  await drop(panel, { "record.csv": record });
  await page.getByRole("alert").filter({ hasText: "found T7" }).waitFor();
  await close();
});

test("the sample is the record of trueaxis thermal simulate", async () => {
  const { page, panel, close } = await opened();
  await panel.getByText(/^warm-up\.csv: /).waitFor();
  const sample = await page.evaluate(() => globalThis.trueaxisDesk.bench.call("thermal_sample"));
  const { code, stdout } = await run("trueaxis", ["thermal", "simulate", "--at", "0,0,-200,60"]);
  assert.equal(code, 0);
  const [own, other] = [sample, stdout].map((text) => text.trim().split("\n").map((line) => line.split(",")));
  assert.deepEqual([own.length, own[0]], [other.length, other[0]]);
  // The browser's functions may differ in their last bit: by a step of what is written.
  for (const [i, row] of own.entries()) for (const [k, field] of row.entries()) assert.ok(i === 0 || Math.abs(field - other[i][k]) < 0.0011, `line ${i + 1}: ${row} and ${other[i]}`);
  await close();
});
