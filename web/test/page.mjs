// The page in Chromium: `node page.mjs --page ADDRESS [--board ADDRESS] --trace FILE --listed FILE --shots FOLDER [--chromium PATH] [--only WORDS]`.
// ADDRESS is that of `isostep web`, without a board and with one; FILE is the trace of programs/parking.nc by the native simulator, and what the native
// tool takes of a listing of grblHAL's.
import assert from "node:assert/strict";
import { tests as axes } from "./axes.mjs";
import { tests as axe } from "./axe.mjs";
import { tests as faults } from "./faults.mjs";
import { browser, complaints, machines, paths } from "./harness.mjs";
import { tests as live } from "./live.mjs";
import { tests as look } from "./look.mjs";
import { tests as ofMachine } from "./machines.mjs";
import { tests as offline } from "./offline.mjs";
import { tests as operate } from "./operate.mjs";
import { tests as program } from "./program.mjs";
import { tests as serial } from "./serial.mjs";
import { tests as served } from "./served.mjs";
import { tests as settings } from "./settings.mjs";
import { tests as shown } from "./shown.mjs";
import { tests as simulated } from "./simulated.mjs";
import { tests as whatIf } from "./whatif.mjs";

let failed = 0;
const either = Object.assign({}, ...machines.flatMap((machine) => [ofMachine, operate, live, settings].map((of) => of(machine))));
const tests = { ...program, ...whatIf, ...shown, ...simulated, ...axes, ...either, ...(paths.board && served), ...(paths.emulator && faults), ...serial, ...offline, ...axe, ...look };
for (const [name, test] of Object.entries(tests)) {
  if (!name.includes(paths.only ?? "")) continue;
  complaints.length = 0;
  try {
    await test();
    assert.deepEqual(complaints, [], "the browser's log");
    console.log(`ok      ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED  ${name}\n${error.stack}`);
    for (const page of browser.contexts().flatMap((context) => context.pages())) {
      for (const id of ["log", "sending-what", "fits", "sending-now"]) console.log(await page.locator(`#${id}`).evaluate((place) => place.textContent.slice(-1000)));
    }
  }
  await Promise.all(browser.contexts().map((context) => context.close()));
}
await browser.close();
process.exitCode = failed ? 1 : 0;
