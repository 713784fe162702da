// The servo scope against `firmware-sim run`.

import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { closeBrowser, drop, numbers, openDesk, run, saved, shot, sim, view } from "./harness.mjs";

after(closeBrowser);

/** Timeout for a computer that runs other tests at the same time. */
const LONG = 240_000;
const KINDS = { uncorrected: "uncompensated", corrected: "compensated", "servo alone": "servo_only", "everything on": "full" };
const SIZES = /^Contour error of the true tip/;
/** A program of a few seconds that contains everything an act may meet. */
const TINY = "G21 G90 G94 G17\nF2400\nG0 Z5\nG1 Z0\nX20 Y10\nG2 X20 Y-10 I0 J-10\nG1 X-10\nY0\nX0\nM2\n";

async function open(options) {
  const desk = await openDesk(options);
  const panel = await view(desk.page, "Servo scope");
  if (options?.hash) await panel.locator(".bar[data-state]").waitFor();
  else {
    // The opening run goes on by itself: these tests begin with a run of their own.
    await state(panel, "running");
    await panel.getByRole("button", { name: "Pause" }).click();
    await panel.getByRole("button", { name: "Restart" }).click();
    await state(panel, "ready");
    await panel.getByLabel("Pace").selectOption("fast");
  }
  return { ...desk, panel };
}

async function state(panel, wanted) {
  await panel.locator(`.bar[data-state="${wanted}"]`).waitFor({ timeout: LONG });
}

async function program(panel, name, text) {
  await drop(panel, { [name]: text });
  await panel.getByRole("option", { name: "G21 G90" }).waitFor();
  await state(panel, "ready");
}

async function toTheEnd(panel) {
  await panel.getByRole("button", { name: "To the end" }).click();
  await state(panel, "done");
}

async function figures(panel) {
  const sizes = await numbers(panel.getByRole("table", { name: SIZES }));
  const digests = await numbers(panel.getByRole("table", { name: /^Digest of the step/ }));
  return { sizes, digests };
}

/** Contour errors agree to the last printed digit; the digests are equal. */
function same({ sizes, digests }, document) {
  for (const [text, kind] of Object.entries(KINDS)) {
    const { max, rms } = document.contour_error_um[kind];
    for (const [name, wanted] of [["largest", max], ["RMS", rms]]) {
      const found = sizes[text][name];
      assert.ok(Math.abs(found - wanted) < 1e-9, `${text}, ${name}: found ${found}, the command line has ${wanted}`);
    }
    assert.equal(digests[text].digest, document.digest[kind], `${text}: digest`);
  }
}

function folder() {
  return fs.mkdtempSync(path.join(os.tmpdir(), "scope-"));
}

/** Saves the scenario's files, unpacks them and runs the printed command in their folder. */
async function reproduced(page, panel) {
  const { bytes } = await saved(page, panel.getByRole("button", { name: "Save files (ZIP)" }));
  const at = folder();
  fs.writeFileSync(path.join(at, "all.zip"), bytes);
  execFileSync("python3", ["-m", "zipfile", "-e", "all.zip", "."], { cwd: at });
  const command = await panel.locator(".command code").textContent();
  assert.equal(fs.readFileSync(path.join(at, "command.txt"), "utf8"), `${command}\n`);
  const [name, ...given] = command.split(" ");
  assert.equal(name, "firmware-sim");
  return sim([...given, "--json"], { cwd: at });
}

test("a built-in program gives the command line's figures and digests", async () => {
  const { panel, close } = await open();
  await panel.getByLabel("Program", { exact: true }).selectOption("short-tour");
  await panel.getByRole("option", { name: "Everything that a servo cycle meets" }).waitFor();
  await toTheEnd(panel);
  const document = await sim(["run", "--program", "short-tour", "--json"]);
  same(await figures(panel), document);
  assert.equal(await panel.locator(".bar progress").evaluate((meter) => meter.value), 1);
  const counts = await numbers(panel.getByRole("table", { name: "The corrected machine" }));
  assert.equal(counts.cycles.run, document.cycles);
  assert.equal(counts["correction limited / cycles"].run, document.limited_cycles);
  await close();
});

