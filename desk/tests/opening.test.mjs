// What the desk shows by itself: a running machine, samples that are evaluated and marked, plots that say what will be there.

import assert from "node:assert/strict";
import { after, test } from "node:test";
import { closeBrowser, numbers, openDesk, view } from "./harness.mjs";

after(closeBrowser);

const TRACES = "Contour error of the true tool tip";
const cycle = async (panel) => Number(/: ([\d,]+) of /.exec(await panel.locator(".bar output").textContent())[1].replaceAll(",", ""));

/** Waits until more cycles than `from` have run. */
async function runs(panel, from) {
  for (let i = 0; i < 300; i++) {
    if ((await cycle(panel)) > from) return;
    await panel.page().waitForTimeout(100);
  }
  assert.fail(`found no cycle after ${from} in 30 s`);
}

async function opened(options) {
  const desk = await openDesk(options);
  // By its id, so that it is found while it is hidden.
  const panel = desk.page.locator("#panel-scope");
  await panel.locator('.bar[data-state="running"]').waitFor();
  return { ...desk, panel };
}

test("it opens on a running machine with at least three curves, and says what to try", async () => {
  const { page, panel, close } = await opened();
  await page.waitForFunction(() => document.documentElement.dataset.motionMs !== undefined);
  // Printed and not bounded: other programs run on the computer of this test.
  console.log(`first motion ${await page.evaluate(() => document.documentElement.dataset.motionMs)} ms after loading`);
  await runs(panel, await cycle(panel));
  const described = await panel.getByRole("img", { name: TRACES }).getAttribute("aria-description");
  assert.ok(described.match(/: \S+ to \S+/g).length >= 3, described);
  const intro = panel.getByRole("note", { name: "What is seen" });
  await intro.getByText(/how far the tool tip is from its path/).waitFor();
  // The first cut gives the sentence.
  await panel.getByText(/^Largest contour error while cutting so far: uncorrected \S+ µm, corrected \S+ µm/).waitFor();
  await panel.getByText("rapid traverse, not counted in the figures").waitFor();
  await close();
});

test("a warmer machine, a pulled plug and other tables take one click each, and the run goes on", async () => {
  const { panel, close } = await opened();
  await panel.getByRole("button", { name: "Pull an encoder's plug" }).click();
  await panel.getByRole("cell", { name: /^dropout:X@.*\+500$/ }).waitFor();
  await panel.getByRole("cell", { name: "X encoder not a number FeedbackNotFinite" }).first().waitFor();
  await panel.getByRole("button", { name: "Exchange its tables" }).click();
  await panel.getByRole("cell", { name: /^exchange:half-tables@/ }).waitFor();
  const before = await cycle(panel);
  await panel.getByRole("button", { name: "Warm it by 6 K" }).click();
  assert.equal(await panel.getByRole("spinbutton", { name: "Temperature / °C" }).inputValue(), "26");
  await panel.page().waitForFunction((before) => Number(/: ([\d,]+) of /.exec(document.querySelector(".scope .bar output").textContent)[1].replaceAll(",", "")) < before, before);
  await panel.locator('.bar[data-state="running"]').waitFor();
  await close();
});

test("the opening run rests while another view is in front, and ends with the first command", async () => {
  const { page, panel, close } = await opened();
  await view(page, "Uncertainty");
  await page.waitForTimeout(500);
  const rested = await cycle(panel);
  await page.waitForTimeout(700);
  assert.equal(await cycle(panel), rested);
  await view(page, "Servo scope");
  await runs(panel, rested);
  await panel.getByRole("button", { name: "Pause" }).click();
  await panel.locator('.bar[data-state="paused"]').waitFor();
  await view(page, "Uncertainty");
  await view(page, "Servo scope");
  await page.waitForTimeout(700);
  assert.equal(await panel.locator(".bar").getAttribute("data-state"), "paused");
  await close();
});

