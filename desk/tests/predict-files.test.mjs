// A part with all that belongs to it: temperatures, set-ups, the servo, and what to measure; against the command line.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, drop, numbers, openDesk, run, saved, view } from "./harness.mjs";

after(closeBrowser);
const folder = fs.mkdtempSync(path.join(os.tmpdir(), "predict-"));
const axis = (letter) => `[axis.${letter}]
travel_mm = [-100, 100]
[axis.${letter}.limits]
magnitude_um = 500
[axis.${letter}.uncertainty]
scale_ppm = 10
[axis.${letter}.thermal]
expansion_um_per_m_k = 10
[axis.${letter}.drive]
position_gain_per_s = 80
velocity_gain_per_s = 600
reset_time_s = 0.01
lowest_resonance_hz = 1000
`;
const MACHINE = `name = "small"
chain = "w X' Y' b Z t"
[location]
C0Y_urad = 50
[uncertainty]
sensor_k = 0.1
${["X", "Y", "Z"].map(axis).join("")}`;
const RING = "G21 G90 G17 F1000\nG0 X20 Y0 Z0\nG3 X20 Y0 I-20 J0\nM2\n";
const PART = `name = "ring"
program = "ring.ngc"
at_mm = [0, 0, -50]
[[feature]]
name = "bore"
kind = "circle"
lines = [3, 3]
[[tolerance]]
feature = "bore"
kind = "size"
limits_um = [-0.45, 0.45]
`;
const BALL = '[probe]\nrepeatability_um = 0.1\n[[instrument]]\nkind = "ball"\n[[instrument]]\nkind = "ring"\ndiameter_mm = 40\nuncertainty_um = 0.1\n';
const THERMAL = `reference_temperature_c = 20
[[sensor]]
name = "T1"
knots_c = [10, 40]
[axis.X]
uncertainty_um = 0.5
[axis.X.sensor.T1]
offset_um = [-80, 160]
slope_um_per_m = [-300, 600]
`;
const SHIFT = `t_s,T1_c\n${Array.from({ length: 20 }, (_, row) => `${28800 + 60 * row},${20 + 0.5 * row}\n`).join("")}`;

/** Files of the command line; returns the given ones, to be dropped. */
function written(files) {
  for (const [name, text] of Object.entries(files)) fs.writeFileSync(path.join(folder, name), text);
  return files;
}
const predict = (...options) => cli(["predict", ".", "part.toml", "--trials", "1000", ...options, "--json"], { cwd: folder });

function near(found, needed, what) {
  assert.ok(Math.abs(found - needed) <= 1e-6 * Math.max(1, Math.abs(needed)), `${what}: found ${found}, the command line has ${needed}`);
}

/** Waits until the page shows this value of a characteristic. */
async function shows(panel, title, of) {
  await panel.page().waitForFunction(([title, um]) => {
    const head = [...document.querySelectorAll(".predict tbody th")].find((cell) => cell.textContent === title);
    return head && Math.abs(Number(head.parentElement.children[2].dataset.value) - um) <= 1e-6;
  }, [title, of.uncorrected_um]);
  const row = (await numbers(panel.getByRole("table", { name: "Characteristics" })))[title];
  near(row["corrected / µm"], of.corrected_um, title);
  near(row["± 95 % / µm"], of.expanded_um, title);
  return row;
}

async function opened(files) {
  const { page, close } = await openDesk();
  const panel = await view(page, "Predict");
  await panel.getByText("8 conform, 1 is undecided.").waitFor();
  await drop(panel, files);
  return { page, panel, close };
}

test("temperatures of a record and a thermal.toml are those of the command line", async () => {
  const files = written({ "machine.toml": MACHINE, "part.toml": PART, "ring.ngc": RING, "shift.csv": SHIFT });
  const bore = async (...options) => (await predict(...options)).features[0];
  const { page, panel, close } = await opened(files);
  const warmer = panel.getByLabel("Machine / °C", { exact: true });
  await shows(panel, "bore, size", await bore("--thermal", "shift.csv"));
  assert.equal(await warmer.count(), 0, "a record says how warm the machine is");
  const start = panel.getByLabel("Start of the program", { exact: false });
  for (const [text, ...options] of [["120", "--start", "120"], ["08:10", "--at", "08:10"]]) {
    await start.fill(text);
    await shows(panel, "bore, size", await bore("--thermal", "shift.csv", ...options));
    assert.match(await panel.locator("code").first().textContent(), new RegExp(`--thermal shift.csv ${options.join(" ")}$`));
  }
  // The moved part follows the record too.
  written({ "part.toml": PART.replace("[0, 0, -50]", "[30, 0, -50]") });
  const moved = JSON.parse(await page.evaluate(() => globalThis.trueaxisDesk.bench.call("predict_at", 30, 0, -50, undefined)));
  near(moved.document.features[0].uncorrected_um, (await bore("--thermal", "shift.csv", "--at", "08:10")).uncorrected_um, "moved");
  written({ "part.toml": PART });

  await start.fill("24:10");
  await page.getByRole("alert").filter({ hasText: 'start: found 24:10, needed seconds, or hours and minutes' }).waitFor();
  await start.fill("08:10");
  await drop(panel, written({ "thermal.toml": THERMAL }));
  await panel.getByText("Growth by thermal.toml. Temperatures of shift.csv.").waitFor();
  // A new drop keeps the start.
  await shows(panel, "bore, size", await bore("--thermal", "shift.csv", "--at", "08:10"));

  await panel.getByRole("button", { name: "Leave out" }).click();
  fs.rmSync(path.join(folder, "thermal.toml"));
  await shows(panel, "bore, size", await bore());
  await warmer.waitFor();
  await close();
});

