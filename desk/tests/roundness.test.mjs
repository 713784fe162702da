// Roundness: every figure against the command line's, readings and settings that no other test uses.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, drop, numbers, openDesk, run, saved, shot, sim, view } from "./harness.mjs";

const folder = fs.mkdtempSync(path.join(os.tmpdir(), "trueaxis-desk-"));
after(async () => {
  fs.rmSync(folder, { recursive: true });
  await closeBrowser();
});

const TURN = 2 * Math.PI;
/** Five lobes, finer waves, and a part that differs from turn to turn. */
const profile = (s) => 1.7 * Math.cos(5 * s + 0.4) + 0.6 * Math.cos(13 * s) + 0.21 * Math.sin(47 * s + 1);
const motion = (theta, turn) => [3 * Math.cos(theta) + 0.4 * Math.cos(3 * theta) + 0.05 * turn, 2 * Math.sin(theta) - 0.3 * Math.sin(2 * theta) - 0.02 * turn * turn];

/** Writes a file with the readings of three stationary probes; returns its text. */
function probes(name, degrees, thetas, header) {
  const lines = thetas.map((theta_deg, row) => {
    const theta = (theta_deg * TURN) / 360;
    const [x, y] = motion(theta, Math.floor(theta_deg / 360));
    const readings = [0, degrees[0], degrees[0] + degrees[1]].map((angle) => {
      const phi = (angle * TURN) / 360;
      const noise = 0.004 * Math.sin(12.9898 * row + 78.233 * phi);
      return (profile(theta + phi) + y * Math.cos(phi) + x * Math.sin(phi) + noise).toFixed(5);
    });
    return header.includes("theta_deg") ? [theta_deg.toFixed(6), ...readings].join(",") : readings.join(",");
  });
  const text = `${header}\n${lines.join("\n")}\n`;
  fs.writeFileSync(path.join(folder, name), text);
  return text;
}

/**
 * Compares figures that depend on a Fourier transform. `rustfft` uses the processor's vector instructions, which the page
 * lacks, so the order of additions differs. Printed digits are equal; numbers at full precision agree within 1e-12 µm.
 */
function near(found, needed, what) {
  if (Array.isArray(needed)) {
    assert.equal(found.length, needed.length, what);
    needed.forEach((one, i) => near(found[i], one, `${what}, ${i}`));
  } else if (needed === null) assert.ok(found === null || found === "–", `${what}: ${found}`);
  else assert.ok(Math.abs(found - needed) <= 1e-12 * Math.max(1, Math.abs(needed)), `${what}: ${found} against ${needed}`);
}

/** Types a number and leaves the field, as a user does. */
async function type(scope, label, value) {
  const field = scope.getByRole("spinbutton", { name: label });
  await field.fill(String(value));
  await field.press("Tab");
}

/** Sets points, band and angles of a group of probe controls. */
async function arrange(panel, group, { n, harmonics, phi2_deg, phi3_deg, p, q }) {
  const probes = panel.getByRole("group", { name: group });
  await probes.getByLabel("Points of a revolution").selectOption(String(n));
  await probes.getByLabel("Angles in").selectOption(p === undefined ? "degrees" : "slots");
  await type(probes, "First harmonic", harmonics[0]);
  await type(probes, "Last harmonic", harmonics[1]);
  await type(probes, /φ2/, p ?? phi2_deg);
  await type(probes, /φ3/, q ?? phi3_deg);
}

/** Waits until the status line of the readings contains this text. */
const status = (panel, text) => panel.getByRole("status").filter({ hasText: text }).waitFor();

/** Columns of the CSV that a plot saves. */
async function columns(page, panel, title) {
  const figure = panel.getByRole("figure").filter({ hasText: title }).last();
  await figure.getByText("Table", { exact: true }).click();
  const { bytes } = await saved(page, figure.getByRole("button", { name: "Save CSV" }));
  const [, ...rows] = bytes.toString().trim().split("\n").map((line) => line.split(","));
  return rows[0].map((_, column) => rows.map((row) => (row[column] === "" ? null : Number(row[column]))));
}

