// Uncertainty of the corrected position against the command line.

import assert from "node:assert/strict";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, numbers, openDesk, root, run, shot, view } from "./harness.mjs";

after(closeBrowser);
const mill = path.join(root, "compensation-tables/mill-3axis");

function near(found, needed, what) {
  assert.ok(Math.abs(found - needed) <= 1e-6 * Math.max(1, Math.abs(needed)), `${what}: found ${found}, the command line has ${needed}`);
}

async function spread(panel, name, needed) {
  const shown = await numbers(panel.getByRole("table", { name }));
  for (const [method, key] of [["by derivatives", "jacobian"], ["by machines drawn", "monte_carlo"]]) {
    near(shown[method].radius, needed[key].radius_um, `${name}, ${method}`);
    ["X", "Y", "Z"].forEach((axis, i) => near(shown[method][axis], needed[key].expanded_um[i], `${name}, ${method}, ${axis}`));
  }
}

test("worst point, a position and contributions are those of trueaxis uncertainty", async () => {
  const { page, close } = await openDesk();
  const panel = await view(page, "Uncertainty");
  await panel.getByText(/^mill-3axis, .*standard uncertainty/).waitFor();
  const found = await cli(["uncertainty", mill, "--trials", "2000", "--json"]);
  await spread(panel, "Worst point", found.worst);
  const shares = await numbers(panel.getByRole("table", { name: "Contributions" }));
  for (const { term, share, rms_um, worst_um } of found.contributions) {
    near(shares[term]["share, %"], 100 * share, term);
    near(shares[term]["RMS over the volume, µm"], rms_um, term);
    near(shares[term]["at the worst point, µm"], worst_um, term);
  }
  await panel.getByLabel("Seed").fill("7");
  await panel.getByLabel("Coverage").fill("99");
  await panel.getByLabel("Also at").fill("120, -40, -200");
  await panel.getByRole("table", { name: "Requested position" }).waitFor();
  const asked = await cli(["uncertainty", mill, "--at=120,-40,-200", "--confidence", "99", "--trials", "2000", "--seed", "7", "--json"]);
  await panel.getByText("expanded, 99 %").first().waitFor();
  await spread(panel, "Requested position", asked.at);
  await spread(panel, "Worst point", asked.worst);
  assert.equal(await panel.locator("code").first().textContent(), "trueaxis uncertainty mill-3axis --at=120,-40,-200 --confidence 99 --points 9 --trials 2000 --seed 7");
  await page.evaluate(() => scrollTo(0, 0));
  await shot(page, "uncertainty");
  await panel.getByLabel("Also at").fill("120, -40");
  const refused = await run("trueaxis", ["uncertainty", mill, "--at=120,-40"]);
  const alert = page.getByRole("alert").filter({ hasText: "--at" });
  await alert.waitFor();
  assert.equal(await alert.locator("span").textContent(), refused.stderr.trim().replace(/^error: /, ""));
  await close();
});
