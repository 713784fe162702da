// Tests links without the page.

import assert from "node:assert/strict";
import path from "node:path";
import { test } from "node:test";
import { deflateRawSync } from "node:zlib";
import { build } from "esbuild";
import { root } from "./harness.mjs";

globalThis.location = { href: "file:///desk.html" };
const built = await build({ entryPoints: [path.join(root, "desk/src/core/link.ts")], bundle: true, format: "esm", write: false });
const { fromLink, link, parse } = await import(`data:text/javascript;base64,${Buffer.from(built.outputFiles[0].contents).toString("base64")}`);

const kept = { version: 1, view: "scope", machine: { name: "m", files: { "machine.toml": "µ" } }, views: { scope: { a: [1, null] } } };
const fragment = (bytes) => `#open=${deflateRawSync(bytes).toString("base64url")}`;

test("a link keeps its content", async () => {
  const address = await link(kept);
  assert.deepEqual(await fromLink(new URL(address).hash), kept);
  assert.equal(await fromLink("#scope"), undefined);
});

test("a link is unpacked up to 16 MB and no further", async () => {
  const padded = (length) => JSON.stringify({ ...kept, padding: "x".repeat(length) });
  assert.deepEqual(await fromLink(fragment(padded(15 << 20))), kept);
  await assert.rejects(fromLink(fragment(padded(17 << 20))), /found more than 16 MB in it, needed at most that.*needed: a link that this page made/);
  // 250 kB that would inflate to 256 MB.
  const large = fragment(Buffer.alloc(256 << 20));
  const before = process.resourceUsage().maxRSS;
  await assert.rejects(fromLink(large), /found more than 16 MB/);
  const grown = (process.resourceUsage().maxRSS - before) / 1024;
  assert.ok(grown < 120, `${grown} MB more`);
  await assert.rejects(link({ ...kept, view: "x".repeat(17 << 20) }), /found 18 MB, needed at most 16 in a link/);
});

test("a refused state of a view names the value found and the value needed", () => {
  const of = (state) => () => parse(JSON.stringify({ ...kept, views: { x: state } }));
  assert.throws(of(null), /views\.x: found null, needed what this page saved of a view/);
  assert.throws(of(3), /views\.x: found a number, needed/);
  assert.throws(of([]), /views\.x: found a list, needed/);
  assert.throws(of("x"), /views\.x: found a string, needed/);
  assert.doesNotThrow(of({}));
  assert.throws(() => parse(JSON.stringify({ ...kept, views: [] })), /found a file without view, machine and views/);
});
