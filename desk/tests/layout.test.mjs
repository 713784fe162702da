// Layout at three widths in both themes, colours, and a change of the theme in mid-session.

import assert from "node:assert/strict";
import { after, test } from "node:test";
import { closeBrowser, GROUPS, openDesk, settled, shot, view } from "./harness.mjs";

after(closeBrowser);

const VIEWS = Object.values(GROUPS).flat();
/** Edge of a target that a finger hits, px (WCAG 2.2, 2.5.5). */
const TARGET = 44;

/** A gate takes one theme at each width, since a theme changes no layout; TRUEAXIS_TEST_SHARE=1 takes both. */
const both = process.env.TRUEAXIS_TEST_SHARE === "1";

for (const width of [1440, 1024, 390])
  for (const dark of both ? [false, true] : [width === 1024])
    test(`every view has room in ${width} px, ${dark ? "dark" : "light"}`, async () => {
      const { page, close } = await openDesk({ width, dark });
      for (const name of VIEWS) {
        const panel = await view(page, name);
        // No empty room: a plot, a picture or a table.
        await settled(panel);
        const wide = await page.evaluate(() => {
          const page = document.documentElement;
          const beyond = [...document.querySelectorAll("body *")].filter((one) => one.checkVisibility() && one.getBoundingClientRect().right > page.clientWidth + 1);
          return { by: page.scrollWidth - page.clientWidth, first: beyond.slice(0, 4).map((one) => `${one.tagName} ${one.className} ${one.textContent.slice(0, 30)}`) };
        });
        assert.ok(wide.by <= 0, `${name}: ${wide.by} px wider than the page: ${wide.first.join("; ")}`);
        await shot(page, `${name.toLowerCase().replaceAll(" ", "-")}-${width}${dark ? "-dark" : ""}`, true);
      }
      await close();
    });

test("the header is one row at 1024 px, and the run's controls come first at every width", async () => {
  for (const width of [1440, 1024, 390]) {
    const { page, close } = await openDesk({ width });
    const panel = await view(page, "Servo scope");
    const height = await page.evaluate(() => document.querySelector("header").getBoundingClientRect().height);
    if (width >= 1024) assert.ok(height < 56, `${width} px: a header of ${height} px`);
    const run = await panel.getByRole("button", { name: "Run", exact: true }).boundingBox();
    assert.ok(run.y + run.height < 900, `${width} px: Run at ${run.y}`);
    assert.match(await panel.getByRole("button").first().textContent(), /^Run$/);
    await close();
  }
});

test("machine, changes, undo and save stay in sight", async () => {
  for (const width of [1440, 1024, 390]) {
    const { page, close } = await openDesk({ width });
    const machine = page.getByRole("group", { name: "Machine", exact: true });
    for (const name of ["Servo scope", "Machine"]) {
      await view(page, name);
      await page.evaluate(() => scrollTo(0, document.documentElement.scrollHeight));
      for (const part of [machine.getByText("Machine mill-3axis, as opened"), machine.getByRole("button", { name: "Undo" }), machine.getByRole("button", { name: "Save machine" })]) {
        const { x, y, width: wide, height } = await part.boundingBox();
        assert.ok(y >= 0 && y + height <= 120 && x >= 0 && x + wide <= width, `${width} px, ${name}: ${await part.textContent()} at ${x}, ${y}`);
        const hit = await part.evaluate((one, [x, y]) => one.contains(document.elementFromPoint(x, y)), [x + wide / 2, y + height / 2]);
        assert.ok(hit, `${width} px, ${name}: ${await part.textContent()} is covered`);
      }
    }
    await close();
  }
});

test("on a phone a finger hits every control, and a view is one column", async () => {
  const { page, close } = await openDesk({ width: 390 });
  for (const name of VIEWS) {
    const panel = await view(page, name);
    await settled(panel);
    const small = await page.evaluate((least) => {
      const targets = [...document.querySelectorAll("button, select, summary, .picker, .tick, input:not([type='file'], [type='checkbox'])")].filter((one) => one.checkVisibility());
      const sizes = targets.map((one) => [one, one.getBoundingClientRect()]);
      return sizes.filter(([, { width, height }]) => width < least - 0.5 || height < least - 0.5).map(([one, { width, height }]) => `${one.tagName} ${one.textContent.slice(0, 20)} ${width} × ${height}`);
    }, TARGET);
    assert.deepEqual(small, [], name);
    const plots = await panel.locator("figure > .plot:visible").evaluateAll((all) => all.map((one) => one.getBoundingClientRect().width));
    for (const width of plots) assert.ok(width > 280, `${name}: a plot of ${width} px`);
  }
  await close();
});