/** Compares all figures on the page with a document of `trueaxis roundness --json`. */
async function compare(page, panel, document) {
  const zones = await numbers(panel.getByRole("table", { name: /^Roundness of the mean/ }));
  for (const name of ["lsc", "mzc", "mic", "mcc"]) {
    const row = Object.entries(zones).find(([key]) => key.startsWith(name.toUpperCase()))[1];
    near(row["zone, µm"], document[`${name}_um`], name);
    near([row["centre x, µm"], row["centre y, µm"]], document.centres_um[name], name);
    const line = panel.getByRole("row", { name: new RegExp(`^${name.toUpperCase()}, `) });
    assert.equal(await line.locator("[data-value]").first().textContent(), document[`${name}_um`].toFixed(3));
  }
  const spindle = await numbers(panel.getByRole("table", { name: /^Error motion/ }));
  for (const [key, of] of [["X, across probe 1", document.spindle.x], ["Y, along probe 1", document.spindle.y]]) {
    const row = spindle[key];
    const shown = [row["synchronous, µm"], row["asynchronous, µm"], row["total, µm"], row["once per revolution, µm"], row["its phase, °"]];
    near(shown, [of.synchronous_um, of.asynchronous_um, of.total_um, of.once_per_revolution_um, of.once_per_revolution_phase_deg], key);
  }
  const amplitudes = await columns(page, panel, "Amplitude of every harmonic");
  const { harmonics } = document;
  near(amplitudes, [harmonics.map((of) => of.k), harmonics.map((of) => (of.suppressed ? null : of.amplitude_um))], "amplitudes");
  const [, kept, suppressed] = await columns(page, panel, "Noise gain of every harmonic");
  assert.deepEqual(harmonics.map((_, i) => kept[i] ?? suppressed[i]), harmonics.map((of) => of.noise_gain));
  assert.deepEqual(suppressed.map((gain) => gain !== null), harmonics.map((of) => of.suppressed));
  const turns = document.per_revolution;
  const found = await columns(page, panel, "Roundness of every revolution");
  near(found, ["revolution", "lsc_um", "mzc_um", "mcc_um", "mic_um"].map((key) => turns.map((of) => of[key])), "zones");
  const departures = await columns(page, panel, "Largest distance of every revolution");
  near(departures.slice(1), ["x_from_mean_um", "y_from_mean_um"].map((key) => turns.map((of) => of[key])), "departures");
}

