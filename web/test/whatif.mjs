// Settings that are tried beside a program, a machine's own, and a link that has both.
import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { deflateRawSync, inflateRawSync } from "node:zlib";
import { hasEnded, longProgram, opened, paths, put, run } from "./harness.mjs";

const at = (path) => fileURLToPath(new URL(`../../${path}`, import.meta.url));
const LISTED = at("crates/report/tests/listings/longmill-mk3.txt");
const ASKS = "Move a setting to see what becomes of the time.";
const CORNERS = "G21 G91\nG1 X30 F2400\nY30\nX-30\nY-30\nG4 P0.2\n";

const number = (page, setting) => page.locator(`.knob input[type=number][data-number="${setting}"]`);
const slider = (page, setting) => page.locator(`.knob:has([data-number="${setting}"]) input[type=range]`);
const choice = (page, setting) => page.locator(`.knob select[data-number="${setting}"]`);
const headline = (page) => page.locator("#what-if-time").textContent();
const settings = (page) => page.inputValue("#settings");
const text = (page) => page.evaluate(() => [...document.getElementById("program").shadowRoot.querySelectorAll(".cm-line")].map((line) => line.textContent).join("\n"));

/** What the knobs are made of comes from the machine. */
const hasKnobs = (page) => page.locator(".knob").first().waitFor();

/** Waits for the answer, and returns both times. */
async function becomes(page) {
  await page.waitForFunction(() => / becomes .+, /.test(document.getElementById("what-if-time").textContent));
  const [, before, after] = /^(.+) becomes (.+?), /.exec(await headline(page));
  return { before, after };
}

/** How long the program of the last run takes, as a clock shows it. */
async function taken(page) {
  const words = await page.locator("#figures div", { hasText: "the program takes" }).locator("dd").textContent();
  const [, minutes, seconds] = /^(\d+) min (\d+) s$/.exec(words) ?? [];
  return minutes ? `${minutes}:${seconds.padStart(2, "0")}` : words;
}

/** Drops a file somewhere, and returns whether the browser was kept from opening it. */
const drop = (page, selector, name, content) => page.locator(selector).evaluate((target, [name, content]) => {
  const dataTransfer = new DataTransfer();
  dataTransfer.items.add(new File([content], name));
  const init = { dataTransfer, bubbles: true, cancelable: true, composed: true };
  const over = new DragEvent("dragover", init);
  target.dispatchEvent(over);
  const dropped = new DragEvent("drop", init);
  target.dispatchEvent(dropped);
  return over.defaultPrevented && dropped.defaultPrevented;
}, [name, content]);

const asAddress = (bytes) => bytes.toString("base64url");
const folded = (value) => asAddress(deflateRawSync(Buffer.from(JSON.stringify(value))));

async function told(address) {
  const page = await opened(address);
  const item = page.locator("#troubles li").first();
  await item.waitFor();
  const words = await item.textContent();
  await run(page, "G0 X1\n");
  assert.match(await page.locator("#checks-total").textContent(), /all 9 kept/, "the page lives on");
  return words;
}

