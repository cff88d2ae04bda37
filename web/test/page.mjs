// The page in Chromium: `node page.mjs --page FOLDER --trace FILE --shots FOLDER [--chromium PATH]`.
// FILE is the trace of programs/parking.nc by the native simulator.
import assert from "node:assert/strict";
import { browser, complaints, server } from "./harness.mjs";
import { tests as look } from "./look.mjs";
import { tests as operate } from "./operate.mjs";
import { tests as program } from "./program.mjs";

let failed = 0;
for (const [name, test] of Object.entries({ ...program, ...operate, ...look })) {
  complaints.length = 0;
  try {
    await test();
    assert.deepEqual(complaints, [], "the browser's log");
    console.log(`ok      ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED  ${name}\n${error.stack}`);
  }
  await Promise.all(browser.contexts().map((context) => context.close()));
}
await browser.close();
server.close();
process.exitCode = failed ? 1 : 0;
