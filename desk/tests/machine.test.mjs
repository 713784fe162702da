// The Machine view: its figures and errors equal the command line's, and the library's compiler writes the same file.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, drop, numbers, openDesk, root, run, saved, shot, view } from "./harness.mjs";

after(closeBrowser);

const samples = path.join(root, "compensation-tables");
const panelOf = (page) => view(page, "Machine");

/** The texts of a sample's files. */
function sample(name) {
  const folder = path.join(samples, name);
  return Object.fromEntries(fs.readdirSync(folder).map((file) => [file, fs.readFileSync(path.join(folder, file))]));
}

/** Writes these files into a folder. */
function folder(files) {
  const place = fs.mkdtempSync(path.join(os.tmpdir(), "desk-machine-"));
  for (const [name, content] of Object.entries(files)) fs.writeFileSync(path.join(place, name), content);
  return place;
}

const files = (page) => page.evaluate(() => globalThis.trueaxisDesk.machine.files);
const table = (panel, name) => panel.getByRole("table", { name });

/** Waits until `holds` accepts the machine's files. */
async function until(page, holds, what) {
  for (let tries = 0; tries < 1000; tries += 1) {
    if (holds(await files(page))) return;
    await page.waitForTimeout(100);
  }
  assert.fail(what);
}

test("figures are those of tables check and accuracy", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  for (const name of ["mill-3axis", "mill-5axis", "grinder"]) {
    const place = path.join(samples, name);
    const { summary, warnings, lost_motion, feedback_margins } = await cli(["tables", "check", place, "--json"]);
    await panel.getByLabel("Sample machine").selectOption(name);
    await panel.getByText(summary.crc.toString(16).padStart(8, "0")).waitFor();
    await panel.getByText(summary.machine_id.toString(16).padStart(8, "0")).waitFor();
    await panel.getByText(`${summary.memory_scalars} scalars`).waitFor();
    assert.deepEqual(await panel.locator(".warnings .warning").allTextContents(), warnings);
    const rows = await numbers(table(panel, /^Upper bounds/));
    assert.deepEqual(Object.keys(rows), summary.axes.map(({ axis }) => axis));
    for (const axis of summary.axes) {
      const row = rows[axis.axis];
      assert.equal(row["Magnitude limit"], axis.magnitude_micro, name);
      assert.equal(row["Slope limit"], axis.slope_per_s);
      const lost = lost_motion.find((one) => one.axis === axis.axis);
      assert.equal(row["Applied within / ms"], lost ? lost.lead_in_ms : "–");
      const most = axis.table?.errors.filter(({ unit }) => (unit === "um") === (axis.unit === "mm")).map((one) => one.max_abs);
      assert.equal(row["Largest table error"], most ? Math.max(...most) : "no table");
    }
    if (feedback_margins.length > 0) {
      const margins = await numbers(table(panel, "Margins of the contour feedback"));
      for (const of of feedback_margins) assert.equal(margins[of.axis]["Phase margin / °"], of.phase_margin_deg);
    }
  }
  await panel.getByLabel("Sample machine").selectOption("mill-3axis");
  const { measured, compensated } = await cli(["tables", "accuracy", `${samples}/mill-3axis/x-iso230-2.csv`, "--machine", `${samples}/mill-3axis`, "--json"]);
  const iso = await numbers(table(panel, /^x-iso230-2.csv/));
  for (const [name, of] of [
    ["A, bidirectional accuracy", ({ both }) => both.accuracy],
    ["E↑, positive approach", ({ up }) => up.systematic],
    ["R, bidirectional repeatability", ({ both }) => both.repeatability],
    ["M, range of the mean deviation", ({ both }) => both.mean_range],
    ["B̄, mean reversal error", ({ both }) => both.mean_reversal],
  ]) {
    assert.deepEqual(iso[name], { measured: of(measured), corrected: of(compensated) }, name);
  }
  await close();
});

