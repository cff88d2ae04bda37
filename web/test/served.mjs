// The board of the page's server, and the job that the server holds.
import assert from "node:assert/strict";
import { opened, paths, put } from "./harness.mjs";

const is = (page, state) => page.locator(`#state[data-state=${state}]`).waitFor();
const says = (page, words) => page.locator("#sending-now", { hasText: words }).waitFor();

/** Moves of 1 mm to and fro, which end where they began. */
const toAndFro = (lines) => `G21 G91 F600\n${"G1 X1\nG1 X-1\n".repeat(lines / 2)}`;

/** A page with the board at rest, and nothing left of a job before. */
async function rested() {
  const page = await opened(paths.board);
  await is(page, "Idle");
  return page;
}

async function sends(page, program) {
  await put(page, "program", program);
  await page.locator("#send-program:enabled").click();
}

export const tests = {
  async "the board of the server is attached by its address, which does not keep the token"() {
    const page = await opened(paths.board);
    await is(page, "Idle");
    assert.equal(new URL(page.url()).hash, "#operate");
    assert.equal(await page.locator("#which").inputValue(), "server");
    assert.match(await page.locator("#what").textContent(), /^The board of this server/);
    assert.match(await page.locator("#what-now").textContent(), /real machine/);
    assert.equal(await page.locator("#homed-now").textContent(), "unknown");
    assert.ok(await page.locator("#simulated").isHidden());
    await page.reload();
    await is(page, "Idle");
    await page.selectOption("#which", "simulated");
    await is(page, "Idle");
    assert.equal(await page.locator("#homed-now").textContent(), "no");
    assert.ok(await page.locator("#simulated").isVisible());
  },

  async "two pages have the board: each hears its own answers, and both see the machine"() {
    const [first, second] = [await rested(), await rested()];
    for (const [page, line, answer] of [[first, "$G", /^\[GC:/], [second, "G42", /^error:20: /]]) {
      await page.fill("#line", line);
      await page.locator("#line").press("Enter");
      await page.locator("#log div", { hasText: answer }).waitFor();
    }
    assert.equal(await second.locator("#log div", { hasText: /^\[GC:/ }).count(), 0);
    assert.equal(await first.locator("#log div", { hasText: /^error:20/ }).count(), 0);
    await first.locator("#pad .xp").hover();
    await first.mouse.down();
    await is(second, "Jog");
    await second.close();
    await first.waitForTimeout(300);
    assert.equal(await first.locator("#state").textContent(), "Jog", "a page that goes leaves the jog of another");
    await first.mouse.up();
    await is(first, "Idle");
  },

  async "a job lives on the server: through a reload, without a page, and for a second page"() {
    const first = await rested();
    await sends(first, toAndFro(120));
    await is(first, "Run");
    const progress = /^line \d+ of 121 is under way/;
    await says(first, progress);
    await first.reload();
    await is(first, "Run");
    await says(first, progress);
    assert.ok(await first.locator("#stop-program").isVisible());
    const second = await opened(paths.board);
    await says(second, progress);
    assert.ok(await second.locator("#send-program").isDisabled());
    await first.close();
    await second.close();
    const third = await opened(paths.board);
    await is(third, "Run");
    await says(third, "Done: 121 lines.");
    await third.reload();
    await says(third, "Done: 121 lines.");
  },

  async "a second page holds, resumes and stops the job of the first"() {
    const [first, second] = [await rested(), await rested()];
    await sends(first, toAndFro(400));
    await is(second, "Run");
    await second.click("#hold");
    await is(first, "Hold");
    await second.locator("#resume:enabled").click();
    await is(first, "Run");
    await second.click("#stop-program");
    await says(first, /Stopped by a reset, line \d+ was next/);
    await says(second, /Stopped by a reset, line \d+ was next/);
    await is(first, "Idle");
  },

  async "a refused line ends the job in words on every page, and what must not be sent is not begun"() {
    const [first, second] = [await rested(), await rested()];
    await sends(first, "G21 G91\nG42 X1\nG1 X50 F1200\n");
    for (const page of [first, second]) await says(page, /Stopped: line 2 `G42 X1` was refused\. error:20: ./);
    await is(first, "Idle");
    await sends(first, "G0 X5 ?\n");
    await says(first, /^Not sent: line 1: '\?' is a real-time command/);
  },

  async "a page whose script hangs has gone, and finds the job when it connects again"() {
    const page = await rested();
    await sends(page, toAndFro(200));
    await is(page, "Run");
    await page.evaluate(() => {
      const until = performance.now() + 4000;
      while (performance.now() < until);
    });
    await page.locator("#link-trouble", { hasText: "this page has not answered for 2 s" }).waitFor();
    await says(page, /^The server goes on with .*, as long as it runs/);
    await page.click("#connect");
    await is(page, "Run");
    await says(page, / of 201 /);
    await page.click("#stop-program");
    await says(page, /Stopped by a reset/);
    await is(page, "Idle");
  },

  async "without the token the page says which address has it"() {
    const page = await opened(new URL(paths.board).origin);
    await page.click("#tab-operate");
    await is(page, "Idle");
    await page.selectOption("#which", "server");
    await page.click("#connect");
    await page.locator("#which-trouble", { hasText: "open the address that isostep web has printed" }).waitFor();
  },
};
