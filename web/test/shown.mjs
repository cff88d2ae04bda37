// What is shown of a run, and what can be saved of it.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { hasEnded, opened, PHONE, parked, put, run } from "./harness.mjs";

/** A corner that is taken exactly, and a laser. */
const CORNER = "G21 G91 G61\nG1 X20 F1200\nY20\n";
const LASER = "$32=1\nG21 G91\nM3 S500\nG1 X20 F1200\nY20 S1000\nM5\nG1 X-20\n";

/** The colours of a canvas, as text. */
const pixels = (page, id) => page.evaluate((id) => document.getElementById(id).toDataURL(), id);

/** Waits until a canvas is another than it was. */
const changes = (page, id, before) => page.waitForFunction(([id, before]) => document.getElementById(id).toDataURL() !== before, [id, before]);

/** Shows a program in some colours, and returns what they are said to mean. */
async function keyOf(page, program, tone) {
  await run(page, program);
  await hasEnded(page);
  const before = await pixels(page, "path");
  await page.selectOption("#tone", tone);
  await changes(page, "path", before);
  return page.locator("#path-key").textContent();
}

async function saved(page, button) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click(button)]);
  return { name: download.suggestedFilename(), text: await readFile(await download.path(), "utf8") };
}

export const tests = {
  async "the path is coloured by acceleration over its limit, and by the tool's power"() {
    const page = await parked();
    assert.match(await page.locator("#path-key").textContent(), /^Speed: 0 {2}54\.5 mm\/s/);
    const above = /above it, at most (\d+) %/.exec(await keyOf(page, CORNER, "load"));
    assert.ok(Number(above?.[1]) > 150, `${above}`);
    await page.selectOption("#tone", "speed");
    assert.doesNotMatch(await keyOf(page, CORNER.replace("G61", ""), "load"), /above/);
    await page.selectOption("#tone", "speed");
    assert.match(await keyOf(page, LASER, "power"), /^Tool: off is grey, 0 {2}100 % of its power/);
  },

  async "what is made already stands out while it is played back"() {
    const page = await parked();
    assert.ok(!(await page.getAttribute("#path", "class")));
    await page.locator("#time").fill("50");
    assert.equal(await page.getAttribute("#path", "class"), "ahead");
    const half = await pixels(page, "done");
    await page.locator("#time").fill("55");
    assert.notEqual(await pixels(page, "done"), half);
    await page.locator("#time").fill("50");
    assert.equal(await pixels(page, "done"), half, "time went back");
  },

  async "the path in space is turned by keys and by the mouse"() {
    const page = await parked();
    await page.selectOption("#plane", "3D");
    await page.locator("#space").waitFor();
    const seen = async () => (await page.locator("#space").screenshot()).toString("base64");
    const first = await seen();
    await page.focus("#space");
    await page.keyboard.press("ArrowLeft");
    assert.notEqual(await seen(), first);
    await page.keyboard.press("ArrowRight");
    const { x, y, width, height } = await page.locator("#space").boundingBox();
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + width / 2 + 80, y + height / 2, { steps: 4 });
    await page.mouse.up();
    assert.notEqual(await seen(), first);
    assert.equal((await saved(page, "#save-picture")).name, "parking.png");
    await page.selectOption("#plane", "XZ");
    assert.ok(await page.locator("#space").isHidden());
  },

  async "the whole is seen in space, on wide and tall screens, until somebody turns it"() {
    const page = await parked();
    await page.selectOption("#plane", "3D");
    const reaches = (from, to) => page.waitForFunction(([from, to]) => {
      const reach = Number(document.getElementById("space").dataset.reach);
      return reach > from && reach < to;
    }, [from, to]);
    await reaches(0.8, 1);
    await page.setViewportSize(PHONE);
    await reaches(0.8, 1);
    await page.selectOption("#fit", "travel");
    await reaches(0.8, 1);
    assert.match(await page.textContent("#path-key"), /The box: the travel\.$/);
    await page.selectOption("#programs", "engraving.nc");
    await page.locator("#results:not([data-state=ended])").waitFor({ state: "attached" });
    await hasEnded(page);
    await page.selectOption("#fit", "path");
    await reaches(0.8, 1);
    await page.focus("#space");
    for (let press = 0; press < 3; press++) await page.keyboard.press("+");
    await reaches(1.1, 9);
  },

  async "what limits a program is said as the tool says it, and its lines are a click away"() {
    const page = await parked();
    await run(page, "G21 G91\nG1 X40 F2400\nY40\nX-40\nG1 Y5 F100\n");
    const words = page.locator("#advice");
    await page.locator("#advice tr", { hasText: "limited by" }).waitFor();
    assert.match(await words.textContent(), /extentsX 0\.000 to 40\.000, Y 0\.000 to 45\.000/);
    assert.match(await words.textContent(), /the feed \d+\.\d %/);
    await words.locator("button", { hasText: "line 3" }).first().click();
    const selected = await page.evaluate(() => document.getElementById("program").shadowRoot.getSelection().toString());
    assert.equal(selected, "Y40");
    assert.equal(await page.locator("#program .cm-gutterElement.cm-current").textContent(), "3");
  },

  async "curves go closer by dragging, and values stand below them"() {
    const page = await parked();
    const over = page.locator("#curves .u-over").first();
    await page.locator("#time").fill("50");
    // What is said above them comes later, and moves them.
    await page.locator("#advice tr").first().waitFor();
    await over.scrollIntoViewIfNeeded();
    const { x, y, width, height } = await over.boundingBox();
    const cursor = () => page.locator("#curves .cursor").first().evaluate((mark) => parseFloat(mark.style.left));
    const before = await cursor();
    await page.mouse.move(x + before - 20, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + before + 60, y + height / 2, { steps: 5 });
    await page.mouse.up();
    const after = await cursor();
    assert.ok(Math.abs(after - width / 4) < 12, `${before} to ${after} of ${width} pixels`);
    await page.mouse.click(x + width / 2, y + height / 2);
    assert.ok(Math.abs((await cursor()) - width / 2) < 3);
    assert.match(await page.locator("#curves .u-legend").first().textContent(), /s:?\d+\.\d{4}X/);
  },

  async "wires, report and picture are saved"() {
    const page = await parked();
    const waves = await saved(page, "#save-waves");
    assert.equal(waves.name, "parking.vcd");
    assert.match(waves.text, /^\$timescale/);
    assert.match(waves.text, /step_x/i);
    const report = await saved(page, "#save-report");
    assert.equal(report.name, "parking.json");
    assert.equal(JSON.parse(report.text).program, "parking.nc");
    assert.equal((await saved(page, "#save-picture")).name, "parking.png");
    await page.locator("#run:enabled").waitFor();
  },

  async "speed profiles stand side by side with the figures of the tool"() {
    const page = await opened("#profiles");
    await page.locator("#profiles-rows th", { hasText: "s-curve" }).waitFor();
    const keys = await page.locator("#profiles-rows .line").evaluateAll((lines) => lines.map((line) => getComputedStyle(line).backgroundColor));
    assert.equal(new Set(keys).size, 7);
    assert.ok(!keys.includes("rgba(0, 0, 0, 0)"), keys.join());
    await page.fill("#profile-start", "0");
    await page.locator("#profiles-refused li").nth(3).waitFor();
    const total = page.locator("#profiles-rows tr", { hasText: "total, s" });
    assert.equal(await total.textContent(), "total, s2.6266672.8266673.174631");
    assert.equal(
      await page.locator("#profiles-command").textContent(),
      "isostep profile --speed-profile trapezoid,s-curve,sine --steps 4000 --top-speed 2400 --accel 2500 --decel 2500 --jerk 12500",
    );
    await page.fill("#profile-distance", "0");
    await page.locator("#profiles-trouble", { hasText: "1 to 1000000" }).waitFor();
  },

  async "a defect is reported with its place, and the page lives on"() {
    const page = await parked();
    await page.evaluate(() => {
      const Whole = Worker;
      window.Worker = class extends Whole {
        constructor(address, options) {
          super(window.isWhole ? address : `${address}?defect`, options);
        }
      };
    });
    await run(page, "G0 X1\n");
    const reported = await page.locator("#troubles li").first().textContent();
    assert.match(reported, /^this is a defect of Isostep: panicked at .*panic\.rs:\d+.*on purpose/s);
    assert.equal(await page.locator("#status").textContent(), "It could not be run.");
    await page.evaluate(() => (window.isWhole = true));
    await run(page, "G0 X1\n");
    assert.match(await page.locator("#checks-total").textContent(), /all 9 kept/);
  },

  async "the editor takes keys, undoes, and is left by Tab"() {
    const page = await parked();
    const text = () => page.evaluate(() => document.getElementById("program").shadowRoot.querySelector(".cm-content").textContent);
    await put(page, "program", "G0 X1");
    await page.locator("#program .cm-content").click();
    await page.keyboard.press("End");
    await page.keyboard.type("2");
    assert.equal(await text(), "G0 X12");
    await page.keyboard.press("Control+z");
    assert.equal(await text(), "G0 X1");
    await page.keyboard.press("Tab");
    assert.notEqual(await page.evaluate(() => document.activeElement.id), "program");
  },
};
