// The board of the page's server.
import assert from "node:assert/strict";
import { opened, paths } from "./harness.mjs";

const is = (page, state) => page.locator(`#state[data-state=${state}]`).waitFor();

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

  async "a second page is told that the first has the board, and takes it when that is closed"() {
    const first = await opened(paths.board);
    await is(first, "Idle");
    const second = await opened(paths.board);
    await second.locator("#link-trouble", { hasText: "another page has the board: close that one, then connect again" }).waitFor();
    assert.equal(await second.locator("#connect").textContent(), "Connect again");
    await is(first, "Idle");
    await first.click("#connect");
    await is(first, "Off");
    await second.click("#connect");
    await is(second, "Idle");
    assert.ok(await second.locator("#link-trouble").isHidden());
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
