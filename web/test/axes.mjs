// Programs and machines with a fourth axis, A.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { hasEnded, opened, paths, put, run } from "./harness.mjs";
import { answers, is, operated, reads, sends, stands } from "./machine.mjs";

const TURNS = "G21 G90 (A90 is a word of a comment)\nG1 X20 F1200\nG1 X30 A90 F1800\nG0 A-45\n";

/** A page whose simulated machine has A, with it in Idle. */
async function withA() {
  const page = await opened();
  await hasEnded(page);
  await page.selectOption("#axes", "4");
  await page.click("#tab-operate");
  await is(page, "Idle");
  return page;
}

export const tests = {
  async "axes: a program with A is run on the machine with A by itself, which nobody else loads"() {
    const page = await opened();
    const loaded = [];
    page.on("request", (request) => loaded.push(request.url().split("/").at(-1)));
    await hasEnded(page);
    await run(page, "G21 G90 (A90)\nG0 X5 ; A3\nG42 X1\n");
    assert.equal(await page.inputValue("#axes"), "3");
    assert.equal(await page.textContent("#axes-note"), "");
    assert.ok(!loaded.includes("machine4_bg.wasm"));
    assert.ok(await page.locator("#key-a").isHidden());
    await run(page, TURNS);
    assert.equal(await page.inputValue("#axes"), "4");
    assert.equal(await page.textContent("#axes-note"), "Line 3 has A, so this is a machine with X, Y, Z and A.");
    await hasEnded(page);
    assert.ok(loaded.includes("machine4_bg.wasm"));
    assert.equal(await page.textContent("#checks-total"), "all 9 kept");
    assert.match(await page.textContent("#figures"), /ends atX 30\.00, Y 0\.00, Z 0\.00 mm, A -45\.00 degrees/);
    assert.match(await page.textContent("#place-now"), /^X 30\.00 {2}Y 0\.00 {2}Z 0\.00 mm {2}A -45\.00 degrees, 0\.0 mm\/s$/);
    const charts = () => page.locator("#curves .u-title").evaluateAll((titles) => titles.filter((title) => title.checkVisibility()).map((title) => title.textContent));
    assert.deepEqual(await charts(), ["Speed, mm/s", "Speed of A, degrees/s", "Acceleration, mm/s²", "Acceleration of A, degrees/s²"]);
    assert.ok(await page.locator("#key-a").isVisible());
    // It is so after a reload, too.
    await page.reload();
    await hasEnded(page);
    assert.equal(await page.inputValue("#axes"), "4");
    assert.match(await page.textContent("#figures"), /A -45\.00 degrees/);
    await run(page, "G21 G91\nG1 A20 F600\n", "$133=400\n$376=0\n");
    await hasEnded(page);
    assert.match(await page.textContent("#figures"), /Z 0\.00, A 20\.00 mm/);
    assert.deepEqual(await charts(), ["Speed of A, mm/s", "Acceleration of A, mm/s²"]);
  },

  async "axes: who has chosen X, Y and Z is told what a program with A needs, and a link has the choice"() {
    const page = await opened();
    await hasEnded(page);
    await page.selectOption("#axes", "4");
    await page.selectOption("#axes", "3");
    await run(page, TURNS);
    assert.match(await page.locator("#troubles li").first().textContent(), /^line 3 `G1 X30 A90 F1800`: error:20 /);
    assert.equal(await page.textContent("#axes-note"), "Line 3 has A, which a machine with X, Y and Z refuses: choose X Y Z A.");
    await page.selectOption("#axes", "4");
    await page.click("#run");
    await hasEnded(page);
    assert.equal(await page.textContent("#checks-total"), "all 9 kept");
    await page.context().grantPermissions(["clipboard-read", "clipboard-write"], { origin: new URL(paths.page).origin });
    await page.click("#copy-link");
    await page.locator("#link-state", { hasText: "Copied" }).waitFor();
    const other = await opened(await page.evaluate(() => navigator.clipboard.readText()));
    await hasEnded(other);
    await other.waitForFunction(() => /A -45\.00 degrees/.test(document.getElementById("figures").textContent));
    assert.equal(await other.inputValue("#axes"), "4");
    assert.equal(await other.textContent("#axes-note"), "");
  },

  async "axes: what-if and the report are of the machine with A"() {
    const page = await opened();
    await hasEnded(page);
    await run(page, TURNS);
    await hasEnded(page);
    await page.locator("#what-if-knobs input[type=range]").first().evaluate((knob) => {
      knob.value = knob.min;
      knob.dispatchEvent(new Event("input"));
    });
    await page.locator("#what-if-time", { hasText: "becomes" }).waitFor();
    await page.locator("#advice", { hasText: /Z 0\.000 to 0\.000 mm: 30\.000 x 0\.000 x 0\.000, A -45\.000 to 90\.000 degrees/ }).waitFor();
    const [download] = await Promise.all([page.waitForEvent("download"), page.click("#save-trace")]);
    assert.match(await readFile(await download.path(), "utf8"), /,A,/i);
  },

  async "axes: the simulated machine has A, which is jogged, zeroed and homed"() {
    const page = await withA();
    await page.locator("#work-a").waitFor();
    assert.equal(await page.textContent("#letter-a"), "A°");
    await page.check("[name=jog-step][value='10']");
    await page.click("[data-axis='3'][data-direction='1']");
    await stands(page, "a", 10);
    await page.click("#zero-a");
    await stands(page, "a", 0, "work");
    await page.fill("#go-a", "-5");
    await page.click("#go");
    await stands(page, "a", -5, "work");
    await page.fill("#go-a", "0");
    await page.click("#go");
    await stands(page, "a", 0, "work");
    await stands(page, "a", 10);
    await page.selectOption("#live-rate", "20");
    await page.click("#home");
    await is(page, "Home");
    await is(page, "Idle");
    await reads(page, "homed-now", /^X, Y, Z only$/);
    // By default A does not home.
    await answers(page, "$901=4312");
    await page.click("#home-a");
    await is(page, "Home");
    await is(page, "Idle");
    await reads(page, "homed-now", /^yes$/);
    await stands(page, "a", 0);
    await page.selectOption("#live-rate", "1");
    const hold = await page.locator("[data-axis='3'][data-direction='-1']").boundingBox();
    await page.check("[name=jog-step][value='']");
    await page.mouse.move(hold.x + 5, hold.y + 5);
    await page.mouse.down();
    await is(page, "Jog");
    await page.mouse.up();
    await is(page, "Idle");
    await page.waitForFunction(() => Number(document.getElementById("place-a").textContent) < 0);
  },

  async "axes: a program with A is planned, found on its way and made by a machine with A"() {
    const page = await withA();
    await page.selectOption("#live-rate", "20");
    await page.click("#home");
    await is(page, "Home");
    await is(page, "Idle");
    await reads(page, "homed-now", /^X, Y, Z only$/);
    await put(page, "program", TURNS);
    await reads(page, "sending-what", /: 4 lines, about 9 s, X 0\.0 to 30\.0 mm, A -45\.0 to 90\.0 degrees of the machine\.$/);
    // A has no end, so nobody needs to know where it stands.
    await reads(page, "fits", /^It fits into the travel\.$/);
    await sends(page, TURNS);
    await reads(page, "sending-now", /^Done/);
    await stands(page, "a", -45);
    // With an end it has to be homed, as others have.
    await answers(page, "G0 A0");
    await stands(page, "a", 0);
    await answers(page, "$901=4312");
    await answers(page, "$133=60");
    await reads(page, "fits", /^Whether it fits is not known: A is not homed\.$/);
    await page.click("#home-a");
    await is(page, "Home");
    await is(page, "Idle");
    await reads(page, "fits", /^It does not fit\. A would go to -45\.00 degrees, which is 45\.00 degrees below the machine's zero, first in line 3\./);
  },

  async "axes: a machine with A has its settings in the form, with their words"() {
    const page = await withA();
    await page.click("#tab-settings");
    await page.fill("#find-setting", "$103");
    await page.locator(".setting[data-number='103'] .name", { hasText: /^A steps per/ }).waitFor();
    await page.fill("#find-setting", "$376");
    await page.locator(".setting[data-number='376']", { hasText: "rotary" }).waitFor();
    await page.click("#settings-for-run");
    assert.equal(await page.inputValue("#axes"), "4");
    const three = await operated(undefined, "settings");
    await three.fill("#find-setting", "$102");
    await three.locator(".setting[data-number='102']").waitFor();
    assert.equal(await three.locator(".setting[data-number='103']").count(), 0);
  },
};
