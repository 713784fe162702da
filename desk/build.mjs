// Joins page, styles, scripts and module to one file: dist/desk.html.

import { build } from "esbuild";
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import fs from "node:fs";
import { gzipSync } from "node:zlib";

const common = { bundle: true, minify: true, target: "es2022", write: false, legalComments: "none", loader: { ".txt": "text", ".csv": "text", ".log": "text", ".toml": "text", ".ngc": "text" }, define: { "import.meta.url": '"about:blank"' } };
const page = await build({ ...common, entryPoints: ["src/main.ts"], format: "esm", outdir: "dist" });
const worker = await build({ ...common, entryPoints: ["src/worker.ts"], format: "iife" });

const output = (ending) => page.outputFiles.find((file) => file.path.endsWith(ending)).text;
const script = (text) => text.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
// The module contains the step for three to six axes: near-copies, further apart than gzip's window. xz output is a third smaller.
const packed = execFileSync("xz", ["--format=xz", "--check=crc32", "--lzma2=preset=9e,dict=8MiB,lc=4,pb=0", "--stdout", "pkg/trueaxis_desk_bg.wasm"], { maxBuffer: 1 << 26 });
const module = packed.toString("base64");
const own = script(output(".js"));
// Hash of the only script that the page's policy permits.
const hash = `'sha256-${createHash("sha256").update(own).digest("base64")}'`;
const parts = { CSS: output(".css"), WASM: module, WORKER: script(worker.outputFiles[0].text), JS: own };
let html = fs.readFileSync("src/page.html", "utf8").replace("'own-script'", hash);
for (const [name, text] of Object.entries(parts)) html = html.replace(`/*${name}*/`, () => text);
fs.mkdirSync("dist", { recursive: true });
fs.writeFileSync("dist/desk.html", html);

const kB = (bytes) => `${Math.round(bytes / 1000)} kB`;
console.log(`dist/desk.html: ${kB(html.length)}, gzipped ${kB(gzipSync(html, { level: 9 }).length)}`);
