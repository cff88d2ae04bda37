// How the page looks, on every screen.
import assert from "node:assert/strict";
import { join } from "node:path";
import { hasEnded, opened, paths, PHONE, WIDE } from "./harness.mjs";

export const tests = {
  async "tabs, labels and widths are for everybody"() {
    const page = await opened("", { viewport: PHONE });
    await hasEnded(page);
    for (const tab of ["run", "operate", "settings"]) {
      await page.click(`#tab-${tab}`);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.equal(wide, 0, `${tab} is ${wide} pixels too wide for a phone`);
    }
    const nameless = await page.evaluate(() => [...document.querySelectorAll("input, select, textarea, button")]
      .filter((control) => !control.labels?.length && !control.getAttribute("aria-label") && !control.textContent.trim())
      .map((control) => control.id));
    assert.deepEqual(nameless, []);
  },

  async "pictures of the page"() {
    for (const colorScheme of ["light", "dark"]) {
      for (const [name, viewport] of Object.entries({ wide: WIDE, narrow: PHONE })) {
        const page = await opened("", { viewport, colorScheme });
        await hasEnded(page);
        await page.locator("#time").fill("50");
        await page.screenshot({ path: join(paths.shots, `run-${colorScheme}-${name}.png`), fullPage: true });
        await page.click("#tab-operate");
        await page.locator("#state[data-state=Idle]").waitFor();
        await page.screenshot({ path: join(paths.shots, `operate-${colorScheme}-${name}.png`), fullPage: true });
        await page.click("#tab-settings");
        await page.locator(".setting").first().waitFor();
        await page.screenshot({ path: join(paths.shots, `settings-${colorScheme}-${name}.png`), fullPage: true });
        await page.context().close();
      }
    }
  },
};
