// The helicoid's view against `trueaxis helicoid`.

import assert from "node:assert/strict";
import fs from "node:fs";
import os from "node:os";
import path from "node:path";
import { after, test } from "node:test";
import { cli, closeBrowser, numbers, openDesk, run, saved, shot, view } from "./harness.mjs";

after(closeBrowser);

const NAME = "Helicoid and five axes";

async function open(options) {
  const desk = await openDesk(options);
  const panel = await view(desk.page, NAME);
  await panel.getByRole("table", { name: "Displacements of the five axes" }).waitFor();
  return { ...desk, panel };
}

/** Types into fields, and selects options, by their labels. */
async function type(panel, values) {
  for (const [label, value] of Object.entries(values)) {
    const field = panel.getByLabel(label, { exact: true });
    if (typeof value === "number") {
      await field.fill(String(value));
      await field.press("Tab");
    } else await field.selectOption(value);
  }
}

// Options of the view's initial inputs.
const START = "helicoid --module-mm 3 --teeth 24 --pressure-angle-deg 20 --helix-angle-deg 15 --u-rad 0.1:0.6:6 --theta-rad 0:0.2:9 --form vertical --pivot-mm 150";

const table = (panel, name) => panel.getByRole("table", { name, exact: true });

/** The table's numbers, once they belong to the latest input. */
async function settled(panel, name, row, wanted) {
  const found = table(panel, name);
  await found.locator("tr", { hasText: row }).locator(`[data-value="${wanted}"]`).first().waitFor();
  return numbers(found);
}

// Two inputs, as fields of the view and as options of the command line.
const CASES = [
  {
    name: "a gear, horizontal, edge finder, branch 2, turned senses",
    fields: {
      "Normal module / mm": 4.25, "Teeth": 31, "Normal pressure angle / degrees": 22.5, "Helix angle / degrees": 27.5,
      "Spindle at A = 0": "horizontal", "Pivot length from": "finder", "Edge finder, travel / mm": 171.125, "Edge finder, ball radius / mm": 3.0,
      "Direction of A": "-1", "Direction of C": "-1", "Branch": "2", "Work offset X / mm": 1.5, "Work offset Y / mm": -2.25, "Work offset Z / mm": 40,
      "u from / rad": 0.15, "u to / rad": 0.55, "u values": 5, "θ from / rad": -0.3, "θ to / rad": 0.2, "θ values": 7,
      "Passes along": "u", "Feed / mm/min": 640, "Clearance / mm": 35,
    },
    line: "--module-mm 4.25 --teeth 31 --pressure-angle-deg 22.5 --helix-angle-deg 27.5 --u-rad 0.15:0.55:5 --theta-rad -0.3:0.2:7 --form horizontal " +
      "--edge-finder-mm 171.125 --edge-finder-radius-mm 3 --branch 2 --work-offset-mm 1.5,-2.25,40 --direction-a -1 --direction-c -1 " +
      "--feed-mm-per-min 640 --clearance-mm 35 --passes u",
    at: [0.15, -0.3],
  },
  {
    name: "a base circle with a left-hand lead",
    fields: {
      "Given by": "base", "Base radius / mm": 41.5, "Lead parameter / mm/rad": -77.25, "Side, from +z, tip up": "left", "Pivot length / mm": 212.5,
      "u from / rad": -0.7, "u to / rad": -0.2, "u values": 4, "θ from / rad": 0.1, "θ to / rad": 0.9, "θ values": 5,
    },
    line: "--base-radius-mm 41.5 --lead-parameter-mm-per-rad -77.25 --u-rad -0.7:-0.2:4 --theta-rad 0.1:0.9:5 --form vertical --pivot-mm 212.5 --flank left",
    at: [-0.7, 0.1],
  },
];

