// The picture of the machine that is operated, and what is known of a program before it is sent: whichever machine it is.
import assert from "node:assert/strict";
import { put } from "./harness.mjs";
import { answers, endsWith, home, is, operated, place, reads, rests, sends, sent, stands } from "./machine.mjs";

/** A square of 40 mm, and then a way back. */
const SQUARE = "G21 G90\nG1 X40 F1500\nG1 Y40\nG1 X0\nG1 Y0\n";

/** Where the picture has the tool, mm of the machine. */
const drawn = (page) => page.evaluate(() => document.getElementById("tool").dataset.at?.split(" ").map(Number) ?? []);

/** The colours of a canvas near a place of the path, as `r g b a`. */
async function colourAt(page, canvas, share) {
  return page.evaluate(([canvas, share]) => {
    const place = document.getElementById(canvas);
    const { width, height } = place;
    const { data } = place.getContext("2d").getImageData(0, 0, width, height);
    // The longest row of pixels that are drawn: a side of the square.
    let [best, row, from] = [0, 0, 0];
    for (let y = 0; y < height; y++) {
      for (let x = 0, run = 0; x < width; x++) {
        run = data[4 * (y * width + x) + 3] > 100 ? run + 1 : 0;
        if (run > best) [best, row, from] = [run, y, x - run + 1];
      }
    }
    return { length: best, at: [...data.slice(4 * (row * width + from + Math.floor(best * share)), 4 * (row * width + from + Math.floor(best * share)) + 4)] };
  }, [canvas, share]);
}

const arrives = (page, axis, place) => page.waitForFunction(([axis, place]) => document.getElementById(`place-${axis}`).textContent === place, [axis, place]);

