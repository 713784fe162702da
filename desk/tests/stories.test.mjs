// The desk's work from end to end, by role and name: what a test finds is put into the machine, and the scope runs it.

import assert from "node:assert/strict";
import { after, test } from "node:test";
import { closeBrowser, drop, openDesk, saved, shot, view } from "./harness.mjs";

after(closeBrowser);

/** Timeout for a computer that runs other tests at the same time. */
const LONG = 240_000;
const EXCHANGED = /^Tables exchanged at \S+ s: the largest corrected contour error (falls|rises) from (\S+) to (\S+) µm\.$/;
/** A program of a few seconds about the machine's zero. */
const TINY = "G21 G90 G94 G17\nF2400\nG0 Z5\nG1 Z0\nX20 Y10\nG2 X20 Y-10 I0 J-10\nG1 X-10\nY0\nX0\nM2\n";

const header = (page) => page.getByRole("group", { name: "Machine", exact: true });
const scope = (page) => page.getByRole("tabpanel", { name: "Servo scope" });

/** Contour errors before and after the exchange of tables, once the run has ended: until then the sentence ends in "so far". */
async function errors(panel) {
  const sentence = panel.getByText(EXCHANGED);
  await sentence.waitFor({ timeout: LONG });
  const [, direction, before, after] = EXCHANGED.exec(await sentence.textContent());
  return { direction, before: Number(before), after: Number(after) };
}

/** Puts the result of a view into the machine with its one button, and runs the corrected machine; returns the button's text. */
async function put(page, panel, machine) {
  const button = panel.getByRole("button", { name: /^Put into the machine/ });
  const text = await button.textContent();
  await button.click();
  await panel.getByText(`In ${machine} now.`).waitFor();
  await header(page).getByText(`Machine ${machine}, 1 change since it was opened`).waitFor();
  await panel.getByRole("button", { name: "Run the corrected machine" }).click();
  await scope(page).getByLabel("Pace").selectOption("fast");
  return text;
}

test("ballbar, machine, scope: the error falls with the corrected tables, in either theme, and undo takes the correction back", async () => {
  const { page, close } = await openDesk();
  const ballbar = await view(page, "Ballbar");
  await ballbar.getByRole("button", { name: /^Put into the machine.*→/ }).waitFor();
  const text = await put(page, ballbar, "mill-3axis");
  // Old value, new value, and how well it is known.
  assert.match(text, /^Put into the machinebacklash X \S+ → \S+ ± \S+ µm; /);
  const panel = scope(page);
  await panel.getByRole("cell", { name: "tables before", exact: true }).waitFor();
  await page.getByLabel("Theme").selectOption("dark");
  const found = await errors(panel);
  console.log(`ballbar: ${found.before} to ${found.after} µm`);
  assert.equal(found.direction, "falls");
  assert.ok(found.after < 0.6 * found.before, `${found.before} to ${found.after} µm`);
  await shot(page, "story-ballbar-dark");
  await page.getByLabel("Theme").selectOption("light");

  await header(page).getByRole("button", { name: "Undo" }).click();
  await header(page).getByText("Machine mill-3axis, as opened").waitFor();
  await panel.getByRole("cell", { name: /^none yet/ }).waitFor();
  await view(page, "Ballbar");
  assert.ok(await ballbar.getByRole("button", { name: /^Put into the machine/ }).isEnabled());
  await close();
});

test("touch-probe log, machine, scope: the error falls with the tables that were found", async () => {
  const { page, close } = await openDesk();
  const calibrate = await view(page, "Calibrate");
  await calibrate.getByText("touches, about").waitFor();
  await calibrate.getByRole("button", { name: "Try a sample" }).click();
  await calibrate.getByText("probe.log: 81 touches on mill.").waitFor();
  await put(page, calibrate, "mill");
  const found = await errors(scope(page));
  console.log(`touch probe: ${found.before} to ${found.after} µm`);
  assert.equal(found.direction, "falls");
  assert.ok(found.after < 0.5 * found.before, `${found.before} to ${found.after} µm`);

  // The first undo gives the machine as it was measured, the second the one from before.
  await header(page).getByRole("button", { name: "Undo" }).click();
  await header(page).getByText("Machine mill, as opened").waitFor();
  await header(page).getByRole("button", { name: "Undo" }).click();
  await header(page).getByText("Machine mill-3axis, as opened").waitFor();
  await close();
});

test("a table dragged, scope: the error rises with the edited table", async () => {
  const { page, close } = await openDesk();
  const panel = scope(page);
  await panel.getByRole("button", { name: "Pause" }).click();
  await drop(panel, { "tiny.ngc": TINY });
  await panel.getByRole("option", { name: "G21 G90" }).waitFor();
  await panel.getByRole("button", { name: "Step on" }).click();
  await panel.getByText(/^paused: 1,000 of/).waitFor();

  const machine = await view(page, "Machine");
  const point = machine.getByRole("slider", { name: "EXX_fwd_um at 0 mm" });
  await point.waitFor();
  await point.scrollIntoViewIfNeeded();
  const box = await point.boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; i <= 5; i++) await page.mouse.move(x, y - 8 * i);
  await page.mouse.up();
  await header(page).getByText("Machine mill-3axis, 1 change since it was opened").waitFor();

  await view(page, "Servo scope");
  await panel.getByText("The machine has changed: Restart runs it, Exchange takes its tables.").waitFor();
  await panel.getByLabel("Tables of").selectOption("edited");
  await panel.getByLabel("Acts at / s (empty: now)").fill("0.9");
  await panel.getByRole("button", { name: "Exchange", exact: true }).click();
  await panel.getByRole("cell", { name: "tables edited", exact: true }).waitFor();
  await panel.getByRole("button", { name: "To the end" }).click();
  const found = await errors(panel);
  console.log(`dragged: ${found.before} to ${found.after} µm`);
  assert.equal(found.direction, "rises");
  assert.ok(found.after > 1.5 * found.before, `${found.before} to ${found.after} µm`);

  // What is saved is the edited machine.
  const { name, bytes } = await saved(page, header(page).getByRole("button", { name: "Save machine" }));
  assert.equal(name, "mill-3axis.zip");
  assert.equal(bytes.subarray(0, 4).toString("latin1"), "PK\x03\x04");
  await close();
});
