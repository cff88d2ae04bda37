// Operating a machine, whichever it is: the same on the simulated one and on a board.
import assert from "node:assert/strict";
import { opened, put } from "./harness.mjs";

/** What a person sees and does. */
class Person {
  constructor(page, machine) {
    this.page = page;
    this.machine = machine;
  }

  is(state) {
    return this.page.locator(`#state[data-state=${state}]`).waitFor();
  }

  async place(axis) {
    return Number(await this.page.locator(`#place-${axis}`).textContent());
  }

  /** Waits until an axis is between two places. */
  reaches(axis, least, most = Infinity) {
    return this.page.waitForFunction(([axis, least, most]) => {
      const mm = Number(document.getElementById(`place-${axis}`).textContent);
      return mm >= least && mm <= most;
    }, [axis, least, most]);
  }

  async sends(line) {
    await this.page.fill("#line", line);
    await this.page.locator("#line").press("Enter");
  }

  says(words) {
    return this.page.locator("#log div", { hasText: words }).first().waitFor();
  }

  async hurries(rate) {
    if (this.machine.isSimulated) await this.page.selectOption("#live-rate", rate);
  }

  async homes() {
    await this.hurries("20");
    await this.page.click("#home");
    await this.is("Home");
    await this.is("Idle");
    await this.page.waitForFunction(() => document.getElementById("homed-now").textContent === "yes");
    await this.hurries("1");
  }
}

/** A page with its machine at rest. */
async function attached(machine) {
  const page = await opened(machine.address);
  const person = new Person(page, machine);
  await person.is("Idle");
  return { page, person };
}

export const tests = (machine) => ({
  async [`${machine.name}: it homes, jogs while a button is held, and stops when it is let go`]() {
    const { page, person } = await attached(machine);
    await person.homes();
    const jog = page.locator("#pad .xp");
    await jog.hover();
    await page.mouse.down();
    await person.is("Jog");
    await person.reaches("x", 5);
    await page.mouse.up();
    await person.is("Idle");
    const stopped = await person.place("x");
    assert.ok(stopped >= 5 && stopped < 80, `${stopped} mm`);
    await page.waitForTimeout(500);
    assert.equal(await person.place("x"), stopped);
    await page.locator("#pad .yp").focus();
    await jog.hover();
    await page.mouse.down();
    await person.is("Jog");
    await page.waitForTimeout(300);
    assert.equal(await page.locator("#state").textContent(), "Jog", "the focus went to another button of the pad");
    await page.mouse.up();
    await person.is("Idle");
    const before = await person.place("y");
    await page.keyboard.down("ArrowUp");
    await person.is("Jog");
    await page.waitForTimeout(300);
    await page.keyboard.up("ArrowUp");
    await person.is("Idle");
    assert.ok((await person.place("y")) > before);
    await page.click("#zero");
    await person.is("Jog");
    await person.is("Idle");
    assert.deepEqual([await person.place("x"), await person.place("y")], [0, 0]);
  },

  async [`${machine.name}: a program that is sent is held, resumed and reset`]() {
    const { page, person } = await attached(machine);
    await put(page, "program", "G21 G91\nG1 X20 F1200\nG1 X-10\n(end)\n");
    const before = await person.place("x");
    await page.click("#send-program");
    await person.is("Run");
    await page.click("#hold");
    await person.is("Hold");
    await page.click("#resume");
    await person.is("Idle");
    await person.reaches("x", before + 9.999, before + 10.001);
    await page.locator("#sending-now", { hasText: "Done: 3 lines" }).waitFor();
    await person.sends("$E20");
    await person.says("> $E20");
    await put(page, "program", "G91\nG1 X20 F600\n");
    await page.click("#send-program");
    await person.is("Run");
    await page.click("#reset");
    await person.says("Grbl 1.1");
    await person.is("Idle");
    const stopped = await person.place("x");
    assert.ok(stopped < before + 30, `${stopped} mm`);
  },

  async [`${machine.name}: settings are changed, and refused with the reason`]() {
    const { page, person } = await attached(machine);
    await person.sends("$110=2000");
    await person.sends("$$");
    await person.says(/^\$110=2000/);
    await person.sends("$110=0");
    await page.locator("#log .wrong", { hasText: "error:" }).waitFor();
    await person.says(/^\[MSG:.*110/);
    await person.sends("$110=2880");
    await person.sends("$$");
    await person.says(/^\$110=2880/);
  },

  async [`${machine.name}: an alarm is reported in words, and unlocked`]() {
    const { page, person } = await attached(machine);
    await person.homes();
    await person.sends("$20=1");
    await person.sends("G90 G0 X9999");
    await person.is("Alarm");
    const words = await page.locator("#alarm").textContent();
    assert.match(words, /^ALARM:2: /);
    for (const tab of ["run", "operate"]) {
      await page.click(`#tab-${tab}`);
      assert.ok(await page.locator("#bar-trouble").isVisible());
      assert.equal(await page.locator("#bar-trouble").textContent(), words);
    }
    await page.click("#unlock");
    await person.is("Idle");
    for (const id of ["alarm", "bar-trouble"]) assert.ok(await page.locator(`#${id}`).isHidden());
    await person.sends("$20=0");
    await person.says("> $20=0");
  },

  ...(machine.isSimulated && {
    async [`${machine.name}: an emergency stop locks`]() {
      const { page, person } = await attached(machine);
      await page.check("#stop-button");
      await person.is("Alarm");
      assert.match(await page.locator("#alarm").textContent(), /^ALARM:10: emergency stop pressed: release it/);
      await page.uncheck("#stop-button");
      await page.click("#unlock");
      await person.is("Idle");
      assert.ok(await page.locator("#alarm").isHidden());
    },
  }),
});
