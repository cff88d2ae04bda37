// How the page looks, on every screen.
import assert from "node:assert/strict";
import { join } from "node:path";
import { hasEnded, opened, paths, PHONE, put, run, WIDE } from "./harness.mjs";
import { answers, home, is, reads, stands } from "./machine.mjs";

export const tests = {
  async "tabs, labels and widths are for everybody"() {
    const page = await opened("", { viewport: PHONE });
    await hasEnded(page);
    for (const width of [PHONE.width, 320, 2560]) {
      await page.setViewportSize({ width, height: PHONE.height });
      for (const tab of ["run", "operate", "settings", "profiles"]) {
        await page.click(`#tab-${tab}`);
        const wide = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
        assert.equal(wide, 0, `${tab} is ${wide} pixels too wide for ${width}`);
      }
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

  async "pictures of the page, in every view and state"() {
    for (const colorScheme of ["light", "dark"]) {
      for (const [name, viewport] of Object.entries({ 320: { width: 320, height: 700 }, 390: PHONE, 1440: WIDE, 2560: { width: 2560, height: 1400 } })) {
        const page = await opened("", { viewport, colorScheme, ...(viewport.width <= PHONE.width && { hasTouch: true, isMobile: true }) });
        const picture = (what, options) => page.screenshot({ path: join(paths.shots, `${what}-${colorScheme}-${name}.png`), ...options });
        const whole = { fullPage: true };
        // It would lie over the middle of a whole page.
        await page.evaluate(() => (document.getElementById("bar").style.position = "static"));
        await hasEnded(page);
        await page.locator("#time").fill("12");
        await page.locator("#advice tr").first().waitFor();
        await page.evaluate(() => {
          document.activeElement.blur();
          scrollTo(0, 0);
        });
        // As a person sees it first: the picture in docs.
        await picture("first");
        await picture("run", whole);
        await run(page, "G21 G91\nG42 X1\nG1 X5 F600\n");
        await picture("run-refused", whole);
        await page.selectOption("#programs", "two_tools.nc");
        await hasEnded(page);
        await page.selectOption("#tone", "lost");
        await page.selectOption("#plane", "3D");
        await page.locator("#space").waitFor();
        await page.locator("#picture").screenshot({ path: join(paths.shots, `space-${colorScheme}-${name}.png`) });
        await page.selectOption("#plane", "XY");
        await page.selectOption("#tone", "speed");
        await page.selectOption("#programs", "engraving.nc");
        await hasEnded(page);
        await page.click("#tab-profiles");
        await page.locator("#profiles-rows th").first().waitFor();
        await picture("profiles", whole);
        await page.click("#tab-operate");
        await is(page, "Idle");
        await reads(page, "sending-what", /about/);
        await picture("machine-idle", whole);
        await home(page);
        await answers(page, "$J=G90 X120 Y90 F2800");
        await stands(page, "x", 120);
        await page.click("#zero-all");
        await reads(page, "fits", /^It fits/);
        await page.click("#send-program");
        await reads(page, "sending-now", /^line 1[4-9] of/);
        await picture("machine-run");
        await page.click("#stop");
        await is(page, "Idle");
        await put(page, "program", "G21 G91\nG1 X400 F2000\n");
        await reads(page, "fits", /^It does not fit/);
        await picture("machine-does-not-fit", whole);
        await page.evaluate(() => document.getElementById("stop-button").click());
        await is(page, "Alarm");
        await picture("machine-alarm", whole);
        await page.click("#tab-settings");
        await page.locator(".setting").first().waitFor();
        await page.locator(".setting[data-number='120'] input").fill("80");
        await picture("settings", whole);
        await page.context().close();
      }
    }
  },
};
