// The desk in Debian's Chromium, and the command line to compare it with.

import assert from "node:assert/strict";
import { execFile } from "node:child_process";
import fs from "node:fs";
import path from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

const here = path.dirname(fileURLToPath(import.meta.url));
export const root = path.resolve(here, "../..");
const page_file = process.env.TRUEAXIS_DESK ?? path.join(root, "desk/dist/desk.html");
const target = process.env.CARGO_TARGET_DIR ?? path.join(root, "target");
/** Directory of the built `trueaxis` and `firmware-sim`. */
const programs = path.join(target, process.env.TRUEAXIS_PROFILE ?? "debug");
// WebGL 2 without a graphics card. The rest of the page is drawn as browsers do without one: by the processor, not by a
// graphics card that the processor imitates.
const drawing = ["--disable-gpu-rasterization", "--disable-accelerated-2d-canvas"];
const flags = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", ...drawing];

let browser;

/**
 * Opens a page with the desk and waits until it is ready. `close()` fails if the page logged an error that is not in `quiet`.
 */
export async function openDesk({ hash = "", dark = false, width = 1400, quiet = [] } = {}) {
  browser ??= await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: flags });
  const context = await browser.newContext({
    viewport: { width, height: 900 },
    colorScheme: dark ? "dark" : "light",
    acceptDownloads: true,
  });
  // A busy computer needs more time; a missing element still fails the test.
  context.setDefaultTimeout(180_000);
  const page = await context.newPage();
  const errors = [];
  page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
  page.on("pageerror", (error) => errors.push(error.message));
  page.on("request", (request) => /^(file|blob|data):/.test(request.url()) || errors.push(`request of ${request.url()}`));
  await page.goto(pathToFileURL(page_file).href + hash);
  await page.waitForSelector("html[data-ready]");
  const close = async () => {
    await context.close();
    const left = errors.filter((text) => !quiet.some((known) => text.includes(known)));
    if (left.length > 0) throw new Error(`the page logged errors:\n${left.join("\n")}`);
  };
  return { page, context, close };
}

/** Closes the browser; each test file calls it once, at its end. */
export async function closeBrowser() {
  await browser?.close();
  browser = undefined;
}

/** The groups of the desk and their views. */
export const GROUPS = {
  Measure: ["Ballbar", "Tests", "Roundness", "Friction", "Calibrate"],
  Machine: ["Machine", "Uncertainty"],
  Run: ["Servo scope"],
  Keep: ["Thermal growth", "Keep"],
  Part: ["Predict", "Helicoid and five axes"],
};

/** Opens a view of the desk by its name, its group, then its tab, and waits until it is built. */
export async function view(page, name) {
  const [group] = Object.entries(GROUPS).find(([, views]) => views.includes(name)) ?? [];
  if (group) {
    await page.getByRole("navigation", { name: "Groups of views" }).getByRole("button", { name: group }).click();
    await page.getByRole("tab", { name, exact: true }).click();
  } else await page.getByRole("button", { name: /^About/ }).click();
  const panel = page.getByRole("tabpanel", { name, exact: true });
  await page.locator('[role="tabpanel"]:not([hidden], [aria-busy])').waitFor({ state: "attached" });
  return panel;
}

/** Runs one of the programs; returns its exit code and output. */
export function run(program, given, options = {}) {
  return new Promise((done) => {
    const settings = { cwd: root, maxBuffer: 1 << 28, ...options };
    execFile(path.join(programs, program), given, settings, (error, stdout, stderr) => {
      done({ code: error ? (error.code ?? 1) : 0, stdout, stderr });
    });
  });
}

/** The document that `trueaxis … --json` prints. */
export async function cli(given, options) {
  return json("trueaxis", given, options);
}

/** The document that `firmware-sim … --json` prints. */
export async function sim(given, options) {
  return json("firmware-sim", given, options);
}

async function json(program, given, options) {
  const { code, stdout, stderr } = await run(program, given, options);
  if (code !== 0) throw new Error(`${program} ${given.join(" ")}: exit code ${code}\n${stderr}`);
  return JSON.parse(stdout);
}

/** Drops files, `{ name: text or Uint8Array }`, on an element. */
export async function drop(locator, files) {
  const given = Object.entries(files).map(([name, content]) => [name, Buffer.from(content).toString("base64")]);
  const transfer = await locator.page().evaluateHandle((given) => {
    const transfer = new DataTransfer();
    for (const [name, base64] of given) {
      const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
      transfer.items.add(new File([bytes], name));
    }
    return transfer;
  }, given);
  await locator.dispatchEvent("dragenter", { dataTransfer: transfer });
  await locator.dispatchEvent("drop", { dataTransfer: transfer });
}

/** Numbers of a table at full precision, by row header and column header. */
export async function numbers(table) {
  return table.evaluate((element) => {
    const header = [...element.querySelectorAll("thead th")].map((cell) => cell.textContent);
    const rows = [...element.querySelectorAll("tbody tr")].map((row) => {
      const cells = [...row.children];
      const values = cells.slice(1).map((cell, i) => [header[i + 1], cell.dataset.value === undefined ? cell.textContent : Number(cell.dataset.value)]);
      return [cells[0].textContent, Object.fromEntries(values)];
    });
    return Object.fromEntries(rows);
  });
}

/**
 * Checks expanded uncertainties, `[found, standard error]`: every one is its standard error times one factor of Student's, to
 * a share of `tolerance`.
 */
export function expanded(pairs, tolerance = 1e-5) {
  const factors = pairs.filter(([, error]) => error > 0).map(([found, error]) => found / error);
  if (factors.length === 0) return;
  const [least, most] = [Math.min(...factors), Math.max(...factors)];
  assert.ok(least > 1.9599 && most < least * (1 + tolerance), `found factors of ${least} to ${most}, needed one of 1.96 or more`);
}

/** Clicks on `locator` and returns the name and bytes of the saved file. */
export async function saved(page, locator) {
  const [download] = await Promise.all([page.waitForEvent("download"), locator.click()]);
  return { name: download.suggestedFilename(), bytes: fs.readFileSync(await download.path()) };
}

/** Checks that two logs have the same touches: the browser's trigonometric functions may differ in their last bit. */
export function sameLog(found, needed) {
  const [own, other] = [found, needed].map((text) => text.trim().split("\n").map((line) => line.split(" ")));
  assert.equal(own.length, other.length);
  for (const [i, words] of own.entries())
    for (const [k, word] of words.entries()) assert.ok(word === other[i][k] || Math.abs(Number(word) - Number(other[i][k])) < 1.5e-6, `line ${i + 1}: found ${words.join(" ")}, needed ${other[i].join(" ")}`);
}

/** Waits until a view has something to show and no longer changes, for 5 s at most: the scope runs on. A change is seen only by looking again. */
export async function settled(panel) {
  await panel.locator("canvas:visible, svg:visible, tbody tr:visible").first().waitFor();
  const look = () => panel.evaluate((view) => `${view.scrollHeight} ${view.innerText}`);
  for (let [before, same, tries] = ["", 0, 0]; same < 3 && tries < 25; tries += 1) {
    const now = await look();
    same = now === before ? same + 1 : 0;
    before = now;
    await panel.page().waitForTimeout(200);
  }
}

/** Saves a picture for people to look at. */
export async function shot(page, name, fullPage = false) {
  fs.mkdirSync(path.join(root, "desk/shots"), { recursive: true });
  await page.screenshot({ path: path.join(root, "desk/shots", `${name}.png`), fullPage });
}
