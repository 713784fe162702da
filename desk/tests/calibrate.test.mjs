// Calibration with a touch probe: plan and log against the command line, changes to the machine, refusals.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, drop, expanded, numbers, openDesk, root, run, sameLog, saved, shot, view } from "./harness.mjs";

const probing = (name) => fs.readFileSync(path.join(root, "records/probing", name), "utf8");
const [task, machine, log] = ["task.toml", "mill/machine.toml", "probe.log"].map(probing);

const folder = fs.mkdtempSync(path.join(os.tmpdir(), "calibrate-"));
fs.mkdirSync(path.join(folder, "mill"));
fs.writeFileSync(path.join(folder, "mill/machine.toml"), machine);
fs.writeFileSync(path.join(folder, "task.toml"), task);
fs.writeFileSync(path.join(folder, "probe.log"), log);
after(async () => {
  fs.rmSync(folder, { recursive: true });
  await closeBrowser();
});

/** The page computes with the browser's trigonometric functions, whose last bit may differ. */
function near(found, needed, what) {
  assert.ok(Math.abs(found - needed) <= 1e-6 * Math.max(1, Math.abs(needed)), `${what}: found ${found}, the command line has ${needed}`);
}

async function opened() {
  const desk = await openDesk();
  return { ...desk, panel: await view(desk.page, "Calibrate") };
}

async function planned(panel, found) {
  const shown = await numbers(panel.getByRole("table", { name: "Expected uncertainty" }));
  assert.deepEqual(Object.keys(shown), found.terms.map(({ name }) => name));
  for (const { name, standard_error, unit } of found.terms) {
    near(shown[name]["± 95 %"], 1.959963984540054 * standard_error, name);
    assert.equal(shown[name].unit, unit);
  }
}

test("the task to begin with is planned on the machine that is shown", async () => {
  const { panel, close } = await opened();
  await panel.getByText("touches, about").waitFor();
  const own = path.join(folder, "sample.toml");
  const text = (await panel.getByRole("textbox").inputValue()).replace('"mill-3axis"', `"${path.join(root, "compensation-tables/mill-3axis")}"`);
  fs.writeFileSync(own, text);
  await planned(panel, await cli(["calibrate", "plan", own, "-o", path.join(folder, "sample.ngc"), "--json"]));
  await close();
});

test("a log has the terms of trueaxis calibrate solve, and the machine gets the changes that it writes", async () => {
  const { page, panel, close } = await opened();
  await drop(panel, { "task.toml": task, "machine.toml": machine });
  await panel.getByText("mill: 81 touches").waitFor();
  await planned(panel, await cli(["calibrate", "plan", "task.toml", "-o", "probe.ngc", "--json"], { cwd: folder }));
  const program = await saved(page, panel.getByRole("button", { name: "Save the program" }));
  assert.equal(program.bytes.toString(), fs.readFileSync(path.join(folder, "probe.ngc"), "utf8"));

  await drop(panel, { "probe.log": log });
  await panel.getByText("probe.log: 81 touches on mill.").waitFor();
  const found = await cli(["calibrate", "solve", "task.toml", "probe.log", "-o", "new", "--json"], { cwd: folder });
  const terms = await numbers(panel.getByRole("table", { name: "Terms" }));
  expanded(found.terms.map(({ name, standard_error }) => [terms[name]["± 95 %"], standard_error]));
  for (const { name, value, unit } of found.terms) {
    near(terms[name].value, value, name);
    assert.equal(terms[name].unit, unit);
  }
  assert.ok(Math.abs(terms["squareness C0Y"].value - 50) < 2 * terms["squareness C0Y"]["± 95 %"]);
  const network = await numbers(panel.getByRole("table", { name: "Network" }));
  near(network["sigma of a touch, µm"].value, found.sigma_um, "sigma");
  near(network["unknowns, rank"].value, found.rank, "rank");
  assert.equal(await panel.locator("code").nth(1).textContent(), "trueaxis calibrate solve task.toml probe.log -o mill-3axis");

  // The keyboard selects residuals; a readout states their numbers.
  const plot = panel.getByRole("img", { name: "Residual of every touch" });
  await plot.focus();
  await page.keyboard.press("Home");
  assert.match(await plot.locator("xpath=following-sibling::output").textContent(), /touch: 1\.0000\s+left, positive outside the surface .* µm/);
  await page.evaluate(() => scrollTo(0, 0));
  await page.setViewportSize({ width: 1400, height: await page.evaluate(() => document.body.scrollHeight) });
  await page.waitForTimeout(300);
  await shot(page, "calibrate");

  await panel.getByRole("button", { name: "Put into the machine" }).click();
  await panel.getByText("In mill now.").waitFor();
  const files = await page.evaluate(() => globalThis.trueaxisDesk.machine.files);
  for (const name of fs.readdirSync(path.join(folder, "new"))) assert.equal(files[name], fs.readFileSync(path.join(folder, "new", name), "utf8"), name);
  await close();
});

