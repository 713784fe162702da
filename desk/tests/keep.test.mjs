// A machine that keeps itself true: plan, re-probings and their files against the command line, terms that need a person.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, drop, expanded, numbers, openDesk, root, run, sameLog, saved, shot, view } from "./harness.mjs";

const probing = (name) => fs.readFileSync(path.join(root, "records/probing", name), "utf8");
const [task, machine, begin, look] = ["keep.toml", "mill/machine.toml", "begin.log", "look.log"].map(probing);

const folder = fs.mkdtempSync(path.join(os.tmpdir(), "keep-"));
const at = (name) => path.join(folder, name);
fs.mkdirSync(at("mill"));
for (const [name, text] of Object.entries({ "mill/machine.toml": machine, "keep.toml": task, "begin.log": begin, "look.log": look })) fs.writeFileSync(at(name), text);
after(async () => {
  fs.rmSync(folder, { recursive: true });
  await closeBrowser();
});
const keep = (verb, ...more) => cli(["keep", verb, "keep.toml", ...more, "--json"], { cwd: folder });
const history = () => fs.readFileSync(at("mill/keep/history.jsonl"), "utf8");

/** The page computes with the browser's trigonometric functions, whose last bit may differ. */
function near(found, needed, what) {
  assert.ok(Math.abs(found - needed) <= 1e-6 * Math.max(1, Math.abs(needed)), `${what}: found ${found}, the command line has ${needed}`);
}

async function opened() {
  const desk = await openDesk();
  const panel = await view(desk.page, "Keep");
  await panel.getByText("touches, about").waitFor();
  return { ...desk, panel };
}

async function planned(panel, found) {
  const shown = await numbers(panel.getByRole("table", { name: "Expected uncertainty" }));
  assert.deepEqual(Object.keys(shown), found.terms.map(({ name }) => name));
  for (const { name, standard_error, largest_update, largest_total, unit } of found.terms) {
    near(shown[name]["± 95 %"], 1.959963984540054 * standard_error, name);
    near(shown[name]["at most at once"], largest_update, name);
    near(shown[name]["at most in all"], largest_total, name);
    assert.equal(shown[name].unit, unit);
  }
}

async function showsEvaluation(panel, found) {
  const table = panel.getByRole("table", { name: "Verdicts" });
  // The first probing has no terms to judge: a table without rows is left out.
  assert.equal(await table.isVisible(), found.terms.length > 0);
  const verdicts = found.terms.length > 0 ? await numbers(table) : {};
  assert.deepEqual(Object.keys(verdicts), found.terms.map(({ name }) => name));
  for (const term of found.terms) {
    const own = verdicts[term.name];
    const columns = { "left by the tables": "value", significance: "significance", "updates in all": "from", then: "to", "at most at once": "largest_update", "at most in all": "largest_total" };
    for (const [shown, key] of Object.entries(columns)) near(own[shown], term[key], `${term.name}, ${key}`);
    assert.equal(own.verdict, term.reason ? `refused: ${term.reason}` : term.verdict);
    assert.equal(own.unit, term.unit);
  }
  expanded(found.terms.map(({ name, standard_error }) => [verdicts[name]["± 95 %"], standard_error]));
  const balls = await numbers(panel.getByRole("table", { name: "Positions of the balls" }));
  for (const { name, centre_mm } of found.balls) {
    for (const [k, letter] of ["X", "Y", "Z"].entries()) near(balls[name][`${letter}, mm`], centre_mm[k], letter);
  }
  expanded(found.balls.map(({ name, standard_error_um }) => [balls[name]["± 95 %, µm"], Math.max(...standard_error_um)]));
  // The reason of a refusal, then the notes.
  const notes = await panel.getByRole("list", { name: /^(Warnings|Notes)$/ }).getByRole("listitem").allTextContents();
  for (const note of found.notes) assert.ok(notes.includes(note), note);
  return notes;
}

const command = (panel) => panel.locator("code").nth(1).textContent();

test("the task to begin with is planned on the machine that is shown", async () => {
  const { panel, close } = await opened();
  const text = (await panel.getByRole("textbox", { name: "Machine, probe" }).inputValue()).replace('"mill-3axis"', `"${path.join(root, "compensation-tables/mill-3axis")}"`);
  fs.writeFileSync(at("sample.toml"), text);
  await planned(panel, await cli(["keep", "plan", "sample.toml", "-o", "sample.ngc", "--json"], { cwd: folder }));
  await close();
});

