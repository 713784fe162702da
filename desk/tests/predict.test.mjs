// A part before it is cut, against the command line.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, drop, numbers, openDesk, root, run, shot, view } from "./harness.mjs";

after(closeBrowser);
const mill = path.join(root, "compensation-tables/mill-3axis");
const plate = path.join(root, "records/plate/part.toml");
const text = fs.readFileSync(plate, "utf8");
const program = fs.readFileSync(path.join(root, "records/plate/plate.ngc"), "utf8");

const titled = ({ feature, kind, datums }) => (datums.length === 0 ? `${feature}, ${kind}` : `${feature}, ${kind} ${kind === "distance" ? "from" : "to"} ${datums.join(", ")}`);

function near(found, needed, what) {
  assert.ok(Math.abs(found - needed) <= 1e-6 * Math.max(1, Math.abs(needed)), `${what}: found ${found}, the command line has ${needed}`);
}

async function same(panel, document) {
  const shown = await numbers(panel.getByRole("table", { name: "Characteristics" }));
  assert.deepEqual(Object.keys(shown), document.features.map(titled));
  for (const of of document.features) {
    const row = shown[titled(of)];
    near(row["uncorrected / µm"], of.uncorrected_um, titled(of));
    near(row["corrected / µm"], of.corrected_um, titled(of));
    near(row["± 95 % / µm"], of.expanded_um, titled(of));
    assert.ok(row.verdict.endsWith(of.verdict), `${titled(of)}: ${row.verdict}`);
  }
}

/** The part's file with another text, beside its program. */
function changed(from, to) {
  const folder = fs.mkdtempSync(path.join(os.tmpdir(), "part-"));
  assert.ok(text.includes(from));
  fs.writeFileSync(path.join(folder, "part.toml"), text.replace(from, to));
  fs.writeFileSync(path.join(folder, "plate.ngc"), program);
  return path.join(folder, "part.toml");
}

const predict = (part, seed = "1") => ["predict", mill, part, "--trials", "1000", "--seed", seed];

test("the sample, its budgets and its place are those of trueaxis predict", async () => {
  const { page, close } = await openDesk();
  const panel = await view(page, "Predict");
  await panel.getByText("8 conform, 1 is undecided.").waitFor();
  const found = await cli([...predict(plate), "--json"]);
  await same(panel, found);
  await shot(page, "predict");

  await panel.getByRole("button", { name: "hole 3, distance from hole 1" }).click();
  const shares = await numbers(panel.getByRole("table", { name: "Budget of hole 3" }));
  const { budget } = found.features.find(({ feature }) => feature === "hole 3");
  for (const { term, share, standard_um } of budget.slice(0, 12)) {
    near(shares[term]["share, %"], 100 * share, term);
    near(shares[term]["standard uncertainty, µm"], standard_um, term);
  }

  // While it moves the values are exact; at rest all of it is predicted there.
  const there = await cli([...predict(changed("at_mm = [90.0,", "at_mm = [20.0,")), "--json"]);
  const moved = JSON.parse(await page.evaluate(() => globalThis.trueaxisDesk.bench.call("predict_at", 20, -60, -250)));
  for (const [k, of] of there.features.entries()) near(moved.document.features[k].corrected_um, of.corrected_um, titled(of));
  const x = panel.getByLabel("X / mm", { exact: true });
  await x.fill("20");
  await x.press("Enter");
  await panel.getByText("program zero at X 20, Y −60, Z −250 mm").waitFor();
  await same(panel, there);
  // The chosen budget stays.
  await panel.getByRole("table", { name: "Budget of hole 3" }).waitFor();

  // A warmer machine.
  const warm = await cli([...predict(changed("at_mm = [90.0, -60.0, -250.0]", "temperature = { machine_c = 23 }\nat_mm = [20.0, -60.0, -250.0]")), "--json"]);
  const celsius = panel.getByLabel("Machine / °C", { exact: true });
  await celsius.fill("23");
  await celsius.press("Enter");
  await panel.getByText(/temperature.machine_c = 23/).waitFor();
  await page.waitForFunction(() => !document.body.textContent.includes("Predicting part.toml"));
  await same(panel, warm);

  // The ends of the sliders are those of the travel.
  const slider = panel.getByLabel("X, slider");
  const [least, most] = [await slider.getAttribute("min"), await slider.getAttribute("max")].map(Number);
  assert.ok(Math.abs(most - (300 - 128)) < 1e-9 && Math.abs(least + 300 - 8) < 1e-9, `${least} to ${most}`);
  await close();
});

test("a dropped part waits for its program, and is refused as on the command line", async () => {
  const { page, close } = await openDesk();
  const panel = await view(page, "Predict");
  await panel.getByText("8 conform, 1 is undecided.").waitFor();
  await drop(panel, { "part.toml": text.replace('name = "plate"', 'name = "cover"') });
  await panel.getByText("part.toml: open its program, plate.ngc, too.").waitFor();
  await drop(panel, { "plate.ngc": program });
  await panel.getByText(/^cover, program plate, machine mill-3axis/).waitFor();
  assert.equal(await panel.getByText("Sample, not your record").isVisible(), false);

  const part = changed("lines = [29, 29]", "lines = [31, 31]");
  const refused = await run("trueaxis", predict(part));
  await drop(panel, { "part.toml": fs.readFileSync(part, "utf8"), "plate.ngc": program });
  const alert = page.getByRole("alert").filter({ hasText: "needed lines that cut bore" });
  await alert.waitFor();
  const folder = `${path.dirname(part)}/`;
  assert.equal(await alert.locator("span").textContent(), refused.stderr.trim().replace(/^error: /, "").replaceAll(folder, ""));
  await close();
});

test("a machine that states no uncertainty gets deviations and no verdict", async () => {
  const { page, close } = await openDesk();
  const panel = await view(page, "Predict");
  await panel.getByText("8 conform, 1 is undecided.").waitFor();
  const files = Object.fromEntries(["x.csv", "y.csv", "z.csv"].map((name) => [name, fs.readFileSync(path.join(mill, name), "utf8")]));
  const [stated] = fs.readFileSync(path.join(mill, "machine.toml"), "utf8").split("\n[uncertainty]");
  await drop(panel, { ...files, "machine.toml": stated });
  await panel.getByText("No verdict: the machine states no standard uncertainty.").waitFor();
  const shown = await numbers(panel.getByRole("table", { name: "Characteristics" }));
  assert.ok(Object.values(shown).every((row) => row.verdict === "no verdict" && row["± 95 % / µm"] === "–"));
  await close();
});