test("the servo is that of the command line, and ends where it is cancelled", async () => {
  const files = written({ "machine.toml": MACHINE, "part.toml": PART, "ring.ngc": RING });
  const { page, panel, close } = await openDesk().then(async ({ page, close }) => ({ page, close, panel: await view(page, "Predict") }));
  await panel.getByText("8 conform, 1 is undecided.").waitFor();
  const simulate = panel.getByRole("button", { name: "Simulate the servo" });
  // Minutes of cutting: cancelled on the way.
  await simulate.click();
  await panel.getByText(/Simulating the servo: \d+ %/).waitFor();
  await panel.getByRole("button", { name: "Cancel" }).click();
  await panel.getByRole("button", { name: "Simulate the servo", disabled: false }).waitFor();
  assert.equal(await page.getByRole("alert").isVisible(), false);

  await drop(panel, files);
  await panel.getByText(/^ring, program ring, machine small/).waitFor();
  await simulate.click();
  await panel.getByText(/with the servo/).waitFor();
  const [of] = (await predict("--servo", "--exact-drives")).features;
  const row = await shows(panel, "bore, size", of);
  near(row["everything on / µm"], of.everything_um, "everything on");
  assert.match(await panel.locator("code").first().textContent(), /--servo/);
  assert.match(await panel.locator("figcaption").first().textContent(), /everything on/);
  // Elsewhere it has to run again.
  await panel.getByLabel("X / mm", { exact: true }).fill("10");
  await panel.getByLabel("X / mm", { exact: true }).press("Enter");
  await panel.getByText("program zero at X 10, Y 0, Z −50 mm").waitFor();
  assert.equal(await panel.getByRole("columnheader", { name: "everything on" }).isVisible(), false);
  assert.doesNotMatch(await panel.locator("code").first().textContent(), /--servo/);
  await close();
});

test("what to measure, own tasks and set-ups are those of the command line", async () => {
  const files = written({ "machine.toml": MACHINE, "part.toml": `${PART}${BALL}`, "ring.ngc": RING });
  const { page, panel, close } = await opened(files);
  await panel.getByText(/^ring, program ring, machine small/).waitFor();
  const measure = panel.getByRole("button", { name: "What to measure" });
  const advised = async () => {
    await measure.click();
    const table = panel.getByRole("table", { name: "Before and after" });
    await table.waitFor();
    const { advice } = await predict("--advise");
    const found = await numbers(table);
    for (const of of advice.features) {
      const row = found[`${of.feature}, ${of.kind}`];
      for (const [name, um] of [["± before, µm", of.before_um], ["± after, µm", of.after_um], ["± with all, µm", of.least_um]]) near(row[name], um, name);
      assert.deepEqual([row["verdict before"], row["expected after"]], [of.verdict_before, of.verdict_after]);
    }
    return advice;
  };
  const advice = await advised();
  const minutes = Object.values(await numbers(panel.getByRole("table", { name: "What to measure" }))).reduce((sum, row) => sum + row.minutes, 0);
  near(minutes, advice.minutes, "minutes");
  const { name, bytes } = await saved(page, panel.getByRole("button", { name: "Save task.toml" }));
  assert.equal((await run("trueaxis", ["predict", ".", "part.toml", "--trials", "1000", "--advise", "-o", "own.toml"], { cwd: folder })).code, 0);
  const apart = (text) => text.split("\n").filter((line) => !line.startsWith("machine = ")).join("\n");
  assert.deepEqual([name, apart(bytes.toString())], ["task.toml", apart(fs.readFileSync(path.join(folder, "own.toml"), "utf8"))]);

  // The same task as the owner's own, and a bore of another set-up, in files that follow one another.
  const more = `${PART}[[setup]]
name = "back"
program = "back.ngc"
at_mm = [10, 0, -50]
zero_mm = [5, 0, 0]
[[feature]]
name = "rear"
kind = "circle"
setup = "back"
lines = [3, 3]
[[tolerance]]
feature = "rear"
kind = "size"
limits_um = [-3, 3]
[[instrument]]
kind = "task"
file = "own.toml"
`;
  const own = fs.readFileSync(path.join(folder, "own.toml"), "utf8");
  const rear = RING.replaceAll("20", "15");
  written({ "part.toml": more, "back.ngc": rear });
  await drop(panel, { "part.toml": more, "own.toml": own });
  await page.getByRole("alert").filter({ hasText: "part.toml: found no program back.ngc" }).waitFor();
  await drop(panel, { "back.ngc": rear });
  await shows(panel, "rear, size", (await predict()).features[1]);
  await advised();

  // A bore by a subprogram in a file that is dropped with its program.
  const called = written({
    "part.toml": PART,
    "ring.ngc": "G21 G90 G17 F1000\nG0 X15 Y0 Z0\no<around> call [15]\nM2\n",
    "around.ngc": "o<around> sub\nG3 X#1 Y0 I[0-#1] J0\no<around> endsub\n",
  });
  await drop(panel, called);
  await shows(panel, "bore, size", (await predict()).features[0]);
  await close();
});
