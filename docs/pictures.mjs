// Pictures of pages, for docs/pictures.py: reports as files, and the desk.
//
//   node docs/pictures.mjs page PAGE.html OUT.png FIRST LAST    from one element of a report to another, by CSS selectors
//   node docs/pictures.mjs desk OUT.png                         the scope after the default program
//   node docs/pictures.mjs film FOLDER                          frames of the scope, and frames.json with their places
//
// Prints what the page says, one line for a sentence or a row of a table. Needs desk/node_modules (desk/build.sh) and Chromium.

import fs from "node:fs";
import path from "node:path";
import { pathToFileURL } from "node:url";
import { chromium } from "../desk/node_modules/playwright-core/index.mjs";
import { closeBrowser, openDesk, view } from "../desk/tests/harness.mjs";

/** Room around a picture, px. */
const MARGIN = 16;
/** The film: size of the page; the part of it that is filmed, the run and its traces, px; its steps, the whole default program. */
const FILM = { size: { width: 1024, height: 640 }, clip: { x: 0, y: 88, width: 666, height: 552 }, frames: 24, ms: 200, rest_ms: 2600, quality: 0.5 };

/** Sentences and tables of a document, rows with their cells apart by tabs. */
function words(parts) {
  return parts.evaluateAll((all) =>
    all.flatMap((one) => {
      const said = (element) => element.textContent.trim().replace(/\s+/g, " ");
      return one.tagName === "TABLE" ? [...one.querySelectorAll("tr")].map((row) => [...row.cells].map(said).join("\t")) : [said(one)];
    }),
  );
}

async function page(file, out, first, last) {
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
  const page = await browser.newPage({ viewport: { width: 1120, height: 900 }, colorScheme: "light" });
  await page.goto(pathToFileURL(path.resolve(file)).href);
  const [from, to] = [await page.locator(first).first().boundingBox(), await page.locator(last).first().boundingBox()];
  if (!from || !to) throw new Error(`${file}: found no ${from ? last : first}, needed both`);
  const y = Math.max(0, from.y - MARGIN);
  await page.screenshot({ path: out, fullPage: true, clip: { x: 0, y, width: 1120, height: to.y + to.height + MARGIN - y } });
  const said = await words(page.locator("h1, .run, .result, main > table"));
  await browser.close();
  return said;
}

/** The scope before the first cycle of the default program. */
async function scope(size) {
  const desk = await openDesk(size);
  await desk.page.setViewportSize(size);
  const panel = await view(desk.page, "Servo scope");
  const state = (wanted) => panel.locator(`.bar[data-state="${wanted}"]`).waitFor();
  await state("running");
  await panel.getByRole("button", { name: "Pause" }).click();
  await panel.getByRole("button", { name: "Restart" }).click();
  await state("ready");
  return { ...desk, panel, state };
}

async function desk(out) {
  const { page, panel, state, close } = await scope({ width: 1440, height: 900 });
  await panel.getByRole("button", { name: "To the end" }).click();
  await state("done");
  await page.mouse.move(0, 0);
  await page.evaluate(() => document.activeElement?.blur());
  await page.waitForTimeout(500);
  await page.screenshot({ path: out });
  const said = await words(panel.locator(".result, .figures table").filter({ visible: true }));
  await close();
  return said;
}

/** The part of a picture that differs from the one before, at even coordinates as the format needs, as WebP. Runs in the page. */
async function difference([png, quality]) {
  const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
  const { width, height } = bitmap;
  const canvas = new OffscreenCanvas(width, height);
  const context = canvas.getContext("2d", { alpha: false, willReadFrequently: true });
  context.drawImage(bitmap, 0, 0);
  const now = new Uint32Array(context.getImageData(0, 0, width, height).data.buffer);
  const before = globalThis.before;
  globalThis.before = now;
  let [left, top, right, bottom] = before ? [width, height, 0, 0] : [0, 0, width, height];
  if (before)
    for (let y = 0; y < height; y++)
      for (let x = 0; x < width; x++)
        if (now[y * width + x] !== before[y * width + x]) [left, top, right, bottom] = [Math.min(left, x), Math.min(top, y), Math.max(right, x + 1), Math.max(bottom, y + 1)];
  if (right <= left) return null;
  [left, top] = [left - (left % 2), top - (top % 2)];
  const part = new OffscreenCanvas(right - left, bottom - top);
  part.getContext("2d", { alpha: false }).drawImage(canvas, -left, -top);
  const bytes = new Uint8Array(await (await part.convertToBlob({ type: "image/webp", quality })).arrayBuffer());
  return { x: left, y: top, width: part.width, height: part.height, webp: btoa(Array.from(bytes, (byte) => String.fromCharCode(byte)).join("")) };
}

async function film(folder) {
  const { size, clip, frames, ms, rest_ms, quality } = FILM;
  const { page, panel, context, close } = await scope(size);
  const darkroom = await context.newPage();
  const progress = async () => (await panel.locator(".bar output").textContent()).match(/: ([\d,]+) of ([\d,]+) /).slice(1).map((count) => Number(count.replaceAll(",", "")));
  const [, cycles] = await progress();
  await panel.getByLabel("Cycles", { exact: true }).fill(String(Math.ceil(cycles / frames)));
  const places = [];
  for (let number = 0; number < frames; number++) {
    const [at] = await progress();
    await panel.getByRole("button", { name: "Step on" }).click();
    while ((await progress())[0] === at || (await panel.locator('.bar[data-state="running"]').count()) > 0) await page.waitForTimeout(50);
    await page.mouse.move(0, 0);
    await page.evaluate(() => document.activeElement?.blur());
    // The picture of the place follows the traces.
    await page.waitForTimeout(500);
    const found = await darkroom.evaluate(difference, [(await page.screenshot({ clip })).toString("base64"), quality]);
    if (!found) continue;
    const { webp, ...place } = found;
    const name = `${String(places.length).padStart(3, "0")}.webp`;
    fs.writeFileSync(path.join(folder, name), Buffer.from(webp, "base64"));
    places.push({ name, ...place, ms });
  }
  places.at(-1).ms = rest_ms;
  fs.writeFileSync(path.join(folder, "frames.json"), JSON.stringify({ width: clip.width, height: clip.height, frames: places }));
  await close();
  return [];
}

const [what, ...given] = process.argv.slice(2);
const made = { page, desk, film }[what];
if (!made) throw new Error("usage: pictures.mjs page PAGE.html OUT.png FIRST LAST | desk OUT.png | film FOLDER");
console.log((await made(...given)).join("\n"));
await closeBrowser();