test("a round is that of trueaxis keep, and leaves its files", async () => {
  const { page, panel, close } = await opened();
  await drop(panel, { "keep.toml": task, "machine.toml": machine });
  await panel.getByText("mill: 46 touches, about").waitFor();
  await planned(panel, await keep("plan", "-o", "look.ngc"));
  const program = await saved(page, panel.getByRole("button", { name: "Save the program" }));
  assert.equal(program.bytes.toString(), fs.readFileSync(at("look.ngc"), "utf8"));

  await panel.getByRole("textbox", { name: "probed at" }).fill("2026-05-04T06:00:00Z");
  await panel.getByRole("spinbutton", { name: "parts made" }).fill("0");
  await drop(panel, { "begin.log": begin });
  await panel.getByText("begin.log: 46 touches on mill.").waitFor();
  const line = await command(panel);
  assert.equal(line, "trueaxis keep begin keep.toml begin.log --time 2026-05-04T06:00:00Z --parts 0");
  await showsEvaluation(panel, await cli([...line.split(" ").slice(1), "--json"], { cwd: folder }));
  await panel.getByRole("button", { name: "Enter it in the history" }).click();
  await panel.getByText("Entry 1 is in the history").waitFor();

  // Inputs for the second probing must not remove the files of the first.
  await panel.getByRole("textbox", { name: "probed at" }).fill("2026-05-04T07:00:00Z");
  await panel.getByRole("spinbutton", { name: "parts made" }).fill("12");
  await panel.getByText("--time 2026-05-04T07:00:00Z --parts 12").waitFor();
  const kept = await saved(page, panel.getByRole("button", { name: "Save keep/history.jsonl" }));
  assert.equal(kept.name, "keep-history.jsonl");
  sameHistory(kept.bytes.toString(), history());

  // The second re-probing, compared with the first: the command's output and its files.
  await drop(panel, { "look.log": look, "history.jsonl": history() });
  await panel.getByText("look.log: 46 touches on mill.").waitFor();
  assert.equal(await command(panel), "trueaxis keep check keep.toml look.log --time 2026-05-04T07:00:00Z --parts 12");
  const checked = await keep("check", "look.log", "--parts", "12");
  assert.equal(checked.updates, 2);
  await showsEvaluation(panel, checked);
  await page.evaluate(() => scrollTo(0, 0));
  await page.setViewportSize({ width: 1400, height: await page.evaluate(() => document.body.scrollHeight) });
  await page.waitForTimeout(300);
  await shot(page, "keep");
  const copy = await saved(page, panel.getByRole("button", { name: "Save keep/0002/machine.toml" }));
  assert.equal(copy.bytes.toString(), machine);

  await keep("apply", "look.log", "--time", "2026-05-04T07:00:00Z", "--parts", "12");
  await panel.getByRole("button", { name: "Put into the machine" }).click();
  await panel.getByText("In mill now.").waitFor();
  const files = await page.evaluate(() => globalThis.trueaxisDesk.machine.files);
  for (const name of ["machine.toml", "x.csv", "z.csv"]) assert.equal(files[name], fs.readFileSync(at(`mill/${name}`), "utf8"), name);
  sameHistory((await saved(page, panel.getByRole("button", { name: "Save keep/history.jsonl" }))).bytes.toString(), history());
  const past = await numbers(panel.getByRole("table", { name: "Entries" }));
  assert.deepEqual([past[1]["what was done"], past[2]["what was done"]], ["begin", "update"]);
  const text = (await run("trueaxis", ["keep", "history", "keep.toml"], { cwd: folder })).stdout;
  assert.ok(past[2].changed !== "" && text.includes(past[2].changed), past[2].changed);

  // The same log would be added twice: it is refused.
  await drop(panel, { "again.log": look });
  await page.getByRole("alert").filter({ hasText: "the log of entry 2 for the second time" }).waitFor();
  await close();
});

/** Compares two histories, whose last bits, and with them the check sums, may differ. */
function sameHistory(found, needed) {
  const rows = (text) => text.trim().split("\n").map((line) => JSON.parse(line));
  const [own, other] = [rows(found), rows(needed)];
  assert.equal(own.length, other.length);
  for (const [i, entry] of own.entries()) {
    for (const key of ["entry", "deed", "time", "parts", "plan", "log", "files", "tables"]) assert.deepEqual(entry[key], other[i][key], key);
    for (const [k, term] of entry.measured.entries()) near(term.value, other[i].measured[k].value, term.term);
  }
}