test("readings at equidistant angles: figures, warnings, suppressed harmonics", async () => {
  const degrees = [77.5, 131.25];
  const thetas = Array.from({ length: 5 * 512 }, (_, row) => (360 * row) / 512);
  const text = probes("five-turns.csv", degrees, thetas, "h1_um,h2_um,h3_um");
  const { page, close } = await openDesk();
  const panel = await view(page, "Roundness");
  await status(panel, "grinder-probes.csv, simulated: 8 revolutions of 1024 points");
  await panel.getByLabel("Arm follows the pin").uncheck();
  await arrange(panel, "Probes of these readings", { n: 512, harmonics: [2, 60], phi2_deg: degrees[0], phi3_deg: degrees[1] });
  await type(panel, "Noise gain limit", 4.5);
  await drop(panel, { "five-turns.csv": text });
  await status(panel, "five-turns.csv: 5 revolutions of 512 points");
  const filter = panel.getByLabel("Gaussian filter");
  for (let step = 0; step < 4; step += 1) await filter.press("ArrowLeft");
  for (let step = 0; step < 3; step += 1) await filter.press("ArrowRight");
  await panel.getByRole("table", { name: /filter 150 UPR/ }).waitFor();

  const given = ["roundness", "five-turns.csv", "--n=512", "--phi2-deg=77.5", "--phi3-deg=131.25", "--harmonics=2..60", "--upr=150", "--noise-gain-limit=4.5", "--json"];
  const document = await cli(given, { cwd: folder });
  assert.ok(document.warnings.length === 3 && document.harmonics.some((of) => of.suppressed));
  await compare(page, panel, document);
  const notes = await panel.getByRole("list", { name: "Warnings and notes" }).getByRole("listitem").allTextContents();
  const { stderr } = await run("trueaxis", given, { cwd: folder });
  assert.deepEqual(notes, stderr.trim().split("\n"));
  await status(panel, /harmonics [\d, ]+ suppressed: noise gain up to [\d.]+, limit 4.5/);

  // The command that the page shows prints the same document.
  const command = await panel.getByText(/^trueaxis roundness/).textContent();
  assert.deepEqual(await cli(command.split(" ").slice(1), { cwd: folder }), document);
  // The picture omits a hidden circle.
  const circles = panel.getByRole("group", { name: "Reference circles" });
  await panel.getByRole("figure").filter({ hasText: "MIC, zone" }).first().waitFor();
  await circles.getByLabel(/MIC/).press("Space");
  await panel.getByRole("figure").filter({ hasText: "MIC, zone" }).first().waitFor({ state: "detached" });
  assert.match(await panel.locator("figure.polar figcaption").textContent(), /Magnification \d+ : 1/);
  await close();
});

test("readings with their own angles, a trace, and wrong files", async () => {
  const thetas = Array.from({ length: 1100 }, (_, row) => 20 + row + 0.3 * Math.sin(row));
  const text = probes("uneven.csv", [60.47, 234.14], thetas, "theta_deg,h1_um,h2_um,h3_um");
  const { page, close } = await openDesk();
  const panel = await view(page, "Roundness");
  await status(panel, "simulated");
  await arrange(panel, "Probes of these readings", { n: 256, harmonics: [2, 50], phi2_deg: 60.47, phi3_deg: 234.14 });
  await panel.getByLabel("Arm follows the pin").uncheck();
  await drop(panel, { "uneven.csv": text });
  await status(panel, /uneven.csv: \d revolutions of 256 points/);
  const given = ["roundness", "uneven.csv", "--n=256", "--phi2-deg=60.47", "--phi3-deg=234.14", "--harmonics=2..50", "--upr=50", "--json"];
  const document = await cli(given, { cwd: folder });
  await compare(page, panel, document);
  const { stderr } = await run("trueaxis", given, { cwd: folder });
  const notes = await panel.getByRole("list", { name: "Warnings and notes" }).getByRole("listitem").allTextContents();
  assert.deepEqual([...notes].sort(), stderr.trim().split("\n").sort());

  const points = Array.from({ length: 173 }, (_, i) => {
    const [angle, radius] = [(TURN * i) / 173, 12.5 + 1e-3 * profile((TURN * i) / 173)];
    return `${(4 + radius * Math.cos(angle)).toFixed(7)},${(-2 + radius * Math.sin(angle)).toFixed(7)}`;
  });
  fs.writeFileSync(path.join(folder, "trace.csv"), `x_mm,y_mm\n${points.join("\n")}\n`);
  await drop(panel, { "trace.csv": fs.readFileSync(path.join(folder, "trace.csv")) });
  await status(panel, "trace.csv: 173 points");
  const circles = await cli(["circle", "trace.csv", "--json"], { cwd: folder });
  const shown = await numbers(panel.getByRole("table", { name: /^Reference circles of 173/ }));
  for (const [key, row] of Object.entries(shown)) {
    const of = circles[key.slice(0, 3).toLowerCase()];
    const parts = ["zone, µm", "centre x, mm", "centre y, mm", "radius, mm"].map((name) => row[name]);
    near(parts, [of.zone_um, ...of.centre_mm, of.radius_mm], key);
    assert.equal(row["zone, µm"].toFixed(3), of.zone_um.toFixed(3));
  }

  const bad = text.replace(/^((?:.*\n){41}[^,]*,)[^,]*/, "$1seven");
  const short = text.split("\n").slice(0, 200).join("\n");
  const backwards = "x_mm,y_mm\n1,2\n3,4\n5,6\n";
  for (const [name, content, options] of [
    ["bad.csv", bad, given.slice(2)],
    ["short.csv", short, given.slice(2)],
    ["unknown.csv", text.replace("h3_um", "h4_um"), given.slice(2)],
    ["line.csv", backwards, undefined],
  ]) {
    fs.writeFileSync(path.join(folder, name), content);
    await drop(panel, { [name]: content });
    await status(panel, `${name} could not be evaluated`);
    const { code, stderr } = await run("trueaxis", options ? ["roundness", name, ...options] : ["circle", name], { cwd: folder });
    assert.equal(code, 2);
    const alert = await page.getByRole("alert").locator("span").textContent();
    assert.equal(`error: ${alert}`, stderr.trim(), name);
  }
  assert.match(fs.readFileSync(path.join(folder, "bad.csv"), "utf8").split("\n")[41], /,seven,/);
  await panel.getByRole("button", { name: "Simulated readings" }).press("Enter");
  await status(panel, "simulated: 8 revolutions");
  assert.equal(await page.getByRole("alert").count(), 0);
  await close();
});

