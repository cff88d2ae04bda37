// Operating a machine.
import assert from "node:assert/strict";
import { opened, put } from "./harness.mjs";

export const tests = {
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
};