for (const { name, fields, line, at } of CASES)
  test(`${name}: figures, table and program are the command line's`, async () => {
    const { page, panel, close } = await open();
    await type(panel, fields);
    const given = ["helicoid", ...line.split(" ")];
    const document = await cli([...given, "--json"]);

    // The number of points comes from the last field typed.
    await settled(panel, "Flank", "points of the grid", document.points.length);
    const data = await settled(panel, "Flank", "lead parameter", document.surface.lead_parameter_mm_per_rad);
    assert.equal(data["base radius"].value, document.surface.base_radius_mm);
    assert.equal(data.lead.value, document.surface.lead_mm);
    assert.equal(data["tilt γ of the normal"].value, document.surface.tilt_deg);
    assert.equal(data["points of the grid"].value, document.points.length);
    if (document.gear) {
      assert.equal(data["transverse module"].value, document.gear.transverse_module_mm);
      assert.equal(data["base helix angle"].value, document.gear.base_helix_angle_deg);
    }

    // The tool at the first point of the grid, on both branches; then at the last point.
    const [last, first] = [document.points.at(-1), document.points[0]];
    const other = document.inputs.branch === 1 ? 2 : 1;
    const opposite = await cli([...given.filter((word, i) => word !== "--branch" && given[i - 1] !== "--branch"), "--branch", String(other), "--json"]);
    for (const [point, there, [u, theta]] of [[first, opposite.points[0], at], [last, opposite.points.at(-1), [last.u_rad, last.theta_rad]]]) {
      await type(panel, { "Tool at u / rad": u, "Tool at θ / rad": theta });
      const branch = `Branch ${document.inputs.branch}`;
      // Only C shows that the page read both fields: Y and A do not depend on θ.
      await table(panel, "Displacements of the five axes").locator(`[data-value="${point.c_deg}"]`).first().waitFor();
      const rows = await numbers(table(panel, "Displacements of the five axes"));
      for (const [axis, key] of [["X / mm", "x_mm"], ["Y / mm", "y_mm"], ["Z / mm", "z_mm"], ["A / degrees", "a_deg"], ["C / degrees", "c_deg"]]) {
        assert.equal(rows[axis][branch], point[key], `${axis} on the branch asked for`);
        assert.equal(rows[axis][`Branch ${other}`], there[key], `${axis} on the other branch`);
      }
      assert.ok(rows["Tip off the flank / µm"][branch] < 1e-8 && rows["Tool off the normal / µrad"][branch] < 1e-6);
    }

    // Travel over the grid.
    for (const [branch, points] of [[document.inputs.branch, document.points], [other, opposite.points]]) {
      const travel = await numbers(table(panel, `Travel over the grid, branch ${branch}`));
      for (const [axis, key] of [["X / mm", "x_mm"], ["Z / mm", "z_mm"], ["C / degrees", "c_deg"]]) {
        assert.equal(travel[axis].From, Math.min(...points.map((point) => point[key])));
        assert.equal(travel[axis].To, Math.max(...points.map((point) => point[key])));
      }
    }

    // The saved files, and the command line that the page shows.
    const folder = fs.mkdtempSync(path.join(os.tmpdir(), "helicoid-"));
    const shown = await panel.locator(".command code").textContent();
    const words = shown.split(" ").slice(1);
    const done = await run("trueaxis", [...words], { cwd: folder });
    assert.equal(done.code, 0, done.stderr);
    const file = async (button, name) => {
      const { bytes } = await saved(page, panel.getByRole("button", { name: button }).last());
      assert.equal(bytes.toString(), fs.readFileSync(path.join(folder, name), "utf8"), button);
    };
    await file("Save G-code", "helicoid.ngc");
    await file("Save CSV", "helicoid.csv");
    const kept = await saved(page, panel.getByRole("button", { name: "Save JSON" }));
    assert.deepEqual(JSON.parse(kept.bytes), document);
    const same = await run("trueaxis", [...given, "--gcode", "again.ngc", "-o", "again.csv"], { cwd: folder });
    assert.equal(same.code, 0, same.stderr);
    assert.equal(fs.readFileSync(path.join(folder, "again.ngc"), "utf8"), fs.readFileSync(path.join(folder, "helicoid.ngc"), "utf8"));
    fs.rmSync(folder, { recursive: true });
    await close();
  });

