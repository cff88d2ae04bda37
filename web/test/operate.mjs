// Operating a machine, by what its console reports: whichever machine it is, without anything in its way.
import assert from "node:assert/strict";
import { put } from "./harness.mjs";
import { answers, endsWith, hears, home, is, operated, place, reads, rests, sends, sent, stands } from "./machine.mjs";

export const tests = (machine) => ({
  async [`${machine.name}: a step is made whole, however short the press; ten presses are ten steps`]() {
    const page = await operated(machine);
    await page.check("[name=jog-step][value='0.1']");
    await page.locator("#pad .xp").click();
    await hears(page, "> $J=G21 G91 X0.1");
    await stands(page, "x", 0.1);
    for (let press = 0; press < 10; press++) await page.locator("#pad .xp").click();
    await stands(page, "x", 1.1);
    await page.check("[name=jog-step][value='10']");
    await page.locator("#pad .zp").focus();
    await page.keyboard.press("PageUp");
    await stands(page, "z", 10);
    assert.deepEqual((await answers(page, "$G"))[0].includes("G90"), true, "the modes of the program are as they were");
  },

  async [`${machine.name}: what a person is typing stays while reports come`]() {
    const page = await operated(machine);
    const typed = { "jog-feed": "12", "tool-s": "34", "probe-distance": "5", "probe-feed": "67", "probe-thickness": "8", line: "G0 X" };
    for (const [id, value] of Object.entries(typed)) await page.fill(`#${id}`, value);
    await put(page, "program", "M3 S700\nG1 X8 F300\nG55\nM5\n");
    await page.evaluate(() => document.getElementById("send-program").click());
    await reads(page, "tool-now", /^on, M3, S 700 now$/);
    await endsWith(page, machine, "Done: 4 lines\\.");
    await is(page, "Idle");
    await stands(page, "x", 8);
    for (const [id, value] of Object.entries(typed)) assert.equal(await page.inputValue(`#${id}`), value, id);
    assert.equal(await page.inputValue("#work-system"), "G55");
    assert.equal(await page.evaluate(() => document.activeElement.id), "line", "nothing else has taken the focus");
  },

  async [`${machine.name}: a setting that gives steps another length takes the zero of its axis away`]() {
    const page = await operated(machine);
    await home(page);
    await answers(page, "$101=100");
    await reads(page, "homed-now", /^X, Z only$/);
    await page.click("#home");
    await is(page, "Home");
    await is(page, "Idle");
    await answers(page, "$RST=#");
    await reads(page, "homed-now", /^yes$/);
    await page.click("#tab-settings");
    await page.click("#restore-settings");
    await page.click("#restore-yes");
    await page.click("#tab-operate");
    await reads(page, "homed-now", /^X, Z only$/);
  },

  async [`${machine.name}: a jog beyond the travel is refused in the machine's words`]() {
    const page = await operated(machine);
    await home(page);
    await page.check("[name=jog-step][value='10']");
    await page.locator("#pad .xm").click();
    await hears(page, /^error:15: .*travel/);
  },

  async [`${machine.name}: a reset and a soft limit keep what is homed; a homing that is stopped does not`]() {
    const page = await operated(machine);
    await home(page);
    await page.click("#reset");
    await hears(page, "Grbl 1.1");
    await is(page, "Idle");
    await reads(page, "homed-now", /^yes$/);
    await answers(page, "G0 X-5");
    await is(page, "Alarm");
    await reads(page, "alarm", /^ALARM:2: /);
    await page.click("#unlock");
    await is(page, "Idle");
    await reads(page, "homed-now", /^yes$/);
    // Far from the switches, so that there is time to stop it.
    await answers(page, "$J=G53 G21 G90 X40 Y40 Z40 F2800");
    await stands(page, "z", 40);
    await page.click("#home");
    await is(page, "Home");
    await page.click("#stop");
    await is(page, "Alarm");
    await reads(page, "alarm", /^ALARM:6: /);
    await reads(page, "homed-now", /^no$/);
    await page.click("#unlock");
    await home(page);
  },

  async [`${machine.name}: the zero of the work is set, shown beside the machine's, and gone to`]() {
    const page = await operated(machine);
    for (const jog of ["X10", "Y6", "Z4"]) await answers(page, `$J=G91 ${jog} F2000`);
    await rests(page, "z");
    await page.click("#zero-x");
    await page.click("#zero-z");
    await stands(page, "x", 0, "work");
    await stands(page, "y", 6, "work");
    await stands(page, "z", 0, "work");
    await stands(page, "x", 10);
    await page.click("#zero-all");
    await stands(page, "y", 0, "work");
    await page.selectOption("#work-system", "G55");
    await stands(page, "y", 6, "work");
    assert.match((await answers(page, "$G"))[0], /\bG55\b/);
    await answers(page, "G54");
    await answers(page, "$J=G91 X5 Y5 Z5 F2000");
    await rests(page, "x");
    assert.equal(await page.inputValue("#work-system"), "G54", "the console has chosen it");
    await page.click("#zero");
    await hears(page, /^> \$J=G21 G90 Z0/);
    for (const axis of ["x", "y", "z"]) await stands(page, axis, 0, "work");
    assert.deepEqual(await sent(page, 2), ["$J=G21 G90 X0 Y0 F1500", "$J=G21 G90 Z0 F1500"]);
    await answers(page, "$J=G91 X3 Z-2 F2000");
    await rests(page, "z");
    await page.click("#zero");
    await stands(page, "x", 0, "work");
    assert.deepEqual(await sent(page, 2), ["$J=G21 G90 Z0 F1500", "$J=G21 G90 X0 Y0 F1500"], "Z was below its zero");
  },

  async [`${machine.name}: a place is in inches if the machine reports inches`]() {
    const page = await operated(machine);
    await answers(page, "$J=G91 G21 X25.4 F2000");
    await stands(page, "x", 25.4);
    await answers(page, "$13=1");
    await reads(page, "position-unit", /^inches$/);
    await reads(page, "place-x", /^1\.0000$/);
    await page.check("[name=jog-step][value='1']");
    await page.locator("#pad .xp").click();
    await reads(page, "place-x", /^1\.0394$/);
    await answers(page, "$13=0");
  },

  async [`${machine.name}: overrides are those that the machine reports`]() {
    const page = await operated(machine);
    const press = (name) => page.getByRole("button", { name, exact: true }).click();
    await press("Feed 10 % more");
    await press("Feed 1 % less");
    await reads(page, "override-feed", /^109 %$/);
    await press("Feed back to 100 %");
    await reads(page, "override-feed", /^100 %$/);
    await press("Feed 10 % less");
    await press("Feed 1 % more");
    await reads(page, "override-feed", /^91 %$/);
    for (const percent of [25, 50, 100]) {
      await press(`Rapids ${percent} %`);
      await reads(page, "override-rapids", new RegExp(`^${percent} %$`));
    }
    await press("Spindle 10 % less");
    await press("Spindle 1 % less");
    await reads(page, "override-spindle", /^89 %$/);
    await press("Spindle 10 % more");
    await press("Spindle 1 % more");
    await press("Spindle back to 100 %");
    await reads(page, "override-spindle", /^100 %$/);
  },

  async [`${machine.name}: the spindle and coolant are on by what the machine reports, and a laser is called one`]() {
    const page = await operated(machine);
    await page.fill("#tool-s", "500");
    await page.click("#tool-cw");
    await reads(page, "tool-now", /^on, M3, S 500 now$/);
    await page.click("#tool-ccw");
    await reads(page, "tool-now", /^on, M4, S 500 now$/);
    await page.click("#tool-off");
    await reads(page, "tool-now", /^off$/);
    const flood = page.locator("#flood[aria-pressed=true]");
    await page.click("#flood");
    await flood.waitFor();
    assert.match((await answers(page, "$G"))[0], /\bM8\b/);
    await page.click("#mist");
    await page.locator("#mist[aria-pressed=true]").waitFor();
    await sends(page, "G21 G91\nG1 X30 F600\nG1 X-30\n");
    await is(page, "Run");
    await page.click("#flood");
    await page.locator("#flood[aria-pressed=false]").waitFor();
    assert.equal(await page.locator("#tool-cw").isDisabled(), true);
    await page.click("#stop");
    await is(page, "Idle");
    await page.click("#flood");
    await flood.waitFor();
    await page.click("#coolant-off");
    await page.locator("#flood[aria-pressed=false]").waitFor();
    await answers(page, "$32=1");
    await reads(page, "h-tool", /^Laser/);
    await answers(page, "$32=0");
    await reads(page, "h-tool", /^Spindle/);
  },

  async [`${machine.name}: a probe that touches nothing is reported, and its alarm in words; what cannot be probed is refused`]() {
    const page = await operated(machine);
    await page.fill("#probe-distance", "0");
    await page.click("#probe");
    await reads(page, "probe-result", /must be above 0 mm/);
    await page.fill("#probe-distance", "3");
    await page.fill("#probe-feed", "300");
    await answers(page, "$J=G91 Z20 F2000");
    await stands(page, "z", 20);
    await answers(page, "G20 G91");
    await page.click("#probe");
    await is(page, "Alarm");
    await reads(page, "probe-result", /^No contact/);
    await reads(page, "alarm", /^ALARM:5: /);
    await page.click("#probe");
    await reads(page, "probe-result", /in Alarm/);
    await page.click("#unlock");
    await stands(page, "z", 17);
    assert.match((await answers(page, "$G"))[0], /\bG20\b.*\bG91\b/, "the modes are as they were");
    await answers(page, "G21 G90");
    await page.click("#probe");
    await is(page, "Alarm");
    await page.click("#unlock");
    await stands(page, "z", 14);
  },

  async [`${machine.name}: a program goes with its line and the time left; a hold and a resume lose nothing`]() {
    const page = await operated(machine);
    await sends(page, "G21 G91\n(a comment)\nG1 X20 F1200\nG1 X-10\n\nG1 Y4\n");
    await is(page, "Run");
    await reads(page, "sending-now", /^line [346] of 6 is under way, about \d+ s left$/);
    await page.click("#hold");
    await is(page, "Hold");
    await page.locator("#resume:enabled").waitFor();
    const held = await place(page, "x");
    await page.waitForTimeout(600);
    assert.equal(await place(page, "x"), held, "the machine is held, not the page's sending alone");
    await page.click("#resume");
    await endsWith(page, machine, "Done: 4 lines\\.");
    await stands(page, "x", 10);
    await stands(page, "y", 4);
  },

  async [`${machine.name}: Stop brakes and forgets the rest, by button and by Escape, and keeps the position`]() {
    const page = await operated(machine);
    const far = `G21 G91\n${"G1 X60 F1200\nG1 X-60\n".repeat(20)}`;
    for (const stop of [() => page.click("#stop"), () => page.keyboard.press("Escape"), () => page.click("#stop-program")]) {
      await sends(page, far);
      await is(page, "Run");
      await stop();
      await endsWith(page, machine, "Stopped: the machine has forgotten what it had not made\\.", "Stopped by a reset, .*: the machine has forgotten what it had not made\\.");
      const stopped = await rests(page, "x");
      assert.ok(stopped >= 0 && stopped < 60, `${stopped} mm`);
      assert.ok(await page.locator("#alarm").isHidden(), "the first stop brakes");
      await answers(page, "G21 G90");
      await answers(page, "$J=G90 X0 F2800");
      await stands(page, "x", 0);
    }
  },

  async [`${machine.name}: a second press sends nothing twice, and an alarm ends a program`]() {
    const page = await operated(machine);
    await put(page, "program", "G21 G91\nG1 X4 F1200\n");
    await page.evaluate(() => ["first", "second"].forEach(() => document.getElementById("send-program").click()));
    await endsWith(page, machine, "Done: 2 lines\\.");
    await stands(page, "x", 4);
    await sends(page, `G21 G91\nG38.2 Z-1 F300\n${"G1 X1\n".repeat(40)}`);
    await is(page, "Alarm");
    await endsWith(page, machine, "Stopped by an alarm\\.", "Stopped by an alarm, .*: ALARM:5: .*");
    await page.click("#unlock");
    await stands(page, "x", 4);
    // A switch on the way of a probe, which stands near it.
    for (const line of ["$21=1", "$J=G53 G21 G90 X4 F2000"]) await answers(page, line);
    await rests(page, "x");
    await sends(page, `G21 G91\nG38.2 X-300 F600\n${"G1 X1\n".repeat(40)}`);
    await is(page, "Alarm");
    await endsWith(page, machine, "Stopped by an alarm\\.", "Stopped by an alarm, .*: ALARM:1: .*");
    // The tests behind this find it off the switch.
    await page.click("#unlock");
    await is(page, "Idle");
    await answers(page, "$J=G91 G21 X6 F600");
    await rests(page, "x");
  },

  async [`${machine.name}: a refused line stops the machine, because what is on its way makes no sense without it`]() {
    const page = await operated(machine);
    await sends(page, "G21 G91\nG42 X1\nG1 X50 F1200\n");
    await endsWith(page, machine, "Stopped: line 2 `G42 X1` was refused\\. error:20: .+");
    assert.ok((await rests(page, "x")) < 5, "the line behind it was in the machine already");
  },

  async [`${machine.name}: errors are reported in the machine's words`]() {
    const page = await operated(machine);
    const answer = (await answers(page, "G1 X1 F0")).at(-1);
    assert.match(answer, /^error:22: .*[Ff]eed/);
    assert.equal((await answers(page, "G1 X1 F0")).at(-1), answer, "the second time from memory");
    await sends(page, "G0 X5 ?\n");
    await reads(page, "sending-now", /^Line 1 .* has a byte that the machine would obey at once|^Not sent: line 1: .* is a real-time command/);
  },
});
