// What only a simulated machine has: a contact to press, its power, and its time.
import assert from "node:assert/strict";
import { answers, home, is, operated, reads, rests, sends, sent, setting, stands } from "./machine.mjs";

export const tests = {
  async "simulated: the emergency stop locks, and is reported in words"() {
    const page = await operated();
    await page.check("#stop-button");
    await is(page, "Alarm");
    await reads(page, "alarm", /^ALARM:10: emergency stop pressed: release it/);
    await page.uncheck("#stop-button");
    await page.click("#unlock");
    await is(page, "Idle");
    assert.ok(await page.locator("#alarm").isHidden());
  },

  async "simulated: the time left is that of the same program in virtual time, with the machine's settings"() {
    const page = await operated();
    await answers(page, "$110=1200");
    const left = async (line) => {
      const text = await page.waitForFunction((line) => {
        const { textContent } = document.getElementById("sending-now");
        return textContent.startsWith(`line ${line} of 3 is under way, about`) && textContent;
      }, line);
      return Number(/about (\d+) s left/.exec(await text.jsonValue())[1]);
    };
    // 5.4 and 3.4 s at 20 mm/s and 50 mm/s2.
    await sends(page, "G21 G91\nG1 X100 F6000\nG1 X-60\n");
    const first = await left(2);
    assert.ok(first >= 7 && first <= 9, `${first} s`);
    const second = await left(3);
    assert.ok(second >= 1 && second <= 5, `${second} s`);
    await reads(page, "sending-now", /^Done/);
    await sends(page, "G21 G91\nG38.2 Z20 F600\n");
    await is(page, "Run");
    await page.waitForTimeout(1000);
    assert.doesNotMatch(await page.locator("#sending-now").textContent(), /left/, "nobody knows where the probe touches");
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

  async "simulated: a power-cycle takes the settings of programs, and nothing is homed"() {
    const page = await operated();
    await home(page);
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
