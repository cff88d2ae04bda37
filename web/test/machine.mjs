// A machine on the page, as a person drives it, and what its console says. Nothing here knows which machine it is.
import assert from "node:assert/strict";
import { machines, opened, put } from "./harness.mjs";

/** Where the wait for the machine to do something ends. */
const PATIENCE_MS = 120_000;

/** A page that operates, with a machine in Idle: at power-up, or as if it were. */
export async function operated({ address, isSimulated } = machines[0], view = "operate") {
  const page = await opened(isSimulated ? `#${view}` : address);
  await page.locator("#bar :is([data-state=Idle], [data-state=Alarm], [data-state=Hold])").waitFor({ state: "attached", timeout: PATIENCE_MS });
  await hasSettings(page);
  if (!isSimulated) await restore(page);
  await is(page, "Idle");
  await page.click(`#tab-${view}`);
  return page;
}

const hasSettings = (page) => page.waitForFunction(() => document.querySelectorAll("#setting-groups .setting").length > 0);

/** Sends a line until it is not forgotten by a welcome that was on its way. */
async function obeys(page, line) {
  while ((await answers(page, line)).at(-1) === "forgotten");
}

/** A board that was operated before is at its zero, with the settings, offsets and modes of power-up, and nothing is homed. */
async function restore(page) {
  await page.click("#reset");
  for (const line of ["$X", "$RST=*", "$J=G53 G21 G90 Z0 F2800", "$J=G53 G21 G90 X0 Y0 F2800"]) await obeys(page, line);
  await page.waitForFunction(() => ["x", "y", "z"].every((axis) => Number(document.getElementById(`place-${axis}`).textContent) === 0));
  if (/^(no|unknown)$/.test(await page.locator("#homed-now").textContent())) return;
  // Steps of another length take the zero of their axis away.
  const listed = await answers(page, "$$");
  for (const [, number, steps] of listed.map((line) => /^\$(10[0-2])=(.*)/.exec(line)).filter(Boolean)) {
    await answers(page, `$${number}=${steps / 2}`);
    await answers(page, `$${number}=${steps}`);
  }
  await reads(page, "homed-now", /^(no|unknown)$/);
}

export const is = (page, state) => page.locator(`#bar [data-state=${state}]`).waitFor({ state: "attached", timeout: PATIENCE_MS });

/** What the log says from now on has this text in a line. */
export const hears = (page, text) => page.locator("#log div", { hasText: text }).last().waitFor({ state: "attached" });

/** Lines of the log that were sent, the last ones. */
export const sent = (page, count) => page.locator("#log .sent").evaluateAll((lines, count) => lines.slice(-count).map((line) => line.textContent.slice(2)), count);

/** What the machine prints for a line of the console, up to its answer. */
export async function answers(page, line) {
  const said = await page.evaluateHandle((line) => {
    const lines = [];
    // The log drops its first lines.
    new MutationObserver((changes) => changes.forEach(({ addedNodes }) => lines.push(...[...addedNodes].map((node) => node.textContent)))).observe(
      document.getElementById("log"),
      { childList: true },
    );
    document.getElementById("line").value = line;
    document.getElementById("console").requestSubmit();
    return lines;
  }, line);
  for (;;) {
    const lines = await said.jsonValue();
    if (lines.some((line) => /^(ok|error:\d+.*|forgotten)$/.test(line))) return lines.slice(1);
    await page.waitForTimeout(20);
  }
}

/** The value of a setting by the machine's own list. */
export async function setting(page, number) {
  const line = (await answers(page, "$$")).find((line) => line.startsWith(`$${number}=`));
  return Number(line?.split("=")[1]);
}

/** A text of the page, once it is as wanted. */
export async function reads(page, id, wanted) {
  await page.waitForFunction(([id, source]) => new RegExp(source).test(document.getElementById(id).textContent), [id, wanted.source]);
}

/** Where the machine says that it is. */
export const place = async (page, axis, of = "place") => Number(await page.locator(`#${of}-${axis}`).textContent());

/** The place, once it has not changed for three reports. */
export async function rests(page, axis, of) {
  await is(page, "Idle");
  let before = NaN;
  for (;;) {
    const now = await place(page, axis, of);
    if (now === before) return now;
    before = now;
    await page.waitForTimeout(600);
  }
}

/** Homes by the button. A simulated machine may do so faster. */
export async function home(page) {
  if (await page.locator("#live-rate").isVisible()) await page.selectOption("#live-rate", "20");
  await page.click("#home");
  await is(page, "Home");
  await is(page, "Idle");
  await reads(page, "homed-now", /^yes$/);
  if (await page.locator("#live-rate").isVisible()) await page.selectOption("#live-rate", "1");
}

/** Sends a program from the page. */
export async function sends(page, program) {
  await put(page, "program", program);
  await page.locator("#send-program:enabled").waitFor();
  await page.click("#send-program");
}

/** The place is this one, to the last decimal of a report. */
export const stands = async (page, axis, wanted, of) => assert.ok(Math.abs((await rests(page, axis, of)) - wanted) < 0.0015, `${axis} ${await place(page, axis, of)}`);

/** What stands below a program that has ended, whole: a server that holds it says its name, and more of where it was. */
export const endsWith = (page, { isSimulated }, ofPage, ofServer = ofPage) => reads(page, "sending-now", new RegExp(isSimulated ? `^${ofPage}$` : `^[^:]+: ${ofServer}$`));