test("acts in motion run again by the printed command", async () => {
  const { page, panel, close } = await open();
  await program(panel, "tiny.ngc", TINY);
  const at = panel.getByLabel("Acts at / s (empty: now)");
  await panel.getByRole("spinbutton", { name: "Cycles", exact: true }).fill("4000");
  await panel.getByRole("button", { name: "Step on" }).click();
  await panel.getByText(/^paused: 4,000 of/).waitFor();

  await panel.getByLabel("Axis", { exact: true }).selectOption("Y");
  await panel.getByRole("button", { name: "Inject" }).click();
  await panel.getByRole("cell", { name: "dropout:Y@0.4s+3", exact: true }).waitFor();
  await panel.getByRole("button", { name: "Exchange", exact: true }).click();
  await panel.getByRole("cell", { name: "exchange:half-tables@0.4s", exact: true }).waitFor();
  await at.fill("0.9");
  await panel.getByRole("button", { name: "Friction", exact: true }).click();
  await panel.getByRole("cell", { name: "off:friction@0.9s", exact: true }).waitFor();
  await at.fill("");
  await panel.getByRole("button", { name: "Run", exact: true }).click();
  await state(panel, "done");
  assert.equal(await panel.getByRole("button", { name: "Friction", exact: true }).getAttribute("aria-pressed"), "false");
  assert.match(await panel.getByRole("table", { name: /^Faults that the step reported/ }).textContent(), /0\.400\d.*Y encoder not a number FeedbackNotFinite/);

  const document = await reproduced(page, panel);
  const first = await figures(panel);
  same(first, document);
  assert.equal(document.faults.length, 1);

  // The acts are part of the scenario: Restart repeats them.
  await panel.getByRole("button", { name: "Restart" }).click();
  await state(panel, "ready");
  await toTheEnd(panel);
  assert.deepEqual(await figures(panel), first);
  // Without the exchange, the digests differ.
  await panel.getByRole("button", { name: "Remove exchange:half-tables@0.4s" }).click();
  await panel.getByRole("button", { name: "Restart" }).click();
  await state(panel, "ready");
  await toTheEnd(panel);
  assert.notDeepEqual((await figures(panel)).digests, first.digests);
  await close();
});

test("tables of a machine that was dropped are exchanged for", async () => {
  const { page, panel, close } = await open();
  await program(panel, "tiny.ngc", TINY);
  const files = await page.evaluate(() => globalThis.trueaxisDesk.bench.call("scope_scaled", globalThis.trueaxisDesk.machine.json, 0.9));
  await drop(panel, JSON.parse(files));
  // The message disappears; the new option of the list stays.
  await panel.locator("option[value^='given:']").waitFor({ state: "attached" });
  await panel.getByLabel("Acts at / s (empty: now)").fill("0.5");
  await panel.getByRole("button", { name: "Exchange", exact: true }).click();
  await panel.getByRole("cell", { name: /^exchange:[\w.-]+@0\.5s$/ }).waitFor();
  await toTheEnd(panel);
  same(await figures(panel), await reproduced(page, panel));
  await close();
});

test("a drive by name and its play give the command line's figures, and a reading of wrong sign is reported", async () => {
  const { page, panel, close } = await open();
  await program(panel, "tiny.ngc", TINY);
  await panel.getByLabel("Drive", { exact: true }).selectOption("worn");
  await panel.getByLabel("Acts at / s (empty: now)").fill("0");
  await panel.getByLabel("Fault", { exact: true }).selectOption("scale");
  await panel.getByRole("button", { name: "Inject" }).click();
  await panel.getByRole("cell", { name: /^scale:X@0s/ }).waitFor();
  await toTheEnd(panel);
  await panel.getByRole("cell", { name: "FeedbackRatio" }).first().waitFor();
  const { settings } = await reproduced(page, panel);
  assert.equal(settings.drive.resonance_hz, 80);
  assert.equal(settings.drive.gear_play_mm, 0.006);
  same(await figures(panel), await reproduced(page, panel));
  await close();
});

