// Prints how large and how fast the page is: `node figures.mjs --page ADDRESS --folder FOLDER --shots FOLDER --program FILE... [--chromium PATH]`.
import { readdir, readFile } from "node:fs/promises";
import { basename, join } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { browser, hasEnded, opened, paths, put } from "./harness.mjs";

const LOADS = 5;
const row = (name, ...cells) => console.log(name.padEnd(22), ...cells.map((cell) => String(cell).padStart(12)));

async function sizes() {
  row("kB", "as it is", "gzip", "brotli");
  const total = [0, 0, 0];
  for (const entry of await readdir(paths.folder, { recursive: true, withFileTypes: true })) {
    if (!entry.isFile() || /\.(gz|br|nc)$/.test(entry.name)) continue;
    const file = await readFile(join(entry.parentPath, entry.name));
    const bytes = [file.length, gzipSync(file, { level: 9 }).length, brotliCompressSync(file).length];
    bytes.forEach((count, index) => (total[index] += count));
    row(entry.name, ...bytes.map((count) => (count / 1e3).toFixed(1)));
  }
  row("all", ...total.map((count) => (count / 1e3).toFixed(1)));
}

async function firstPaint() {
  const times = [];
  for (let load = 0; load < LOADS; load++) {
    const page = await opened();
    await hasEnded(page);
    times.push(await page.evaluate(() => performance.getEntriesByName("first-contentful-paint")[0].startTime));
    await page.context().close();
  }
  row("first paint, ms", times.sort((one, other) => one - other)[Math.floor(LOADS / 2)].toFixed(0));
}

async function program(file) {
  const page = await opened();
  page.setDefaultTimeout(600_000);
  await hasEnded(page);
  await put(page, "program", await readFile(file, "utf8"));
  await page.evaluate(() => {
    window.longest = 0;
    const watch = (list) => list.getEntries().forEach(({ duration }) => (window.longest = Math.max(window.longest, duration)));
    new PerformanceObserver(watch).observe({ type: "longtask" });
  });
  await page.click("#run");
  await page.locator("#results[data-state=running]").waitFor();
  await hasEnded(page);
  const run = async (text) => Number(new RegExp(text).exec(await page.locator("#status").textContent())?.[1]);
  const machine = await page.evaluate(() => Number(document.getElementById("time").max));
  const elapsed = await run("run in ([\\d.]+) s");
  await page.waitForFunction(() => document.getElementById("path").dataset.lines);
  await page.locator("#advice tr").first().waitFor();
  for (const tone of ["load", "speed"]) {
    await page.selectOption("#tone", tone);
    await page.waitForTimeout(500);
  }
  const [longest, lines] = [await page.evaluate(() => window.longest), await page.getAttribute("#path", "data-lines")];
  row(basename(file), machine.toFixed(1), elapsed.toFixed(2), (machine / elapsed).toFixed(0), longest.toFixed(0), lines);
  await page.context().close();
}

await sizes();
await firstPaint();
row("in Chromium", "machine, s", "run in, s", "times", "longest, ms", "lines drawn");
for (const file of paths.program) await program(file);
await browser.close();
