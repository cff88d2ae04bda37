// What axe-core finds against the page: in every view, light and dark, on a desk and on a phone.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { hasEnded, opened, PHONE, WIDE } from "./harness.mjs";

const axe = await readFile(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

/** No rule is broken, and each complaint names where. */
async function expectClean(page, where) {
  const { violations, passes } = await page.evaluate(() => window.axe.run());
  const found = violations.flatMap(({ id, nodes }) => nodes.map(({ target, failureSummary }) => `${id}: ${target}: ${failureSummary.replaceAll("\n", " ")}`));
  assert.ok(passes.length > 20, `only ${passes.length} rules had something to look at`);
  assert.deepEqual(found, [], where);
}

function clean(colorScheme, viewport) {
  return async () => {
    // What fades in would be looked at while it is pale.
    const page = await opened("", { viewport, colorScheme, before: axe, reducedMotion: "reduce" });
    await hasEnded(page);
    await page.locator("#advice tr").first().waitFor();
    await expectClean(page, "run");
    await page.click("#tab-profiles");
    await page.locator("#profiles-rows th").first().waitFor();
    await expectClean(page, "profiles");
    await page.click("#tab-operate");
    await page.locator("#state[data-state=Idle]").waitFor();
    await expectClean(page, "operate, Idle");
    await page.locator("#stop-button").check();
    await page.locator("#state[data-state=Alarm]").waitFor();
    await page.locator("#alarm").waitFor();
    await expectClean(page, "operate, Alarm");
    await page.click("#tab-settings");
    await page.locator(".setting").first().waitFor();
    await page.locator(".setting[data-number='120'] input").fill("80");
    await page.locator("#pending").waitFor();
    await expectClean(page, "settings");
  };
}

const screens = Object.entries({ wide: WIDE, narrow: PHONE });
const schemes = ["light", "dark"].flatMap((scheme) => screens.map(([name, viewport]) => [`everybody can use the page: ${scheme}, ${name}`, clean(scheme, viewport)]));
export const tests = Object.fromEntries(schemes);
