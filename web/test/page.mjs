// The page in Chromium: `node page.mjs --page FOLDER --trace FILE --shots FOLDER [--chromium PATH]`.
// FILE is the trace of programs/parking.nc by the native simulator.
import assert from "node:assert/strict";
import { mkdir, readFile } from "node:fs/promises";
import { join } from "node:path";
import { parseArgs } from "node:util";
import { chromium } from "playwright-core";
import { serve } from "../serve.mjs";

const options = Object.fromEntries(["page", "trace", "shots", "chromium"].map((name) => [name, { type: "string" }]));
const { values: paths } = parseArgs({ options });
const PATIENCE_MS = 30_000;
const WIDE = { width: 1440, height: 1000 };
const PHONE = { width: 390, height: 844 };

const server = await serve(paths.page);
const browser = await chromium.launch({ executablePath: paths.chromium ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
await mkdir(paths.shots, { recursive: true });
const complaints = [];

/** A page of its own, of which nothing may be complained. */
async function opened(address = "", { viewport = WIDE, colorScheme = "light" } = {}) {
  const context = await browser.newContext({ viewport, colorScheme, acceptDownloads: true });
  context.setDefaultTimeout(PATIENCE_MS);
  const page = await context.newPage();
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && complaints.push(message.text()));
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("request", (request) => {
    if (!request.url().startsWith(server.address) && !request.url().startsWith("blob:")) complaints.push(`loaded from elsewhere: ${request.url()}`);
  });
  await page.goto(server.address + address);
  return page;
}

/** A chain of short moves that does not stop. */
function longProgram(moves) {
  const lines = Array.from({ length: moves }, (_, line) => `G1 ${["X", "Y"][line % 2]}${line % 4 < 2 ? "" : "-"}0.2`);
  return `G21 G91 F2400\n${lines.join("\n")}\n`;
}

const hasEnded = (page) => page.locator("#results[data-state=ended]").waitFor();

/** Puts a text where a person would paste it. */
const put = (page, id, text) => page.evaluate(([id, text]) => {
  const place = document.getElementById(id);
  place.value = text;
  place.dispatchEvent(new Event("input"));
}, [id, text]);

/** Runs a program on a page, and waits for its end, whatever it is. */
async function run(page, program, settings = "") {
  await page.locator("#run:enabled").waitFor();
  await put(page, "program", program);
  await put(page, "settings", settings);
  await page.click("#run");
  await page.locator("#run:enabled").waitFor();
}

const tests = {
  async "our program keeps every promise, and its trace is the native one"() {
    const page = await opened();
    await hasEnded(page);
    const verdicts = await page.locator("#checks tr").evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
    assert.equal(verdicts.length, 9);
    for (const [kept, promise, found] of verdicts) assert.equal(kept, "kept", `${promise}: ${found}`);
    const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save-trace")]);
    const [ours, native] = await Promise.all([readFile(await download.path()), readFile(paths.trace)]);
    assert.ok(ours.equals(native), `${ours.length} bytes, natively ${native.length}`);
    assert.equal(download.suggestedFilename(), "parking.csv");
  },

  async "what a program has wrong is told at its line"() {
    const page = await opened();
    await hasEnded(page);
    await run(page, "G21\nG90\nG42 X1\nG0 X5\n");
    const told = page.locator("#troubles li").first();
    assert.match(await told.textContent(), /^line 3 `G42 X1`: error:20 /);
    assert.equal(await page.locator("#gutter .marked").textContent(), "3");
    await told.locator("button").click();
    const selected = await page.evaluate(() => document.getElementById("program").value.slice(...["selectionStart", "selectionEnd"].map((end) => document.getElementById("program")[end])));
    assert.equal(selected, "G42 X1");
    assert.match(await page.locator("#checks-total").textContent(), /1 of 9 broken/);
    await run(page, "G21\nG0 X5 ?\n");
    assert.match(await page.locator("#troubles li").first().textContent(), /^line 2 '\?' is a real-time command/);
  },

  async "settings are refused with their limits, and those that may be are in force"() {
    const page = await opened();
    await hasEnded(page);
    await run(page, "G0 X1\n", "$110=-5\n");
    assert.match(await page.locator("#troubles li").first().textContent(), /-5/);
    await run(page, "G0 X1\n", "$100=100\n");
    assert.match(await page.locator("#figures").textContent(), /steps100/);
  },

  async "playback goes to where the slider says"() {
    const page = await opened();
    await hasEnded(page);
    await page.locator("#time").fill("0");
    assert.equal(await page.locator("#place-now").textContent(), "homing");
    await page.locator("#time").fill("50");
    assert.match(await page.locator("#place-now").textContent(), /^X 325\.00 {2}Y 320\.00 {2}Z \d+\.\d\d mm, 30\.0 mm\/s$/);
    await page.locator("#time").fill("0");
    await page.selectOption("#rate", "100");
    await page.click("#play");
    await page.waitForFunction(() => Number(document.getElementById("time").value) > 5);
    await page.click("#play");
    await page.locator("#time").focus();
    const before = Number(await page.inputValue("#time"));
    await page.keyboard.press("ArrowLeft");
    assert.ok(Number(await page.inputValue("#time")) < before);
  },

  async "a program of 20,000 moves is run to its end and drawn"() {
    const page = await opened();
    await hasEnded(page);
    await run(page, longProgram(20_000));
    assert.match(await page.locator("#checks-total").textContent(), /all 9 kept/);
    assert.match(await page.locator("#figures").textContent(), /moves20,000/);
    for (const button of ["zoom-in", "later", "zoom-all"]) await page.click(`#${button}`);
    await page.locator("#time").fill("1000");
    assert.match(await page.locator("#time-now").textContent(), /^999\.|^1000\./);
  },

  async "a long program can be cancelled, and the page lives on"() {
    const page = await opened();
    await hasEnded(page);
    await put(page, "program", longProgram(200_000));
    await page.click("#run");
    await page.waitForFunction(() => document.getElementById("progress").value > 0);
    await page.click("#cancel");
    assert.equal(await page.locator("#status").textContent(), "Cancelled.");
    await run(page, "G0 X1\n");
    assert.match(await page.locator("#checks-total").textContent(), /all 9 kept/);
  },

  async "the machine homes, jogs while a button is held, and stops when it is let go"() {
    const page = await opened("#operate");
    const place = async (axis) => Number(await page.locator(`#place-${axis}`).textContent());
    const is = (state) => page.locator(`#state[data-state=${state}]`).waitFor();
    await is("Idle");
    await page.selectOption("#live-rate", "20");
    await page.click("#home");
    await is("Home");
    await is("Idle");
    await page.waitForFunction(() => document.getElementById("homed-now").textContent === "yes");
    await page.selectOption("#live-rate", "1");
    const jog = page.locator("#pad .xp");
    await jog.hover();
    await page.mouse.down();
    await is("Jog");
    await page.waitForTimeout(800);
    await page.mouse.up();
    await is("Idle");
    const stopped = await place("x");
    assert.ok(stopped > 1 && stopped < 80, `${stopped} mm`);
    await page.waitForTimeout(500);
    assert.equal(await place("x"), stopped);
    await page.locator("#pad .yp").focus();
    await jog.hover();
    await page.mouse.down();
    await is("Jog");
    await page.waitForTimeout(300);
    assert.equal(await page.locator("#state").textContent(), "Jog", "the focus went to another button of the pad");
    await page.mouse.up();
    await is("Idle");
    await page.keyboard.down("ArrowUp");
    await is("Jog");
    await page.waitForTimeout(300);
    await page.keyboard.up("ArrowUp");
    await is("Idle");
    assert.ok((await place("y")) > 0);
  },

  async "a program that is sent is held, resumed and reset; an emergency stop locks"() {
    const page = await opened("#operate");
    const is = (state) => page.locator(`#state[data-state=${state}]`).waitFor();
    await is("Idle");
    await put(page, "program", "G21 G91\nG1 X20 F1200\nG1 X-10\n(end)\n");
    await page.click("#send-program");
    await is("Run");
    await page.click("#hold");
    await is("Hold");
    await page.click("#resume");
    await is("Idle");
    await page.waitForFunction(() => document.getElementById("place-x").textContent === "10.000");
    await page.fill("#line", "$E20");
    await page.keyboard.press("Enter");
    await page.locator("#log", { hasText: "> $E20" }).waitFor();
    await page.check("#stop-button");
    await is("Alarm");
    assert.match(await page.locator("#alarm").textContent(), /^ALARM:10: emergency stop pressed: release it/);
    await page.uncheck("#stop-button");
    await page.click("#unlock");
    await is("Idle");
    assert.ok(await page.locator("#alarm").isHidden());
    await page.click("#reset");
    await page.locator("#log", { hasText: "Grbl 1.1" }).first().waitFor();
  },

  async "tabs, labels and widths are for everybody"() {
    const page = await opened("", { viewport: PHONE });
    await hasEnded(page);
    for (const tab of ["run", "operate"]) {
      await page.click(`#tab-${tab}`);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.equal(wide, 0, `${tab} is ${wide} pixels too wide for a phone`);
    }
    const nameless = await page.evaluate(() => [...document.querySelectorAll("input, select, textarea, button")]
      .filter((control) => !control.labels?.length && !control.getAttribute("aria-label") && !control.textContent.trim())
      .map((control) => control.id));
    assert.deepEqual(nameless, []);
  },

  async "pictures of the page"() {
    for (const colorScheme of ["light", "dark"]) {
      for (const [name, viewport] of Object.entries({ wide: WIDE, narrow: PHONE })) {
        const page = await opened("", { viewport, colorScheme });
        await hasEnded(page);
        await page.locator("#time").fill("50");
        await page.screenshot({ path: join(paths.shots, `run-${colorScheme}-${name}.png`), fullPage: true });
        await page.click("#tab-operate");
        await page.locator("#state[data-state=Idle]").waitFor();
        await page.screenshot({ path: join(paths.shots, `operate-${colorScheme}-${name}.png`), fullPage: true });
        await page.context().close();
      }
    }
  },
};

let failed = 0;
for (const [name, test] of Object.entries(tests)) {
  complaints.length = 0;
  try {
    await test();
    assert.deepEqual(complaints, [], "the browser's log");
    console.log(`ok      ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED  ${name}\n${error.stack}`);
  }
  await Promise.all(browser.contexts().map((context) => context.close()));
}
await browser.close();
server.close();
process.exitCode = failed ? 1 : 0;