test("a refusal is reported in the command line's words, and the earlier result is marked", async () => {
  const { panel, close } = await open();
  for (const [fields, line] of [
    [{ "Helix angle / degrees": 0 }, "--module-mm 3 --teeth 24 --pressure-angle-deg 20 --helix-angle-deg 0 --u-rad 0.1:0.6:6 --theta-rad 0:0.2:9 --pivot-mm 150"],
    [{ "Helix angle / degrees": -15 }, "--module-mm 3 --teeth 24 --pressure-angle-deg 20 --helix-angle-deg -15 --u-rad 0.1:0.6:6 --theta-rad 0:0.2:9 --pivot-mm 150"],
    [{ "Helix angle / degrees": 15, "u from / rad": -0.5 }, "--module-mm 3 --teeth 24 --pressure-angle-deg 20 --helix-angle-deg 15 --u-rad -0.5:0.6:6 --theta-rad 0:0.2:9 --pivot-mm 150"],
    [{ "u from / rad": 0.1, "u values": 2000, "θ values": 2000 }, "--module-mm 3 --teeth 24 --pressure-angle-deg 20 --helix-angle-deg 15 --u-rad 0.1:0.6:2000 --theta-rad 0:0.2:2000 --pivot-mm 150"],
    [{ "u values": 6, "θ values": 9, "Feed / mm/min": -5 }, "--module-mm 3 --teeth 24 --pressure-angle-deg 20 --helix-angle-deg 15 --u-rad 0.1:0.6:6 --theta-rad 0:0.2:9 --pivot-mm 150 --feed-mm-per-min -5"],
  ]) {
    await type(panel, fields);
    const { code, stderr } = await run("trueaxis", ["helicoid", ...line.split(" ")]);
    assert.equal(code, 2);
    const said = stderr.trim().replace(/^error: /, "");
    await panel.getByRole("alert").filter({ hasText: said }).waitFor();
    assert.equal(await panel.getByRole("alert").first().textContent(), said);
    assert.equal(await panel.locator(".stale").count(), 1);
  }
  await type(panel, { "Feed / mm/min": 500 });
  await panel.locator(".stale").waitFor({ state: "detached" });
  assert.equal(await panel.getByRole("alert").first().textContent(), "");
  await close();
});

test("a machine that does not fit is reported, one that fits is used, and errors before and after are shown", async () => {
  const { page, panel, close } = await open();
  const fits = panel.getByRole("status").filter({ hasText: "The machine of the desk" });
  assert.match(await fits.textContent(), /mill-3axis, does not fit: found the axes X, Y, Z, needed X, Y, Z, A and C/);
  await panel.getByRole("button", { name: "Take a machine that fits" }).click();
  await panel.getByText("The machine of the desk, mill-turn, fits").waitFor();
  const errors = table(panel, "Largest errors along the line");
  await errors.waitFor();
  const before = await numbers(errors);
  assert.ok(before["Tip / µm"].Before > 10 && before["Tip / µm"].After < 0.1, JSON.stringify(before));
  assert.ok(Math.abs(before["Along the normal / µm"].Before) <= before["Tip / µm"].Before);

  // Shifted beyond the travel of X: reported for the point, for the grid, and on the line.
  await type(panel, { "Work offset X / mm": 500 });
  await panel.getByText("branch 1 and branch 2 beyond it").first().waitFor();
  const { points } = await cli(`${START} --work-offset-mm 500,0,0 --json`.split(" "));
  const travel = await numbers(table(panel, "Travel over the grid, branch 1"));
  for (const [axis, key] of [["X / mm", "x_mm"], ["Y / mm", "y_mm"]]) {
    const beyond = points.filter((point) => Math.abs(point[key]) > 400).length;
    assert.ok(beyond > 0 && beyond < points.length, axis);
    assert.equal(travel[axis][""], beyond, axis);
  }
  await panel.getByText("Beyond the declared travel on the way").waitFor();

  // Another pivot length no longer fits; the same poses on the machine's own positions still have errors.
  await type(panel, { "Work offset X / mm": 0, "Pivot length / mm": 180 });
  await panel.getByText("pivot length: found 150 mm, needed 180 mm").first().waitFor();
  await panel.getByText("at different positions for the same poses").waitFor();
  await panel.getByRole("button", { name: "Take a machine that fits" }).click();
  await panel.getByText("mill-turn, fits").waitFor();

  await panel.getByRole("button", { name: "Run in the scope" }).click();
  await page.getByRole("tab", { name: "Servo scope", selected: true }).waitFor();
  await close();
});

