// What the tests of the page share: a browser, pages in it, and what a person does there.
import assert from "node:assert/strict";
import { mkdir } from "node:fs/promises";
import { parseArgs } from "node:util";
import { chromium } from "playwright-core";

const options = Object.fromEntries(["page", "folder", "board", "server", "emulator", "trace", "listed", "shots", "chromium", "only"].map((name) => [name, { type: "string" }]));
export const { values: paths } = parseArgs({ options: { ...options, program: { type: "string", multiple: true } } });
const PATIENCE_MS = 30_000;
/** The emulated board homes in seconds of its own, which are longer ones on a computer that has other work. */
const BOARD_PATIENCE_MS = 180_000;

/** What the page operates: each has its address, and the simulated one can be hurried. */
export const machines = [
  { name: "simulated machine", address: `${paths.page}#operate`, isSimulated: true },
  ...(paths.board ? [{ name: "emulated board", address: paths.board, isSimulated: false }] : []),
];
export const WIDE = { width: 1440, height: 1000 };
export const PHONE = { width: 390, height: 844 };

export const browser = await chromium.launch({ executablePath: paths.chromium ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
await mkdir(paths.shots, { recursive: true });
export const complaints = [];

/** A page of its own, of which nothing may be complained. `address` may be behind the page's. */
export async function opened(address = "", { viewport = WIDE, colorScheme = "light", before = undefined, ...touch } = {}) {
  const context = await browser.newContext({ viewport, colorScheme, acceptDownloads: true, ...touch });
  context.setDefaultTimeout(address === paths.board ? BOARD_PATIENCE_MS : PATIENCE_MS);
  const page = await context.newPage();
  page.on("console", (message) => {
    // A picture of a canvas in space is slow, which its driver tells.
    const isOfPictures = message.text().includes("GPU stall due to ReadPixels");
    if (["error", "warning"].includes(message.type()) && !isOfPictures) complaints.push(message.text());
  });
  page.on("pageerror", (error) => complaints.push(String(error)));
  const whole = new URL(address, paths.page);
  page.on("request", (request) => {
    if (!request.url().startsWith(whole.origin) && !request.url().startsWith("blob:")) complaints.push(`loaded from elsewhere: ${request.url()}`);
  });
  if (before) await page.addInitScript(before);
  await page.goto(String(whole));
  return page;
}

/** A chain of short moves that does not stop. */
export function longProgram(moves) {
  const lines = Array.from({ length: moves }, (_, line) => `G1 ${["X", "Y"][line % 2]}${line % 4 < 2 ? "" : "-"}0.2`);
  return `G21 G91 F2400\n${lines.join("\n")}\n`;
}

/** Cancels a run, and returns how long after the click the page has shown so, by its own clock, ms. */
export async function cancelledAfterMs(page) {
  await page.evaluate(() => {
    window.cancelled = new Promise((resolve) => {
      const shown = ({ timeStamp }) => requestAnimationFrame(() => setTimeout(() => resolve(performance.now() - timeStamp)));
      document.getElementById("cancel").addEventListener("click", shown, { once: true });
    });
  });
  await page.click("#cancel");
  const ms = await page.evaluate(() => window.cancelled);
  assert.equal(await page.locator("#status").textContent(), "Cancelled.");
  return ms;
}

export const hasEnded = (page) => page.locator("#results[data-state=ended]").waitFor();

/** A page with programs/parking.nc run. */
export async function parked() {
  const page = await opened();
  await hasEnded(page);
  await page.selectOption("#programs", "parking.nc");
  await page.locator("#results:not([data-state=ended])").waitFor({ state: "attached" });
  await hasEnded(page);
  return page;
}

/** Puts a text where a person would paste it. */
export async function put(page, id, text) {
  // The page may be on another tab.
  await page.evaluate(([id, text]) => {
    const place = document.getElementById(id);
    if (place instanceof HTMLTextAreaElement) return Object.assign(place, { value: text }).dispatchEvent(new Event("input"));
    const editor = place.shadowRoot.querySelector(".cm-content");
    const clipboardData = new DataTransfer();
    clipboardData.setData("text/plain", text);
    const all = { key: "a", code: "KeyA", keyCode: 65, ctrlKey: true, bubbles: true };
    editor.dispatchEvent(new KeyboardEvent("keydown", all));
    editor.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
  }, [id, text]);
}

/** Runs a program on a page, and waits for its end, whatever it is. */
export async function run(page, program, settings = "") {
  await page.locator("#run:enabled").waitFor();
  await put(page, "program", program);
  await put(page, "settings", settings);
  await page.click("#run");
  await page.locator("#run:enabled").waitFor();
}