test("what a feed and a rate ask for is said as on the command line", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  await table(panel, /^Upper bounds/).waitFor();
  const before = await numbers(table(panel, /^Upper bounds/));
  await panel.getByLabel("Feed of all axes").fill("3000");
  await panel.getByLabel("Feed of all axes").press("Enter");
  await page.waitForFunction((rate) => !document.querySelector(`.machine td[data-value="${rate}"]`), before.X.Slope);
  const after = await numbers(table(panel, /^Upper bounds/));
  // A fifth of 15 m/min: a fifth of the slope, a twenty-fifth of the acceleration.
  assert.ok(Math.abs(before.X.Slope / after.X.Slope - 5) < 0.5, `${before.X.Slope} ${after.X.Slope}`);
  await panel.getByLabel("Servo rate").fill("5");
  await panel.getByLabel("Servo rate").press("Enter");
  const { stderr } = await run("trueaxis", ["tables", "check", `${samples}/mill-3axis`, "--rate-hz", "5"]);
  await page.getByRole("alert").filter({ hasText: "--rate-hz" }).waitFor();
  assert.equal(`error: ${await page.getByRole("alert").locator("span").textContent()}\n`, stderr);
  await close();
});

test("a bad file is refused in the words of the command line, and the machine before stays", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  await table(panel, /^x.csv/).waitFor();
  const before = await files(page);
  const x = sample("mill-3axis")["x.csv"].toString();
  const bad = {
    "a word": x.replace("13.997", "about 14"),
    "two directions short": x.replace("EXX_rev_um", "EXX_um"),
    "other bytes": Buffer.concat([Buffer.from("X_mm,EXX_um\n0,1\n10,"), Buffer.from([0xff, 0xfe, 0x0a])]),
    "positions that fall": x.replace("\n-290,", "\n-310,"),
    "UTF-16": Buffer.from("\ufeffX_mm,EXX_um\n0,1\n", "utf16le"),
  };
  for (const [what, content] of Object.entries(bad)) {
    const place = folder({ ...sample("mill-3axis"), "x.csv": content });
    const { code, stderr } = await run("trueaxis", ["tables", "check", "machine.toml"], { cwd: place });
    assert.equal(code, 2, what);
    await drop(panel, { "x.csv": content });
    const message = page.getByRole("alert").locator("span").first();
    await page.waitForFunction((text) => document.querySelector("#error span")?.textContent === text, stderr.replace(/^error: /, "").trimEnd(), { timeout: 120_000 }).catch(() => {});
    assert.equal(`error: ${await message.textContent()}\n`, stderr, what);
    assert.deepEqual(await files(page), before, what);
  }
  await page.getByRole("button", { name: "Close" }).click();
  await drop(panel, { "other.txt": "hello" });
  await page.getByRole("alert").filter({ hasText: "other.txt: found a file that is none of the machine's" }).waitFor();
  await close();
});

test("a folder is opened with what belongs to it", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  const own = { ...sample("mill-5axis"), "notes.txt": "not for the machine" };
  const place = folder(own);
  await panel.getByLabel("Open a folder…").setInputFiles(place);
  await panel.getByText("1 file left out that no machine needs").waitFor();
  delete own["notes.txt"];
  assert.deepEqual(await files(page), Object.fromEntries(Object.entries(own).map(([name, bytes]) => [name, bytes.toString()])));
  assert.equal(await page.evaluate(() => globalThis.trueaxisDesk.machine.name), path.basename(place));
  // A rotary table: both ends of the full circle are one point.
  await panel.getByRole("button", { name: "C", exact: true }).click();
  await panel.getByLabel("Error", { exact: true }).selectOption({ label: "EXC, displacement in X" });
  const end = panel.getByRole("spinbutton", { name: "EXC_um at 360", exact: true });
  await end.fill("3.5");
  await end.press("Enter");
  await until(page, (files) => files["c.csv"].includes("\n0,3.5,") && files["c.csv"].includes("\n360,3.5,"), "the circle stays closed");
  await close();
});

test("separators of a dropped table are reported", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  await drop(panel, { "y.csv": "Y_mm;EYY_um\n-200;-1,5\n0;0,0\n200;2,5\n" });
  await panel.getByText("y.csv: read as semicolon separated with decimal commas").first().waitFor();
  await panel.getByRole("button", { name: "Y", exact: true }).click();
  const zero = panel.getByRole("spinbutton", { name: "EYY_um at 0", exact: true });
  await zero.fill("0.75");
  await zero.press("Enter");
  await until(page, (files) => files["y.csv"].includes("\n0;0,75\n"), "a typed number takes the file's decimals");
  await close();
});

