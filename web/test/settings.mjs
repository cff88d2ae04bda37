// The form of settings, by what the machine lists.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { answers, is, operated, reads, sends, setting } from "./machine.mjs";

const field = (page, number) => page.locator(`.setting[data-number="${number}"]`);
const enter = (page, number, value) => field(page, number).locator("input").fill(value);

async function send(page) {
  await page.locator("#send-settings:enabled").click();
  await page.waitForFunction(() => /set|Nothing was sent/.test(document.getElementById("settings-status").textContent));
}

async function load(page, text) {
  await page.setInputFiles("#settings-file", { name: "mine.txt", mimeType: "text/plain", buffer: Buffer.from(text) });
  await reads(page, "settings-status", /^mine\.txt/);
}

async function saved(page, button) {
  const [download] = await Promise.all([page.waitForEvent("download"), page.click(button)]);
  return readFile(await download.path(), "utf8");
}

export const tests = (machine) => ({
  async [`${machine.name}: every setting that the machine lists has a row with its name, unit and default`]() {
    const page = await operated(machine, "settings");
    const listed = (await answers(page, "$$")).flatMap((line) => /^\$(\d+)=/.exec(line)?.[1] ?? []);
    const shown = await page.locator(".setting").evaluateAll((rows) => rows.map((row) => row.dataset.number));
    assert.deepEqual(shown.toSorted((a, b) => a - b), listed.toSorted((a, b) => a - b));
    const top = field(page, 111);
    assert.equal(await top.locator(".name").textContent(), "Y top speed");
    assert.equal(await top.locator(".unit").textContent(), "mm/min");
    assert.equal(Number(await top.locator("input").inputValue()), await setting(page, 111));
    assert.equal(await page.locator("#setting-groups", { hasText: "Not described" }).count(), 0);
  },

  async [`${machine.name}: what is entered is listed, then set; a number, a switch, a mask, a choice`]() {
    const page = await operated(machine, "settings");
    await enter(page, 120, "75.5");
    await field(page, 21).getByRole("switch").uncheck();
    await field(page, 3).getByLabel("direction invert: Y").check();
    await field(page, 950).locator("select").selectOption("1");
    assert.match(await page.locator("#pending-list").textContent(), /\$120 X acceleration: 50 → 75.5 mm\/s²/);
    assert.equal(await setting(page, 120), 50, "nothing is sent before a person says so");
    await send(page);
    assert.equal(await page.locator("#settings-status").textContent(), "4 set.");
    for (const [number, value] of [[120, 75.5], [21, 0], [3, 2], [950, 1]]) assert.equal(await setting(page, number), value, `$${number}`);
    await page.check("#only-differences");
    assert.equal(await page.locator(".setting:visible").count(), 4);
    assert.equal(await field(page, 120).locator(".default").textContent(), "default 50");
    assert.equal(await saved(page, "#save-differences"), "$3=2\n$21=0\n$120=75.500\n$950=1\n");
  },

  async [`${machine.name}: a refusal stands at its row in the machine's words, and nothing else was sent`]() {
    const page = await operated(machine, "settings");
    await enter(page, 120, "80");
    await enter(page, 31, "5000");
    await send(page);
    await reads(page, "settings-status", /^Nothing was sent: \$31=5000 is not below/);
    assert.match(await field(page, 31).locator(".refused").textContent(), /^\$31=5000 is not below the S at full duty, \$30=1000 rpm: lower/);
    assert.equal(await setting(page, 120), 50);
    await enter(page, 31, "1!");
    await send(page);
    assert.match(await field(page, 31).locator(".refused").textContent(), /^`1!` is no number/);
    await page.click("#discard-settings");
    assert.ok(await page.locator("#pending").isHidden());
    // What this machine's step outputs carry is known to it alone.
    await enter(page, 120, "80");
    await enter(page, 100, "10000");
    await enter(page, 110, "30000");
    await send(page);
    assert.match(await page.locator("#settings-status").textContent(), /^3 set\. .*step outputs carry.*nothing moves/);
    assert.equal(await page.locator(".refused:visible").count(), 0);
    assert.equal(await setting(page, 120), 80);
  },

  async [`${machine.name}: a file is looked at before it is sent, in whichever order its lines are`]() {
    const page = await operated(machine, "settings");
    await load(page, "; mine\n$31=2000\n$30=3000\n$27=100\n$130=500\n$131=500\n$132=500\n$999=1\n$0=2\nok\n");
    await reads(page, "settings-status", /^mine\.txt: 6 of 8 values are not in force\. Left out.*\$999\.$/);
    assert.equal(await page.locator("#pending-list li").count(), 6);
    assert.equal(await setting(page, 30), 1000, "looked at, not sent");
    await send(page);
    assert.equal(await page.locator("#settings-status").textContent(), "6 set.");
    for (const [number, value] of [[30, 3000], [31, 2000], [27, 100], [132, 500]]) assert.equal(await setting(page, number), value);
    const all = await saved(page, "#save-settings");
    assert.match(all, /^\$0=2\n\$1=255\n/);
    await load(page, all);
    assert.match(await page.locator("#settings-status").textContent(), /: 0 of \d+ values are not in force\.$/);
    assert.ok(await page.locator("#pending").isHidden());
    // On the way, in the order of the form, these do not work together.
    await load(page, "$132=50\n$27=2\n$30=1000\n$31=0\n$20=0\n$22=0\n");
    await send(page);
    assert.equal(await page.locator("#settings-status").textContent(), "6 set.");
    for (const [number, value] of [[132, 50], [27, 2], [30, 1000], [31, 0], [22, 0], [20, 0]]) assert.equal(await setting(page, number), value);
    await load(page, "$20=1\n$22=1\n");
    await send(page);
    assert.equal(await setting(page, 20), 1, "it needs $22=1, which comes behind it");
    await load(page, "hello\n");
    assert.match(await page.locator("#settings-status").textContent(), /no \$n=v line/);
  },

  async [`${machine.name}: defaults are restored after a question`]() {
    const page = await operated(machine, "settings");
    await enter(page, 120, "80");
    await send(page);
    await page.click("#restore-settings");
    await page.click("#restore-no");
    assert.equal(await setting(page, 120), 80);
    await page.click("#restore-settings");
    await page.click("#restore-yes");
    await reads(page, "settings-status", /defaults/);
    await is(page, "Idle");
    await page.waitForFunction(() => !document.querySelector(".setting.differs"));
    assert.equal(await setting(page, 120), 50);
  },

  async [`${machine.name}: what a person is typing stays when the machine has other settings`]() {
    const page = await operated(machine, "settings");
    const typed = field(page, 120).locator("input");
    // On the way to 50.5 it is the number that is in force.
    await typed.fill("50.");
    await answers(page, "$121=60");
    assert.equal(await field(page, 121).locator("input").inputValue(), "60");
    assert.equal(await typed.inputValue(), "50.");
    await page.keyboard.type("5");
    await answers(page, "$120=70");
    assert.equal(await typed.inputValue(), "50.5");
    assert.match(await page.locator("#pending-list").textContent(), /^\$120 X acceleration: 70 → 50\.5 mm\/s²$/);
    await send(page);
    assert.equal(await setting(page, 120), 50.5);
    await answers(page, "$120=80");
    assert.equal(await typed.inputValue(), "80", "what was sent is not entered any more");
  },

  async [`${machine.name}: settings wait while the machine moves`]() {
    const page = await operated(machine, "settings");
    await enter(page, 120, "80");
    await page.click("#tab-operate");
    await sends(page, "G21 G91\nG1 X40 F1200\nG1 X-40\n");
    await is(page, "Run");
    await page.click("#tab-settings");
    assert.ok(await page.locator("#send-settings").isDisabled());
    await reads(page, "settings-when", /in Idle and Alarm; it is in Run/);
    await page.keyboard.press("Escape");
    await is(page, "Idle");
    await send(page);
    assert.equal(await setting(page, 120), 80);
  },
});
