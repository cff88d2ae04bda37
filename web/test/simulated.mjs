// What only a simulated machine has: a contact to press, its power, and its time.
import assert from "node:assert/strict";
import { answers, home, is, operated, reads, rests, sent, setting, stands } from "./machine.mjs";

export const tests = {
  async "simulated: the emergency stop locks, and is told in words"() {
    const page = await operated();
    await page.check("#stop-button");
    await is(page, "Alarm");
    await reads(page, "alarm", /^ALARM:10: emergency stop pressed: release it/);
    await page.uncheck("#stop-button");
    await page.click("#unlock");
    await is(page, "Idle");
    assert.ok(await page.locator("#alarm").isHidden());
  },

  async "simulated: a probe finds a plate, and Z is set by its thickness, in whichever modes"() {
    const page = await operated();
    await home(page);
    await answers(page, "$J=G90 Z20 F2000");
    await stands(page, "z", 20);
    await page.check("#plate");
    await page.fill("#probe-distance", "15");
    await page.fill("#probe-feed", "300");
    for (const [modes, line, thickness] of [["G21 G90", "G38.2 Z5.000 F300.000", "1.5"], ["G20 G91", "G38.2 Z-0.5906 F11.8110", "0"]]) {
      await answers(page, modes);
      await page.click("#probe");
      // The switch is 2 mm, $27, below the machine's zero.
      await reads(page, "probe-result", /^Contact at Z 8 mm of the machine\.$/);
      assert.deepEqual(await sent(page, 1), [line]);
      const past = (await rests(page, "z")) - 8;
      assert.ok(past < 0, "it brakes after the contact");
      await page.fill("#probe-thickness", thickness);
      await page.click("#probe-zero");
      await reads(page, "probe-result", /^Z is 0 at/);
      await stands(page, "z", Number(thickness) + past, "work");
      await answers(page, "$J=G21 G53 G90 Z20 F2000");
      await stands(page, "z", 20);
    }
    await answers(page, "$J=G21 G53 G90 Z5 F2000");
    await stands(page, "z", 5);
    await reads(page, "pins-now", /^probe$/);
    await page.click("#probe");
    await reads(page, "probe-result", /touches already/);
  },

  async "simulated: a reset keeps what is homed, a power-cycle does not, and takes the settings of programs"() {
    const page = await operated();
    await home(page);
    await page.click("#reset");
    await page.locator("#log", { hasText: "Grbl 1.1" }).first().waitFor();
    await is(page, "Idle");
    await reads(page, "homed-now", /^yes$/);
    await answers(page, "$110=1234");
    await page.click("#tab-settings");
    await page.click("#settings-for-run");
    assert.equal(await page.inputValue("#settings"), "$110=1234\n");
    await page.click("#tab-operate");
    await page.click("#power");
    await reads(page, "homed-now", /^no$/);
    await is(page, "Idle");
    assert.equal(await setting(page, 110), 1234);
  },
};
