// Prints how large and how fast the page is: `node figures.mjs --page ADDRESS --folder FOLDER --shots FOLDER --program FILE... [--chromium PATH]`.
import { readdir, readFile } from "node:fs/promises";
import { basename, join } from "node:path";
import { brotliCompressSync, gzipSync } from "node:zlib";
import { browser, cancelledAfterMs, hasEnded, opened, paths, put } from "./harness.mjs";

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

/** What somebody does with a run on the page, and how long to wait until all is drawn. */
const ACTS = {
  put: (page, text) => put(page, "program", text),
  run: async (page) => {
    await page.click("#run");
    await page.locator("#results[data-state=running]").waitFor();
    await hasEnded(page);
    await page.locator("#advice tr").first().waitFor();
  },
  colours: (page) => each(["lost", "load", "power", "speed"], (tone) => page.selectOption("#tone", tone)),
  planes: (page) => each(["XZ", "YZ", "XY"], (plane) => page.selectOption("#plane", plane)),
  curves: (page) => each(["zoom-in", "zoom-in", "later", "zoom-out", "zoom-all"], (button) => page.click(`#${button}`)),
  play: (page) => play(page),
  "3D": async (page) => {
    await page.selectOption("#plane", "3D");
    await page.locator("#space").waitFor();
  },
  "play 3D": (page) => play(page),
};
const DRAWN_MS = 1_000;

async function each(names, act) {
  for (const name of names) {
    await act(name);
    await new Promise((resolve) => setTimeout(resolve, DRAWN_MS));
  }
}

async function play(page) {
  await page.locator("#time").fill("100");
  await page.selectOption("#rate", "100");
  await page.click("#play");
  await page.waitForTimeout(DRAWN_MS);
  await page.click("#play");
}

/** The longest task of the page's own thread while something is done, ms: of a processor, and by the clock. */
async function longest(page, act) {
  await browser.startTracing(page, { categories: ["toplevel"] });
  await act();
  await page.waitForTimeout(DRAWN_MS);
  const { traceEvents } = JSON.parse((await browser.stopTracing()).toString());
  const thread = ({ pid, tid }) => `${pid} ${tid}`;
  const mains = new Set(traceEvents.filter(({ name, args }) => name === "thread_name" && args.name === "CrRendererMain").map(thread));
  const tasks = traceEvents.filter((event) => event.name.endsWith("RunTask") && mains.has(thread(event)));
  return ["tdur", "dur"].map((span) => Math.max(...tasks.map((task) => task[span] ?? 0)) / 1e3);
}

/** What the process of the page holds of its own, with its workers and their WebAssembly, MB. Only Linux tells. */
async function memory(ofBrowser) {
  const { processInfo } = await ofBrowser.send("SystemInfo.getProcessInfo");
  const renderers = processInfo.filter(({ type }) => type === "renderer");
  const texts = await Promise.all(renderers.map(({ id }) => readFile(`/proc/${id}/status`, "utf8").catch(() => "")));
  return Math.max(...texts.map((text) => Number(/RssAnon:\s+(\d+)/.exec(text)?.[1]) / 1e3));
}

/** Does something, and returns the most memory of the page meanwhile, MB. */
async function most(ofBrowser, act) {
  let [found, isDone] = [0, false];
  const looking = (async () => {
    for (; !isDone; await new Promise((resolve) => setTimeout(resolve, 100))) found = Math.max(found, await memory(ofBrowser));
  })();
  await act();
  isDone = true;
  await looking;
  return found;
}

/** The longest task of each act, on a page of its own, because what watches over them takes memory. */
async function blocksOf(text) {
  const page = await opened();
  page.setDefaultTimeout(600_000);
  await hasEnded(page);
  const blocks = [];
  for (const [name, act] of Object.entries(ACTS)) blocks.push([name, await longest(page, () => act(page, text))]);
  await page.context().close();
  return blocks;
}

async function program(file) {
  const text = await readFile(file, "utf8");
  const page = await opened();
  page.setDefaultTimeout(600_000);
  await hasEnded(page);
  const ofBrowser = await browser.newBrowserCDPSession();
  const before = await memory(ofBrowser);
  await ACTS.put(page, text);
  const put = await memory(ofBrowser);
  const peak = await most(ofBrowser, () => ACTS.run(page));
  const [, seconds] = /run in ([\d.]+) s/.exec(await page.locator("#status").textContent()) ?? [];
  const machine = await page.evaluate(() => Number(document.getElementById("time").max));
  const lines = await page.getAttribute("#path", "data-lines");
  await page.click("#run");
  await page.waitForFunction(() => document.getElementById("progress").value > 0.02);
  const cancelled = await cancelledAfterMs(page);
  row(basename(file), machine.toFixed(1), seconds, (machine / seconds).toFixed(0), lines, before.toFixed(0), put.toFixed(0), peak.toFixed(0), cancelled.toFixed(0));
  await page.context().close();
  for (const [name, spans] of await blocksOf(text)) row(`  ${name}`, ...spans.map((ms) => ms.toFixed(0)));
}

await sizes();
await firstPaint();
row("in Chromium", "machine, s", "run in, s", "times", "lines drawn", "before, MB", "pasted, MB", "memory, MB", "cancelled, ms");
row("  longest block while", "of a core, ms", "passed, ms");
for (const file of paths.program) await program(file);
await browser.close();