test("a program runs with the files of its subprograms that are dropped with it", async () => {
  const { page, panel, close } = await open();
  const main = "G21 G90 G94 G17 F2400\nG1 Z0\no<side> call [20]\no<side> call [-5]\nM98 P100\nM2\n";
  const files = { "side.ngc": "o<side> sub\nG1 X#1\nY#1\nX0 Y0\no<side> endsub\n", "part.ngc": main, "100.ngc": "O100\nG1 Z2\nM99\n" };
  await drop(panel, files);
  await panel.getByRole("option", { name: "o<side> call [20]" }).waitFor();
  assert.equal(await panel.getByLabel("Program", { exact: true }).locator("option:checked").textContent(), "part.ngc");
  await state(panel, "ready");
  await toTheEnd(panel);
  same(await figures(panel), await reproduced(page, panel));

  // A link keeps them.
  await page.getByRole("button", { name: "Link" }).click();
  await page.waitForFunction(() => location.hash.startsWith("#open="));
  const second = await open({ hash: new URL(page.url()).hash });
  await state(second.panel, "ready");
  await toTheEnd(second.panel);
  assert.deepEqual(await figures(second.panel), await figures(panel));
  await second.close();

  // Alone it is refused with the name of the file that is missing; two programs without a main one too.
  await drop(panel, { "part.ngc": main });
  await page.getByRole("alert").filter({ hasText: "part.ngc:3: found `O<side> call` without its subprogram; needed: `O<side> sub` in the program, or a file side.ngc with it beside the program" }).waitFor();
  await drop(panel, { "one.ngc": TINY, "other.ngc": TINY });
  await page.getByRole("alert").filter({ hasText: "found 2 programs, one.ngc and other.ngc called by no other one; needed one with the files of its subprograms" }).waitFor();
  await close();
});

test("bad files are refused as on the command line, and the run stays", async () => {
  const { page, panel, close } = await open();
  await program(panel, "tiny.ngc", TINY);
  const alert = page.locator("#error");
  const at = folder();
  const refused = async (name, text, given) => {
    fs.writeFileSync(path.join(at, name), text);
    const { code, stderr } = await run("firmware-sim", ["run", ...given], { cwd: at });
    assert.equal(code, 2);
    await drop(panel, { [name]: text });
    await alert.getByText(name.split(".")[0]).waitFor();
    const message = await alert.locator("span").textContent();
    assert.ok(stderr.includes(message), `the page: ${message}\nthe command line: ${stderr}`);
    return message;
  };
  assert.match(await refused("bad.ngc", "G1 X10 F100\nG5.9 X2\n", ["--program", "bad.ngc"]), /^bad\.ngc:2: /);
  assert.match(await refused("far.ngc", "G21 G90 F900\nG1 X4000\n", ["--program", "far.ngc"]), /far/);
  assert.match(await refused("mine.toml", "[drive]\ngain = 3\n", ["--scenario", "mine.toml"]), /^mine\.toml:2: drive\.gain: found no such setting, needed one of/);
  assert.match(await refused("faults.toml", 'seed = 2\nfaults = ["vanish:X@1s+1"]\n', ["--scenario", "faults.toml"]), /^faults\.toml:2: faults: found/);
  // The open run continues.
  assert.equal(await panel.getByLabel("Program", { exact: true }).locator("option:checked").textContent(), "tiny.ngc");
  await toTheEnd(panel);
  await close();
});