/** Pixels of a canvas within 12 of a colour, in each of its parts. */
function pixels(canvas, colour) {
  return canvas.evaluate((canvas, [red, green, blue]) => {
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    let count = 0;
    for (let i = 0; i < data.length; i += 4)
      if (data[i + 3] === 255 && Math.abs(data[i] - red) + Math.abs(data[i + 1] - green) + Math.abs(data[i + 2] - blue) < 12) count++;
    return count;
  }, colour);
}

/** The curve `after` of core/theme.ts on a light and a dark page. */
const [LIGHT, DARK] = [[0x00, 0x5a, 0x9c], [0x6d, 0xb3, 0xf2]];

test("a change of the theme redraws the plots of hidden views too", async () => {
  const { page, close } = await openDesk();
  const scope = await view(page, "Servo scope");
  await scope.getByText(/^Largest contour error while cutting so far/).waitFor();
  await scope.getByRole("button", { name: "Pause" }).click();
  const curve = scope.locator(".traces canvas").first();
  assert.ok((await pixels(curve, LIGHT)) > 20);
  await view(page, "Uncertainty");
  await page.getByLabel("Theme").selectOption("dark");
  await view(page, "Servo scope");
  await page.waitForTimeout(500);
  assert.ok((await pixels(curve, DARK)) > 20, "found no curve of the dark theme");
  assert.equal(await pixels(curve, LIGHT), 0, "found curves of the light theme on a dark page");
  await close();
});

test("rapids are shaded in the traces", async () => {
  const { page, close } = await openDesk();
  const scope = await view(page, "Servo scope");
  await scope.getByText("rapid traverse, not counted in the figures").waitFor();
  await scope.getByRole("button", { name: "Pause" }).click();
  // A grid of lines covers less than a hundredth of the plot.
  const canvas = scope.locator(".traces canvas").first();
  const size = await canvas.evaluate(({ width, height }) => width * height);
  assert.ok((await pixels(canvas, [0xe4, 0xe7, 0xeb])) > 0.01 * size);
  await close();
});

const luminance = (colour) => {
  const [red, green, blue] = colour.map((part) => (part / 255 <= 0.04045 ? part / 255 / 12.92 : ((part / 255 + 0.055) / 1.055) ** 2.4));
  return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
};
const contrast = (one, other) => (Math.max(one, other) + 0.05) / (Math.min(one, other) + 0.05);

/**
 * Linear red, green and blue as seen without one kind of cone, as libDaltonLens computes them: after Viénot, Brettel and Mollon
 * (1999), and without the blue ones by one half-plane of Brettel, Viénot and Mollon (1997).
 */
const SEEN = {
  everyone: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  protanopes: [[0.11238, 0.88762, 0], [0.11238, 0.88762, 0], [0.00401, -0.00401, 1]],
  deuteranopes: [[0.29275, 0.70725, 0], [0.29275, 0.70725, 0], [-0.02234, 0.02234, 1]],
  tritanopes: [[1.01277, 0.13548, -0.14826], [-0.01243, 0.86812, 0.14431], [0.07589, 0.805, 0.11911]],
};
const linear = (part) => (part / 255 <= 0.04045 ? part / 255 / 12.92 : ((part / 255 + 0.055) / 1.055) ** 2.4);

test("every colour of the error scale stands out from the page, and a larger error more than a smaller one, for all eyes", async () => {
  for (const dark of [false, true]) {
    const { page, close } = await openDesk({ dark });
    const scope = await view(page, "Servo scope");
    const bar = scope.getByRole("img", { name: /^Colours from 0/ });
    const colours = await bar.evaluate((canvas) => {
      const { data } = canvas.getContext("2d").getImageData(0, 5, canvas.width, 1);
      return Array.from({ length: canvas.width }, (_, x) => [...data.slice(4 * x, 4 * x + 3)]);
    });
    const paper = luminance(dark ? [20, 23, 27] : [255, 255, 255]);
    for (const [eyes, matrix] of Object.entries(SEEN)) {
      const seen = colours.map((colour) => {
        const parts = matrix.map((row) => row.reduce((sum, factor, k) => sum + factor * linear(colour[k]), 0));
        return 0.2126 * parts[0] + 0.7152 * parts[1] + 0.0722 * parts[2];
      });
      const contrasts = seen.map((one) => contrast(one, paper));
      const least = Math.min(...contrasts);
      assert.ok(least >= (eyes === "everyone" ? 3 : 2.5), `${dark ? "dark" : "light"}, ${eyes}: a contrast of ${least.toFixed(2)}`);
      // In eighths of the scale.
      for (let k = 20; k < contrasts.length; k += 20) assert.ok(contrasts[k] > contrasts[k - 20], `${dark ? "dark" : "light"}, ${eyes}: at ${k}`);
    }
    await close();
  }
});