test("a reader who wants no motion gets a run that waits; its plots say what will be there, its figures are dashes", async () => {
  const { context, close } = await openDesk();
  const page = await context.newPage();
  await page.emulateMedia({ reducedMotion: "reduce" });
  await page.goto(context.pages()[0].url());
  await page.waitForSelector("html[data-ready]");
  const panel = page.getByRole("tabpanel", { name: "Servo scope" });
  await panel.locator('.bar[data-state="ready"]').waitFor();
  await panel.getByText("Run draws the contour error of each machine here.").waitFor();
  await panel.getByText("Run draws what each axis adds to its command here.").waitFor();
  const sizes = await numbers(panel.getByRole("table", { name: /^Contour error of the true tip/ }));
  for (const [name, { largest, RMS }] of Object.entries(sizes)) assert.deepEqual([largest, RMS], ["NaN", "NaN"].map(Number), name);
  assert.deepEqual(await panel.getByRole("table", { name: /^Contour error of the true tip/ }).locator("td").allTextContents(), Object.keys(sizes).flatMap(() => ["–", "–"]));
  await close();
});

const SENTENCES = {
  Ballbar: /^Squareness \(49\.\d+ ± 0\.\d+ µrad\) is 33\.\d+ % of the deviation: correct it first\.$/,
  Tests: /^Diagonal scale is 20\.\d+ ± 0\.\d+ ppm, the clearest of 4\.$/,
  Roundness: /^.+: \S+ µm\.$/,
  "Thermal growth": /^In cycles that the model did not see it leaves at most \S+ of \S+ µm of drift/,
  Uncertainty: /^The tip is known to \S+ µm at the worst point; .+ is \S+ % of the squared uncertainty: measure it better first\.$/,
};

test("a view opens with a sample that it has evaluated, marks it, and says its result in a sentence", async () => {
  const { page, close } = await openDesk();
  for (const [name, wanted] of Object.entries(SENTENCES)) {
    const panel = await view(page, name);
    const sentence = panel.locator(".result:visible").first();
    await sentence.waitFor();
    console.log(`${name}: ${await sentence.textContent()}`);
    assert.match(await sentence.textContent(), wanted, name);
    assert.equal(await panel.getByText("Sample, not your record").isVisible(), name !== "Uncertainty", name);
  }
  const friction = await view(page, "Friction");
  await friction.getByRole("img", { name: "Following error of the simulated record" }).waitFor();
  assert.ok(await friction.getByText("Sample, not your record").isVisible());
  await friction.getByRole("button", { name: "Find friction" }).click();
  await friction.getByText(/^The largest spike falls from \S+ to \S+ µm in X, from \S+ to \S+ µm in Y\.$/).waitFor();
  await close();
});

test("probing offers its sample with one click", async () => {
  const { page, close } = await openDesk();
  for (const [name, status] of [["Calibrate", "probe.log: 81 touches on mill."], ["Keep", "begin.log: 46 touches on mill."]]) {
    const panel = await view(page, name);
    await panel.getByText("touches, about").waitFor();
    await panel.getByRole("button", { name: "Try a sample" }).click();
    await panel.getByText(status).waitFor();
    assert.ok(await panel.getByText("Sample, not your record").isVisible(), name);
  }
  await close();
});

test("a sample becomes a machine, and the scope takes it", async () => {
  const { page, close } = await openDesk();
  await page.getByText("Machine mill-3axis, as opened").waitFor();
  const panel = await view(page, "Ballbar");
  await panel.getByRole("button", { name: "Put into the machine" }).click();
  await panel.getByText("In mill-3axis now.").waitFor();
  await page.getByText("Machine mill-3axis, 1 change since it was opened").waitFor();
  const scope = await view(page, "Servo scope");
  await scope.locator('.bar[data-state="running"]').waitFor();
  await close();
});

test("an own machine gets no sample unasked", async () => {
  const { page, close } = await openDesk();
  await page.evaluate(async () => {
    const { bench, machine } = globalThis.trueaxisDesk;
    machine.set("mill-5axis", JSON.parse(await bench.call("machine_sample", "mill-5axis")));
  });
  for (const name of ["Ballbar", "Tests", "Thermal growth"]) {
    const panel = await view(page, name);
    await panel.getByRole("button", { name: "Try a sample" }).first().waitFor();
    assert.ok(await panel.getByText("Sample, not your record").isHidden(), name);
    assert.ok(await panel.locator(".result").first().isHidden(), name);
  }
  await close();
});