export const tests = (machine) => ({
  async [`${machine.name}: the picture has the tool where the machine is, and the path from the work's zero`]() {
    const page = await operated(machine);
    await home(page);
    await put(page, "program", SQUARE);
    await answers(page, "$J=G90 X100 Y60 F2800");
    await stands(page, "x", 100);
    await page.click("#zero-all");
    await reads(page, "sending-what", /: 5 lines, about 8 s, X 100\.0 to 140\.0, Y 60\.0 to 100\.0 mm of the machine\.$/);
    await reads(page, "fits", /^It fits into the travel\.$/);
    assert.equal(await page.getAttribute("#picture", "data-of"), "program");
    await page.waitForFunction(() => document.getElementById("tool").dataset.at === "100.00 60.00");
    await answers(page, "$J=G91 X-30 Y5 F2800");
    await rests(page, "x");
    const [x, y] = await drawn(page);
    assert.ok(Math.abs(x - 70) < 0.05 && Math.abs(y - 65) < 0.05, `${x} ${y}`);
    await page.selectOption("#plane", "YZ");
    await page.waitForFunction(() => document.getElementById("tool").dataset.at.startsWith("65.00 "));
  },

  async [`${machine.name}: a program that does not fit is refused, with the axis, the place, the limit and the line`]() {
    const page = await operated(machine);
    await home(page);
    const travel = Number((await answers(page, "$$")).find((line) => line.startsWith("$130=")).split("=")[1]);
    await put(page, "program", SQUARE);
    await answers(page, `$J=G90 X${travel - 30} F2800`);
    await stands(page, "x", travel - 30);
    await page.click("#zero-x");
    await reads(page, "fits", new RegExp(`^It does not fit\\. X would go to ${travel + 10}\\.00 mm, which is 10\\.00 mm past the end of the travel at ${travel} mm, first in line 2\\.`));
    await page.locator("#send-program:disabled").waitFor();
    await page.locator("#outline:disabled").waitFor();
    await answers(page, "$J=G91 X-20 F2800");
    await rests(page, "x");
    await page.click("#zero-x");
    await reads(page, "fits", /^It fits/);
    await page.locator("#send-program:enabled").waitFor();
    await put(page, "program", "G21 G91\nG1 X5 F600\nX-200\n");
    await reads(page, "fits", /^It does not fit\. X would go to -?[\d.]+ mm, which is|^It fits/);
  },

  async [`${machine.name}: what is not homed is said, and nothing is refused for it`]() {
    const page = await operated(machine);
    await put(page, "program", SQUARE);
    await reads(page, "fits", /^Whether it fits is not known: X, Y are not homed\.$/);
    await page.click("#home-x");
    await is(page, "Home");
    await is(page, "Idle");
    await reads(page, "homed-now", /^X only$/);
    await reads(page, "fits", /^Whether it fits is not known: Y is not homed\.$/);
    await page.locator("#send-program:enabled").waitFor();
  },

  async [`${machine.name}: what is made stands out while the program goes, and the time left is that of what is ahead`]() {
    const page = await operated(machine);
    await put(page, "program", SQUARE);
    await reads(page, "sending-what", /about 8 s/);
    await page.click("#send-program");
    await is(page, "Run");
    assert.equal(await page.getAttribute("#path", "class"), "ahead");
    await reads(page, "sending-now", /^line 4 of 5 is under way, about [234] s left$/);
    const made = await colourAt(page, "done", 0.5);
    const all = await colourAt(page, "path", 0.5);
    assert.ok(made.length > 50 && made.at[3] > 100, "a side is made");
    assert.ok(made.at.slice(0, 3).every((part, index) => Math.abs(part - all.at[index]) < 6), `it has its colour: ${made.at}, ${all.at}`);
    await endsWith(page, machine, "Done: 5 lines\\.");
    assert.equal((await page.getAttribute("#path", "class")) ?? "", "");
  },

  async [`${machine.name}: the tool goes round the outline, and to a typed place`]() {
    const page = await operated(machine);
    await put(page, "program", "G21 G90\nG0 X2 Y1\nG1 X9 Y4 F1500\n");
    await page.locator("#outline:enabled").waitFor();
    await reads(page, "sending-what", /X 0\.0 to 9\.0, Y 0\.0 to 4\.0/);
    await page.click("#outline");
    await is(page, "Jog");
    await is(page, "Idle");
    assert.deepEqual(await sent(page, 5), [[0, 0], [9, 0], [9, 4], [0, 4], [0, 0]].map(([x, y]) => `$J=G53 G21 G90 X${x.toFixed(3)} Y${y.toFixed(3)} F1500`));
    await page.click("#go");
    await reads(page, "go-trouble", /at least one/);
    await page.fill("#go-x", "7.5");
    await page.fill("#go-z", "3");
    await page.click("#go");
    await arrives(page, "x", "7.500");
    await arrives(page, "z", "3.000");
    assert.deepEqual(await sent(page, 2), ["$J=G21 G90 Z3 F1500", "$J=G21 G90 X7.5 F1500"], "up goes first");
    await page.fill("#go-z", "1");
    await page.fill("#go-x", "1");
    await page.click("#go");
    await arrives(page, "x", "1.000");
    await arrives(page, "z", "1.000");
    assert.deepEqual(await sent(page, 2), ["$J=G21 G90 X1 F1500", "$J=G21 G90 Z1 F1500"], "down goes last");
  },

  async [`${machine.name}: a gamepad jogs while its stick is held; one button holds, another stops`]() {
    const page = await operated(machine);
    await page.evaluate(() => {
      const buttons = Array.from({ length: 16 }, () => ({ pressed: false }));
      const gamepad = (window.gamepad = { id: "A gamepad", mapping: "standard", axes: [0, 0, 0, 0], buttons });
      navigator.getGamepads = () => [null, gamepad];
      window.dispatchEvent(Object.assign(new Event("gamepadconnected"), { gamepad }));
    });
    await reads(page, "gamepad", /^A gamepad: left stick/);
    const tilts = (stick, value) => page.evaluate(([stick, value]) => (window.gamepad.axes[stick] = value), [stick, value]);
    const presses = (button, pressed = true) => page.evaluate(([button, pressed]) => (window.gamepad.buttons[button].pressed = pressed), [button, pressed]);
    const passes = (axis, mm) => page.waitForFunction(([axis, mm]) => Number(document.getElementById(`place-${axis}`).textContent) > mm, [axis, mm]);
    await tilts(0, 0.4);
    await page.waitForTimeout(300);
    assert.deepEqual([await page.locator("#state").textContent(), await rests(page, "x")], ["Idle", 0], "it is near its middle");
    await tilts(0, 1);
    await passes("x", 8);
    await tilts(0, 0);
    const x = await rests(page, "x");
    assert.ok(x < 8 + 25, `${x} mm`);
    // Up is less.
    await tilts(3, -1);
    await passes("z", 2);
    await tilts(3, 0);
    await is(page, "Idle");
    await presses(12);
    await passes("y", 2);
    await presses(12, false);
    assert.equal(await rests(page, "x"), x);
    await sends(page, "G21 G91\nG1 X40 F600\n");
    await is(page, "Run");
    await presses(1);
    await is(page, "Hold");
    await presses(1, false);
    await page.locator("#resume:enabled").click();
    await is(page, "Run");
    await presses(0);
    await reads(page, "sending-now", /Stopped/);
    assert.ok((await rests(page, "x")) < x + 40);
  },

  async [`${machine.name}: a macro sends its lines until one is refused; ! and ~ hold and resume`]() {
    const page = await operated(machine);
    await page.locator("#macros-text").evaluate((text) => Object.assign(text, { value: "[Far]\nG21 G91\nG1 X40 F1200\n\n[Wrong]\nG42 X1\nG0 X5\n" }).dispatchEvent(new Event("input")));
    await page.click("#macros button:text-is('Far')");
    await is(page, "Run");
    await page.keyboard.press("!");
    await is(page, "Hold");
    await page.locator("#resume:enabled").waitFor();
    assert.ok((await place(page, "x")) < 40);
    await page.focus("#line");
    await page.keyboard.type("~");
    await page.fill("#line", "");
    assert.equal(await page.locator("#state").textContent(), "Hold:0", "who types does not resume");
    await page.locator("#h-macros").click();
    await page.locator("#line").blur();
    await page.keyboard.press("~");
    await is(page, "Idle");
    await stands(page, "x", 40);
    await page.click("#macros button:text-is('Wrong')");
    await page.locator("#log .wrong", { hasText: "error:20" }).waitFor();
    await stands(page, "x", 40);
    await page.reload();
    await page.locator("#macros button", { hasText: "Far" }).waitFor();
  },

  async [`${machine.name}: a program begins at a line, from what the lines before it leave, or it is said why not`]() {
    const page = await operated(machine);
    const program = "G21 G91 (relative)\nM3 S400\nG1 Z2 F600\nG1 X5\nG1 Y5\nG1 Z-1\nG1 X5\nG1 Y-3 F900\nG1 X-2\nG1 Z1\n";
    await put(page, "program", program);
    await page.fill("#from-line", "3");
    await reads(page, "from-what", /^Line 3 is so near the beginning/);
    await page.locator("#send-program:disabled").waitFor();
    await page.fill("#from-line", "99");
    await reads(page, "from-what", /^There is no line 99: the program has 11\.$/);
    await page.fill("#from-line", "1");
    await page.locator("#send-program:enabled").waitFor();
    // Whoever presses before it is known from where sends nothing: not the whole program either.
    await page.evaluate(() => {
      Object.assign(document.getElementById("from-line"), { value: "8" }).dispatchEvent(new Event("input"));
      document.getElementById("send-program").disabled = false;
      document.getElementById("send-program").click();
    });
    await reads(page, "from-what", /^From line 8: up to Z 2\.000, over to X10\.000 Y5\.000, M3 S400, down to Z1\.000 of the machine with .*G91.*F600/);
    assert.equal(await page.locator("#log .sent", { hasText: "the program" }).count(), 0);
    await reads(page, "sending-what", /from line 8: 9 lines, about \d+ s, X 0\.0 to 10\.0, Y 0\.0 to 5\.0, Z 0\.0 to 2\.0/);
    await page.locator("#send-program:enabled").click();
    await is(page, "Run");
    await reads(page, "tool-now", /^on, M3, S 400 now$/);
    await endsWith(page, machine, "Done: 9 lines\\.");
    for (const [axis, mm] of [["x", "8.000"], ["y", "2.000"], ["z", "2.000"]]) await arrives(page, axis, mm);
    await put(page, "program", "G21\nG1 X1 F600\nG10 L20 P1 X0\nG1 X2\nG1 X3\nG1 X4\nG1 X5\nG1 X6\n");
    await page.fill("#from-line", "8");
    await reads(page, "from-what", /^Line 3 sets offsets or places \(G10\)/);
  },

  async [`${machine.name}: a program that waits for a person says why, in its own words`]() {
    const page = await operated(machine);
    await put(page, "program", "G21 G91\nG1 X3 F1200\n(turn the part over)\nM0\nG1 X3\n");
    await page.locator("#send-program:enabled").click();
    await is(page, "Hold");
    await reads(page, "sending-now", /^The program waits in line 4: turn the part over\. Resume goes on/);
    await page.locator("#resume:enabled").click();
    await endsWith(page, machine, "Done: 4 lines\\.");
    await stands(page, "x", 6);
  },
});