export const tests = {
  async "what is moved says what becomes of the time, which is that of a run with it"() {
    const page = await opened();
    await hasEnded(page);
    await hasKnobs(page);
    // One homes, so that its edges are made; the other does not; and one takes minutes.
    for (const program of [await readFile(at("programs/engraving.nc"), "utf8"), CORNERS, await readFile(at("programs/parking.nc"), "utf8")]) {
      await run(page, program);
      await hasEnded(page);
      assert.equal(await headline(page), ASKS);
      const asSet = await taken(page);
      await slider(page, 120).fill("0.301");
      assert.equal(await number(page, 120).inputValue(), "100");
      const moved = await becomes(page);
      assert.equal(moved.before, asSet);
      await page.click("#what-if-back");
      assert.equal(await headline(page), ASKS);
      assert.equal(await number(page, 120).inputValue(), "50");
      assert.equal(await slider(page, 120).inputValue(), "0");
      await number(page, 120).fill("100");
      assert.deepEqual(await becomes(page), moved, "there and back");
      await page.click("#what-if-keep");
      assert.equal(await settings(page), "$120=100\n$121=100\n");
      await page.locator("#run:enabled").waitFor();
      await hasEnded(page);
      assert.equal(await taken(page), moved.after);
      assert.notEqual(moved.after, asSet);
    }
  },

  async "what is kept replaces its own lines, and leaves the others as they are"() {
    const page = await opened();
    await hasEnded(page);
    await hasKnobs(page);
    await run(page, CORNERS, "; mine\n$120=80 (X)\n$121=40\n$110=3000\n$920=60\n");
    await hasEnded(page);
    await number(page, 120).fill("160");
    assert.equal(await page.locator(".knob:has([data-number='120']) small").textContent(), "$120, $121 80, $920 120");
    await becomes(page);
    await page.click("#what-if-keep");
    assert.equal(await settings(page), "; mine\n$120=160\n$121=80\n$110=3000\n$920=120\n");
  },

  async "the last that is moved is the one that is told"() {
    const page = await opened();
    await hasEnded(page);
    await hasKnobs(page);
    await run(page, longProgram(20_000));
    await hasEnded(page);
    await page.evaluate(() => {
      window.told = [];
      new MutationObserver(() => window.told.push(document.getElementById("what-if-time").textContent)).observe(document.getElementById("what-if-time"), { childList: true });
    });
    await number(page, 120).fill("60");
    await page.waitForFunction(() => document.getElementById("what-if-progress").value > 0);
    await number(page, 120).fill("200");
    const last = await becomes(page);
    const all = await page.evaluate(() => window.told.filter((words) => / becomes .+, /.test(words)));
    assert.equal(all.length, 1, all.join("\n"));
    await run(page, longProgram(20_000), "$120=200\n$121=200\n");
    assert.equal(await taken(page), last.after);
  },

  async "what the machine refuses is told in its words"() {
    const page = await opened();
    await hasEnded(page);
    await hasKnobs(page);
    await run(page, CORNERS, "$100=400\n");
    await hasEnded(page);
    await number(page, 110).fill("60000");
    await page.locator("#what-if-refused", { hasText: "$110=60000 is above the 37202 mm/min that the step outputs carry with $0=2 at $100=400" }).waitFor();
    assert.equal(await headline(page), "");
    await page.click("#what-if-back");
    assert.equal(await page.locator("#what-if-refused").textContent(), "");
    await number(page, 930).isDisabled();
    await choice(page, 940).selectOption("1");
    assert.ok(await number(page, 930).isEnabled());
    assert.match((await becomes(page)).after, /s$/);
  },

  async "what becomes of corners, and of a load that rings, is told beside the time"() {
    const page = await opened();
    await hasEnded(page);
    await hasKnobs(page);
    // With coarse steps it is they that shake a load.
    await run(page, CORNERS, "$100=800\n$101=800\n$120=1000\n$121=1000\n");
    await hasEnded(page);
    const row = (name) => page.locator("#what-if-figures tr", { hasText: name }).locator("td");
    await number(page, 904).fill("0.02");
    await becomes(page);
    assert.deepEqual(await row("corners are left by").allTextContents(), ["0.0100 mm", "0.0200 mm"]);
    assert.equal(await row("the load").count(), 0);
    await page.click("#what-if-back");
    assert.equal(await page.locator("#what-if-table").isVisible(), false);
    await page.fill("#what-if-load", "40");
    await choice(page, 950).selectOption({ label: "ZV" });
    await page.waitForFunction(() => !/…/.test(document.getElementById("what-if-figures").textContent) && /load swings/.test(document.getElementById("what-if-figures").textContent));
    const [before, after] = (await row("the load swings after stops").allTextContents()).map(parseFloat);
    assert.ok(before > 0.005 && after < before / 4, `${before} and ${after} mm`);
    assert.deepEqual((await row("shapers leave").allTextContents())[0], "–");
  },

  async "a machine's own settings become those of the tool, each line accounted for"() {
    const page = await opened();
    await hasEnded(page);
    const native = await readFile(paths.listed, "utf8");
    const listing = await readFile(LISTED, "utf8");
    const isTaken = async () => {
      await page.locator("#listing-state", { hasText: "line by line" }).waitFor();
      // The words may be those of the listing before.
      await page.waitForFunction((native) => document.getElementById("settings").value === native, native);
      await put(page, "settings", "");
    };
    assert.ok(await drop(page, "#settings-details summary", "mine.txt", listing));
    await isTaken();
    const said = await page.locator("#listing li").allTextContents();
    assert.ok(said.includes("line 6 `$4=0`: taken as $4=1: grblHAL's 0 is an ENABLE that is active high"), said.join("\n"));
    assert.ok(said.includes("line 63 `$481=0`: nothing here depends on it"), said.join("\n"));
    assert.equal(await page.locator("#listing tr").first().textContent(), "taken33 as they are");
    const program = await text(page);
    // Beside the program it is known by what is in it.
    assert.ok(await drop(page, "header", "mine.nc", listing));
    await isTaken();
    await page.setInputFiles("#listing-file", LISTED);
    await isTaken();
    await page.locator("#settings").evaluate((area, listing) => {
      const clipboardData = new DataTransfer();
      clipboardData.setData("text/plain", listing);
      area.dispatchEvent(new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true }));
    }, listing);
    await page.locator("#listing-state", { hasText: "What was pasted" }).waitFor();
    await isTaken();
    assert.equal(await text(page), program);
    await drop(page, "#settings", "mine.txt", "$27=30\n$130=20\n");
    await page.locator("#listing-state", { hasText: "nothing is taken" }).waitFor();
    assert.equal(await settings(page), "");
  },

  async "a program that is dropped anywhere is opened, and the page stays"() {
    const page = await opened("#profiles");
    await page.locator("#results[data-state=ended]").waitFor({ state: "attached" });
    assert.ok(await drop(page, "#view-profiles", "mine.nc", "$H\n$120=100\nG21\nG1 X5 F600\n"));
    await page.waitForFunction(() => document.getElementById("program").shadowRoot.textContent.includes("G1 X5 F600"));
    assert.equal(await settings(page), "");
    await page.locator("#run").click();
    await hasEnded(page);
    assert.match(await page.locator("#figures").textContent(), /ends atX 5\.00/);
  },

  async "a mistake in the settings is told at the settings, by its line there"() {
    const page = await opened();
    await hasEnded(page);
    await run(page, "G0 X1\nG0 X2\n", "$100=50\n$110=-5\n");
    const told = page.locator("#settings-troubles li");
    assert.match(await told.textContent(), /^line 2 of the settings: \$110=-5 is negative/);
    assert.ok(await page.locator("#settings").isVisible());
    assert.equal(await page.locator("#troubles li").count(), 0);
    assert.equal(await page.locator("#program .cm-gutterElement.cm-refused").count(), 0);
    await told.locator("button").click();
    assert.equal(await page.locator("#settings").evaluate((area) => area.value.slice(area.selectionStart, area.selectionEnd)), "$110=-5");
    await put(page, "settings", "$110=500\n");
    assert.equal(await told.count(), 0);
  },

  async "a line of 5 MB is refused at once, and what was open stays"() {
    const page = await opened();
    await hasEnded(page);
    const program = await text(page);
    const long = Buffer.from(`G21\n${"G1 X1 ".repeat(870_000)}\nG0 X2\n`);
    const began = Date.now();
    await page.setInputFiles("#file", { name: "long.nc", mimeType: "text/plain", buffer: long });
    const told = page.locator("#troubles li");
    await told.waitFor();
    assert.ok(Date.now() - began < 3_000, `${Date.now() - began} ms`);
    assert.match(await told.textContent(), /^long\.nc was not opened: line 2 has 5,220,000 characters, and a line has 65,536 at most/);
    assert.equal(await text(page), program);
    await page.setInputFiles("#file", { name: "short.nc", mimeType: "text/plain", buffer: Buffer.from(`;${"x".repeat(65_535)}\nG0 X3`) });
    await page.waitForFunction(() => document.getElementById("program").shadowRoot.textContent.includes("G0 X3"));
    assert.equal(await told.count(), 0);
    const open = await text(page);
    await put(page, "program", "G1 X1 ".repeat(870_000));
    assert.match(await told.textContent(), /^nothing was pasted: line 1 has 5,220,000 characters/);
    assert.equal(await text(page), open);
  },

  async "a link opens the same program with the same settings, and the same comes of it"() {
    const page = await opened();
    await page.context().grantPermissions(["clipboard-read", "clipboard-write"]);
    await hasEnded(page);
    const program = "(Ä, 日本)\nG21 G91\nG1 X30 F2400\nY30\n";
    await run(page, program, "$120=200\n$121=150\n; mine\n");
    await hasEnded(page);
    const [asSet, figures] = [await taken(page), await page.locator("#figures").textContent()];
    await page.click("#copy-link");
    await page.locator("#link-state", { hasText: "Copied" }).waitFor();
    let link = await page.evaluate(() => navigator.clipboard.readText());
    assert.match(link, /#\/run&program=[\w-]+$/);
    assert.match(await page.locator("#link-state").textContent(), new RegExp(`Copied: ${link.length} characters`));
    const other = await opened(link);
    await hasEnded(other);
    assert.equal(await text(other), program);
    assert.equal(await settings(other), "$120=200\n$121=150\n; mine\n");
    assert.equal(await taken(other), asSet);
    assert.equal(await other.locator("#figures").textContent(), figures);
    assert.equal(new URL(other.url()).hash, "#/run", "a reload has what became of it");
    // What is open takes another.
    await other.evaluate((link) => (location.hash = new URL(link).hash), link.replace(/program=.*/, `program=${folded(["other.nc", "G0 X7\n", ""])}`));
    await other.waitForFunction(() => /ends atX 7\.00/.test(document.getElementById("figures").textContent));
    // Whatever its bytes are, it is in letters that an address has.
    const scattered = (lines) => Array.from({ length: lines }, (_, line) => `G1 X${(line * 7919) % 997} Y${(line * 104729) % 991}`).join("\n");
    await put(page, "program", scattered(200));
    await page.click("#copy-link");
    await page.waitForFunction(async (before) => (await navigator.clipboard.readText()) !== before, link);
    link = await page.evaluate(() => navigator.clipboard.readText());
    const [, letters] = /&program=([\w-]+)$/.exec(link);
    assert.equal(JSON.parse(inflateRawSync(Buffer.from(letters, "base64url")))[1], scattered(200));
    await put(page, "program", scattered(6_000));
    await page.click("#copy-link");
    await page.locator("#link-state", { hasText: /would have [\d,]+ characters, and at most 8,000/ }).waitFor();
    assert.equal(await page.evaluate(() => navigator.clipboard.readText()), link);
  },

  async "a link that is damaged, or unfolds to far more, is refused in words"() {
    const damaged = /^The link is damaged/;
    assert.match(await told("#/run&program=%%%"), damaged);
    assert.match(await told(`#/run&program=${folded(["a.nc", "G0 X1 Y2 Z3\n".repeat(9), ""]).slice(0, -12)}`), damaged);
    assert.match(await told(`#/run&program=${asAddress(Buffer.from("no deflated text"))}`), damaged);
    assert.match(await told(`#/run&program=${folded({ name: "a.nc" })}`), /^The link has no program in it/);
    assert.match(await told(`#/run&program=${folded(["a.nc", 5, ""])}`), /^The link has no program in it/);
    assert.match(await told(`#/run&program=${folded(["a.nc", " \n".repeat(2_000_000), ""])}`), /^The link unfolds to more than 1 MB/);
    assert.match(await told(`#/run&program=${folded(["a.nc", "X".repeat(70_000), ""])}`), /^the link: line 1 has 70,000 characters/);
  },

  async "addresses of before go where they went, and no address scrolls to an element"() {
    for (const [address, tab] of [["#operate", "operate"], ["#/settings", "settings"], ["#profiles", "profiles"], ["#/run", "run"], ["#operate&token=12ab", "operate"]]) {
      const page = await opened(address);
      assert.equal(await page.locator("[role=tab][aria-selected=true]").getAttribute("id"), `tab-${tab}`, address);
      await page.click("#tab-profiles");
      assert.equal(new URL(page.url()).hash, "#/profiles");
      await page.context().close();
    }
  },
};