test("the simulated readings saved give the same on the command line", async () => {
  const { page, close } = await openDesk();
  const panel = await view(page, "Roundness");
  await status(panel, "simulated");
  const { name, bytes } = await saved(page, panel.getByRole("button", { name: "Save these readings" }));
  fs.writeFileSync(path.join(folder, name), bytes);
  const command = await panel.getByText(/^trueaxis roundness/).textContent();
  await compare(page, panel, await cli(command.split(" ").slice(1), { cwd: folder }));
  await panel.evaluate((element) => element.querySelectorAll("details[open]").forEach((details) => (details.open = false)));
  await page.evaluate(() => scrollTo(0, 0));
  await shot(page, "roundness");
  await page.getByLabel("Theme").selectOption("dark");
  await shot(page, "roundness-dark");
  await panel.getByRole("heading", { name: "Harmonics" }).scrollIntoViewIfNeeded();
  await panel.screenshot({ path: new URL("../shots/roundness-whole-dark.png", import.meta.url).pathname });
  await page.getByLabel("Theme").selectOption("light");
  await panel.screenshot({ path: new URL("../shots/roundness-whole.png", import.meta.url).pathname });
  await close();
});

test("probe angles by keyboard, blind ones named, best pairs", async () => {
  const { page, close } = await openDesk();
  const panel = await view(page, "Roundness");
  await status(panel, "simulated");
  const moved = panel.getByRole("group", { name: "Probes moved by hand" });
  await arrange(panel, "Probes moved by hand", { n: 256, harmonics: [3, 70], p: 40, q: 100 });
  const slider = moved.getByRole("slider", { name: /φ2/ });
  for (let step = 0; step < 7; step += 1) await slider.press("ArrowRight");
  const given = (p, q) => ["probe-angles", "--n=256", `--p=${p}`, `--q=${q}`, "--harmonics=3..70", "--count=14", "--json"];
  const document = await cli(given(47, 100));
  const said = panel.getByRole("status").filter({ hasText: "Worst noise gain" });
  await said.locator(`[data-value="${document.pair.worst_noise_gain}"]`).waitFor();
  await said.locator(`[data-value="${document.pair.worst_harmonic}"]`).waitFor();
  const [k, gains] = await columns(page, panel, "Noise gain of these angles");
  assert.deepEqual(k.map((k, i) => ({ k, noise_gain: gains[i] })), document.pair.noise_gains);

  await type(panel, "Pairs to list", 14);
  await panel.getByRole("button", { name: "Find the best pairs" }).press("Enter");
  const rows = Object.entries(await (async () => {
    const table = panel.getByRole("table", { name: /^Best pairs/ });
    await table.waitFor();
    return numbers(table);
  })());
  assert.equal(rows.length, 15);
  [...document.best, document.pair].forEach((of, i) => {
    const row = rows[i][1];
    const shown = [row.p, row.q, row["φ2, °"], row["φ3, °"], row["worst gain"], row["worst noise gain"], row["at harmonic"]];
    assert.deepEqual(shown, [of.p, of.q, of.phi2_deg, of.phi3_deg, of.worst_gain, of.worst_noise_gain, of.worst_harmonic]);
  });
  assert.match(rows[14][0], new RegExp(`${(100 * document.pair.share_of_best).toFixed(1)} %`));
  const command = await panel.getByText(/^trueaxis probe-angles/).textContent();
  assert.deepEqual(await cli(command.split(" ").slice(1)), document);

  // Probes a quarter and half a turn after the first miss some harmonics: page and command list the same ones.
  await type(moved, /φ2/, 64);
  await type(moved, /φ3/, 64);
  const { stderr } = await run("trueaxis", given(64, 64));
  const [list] = stderr.match(/cannot see harmonics [\d, and]+\d/);
  const harmonics = list.match(/\d+/g);
  assert.ok(harmonics.length > 30, list);
  // Waits for the list of both angles: after the first one alone, the page lists others.
  const same = new RegExp(`cannot see harmonics ${harmonics.join("[, and]+")}(?!\\d)`);
  await panel.getByRole("status").filter({ hasText: same }).waitFor();
  await close();
});

