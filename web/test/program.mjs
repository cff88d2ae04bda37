// Running a program in virtual time.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { cancelledAfterMs, hasEnded, longProgram, parked, paths, put, run } from "./harness.mjs";

/** A person takes this for at once. */
const CANCELLED_MS = 200;

export const tests = {
  async "our program keeps every promise, and its trace is the native one"() {
    const page = await parked();
    const verdicts = await page.locator("#checks tr").evaluateAll((rows) => rows.map((row) => [...row.cells].map((cell) => cell.textContent)));
    assert.equal(verdicts.length, 9);
    for (const [kept, promise, found] of verdicts) assert.equal(kept, "kept", `${promise}: ${found}`);
    const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save-trace")]);
    const [ours, native] = await Promise.all([readFile(await download.path()), readFile(paths.trace)]);
    assert.ok(ours.equals(native), `${ours.length} bytes, natively ${native.length}`);
    assert.equal(download.suggestedFilename(), "parking.csv");
  },

  async "what a program has wrong is reported at its line"() {
    const page = await parked();
    await run(page, "G21\nG90\nG42 X1\nG0 X5\n");
    const reported = page.locator("#troubles li").first();
    assert.match(await reported.textContent(), /^line 3 `G42 X1`: error:20 /);
    assert.equal(await page.locator("#program .cm-gutterElement.cm-refused").textContent(), "3");
    assert.match(await page.locator("#program .cm-reported").textContent(), /^`G42 X1`: error:20 /);
    await reported.locator("button").click();
    const selected = await page.evaluate(() => document.getElementById("program").shadowRoot.getSelection().toString());
    assert.equal(selected, "G42 X1");
    assert.match(await page.locator("#checks-total").textContent(), /1 of 9 broken/);
    await run(page, "G21\nG0 X5 ?\n");
    assert.match(await page.locator("#troubles li").first().textContent(), /^line 2 '\?' is a real-time command/);
  },

  async "settings are refused with their limits, and those that may be are in force"() {
    const page = await parked();
    await run(page, "G0 X1\n", "$110=-5\n");
    assert.match(await page.locator("#settings-troubles li").textContent(), /-5/);
    await run(page, "G0 X1\n", "$100=100\n");
    assert.match(await page.locator("#figures").textContent(), /steps100/);
  },

  async "playback goes to where the slider says"() {
    const page = await parked();
    await page.locator("#time").fill("0");
    assert.equal(await page.locator("#place-now").textContent(), "homing");
    await page.locator("#time").fill("50");
    assert.match(await page.locator("#place-now").textContent(), /^X 325\.00 {2}Y 320\.00 {2}Z \d+\.\d\d mm, 30\.0 mm\/s$/);
    assert.match(await page.locator("#program .cm-line.cm-current").textContent(), /^G1 Z/);
    await page.locator("#time").fill("0");
    await page.selectOption("#rate", "10");
    await page.click("#play");
    await page.waitForFunction(() => Number(document.getElementById("time").value) > 5);
    await page.click("#play");
    await page.locator("#time").focus();
    const before = Number(await page.inputValue("#time"));
    await page.keyboard.press("ArrowLeft");
    assert.ok(Number(await page.inputValue("#time")) < before);
  },

  async "a program of 20,000 moves is run to its end and drawn"() {
    const page = await parked();
    await run(page, longProgram(20_000));
    assert.match(await page.locator("#checks-total").textContent(), /all 9 kept/);
    assert.match(await page.locator("#figures").textContent(), /moves20,000/);
    await hasEnded(page);
    assert.ok(Number(await page.getAttribute("#path", "data-lines")) <= 60_000);
    for (const button of ["zoom-in", "later", "zoom-all"]) {
      await page.click(`#${button}`);
      const points = Number(await page.getAttribute("#curves", "data-points"));
      assert.ok(points > 1_000 && points < 300_000, `${points} points of curves`);
    }
    await page.locator("#time").fill("1000");
    assert.match(await page.locator("#time-now").textContent(), /^999\.|^1000\./);
  },

  async "a long program can be cancelled, and the page lives on"() {
    const page = await parked();
    await put(page, "program", longProgram(200_000));
    await page.click("#run");
    await page.waitForFunction(() => document.getElementById("progress").value > 0);
    const ms = await cancelledAfterMs(page);
    assert.ok(ms < CANCELLED_MS, `${ms} ms`);
    await run(page, "G0 X1\n");
    assert.match(await page.locator("#checks-total").textContent(), /all 9 kept/);
  },
};
