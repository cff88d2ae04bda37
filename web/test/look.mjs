// How the page looks, on every screen.
import assert from "node:assert/strict";
import { join } from "node:path";
import { hasEnded, opened, paths, PHONE, WIDE } from "./harness.mjs";

export const tests = {
  async "tabs, labels and widths are for everybody"() {
    const page = await opened("", { viewport: PHONE });
    await hasEnded(page);
    for (const tab of ["run", "operate", "settings", "profiles"]) {
      await page.click(`#tab-${tab}`);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
      assert.equal(wide, 0, `${tab} is ${wide} pixels too wide for a phone`);
    }
    const nameless = await page.evaluate(() => [...document.querySelectorAll("input, select, textarea, button")]
      .filter((control) => !control.labels?.length && !control.getAttribute("aria-label") && !control.textContent.trim())
      .map((control) => control.id));
    assert.deepEqual(nameless, []);
  },

  async "what is touched is large enough for a finger"() {
    const page = await opened("#operate", { viewport: PHONE, hasTouch: true, isMobile: true });
    await page.locator("#state[data-state=Idle]").waitFor();
    for (const tab of ["operate", "settings"]) {
      await page.click(`#tab-${tab}`);
      await page.locator(tab === "settings" ? ".setting >> nth=0" : "#pad").waitFor();
      const small = await page.locator(`#view-${tab}, #bar`).locator("button, select, input:not([type=checkbox]), label:has(input)").evaluateAll((targets) => targets
        .filter((target) => target.offsetParent && target.type !== "radio" && target.getBoundingClientRect().height < 43.9)
        .map((target) => target.id || target.textContent));
      assert.deepEqual(small, []);
    }
  },

  async "pictures of the page"() {
    const picture = async (page, name) => {
      // Whole pages, with the bar at their end.
      const { width } = page.viewportSize();
      await page.setViewportSize({ width, height: await page.evaluate(() => document.documentElement.scrollHeight) });
      await page.screenshot({ path: join(paths.shots, `${name}.png`), fullPage: true });
    };
    for (const colorScheme of ["light", "dark"]) {
      for (const [name, viewport] of Object.entries({ wide: WIDE, narrow: PHONE })) {
        const page = await opened("", { viewport, colorScheme });
        await hasEnded(page);
        await page.locator("#time").fill("50");
        await page.locator("#advice tr").first().waitFor();
        // As a person sees it first: the picture in docs.
        await page.screenshot({ path: join(paths.shots, `first-${colorScheme}-${name}.png`) });
        await page.screenshot({ path: join(paths.shots, `run-${colorScheme}-${name}.png`), fullPage: true });
        await page.selectOption("#plane", "3D");
        await page.locator("#space").waitFor();
        await page.locator("#picture").screenshot({ path: join(paths.shots, `space-${colorScheme}-${name}.png`) });
        await page.click("#tab-profiles");
        await page.locator("#profiles-rows th").first().waitFor();
        await page.screenshot({ path: join(paths.shots, `profiles-${colorScheme}-${name}.png`), fullPage: true });
        await page.click("#tab-operate");
        await page.locator("#state[data-state=Idle]").waitFor();
        await picture(page, `operate-${colorScheme}-${name}`);
        await page.click("#tab-settings");
        await page.locator(".setting").first().waitFor();
        await page.locator(".setting[data-number='120'] input").fill("80");
        await picture(page, `settings-${colorScheme}-${name}`);
        await page.context().close();
      }
    }
  },
};