test("terms that cannot be separated are refused in the command line's words", async () => {
  const { panel, page, close } = await opened();
  const lines = log.split("\n");
  const logs = {
    "missing.log": lines.filter((line) => !line.startsWith("touch 9 ")),
    "twice.log": [...lines.slice(0, -1), lines[8], ""],
    "other.log": ["trueaxis calibrate 00000001 touches 81", ...lines.slice(1)],
    "far.log": lines.map((line) => (line.startsWith("touch 30 ") ? line.replace(/^(touch 30) (\S+)/, (_, touch, x) => `${touch} ${Number(x) + 0.05}`) : line)),
  };
  await drop(panel, { "task.toml": task, "machine.toml": machine });
  await panel.getByText("mill: 81 touches").waitFor();
  for (const [name, of] of Object.entries(logs)) {
    fs.writeFileSync(path.join(folder, name), of.join("\n"));
    const refused = await run("trueaxis", ["calibrate", "solve", "task.toml", name, "-o", "no"], { cwd: folder });
    assert.equal(refused.code, 2, name);
    await drop(panel, { [name]: of.join("\n") });
    const alert = page.getByRole("alert").filter({ hasText: name });
    await alert.waitFor();
    assert.equal(await alert.locator("span").textContent(), refused.stderr.trim().split("\n").at(-1).replace(/^error: /, ""));
    assert.ok(await panel.getByRole("table", { name: "Terms" }).isHidden());
  }
  // A task with a ring only, and a task with an unknown key.
  const alone = task.slice(0, task.indexOf("[reference]")) + task.slice(task.indexOf('[[artefact]]\nname = "ring"'));
  for (const [name, text] of Object.entries({ "alone.toml": alone, "key.toml": task.replace("repeats", "repeat") })) {
    fs.writeFileSync(path.join(folder, name), text);
    const refused = await run("trueaxis", ["calibrate", "plan", name], { cwd: folder });
    assert.equal(refused.code, 2, name);
    await drop(panel, { [name]: text });
    await panel.getByText(refused.stderr.trim().replace(/^error: /, "")).waitFor();
    assert.ok(await panel.getByRole("button", { name: "Save the program" }).isDisabled());
  }
  // The corrected task.
  await panel.getByRole("textbox").fill(task);
  await panel.getByText("mill: 81 touches").waitFor();
  await close();
});

test("a rehearsal is the log of trueaxis calibrate simulate on a machine of drawn errors", async () => {
  const { page, panel, close } = await opened();
  await panel.getByText("touches, about").waitFor();
  fs.cpSync(path.join(root, "compensation-tables/mill-3axis"), path.join(folder, "mill-3axis"), { recursive: true });
  fs.writeFileSync(path.join(folder, "first.toml"), await panel.getByRole("textbox").inputValue());
  const rehearse = panel.getByRole("button", { name: "Rehearse" });
  assert.ok(await panel.getByRole("button", { name: "Save the log" }).isHidden());
  const logs = [];
  for (const seed of [1, 2]) {
    await rehearse.click();
    await panel.getByText(`rehearsed-${seed}.log: `).waitFor();
    const { name, bytes } = await saved(page, panel.getByRole("button", { name: "Save the log" }));
    assert.equal(name, `rehearsed-${seed}.log`);
    logs.push(bytes.toString());
    assert.equal(await panel.locator("code").nth(2).textContent(), `trueaxis calibrate simulate task.toml --seed ${seed} -o ${name}`);
    const said = await run("trueaxis", ["calibrate", "simulate", "first.toml", "--seed", String(seed), "-o", name, "--save-true", `true-${seed}`], { cwd: folder });
    assert.equal(said.code, 0, said.stderr);
    sameLog(bytes.toString(), fs.readFileSync(path.join(folder, name), "utf8"));
  }
  assert.notEqual(logs[0], logs[1]);
  assert.ok(await panel.getByText("Rehearsed, not your record").isVisible());
  // What is true, and what the log shows of it.
  const truth = await numbers(panel.getByRole("table", { name: "True errors of the rehearsal" }));
  const text = fs.readFileSync(path.join(folder, "true-2/machine.toml"), "utf8");
  for (const key of ["A0Z_urad", "B0Z_urad", "C0Y_urad"]) near(truth[`location.${key}`].true, Number(new RegExp(`^${key} = (.*)$`, "m").exec(text)[1]), key);
  near(truth["location.C0Y_urad"]["in the files"], 38, "the files");
  const found = await cli(["calibrate", "solve", "first.toml", "rehearsed-2.log", "--dry-run", "--json"], { cwd: folder });
  const terms = await numbers(panel.getByRole("table", { name: "Terms" }));
  for (const { name, value } of found.terms) assert.ok(Math.abs(terms[name].value - value) < 0.01, `${name}: found ${terms[name].value}, the command line has ${value}`);

  // A log of one's own is no rehearsal, and a machine that states no uncertainties cannot be drawn about.
  await drop(panel, { "task.toml": task, "machine.toml": machine, "probe.log": log });
  await panel.getByText("probe.log: 81 touches on mill.").waitFor();
  assert.ok(await panel.getByText("not your record").isHidden());
  assert.ok(await panel.getByRole("table", { name: "True errors of the rehearsal" }).isHidden());
  await rehearse.click();
  await page.getByRole("alert").filter({ hasText: "machine.toml: found no uncertainty to draw the true errors from, needed [uncertainty.location]" }).waitFor();
  await close();
});
