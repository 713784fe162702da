// Every view checked by axe-core: nothing serious or critical.

import assert from "node:assert/strict";
import fs from "node:fs";
import path from "node:path";
import { after, test } from "node:test";
import { closeBrowser, GROUPS, openDesk, root, settled, view } from "./harness.mjs";

after(closeBrowser);

const AXE = fs.readFileSync(path.join(root, "desk/node_modules/axe-core/axe.min.js"), "utf8");
/** The rules of WCAG 2.2, levels A and AA. */
const RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"];

async function serious(page) {
  const { violations } = await page.evaluate((values) => globalThis.axe.run(document, { resultTypes: ["violations"], runOnly: { type: "tag", values } }), RULES);
  return violations
    .filter(({ impact }) => impact === "serious" || impact === "critical")
    .flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary }) => `${id}: ${target.join(" ")}: ${failureSummary.replaceAll(/\s+/g, " ")}`));
}

/** A gate takes each width and each theme once; TRUEAXIS_TEST_SHARE=1 takes both themes at both widths. */
const both = process.env.TRUEAXIS_TEST_SHARE === "1";

for (const width of [1440, 390])
  for (const dark of both ? [false, true] : [width === 390])
    test(`nothing serious on any view in ${width} px, ${dark ? "dark" : "light"}`, async () => {
      const { page, close } = await openDesk({ width, dark });
      await page.evaluate(AXE);
      const found = [];
      for (const name of [...Object.values(GROUPS).flat(), "About"]) {
        const panel = await view(page, name);
        if (name !== "About") await settled(panel);
        found.push(...(await serious(page)).map((one) => `${name}: ${one}`));
      }
      assert.deepEqual(found, []);
      await close();
    });

test("it finds what is wrong", async () => {
  const { page, close } = await openDesk();
  await page.evaluate(AXE);
  await page.evaluate(() => {
    document.getElementById("status").innerHTML = '<span style="color: #999; background: #fff">too pale to read</span><button></button>';
  });
  const found = (await serious(page)).map((one) => one.split(":")[0]);
  assert.ok(found.includes("color-contrast") && found.includes("button-name"), found.join());
  await close();
});