test("a point is dragged and typed, undone, and the saved files compile to the same bytes", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  const before = await files(page);
  const point = panel.getByRole("slider", { name: "EXX_fwd_um at -100 mm" });
  await point.waitFor();
  const box = await point.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  for (let i = 1; i <= 5; i += 1) await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2 - 8 * i);
  await page.mouse.up();
  const line = (text) => text.split("\n").find((line) => line.startsWith("-100,"));
  const value_of = (files) => Number(line(files["x.csv"]).split(",")[1]);
  const was = value_of(before);
  // The drag covers 40 of some 210 pixels, which span 40 µm.
  await until(page, (files) => value_of(files) > was + 6, "the drag changes the table up to where it ends");
  for (let last = Number.NaN; last !== value_of(await files(page)); ) {
    last = value_of(await files(page));
    await page.waitForTimeout(1500);
  }
  const dragged = (await files(page))["x.csv"];
  const value = value_of({ "x.csv": dragged });
  // Both directions move by the same amount, and nothing else changes.
  const [position, , reverse, ...others] = line(before["x.csv"]).split(",");
  const moved = [position, value, Number((Number(reverse) + value - was).toFixed(3)), ...others].join(",");
  assert.equal(dragged, before["x.csv"].replace(line(before["x.csv"]), moved));
  assert.equal(await panel.getByRole("spinbutton", { name: "EXX_fwd_um at -100", exact: true }).inputValue(), String(value));

  await panel.getByRole("spinbutton", { name: "EXX_rev_um at -300", exact: true }).fill("17.25");
  await panel.getByRole("spinbutton", { name: "EXX_rev_um at -300", exact: true }).press("Enter");
  await until(page, (files) => files["x.csv"].includes("\n-300,14.551,17.25,"), "the typed point");
  await panel.getByRole("button", { name: "Undo" }).click();
  await until(page, (files) => files["x.csv"] === dragged, "undone once");
  await page.keyboard.press("Control+Z");
  await until(page, (files) => files["x.csv"] === before["x.csv"], "the whole drag is one step");
  await page.keyboard.press("Control+Shift+Z");
  await until(page, (files) => files["x.csv"] === dragged, "redone");
  await panel.getByRole("button", { name: "Redo" }).click();
  await until(page, (files) => files["x.csv"].includes("17.25"), "and again");

  const tcomp = await saved(page, panel.getByRole("button", { name: "Save .tcomp" }));
  assert.equal(tcomp.name, "mill-3axis.tcomp");
  const kept = {};
  for (const name of Object.keys(before)) kept[name] = (await saved(page, panel.getByRole("button", { name: `Save ${name}`, exact: true }))).bytes;
  assert.equal(kept["machine.toml"].toString(), sample("mill-3axis")["machine.toml"].toString());
  const place = folder(kept);
  const { code, stderr } = await run("trueaxis", ["tables", "compile", ".", "-o", "m.tcomp"], { cwd: place });
  assert.equal(code, 0, stderr);
  assert.ok(tcomp.bytes.equals(fs.readFileSync(path.join(place, "m.tcomp"))));

  // The compiled file opens again, with the edits.
  await drop(panel, { "again.tcomp": tcomp.bytes });
  await until(page, (files) => files["machine.toml"].startsWith("# From a compiled file"), "the .tcomp opens");
  assert.match((await files(page))["x.csv"], new RegExp(`\n-100,${value},`));
  const again = await saved(page, panel.getByRole("button", { name: "Save .tcomp" }));
  assert.ok(again.bytes.equals(tcomp.bytes));
  await close();
});

test("all of it by the keyboard", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  const point = panel.getByRole("slider", { name: "EXX_fwd_um at -300 mm" });
  await point.waitFor();
  await point.focus();
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowUp");
  await page.keyboard.press("Alt+ArrowUp");
  await page.keyboard.press("Shift+ArrowDown");
  // 14.499 + 0.1 + 0.01 − 1; the reverse value, 16.009, moves by the same amount.
  await until(page, (files) => files["x.csv"].includes("\n-290,13.609,15.119,"), "arrow keys move the point");
  assert.equal(await page.evaluate(() => document.activeElement.getAttribute("aria-label")), "EXX_fwd_um at -290 mm");
  await page.keyboard.press("Control+z");
  await until(page, (files) => files["x.csv"].includes("\n-290,14.499,16.009,"), "undone");

  await panel.getByLabel("C0Y, Y to X / µrad").fill("12.5");
  await page.keyboard.press("Enter");
  await until(page, (files) => files["machine.toml"].includes("C0Y_urad = 12.5\n"), "squareness typed");
  await panel.getByRole("slider", { name: "A0Z, Z to Y, slider" }).press("ArrowRight");
  await until(page, (files) => files["machine.toml"].includes("A0Z_urad = 32.5\n"), "squareness by slider");
  await panel.getByRole("group", { name: "Backlash" }).getByLabel("Y / µm").fill("1.5");
  await page.keyboard.press("Enter");
  await until(page, (files) => files["machine.toml"].includes("backlash_um = 1.5\n"), "backlash");

  await panel.getByLabel("Position of a new row").fill("-295");
  await panel.getByRole("button", { name: "Insert row" }).press("Enter");
  await until(page, (files) => /\n-300,.*\n-295,.*\n-290,/.test(files["x.csv"]), "a row inserted");
  await panel.getByRole("button", { name: "Remove row 2", exact: true }).press("Enter");
  await until(page, (files) => !files["x.csv"].includes("\n-295,"), "a row removed");
  await close();
});