test("typed limits, a grid of one value, and a tool near the singular pose", async () => {
  const { panel, close } = await open();
  await type(panel, { "Travel limits": "typed" });
  await type(panel, { "C from / degrees": -20, "C to / degrees": 20 });
  await panel.getByText("branch 2 beyond it").first().waitFor();
  await type(panel, { "C to / degrees": -30 });
  await panel.getByRole("alert").filter({ hasText: "travel of C: found -20 to -30, needed the low end first" }).waitFor();
  await type(panel, { "C to / degrees": 20, "Given by": "base", "Base radius / mm": 36, "Lead parameter / mm/rad": 1, "u values": 1 });
  const warning = panel.getByRole("status").filter({ hasText: "Nearer than 5°" });
  await warning.waitFor();
  // γ = atan(1/36) = 1.5911°, 1/sin γ = √(1 + 36²).
  assert.match(await warning.textContent(), /1\.5911° away; turning the tool by 1 µrad turns C by up to 36\.0 µrad/);
  await close();
});

test("everything goes by the keyboard, and a link keeps it", async () => {
  const { page, panel, close } = await open();
  const slider = panel.getByLabel("Tool at θ, slider");
  const rows = () => numbers(table(panel, "Displacements of the five axes"));
  const before = (await rows())["Z / mm"]["Branch 1"];
  await slider.focus();
  await page.keyboard.press("End");
  await page.waitForFunction((z) => !document.querySelector(`[data-value="${z}"]`), before);
  assert.notEqual((await rows())["Z / mm"]["Branch 1"], before);
  // The cursor of a plot moves the tool: Home is θ = 0.
  const plot = panel.getByRole("img", { name: "Linear axes over θ" });
  await plot.focus();
  await page.keyboard.press("Home");
  const first = (await cli(`${START} --json`.split(" "))).points[0];
  await table(panel, "Displacements of the five axes").locator(`[data-value="${first.z_mm}"]`).first().waitFor();
  assert.equal(await panel.getByLabel("Tool at θ / rad", { exact: true }).inputValue(), "0");
  await panel.getByLabel("Teeth", { exact: true }).focus();
  await page.keyboard.press("ArrowUp");
  await page.keyboard.press("Tab");
  await settled(panel, "Flank", "reference radius", (await cli(`${START.replace("24", "25")} --json`.split(" "))).gear.reference_radius_mm);
  await page.getByRole("button", { name: "Link" }).click();
  await page.waitForFunction(() => location.hash.startsWith("#open="));
  const hash = new URL(page.url()).hash;
  await close();
  const second = await openDesk({ hash });
  const again = second.page.getByRole("tabpanel", { name: NAME });
  await again.getByRole("table", { name: "Displacements of the five axes" }).waitFor();
  assert.equal(await again.getByLabel("Teeth", { exact: true }).inputValue(), "25");
  await second.close();
});

test("pictures to look at", async () => {
  for (const dark of [false, true]) {
    const { page, panel, close } = await open({ dark });
    await panel.getByRole("button", { name: "Take a machine that fits" }).click();
    await table(panel, "Largest errors along the line").waitFor();
    await page.setViewportSize({ width: 1400, height: 1900 });
    await page.evaluate(() => scrollTo(0, 0));
    await page.waitForTimeout(500);
    await shot(page, dark ? "helicoid-dark" : "helicoid");
    await close();
  }
});