test("settings act, and a link opens the same run in another page", async () => {
  const { page, panel, close } = await open();
  await program(panel, "tiny.ngc", TINY);
  const set = async (name, value) => {
    const input = panel.getByRole("spinbutton", { name, exact: true });
    await input.fill(value);
    await input.press("Tab");
  };
  await set("Feed / %", "150");
  await set("Servo rate / Hz", "4000");
  await set("Encoder noise, RMS / µm", "0.02");
  await set("Temperature / °C", "24");
  await set("Friction / %", "150");
  await set("Seed of the noise", "7");
  await panel.getByLabel("Error model").selectOption("volumetric");
  // The page collects settings for a moment before it opens the run with them.
  // The wait uses the page's clock: on a busy computer its timers come late, but in order.
  await page.evaluate(() => new Promise((done) => setTimeout(done, 600)));
  await state(panel, "ready");
  await panel.getByLabel("Acts at / s (empty: now)").fill("0.3");
  await panel.getByRole("button", { name: "Inject" }).click();
  await panel.getByRole("cell", { name: "dropout:X@0.3s+3", exact: true }).waitFor();
  await toTheEnd(panel);
  const first = await figures(panel);
  const document = await reproduced(page, panel);
  same(first, document);
  const { settings } = document;
  assert.deepEqual([settings.rate_hz, settings.seed, settings.temperature_c, settings.motion.feed_percent], [4000, 7, 24, 150]);
  // 150 % of the friction that the machine file states: 0.45 mm/s times 840 1/s.
  assert.ok(Math.abs(settings.drive.coulomb_mm_per_s2 - 1.5 * 0.45 * 840) < 1e-6);

  await page.getByRole("button", { name: "Link" }).click();
  await page.waitForFunction(() => location.hash.startsWith("#open="));
  const hash = new URL(page.url()).hash;
  const file = await saved(page, page.getByRole("button", { name: "Save", exact: true }));
  await close();

  const second = await open({ hash });
  await state(second.panel, "ready");
  await toTheEnd(second.panel);
  assert.deepEqual(await figures(second.panel), first);
  await second.close();

  const third = await open();
  await third.page.getByLabel("Open", { exact: true }).setInputFiles({ name: file.name, mimeType: "application/json", buffer: file.bytes });
  await third.panel.getByRole("cell", { name: "dropout:X@0.3s+3", exact: true }).waitFor();
  await state(third.panel, "ready");
  await toTheEnd(third.panel);
  assert.deepEqual(await figures(third.panel), first);
  await third.close();
});

test("the page responds and draws during a run", async () => {
  const { page, panel, close } = await open();
  const frames = () =>
    page.evaluate(
      () =>
        new Promise((done) => {
          let count = 0;
          const from = performance.now();
          const tick = () => {
            count++;
            const passed = performance.now() - from;
            if (passed > 4000) done((1e3 * count) / passed);
            else requestAnimationFrame(tick);
          };
          requestAnimationFrame(tick);
        }),
    );
  const idle = await frames();
  await panel.getByRole("button", { name: "Run", exact: true }).click();
  await state(panel, "running");
  const going = await frames();
  console.log(`frames a second: ${idle.toFixed(1)} idle, ${going.toFixed(1)} during a run`);
  assert.match(await panel.locator(".bar output").textContent(), /million cycles a second/);
  // A page that does not respond draws nothing for seconds. How much more it draws depends on what else the computer does.
  assert.ok(going > Math.min(15, 0.25 * idle), `${going} frames a second, ${idle} idle`);
  await panel.getByRole("button", { name: "Pause" }).click();
  await state(panel, "paused");
  await close();
});

test("after a panic the run starts again", async () => {
  const { page, panel, close } = await open();
  await program(panel, "tiny.ngc", TINY);
  await panel.getByRole("button", { name: "Step on" }).click();
  await state(panel, "paused");
  await page.evaluate(() => globalThis.trueaxisDesk.runs.call("panic_on_purpose").catch(() => {}));
  await page.getByRole("alert").getByText(/stopped and was restarted/).waitFor();
  await panel.getByText("The run is lost: Run starts it again.").waitFor();
  await toTheEnd(panel);
  const after = await figures(panel);
  await panel.getByRole("button", { name: "Restart" }).click();
  await state(panel, "ready");
  await toTheEnd(panel);
  assert.deepEqual(await figures(panel), after);
  await close();
});

