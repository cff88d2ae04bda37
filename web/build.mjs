// Writes the page into a folder: `node build.mjs FOLDER`. The machine and its JavaScript are in `machine/` already,
// and a machine with A, for which the same JavaScript is right, in `machine4/`.
// What the page loads lies in a folder that is named by its content, so that no page ever loads what belongs to another build.
import { build } from "esbuild";
import { createHash } from "node:crypto";
import { copyFile, mkdir, readdir, readFile, rename, rm, writeFile } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { brotliCompressSync, gzipSync } from "node:zlib";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2];
if (!out) throw new Error("say into which folder");

const BESIDE = ["manifest.webmanifest", "icon.svg", "icon-192.png", "icon-512.png"];
const options = { bundle: true, minify: true, target: "es2022", legalComments: "eof", logLevel: "warning" };

/** The files in a folder, by their names from there. */
async function files(folder) {
  const entries = await readdir(folder, { recursive: true, withFileTypes: true });
  return entries.filter((entry) => entry.isFile()).map((entry) => join(entry.parentPath, entry.name).slice(folder.length + 1).replaceAll("\\", "/")).sort();
}

await rm(out, { recursive: true, force: true });
const loaded = join(out, "build");
await mkdir(join(loaded, "programs"), { recursive: true });
const { metafile } = await build({ ...options, metafile: true, entryPoints: ["main.ts", "worker.ts"].map((file) => join(here, "src", file)), outdir: loaded, splitting: true, format: "esm" });
await copyFile(join(here, "src/style.css"), join(loaded, "style.css"));
for (const machine of ["machine", "machine4"]) await copyFile(join(here, machine, "machine_bg.wasm"), join(loaded, `${machine}_bg.wasm`));
const programs = join(here, "../programs");
for (const file of (await readdir(programs)).filter((name) => name.endsWith(".nc"))) await copyFile(join(programs, file), join(loaded, "programs", file));
for (const file of [...BESIDE, "board.json"]) await copyFile(join(here, "src", file), join(out, file));

const index = await readFile(join(here, "src/index.html"), "utf8");
const hash = createHash("sha256").update(index);
for (const file of await files(out)) hash.update(`\n${file}\n`).update(await readFile(join(out, file)));
const name = hash.digest("hex").slice(0, 16);
await rename(loaded, join(out, name));
await writeFile(join(out, "index.html"), index.replaceAll('"build/', `"${name}/`));
// What only some programs want is kept when it is wanted.
const later = ["machine4_bg.wasm"];
const FILES = ["./", ...BESIDE, ...(await files(join(out, name))).filter((file) => !later.includes(file)).map((file) => `${name}/${file}`)];
const define = { BUILD: JSON.stringify(name), FILES: JSON.stringify(FILES) };
await build({ ...options, entryPoints: [join(here, "src/service/service.ts")], outdir: out, format: "iife", define });

// What the licences of packages ask for: their texts go with the code.
const inputs = Object.keys(metafile.inputs).map((file) => /.*node_modules\/((?:@[^/]+\/)?[^/]+)\//.exec(file)?.[1]);
const texts = [...new Set(inputs.filter(Boolean))].sort().map(async (name) => {
  const folder = join(here, "node_modules", name);
  const { version, license } = JSON.parse(await readFile(join(folder, "package.json"), "utf8"));
  const words = (await readdir(folder)).filter((file) => /^(licen[sc]e|copying|notice)/i.test(file)).map((file) => readFile(join(folder, file), "utf8"));
  if (!words.length) throw new Error(`${name} has no text of its licence`);
  return `${"-".repeat(80)}\n${name} ${version}: ${license}\n\n${(await Promise.all(words)).join("\n").trim()}\n`;
});
await writeFile(join(out, "LICENCES.txt"), `The page contains these packages of npm:\n\n${(await Promise.all(texts)).join("\n")}`);

// For servers that send what is compressed already, as ours does.
for (const file of (await files(out)).filter((name) => /\.(html|css|js|wasm)$/.test(name))) {
  const content = await readFile(join(out, file));
  await writeFile(join(out, `${file}.gz`), gzipSync(content, { level: 9 }));
  await writeFile(join(out, `${file}.br`), brotliCompressSync(content));
}
