// Writes the page into a folder: `node build.mjs FOLDER`. The module and its JavaScript are in `machine/` already.
import { build } from "esbuild";
import { copyFile, mkdir, readdir, readFile, rm, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, gzipSync } from "node:zlib";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
if (!out) throw new Error("say into which folder");

await rm(out, { recursive: true, force: true });
await mkdir(join(out, "programs"), { recursive: true });
await build({
  entryPoints: [join(here, "src/main.ts"), join(here, "src/worker.ts")],
  outdir: out,
  bundle: true,
  splitting: true,
  minify: true,
  format: "esm",
  target: "es2022",
  legalComments: "eof",
  logLevel: "warning",
});
for (const file of ["index.html", "style.css", "icon.svg", "board.json"]) await copyFile(join(here, "src", file), join(out, file));
await copyFile(join(here, "machine/machine_bg.wasm"), join(out, "machine_bg.wasm"));
const programs = join(here, "../programs");
for (const file of (await readdir(programs)).filter((name) => name.endsWith(".nc"))) {
  await copyFile(join(programs, file), join(out, "programs", file));
}

// For servers that send what is compressed already, as ours does.
for (const file of (await readdir(out)).filter((name) => /\.(html|css|js|wasm)$/.test(name))) {
  const content = await readFile(join(out, file));
  await writeFile(join(out, `${file}.gz`), gzipSync(content, { level: 9 }));
  await writeFile(join(out, `${file}.br`), brotliCompressSync(content));
}