test("a run kept as A is shown beside B", async () => {
  const { panel, close } = await open();
  await program(panel, "tiny.ngc", TINY);
  await toTheEnd(panel);
  const a = await figures(panel);
  await panel.getByRole("button", { name: "Keep this run as A" }).click();
  const feed = panel.getByRole("spinbutton", { name: "Feed / %" });
  await feed.fill("50");
  await feed.press("Tab");
  await panel.getByText("The settings have changed: Restart runs them.").waitFor();
  await panel.getByRole("button", { name: "Restart" }).click();
  await state(panel, "ready");
  await toTheEnd(panel);
  const both = await numbers(panel.getByRole("table", { name: SIZES }));
  for (const kind of Object.keys(KINDS)) {
    const row = both[kind];
    assert.equal(row["A largest"], a.sizes[kind].largest);
    assert.equal(row["A RMS"], a.sizes[kind].RMS);
    assert.notEqual(row["B RMS"], row["A RMS"]);
    assert.ok(Math.abs(row["B − A RMS"] - (row["B RMS"] - row["A RMS"])) < 1e-12);
  }
  const differs = panel.getByRole("table", { name: "Differences" });
  assert.match(await differs.textContent(), /motion\.feed_percent\s*default\s*50/);
  const plot = panel.getByRole("img", { name: "Contour error, A beside B" });
  assert.match(await plot.getAttribute("aria-description"), /length along the path \/ mm\. A: .* to .*; B: .* to /);
  await panel.getByRole("button", { name: "Take A's settings" }).click();
  await state(panel, "ready");
  assert.equal(await feed.inputValue(), "100");
  await close();
});

test("cursor, program line and place go together, by keys alone", async () => {
  const { page, panel, close } = await open();
  await program(panel, "tiny.ngc", TINY);
  const run = panel.getByRole("button", { name: "Run", exact: true });
  await run.focus();
  await page.keyboard.press("Enter");
  await state(panel, "done");
  const plot = panel.getByRole("img", { name: "Contour error of the true tool tip" });
  await plot.focus();
  await page.keyboard.press("Home");
  for (let i = 0; i < 20; i++) await page.keyboard.press("Shift+ArrowRight");
  const readouts = panel.locator(".traces output");
  const time = /time \/ s: (\S+)/.exec(await readouts.nth(0).textContent())[1];
  assert.match(await readouts.nth(1).textContent(), new RegExp(`time / s: ${time.replace(".", "\\.")} `), "the plots' cursors go together");
  const place = panel.locator(".place output");
  const line = /line (\d+)$/.exec(await place.textContent())[1];
  assert.match(await panel.locator(".line[aria-current]").getAttribute("data-line"), new RegExp(`^${line}$`));

  const listing = panel.getByRole("listbox", { name: "Part program" });
  await listing.focus();
  await page.keyboard.press("Home");
  for (let i = 0; i < 5; i++) await page.keyboard.press("ArrowDown");
  await panel.getByText(/line 6$/).waitFor();
  assert.equal(await listing.getByRole("option", { selected: true }).getAttribute("data-line"), "6");
  await close();
});

test("a program of another view runs here, and a picture", async () => {
  for (const dark of [false, true]) {
    const { page, panel, close } = await open({ dark });
    await page.evaluate((text) => globalThis.trueaxisDesk.openProgram({ name: "handed.ngc", text }), TINY);
    await panel.getByRole("option", { name: "G21 G90" }).waitFor();
    await panel.getByLabel("Program", { exact: true }).selectOption("short-tour");
    await panel.getByRole("option", { name: "Everything that a servo cycle meets" }).waitFor();
    await state(panel, "ready");
    await panel.getByLabel("Acts at / s (empty: now)").fill("6");
    await panel.getByRole("button", { name: "Exchange", exact: true }).click();
    await panel.getByRole("cell", { name: "exchange:half-tables@6s", exact: true }).waitFor();
    await toTheEnd(panel);
    const plot = panel.getByRole("img", { name: "Contour error of the true tool tip" });
    await plot.focus();
    await page.keyboard.press("Home");
    for (let i = 0; i < 30; i++) await page.keyboard.press("Shift+ArrowRight");
    await page.evaluate(() => scrollTo(0, 0));
    await shot(page, dark ? "scope-dark" : "scope");
    await close();
  }
});