test("grinding with and without infeed correction, as firmware-sim grinds", async () => {
  const { page, close } = await openDesk();
  const panel = await view(page, "Roundness");
  await status(panel, "simulated");
  const settings = { revolutions: 12, speed_rpm: 290, rate_hz: 5000, feed_um: 0.15, gain: 0.21, seed: 77 };
  const labels = { revolutions: "Revolutions", speed_rpm: "Spindle speed", rate_hz: "Servo rate", feed_um: "Feed that remains", gain: "Gain of the correction", seed: "Seed" };
  const group = panel.getByRole("group", { name: "Grinding" });
  for (const [key, value] of Object.entries(settings)) await type(group, labels[key], value);
  await group.getByRole("button", { name: "Grind" }).press("Enter");
  const table = panel.getByRole("table", { name: "The two runs" });
  await table.waitFor({ timeout: 300_000 });
  const command = await panel.getByText(/^firmware-sim grind/).textContent();
  const document = await sim(command.split(" ").slice(1));
  assert.equal(document.speed_rpm, 290);
  const rows = await numbers(table);
  for (const [name, of] of [["uncorrected", document.uncorrected], ["corrected", document.corrected]]) {
    const shown = ["out of roundness, mean, µm", "synchronous imprint, µm RMS", "revolutions evaluated", "revolutions skipped", "revolutions discarded", "cycles in which the limiter acted"].map((row) => rows[row][name]);
    assert.deepEqual(shown, [of.roundness_um, of.imprint_um, of.evaluated, of.skipped, of.discarded, of.limited_cycles], name);
  }
  const roundness = await columns(page, panel, "Roundness of the ground pin");
  assert.deepEqual(roundness.slice(1), [document.uncorrected, document.corrected].map((of) => of.per_revolution.map((turn) => turn.roundness_um)));
  const imprint = await columns(page, panel, "Imprint of the spindle");
  assert.deepEqual(imprint.slice(1), [document.uncorrected, document.corrected].map((of) => of.per_revolution.map((turn) => turn.imprint_um)));

  await type(group, "Gain of the correction", 0.9);
  await group.getByRole("button", { name: "Grind" }).click();
  await page.getByRole("alert").filter({ hasText: "--gain: found 0.9, needed above 0 and at most" }).waitFor();
  await close();
});