test("a refused edit is reported and changes nothing", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  const position = panel.getByLabel("X_mm, row 2", { exact: true });
  await position.waitFor();
  const before = await files(page);
  await position.fill("-275");
  await position.press("Enter");
  await page.getByRole("alert").filter({ hasText: /^x\.csv:6: column X_mm: found -280, needed a position above/ }).waitFor();
  assert.deepEqual(await files(page), before);
  assert.equal(await position.inputValue(), "-290");

  // A shift of one direction by 5 µm is lost motion, which the hysteresis of 0.1 µm does not cover.
  await panel.getByLabel("Move both directions together").uncheck();
  const point = panel.getByRole("slider", { name: "EXX_fwd_um at -300 mm" });
  for (let i = 0; i < 5; i += 1) await point.press("Shift+ArrowUp");
  await page.getByRole("alert").filter({ hasText: "key axis.X.hysteresis_um: found 0.1, needed more than its correction steps against the travel" }).waitFor();
  await panel.getByLabel("Move both directions together").check();
  await point.press("Shift+ArrowUp");
  await page.getByRole("alert").waitFor({ state: "hidden" });
  await close();
});

test("grids are shown along each axis as their files have them", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  assert.ok(await panel.getByText("Grids of errors").isHidden());
  await drop(panel, sample("router"));
  await panel.getByText("Grid 2: nodes").waitFor();
  const rows = fs.readFileSync(path.join(samples, "router/rail.csv"), "utf8").split("\n").filter((line) => /^-?\d/.test(line)).map((line) => line.split(",").map(Number));
  const shown = async (name) => {
    const plot = panel.getByRole("img", { name });
    await plot.focus();
    await page.keyboard.press("Home");
    return plot.locator("xpath=following-sibling::output").textContent();
  };
  const micro = (value) => value.toPrecision(4).replace("-", "−");
  let text = await shown(/^Grid 1 along X at Y −300/);
  const first = rows.find(([x, y]) => x === -400 && y === -300);
  assert.ok(text.includes(`EX ${micro(first[2])} µm`) && text.includes(`EY ${micro(first[3])} µm`), text);
  await panel.getByLabel("Along", { exact: true }).first().selectOption("Y");
  await panel.getByLabel("Node of X, slider").first().fill("3");
  text = await shown(/^Grid 1 along Y at X −300/);
  const third = rows.find(([x, y]) => x === -300 && y === -300);
  assert.ok(text.includes(`EX ${micro(third[2])} µm`), `${text}: ${third}`);
  await close();
});

test("temperature shows the growth and leaves the machine alone", async () => {
  const { page, close } = await openDesk();
  const panel = await panelOf(page);
  await panel.getByRole("slider", { name: "EXX_fwd_um at -300 mm" }).waitFor();
  const before = await files(page);
  await panel.getByLabel("Axes at / °C").fill("30");
  await page.keyboard.press("Enter");
  // 10 K · 11.5 µm/m/K over −300 mm.
  const at = 14.551 - 34.5;
  await page.waitForFunction((at) => document.querySelector(".machine .plot").getAttribute("aria-description").includes(`with the growth: ${at}`.replace("-", "−")), at.toFixed(2)).catch(() => {});
  assert.match(await panel.locator(".plot").first().getAttribute("aria-description"), /with the growth: −19\.95 to/);
  assert.deepEqual(await files(page), before);
  await close();
});

test("pictures", async () => {
  for (const dark of [false, true]) {
    const { page, close } = await openDesk({ dark });
    const panel = await panelOf(page);
    await panel.getByRole("slider", { name: "EXX_fwd_um at -300 mm" }).waitFor();
    await page.waitForTimeout(500);
    await shot(page, dark ? "machine-dark" : "machine");
    await close();
  }
});