test("a term out of its bounds needs a person, and bad re-probings are refused in the command line's words", async () => {
  fs.rmSync(at("mill"), { recursive: true });
  fs.mkdirSync(at("mill"));
  fs.writeFileSync(at("mill/machine.toml"), machine);
  await keep("begin", "begin.log");
  const { page, panel, close } = await opened();
  const tight = task.replace("largest_update_um = 15.0", "largest_update_um = 7.0");
  fs.writeFileSync(at("keep.toml"), tight);
  await drop(panel, { "keep.toml": tight, "machine.toml": machine, "history.jsonl": history(), "look.log": look });
  await panel.getByText("look.log: 46 touches on mill.").waitFor();
  const refused = await run("trueaxis", ["keep", "check", "keep.toml", "look.log", "--json"], { cwd: folder });
  assert.equal(refused.code, 3);
  const words = refused.stderr.trim().split("\n").at(-1).replace(/^error: /, "");
  assert.equal((await showsEvaluation(panel, JSON.parse(refused.stdout)))[0], words);
  assert.ok(await panel.getByRole("button", { name: "Put into the machine" }).isHidden());
  await panel.getByRole("textbox", { name: "terms that may be out of" }).fill("offset Z");
  await panel.getByRole("button", { name: "Put into the machine" }).waitFor();
  assert.equal(await command(panel), "trueaxis keep check keep.toml look.log --accept 'offset Z'");

  const lines = look.split("\n");
  const logs = {
    "missing.log": lines.filter((line) => !line.startsWith("touch 4 ")),
    "twice.log": [...lines.slice(0, -1), lines[4], ""],
    "other.log": ["trueaxis calibrate 00000001 touches 81", ...lines.slice(1)],
  };
  for (const [name, of] of Object.entries(logs)) {
    fs.writeFileSync(at(name), of.join("\n"));
    const { code, stderr } = await run("trueaxis", ["keep", "check", "keep.toml", name, "--accept", "offset Z"], { cwd: folder });
    assert.equal(code, 2, name);
    await drop(panel, { [name]: of.join("\n") });
    const alert = page.getByRole("alert").filter({ hasText: name });
    await alert.waitFor();
    assert.equal(await alert.locator("span").textContent(), stderr.trim().split("\n").at(-1).replace(/^error: /, ""));
    assert.ok(await panel.getByRole("table", { name: "Verdicts" }).isHidden());
  }
  // Somebody has changed the tables.
  await drop(panel, { "machine.toml": `${machine}# by hand\n`, "look.log": look });
  await page.getByRole("alert").filter({ hasText: "changed by hand" }).waitFor();
  await panel.getByRole("checkbox", { name: "changed by hand" }).check();
  await panel.getByText("used as they are").waitFor();
  await close();
});

test("a rehearsal is the log of trueaxis keep simulate: at first of the machine as it is, later of one that has moved", async () => {
  const { page, panel, close } = await opened();
  fs.cpSync(path.join(root, "compensation-tables/mill-3axis"), at("mill-3axis"), { recursive: true });
  fs.writeFileSync(at("keep.toml"), await panel.getByRole("textbox", { name: "Machine, probe" }).inputValue());
  for (const [seed, machine] of [[1, ["--machine", "mill-3axis"]], [2, []]]) {
    await panel.getByRole("button", { name: "Rehearse" }).click();
    const name = `rehearsed-${seed}.log`;
    await panel.getByText(`${name}: `).waitFor();
    const line = ["keep", "simulate", "keep.toml", ...machine, "--seed", String(seed), "-o", name];
    assert.equal(await panel.locator("code").nth(2).textContent(), `trueaxis ${line.join(" ")}`);
    assert.equal((await run("trueaxis", line, { cwd: folder })).code, 0);
    sameLog((await saved(page, panel.getByRole("button", { name: "Save the log" }))).bytes.toString(), fs.readFileSync(at(name), "utf8"));
    const truth = await numbers(panel.getByRole("table", { name: "True errors of the rehearsal" }));
    assert.equal(truth["location.C0Y_urad"].true === truth["location.C0Y_urad"]["in the files"], seed === 1);
    if (seed === 1) await panel.getByRole("button", { name: "Enter it in the history" }).click();
    else await panel.getByRole("table", { name: "Verdicts" }).waitFor();
  }
  await close();
});
