// Faults while the emulated board is operated: the board, the server and the browser are processes of their own, which are stopped and killed.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";
import { browser, paths, put } from "./harness.mjs";
import { is, place, reads, rests } from "./machine.mjs";

const PATIENCE_MS = 120_000;
/** The jogs' feed, mm/s, and how far one goes at most after its page has gone: what the machine has ahead, and a report's time. */
const JOG_MM_PER_S = 1500 / 60;
const BEHIND_MM = JOG_MM_PER_S * 0.6;
/** How long the server and the browser are stopped. */
const STOPPED_MS = 5_000;

/** A process that has said on its output what is waited for. */
class Process {
  constructor(command, args) {
    // A group of its own, so that the board's parts end together.
    this.child = spawn(command, args, { stdio: ["ignore", "pipe", "pipe"], detached: true });
    this.said = "";
    for (const output of [this.child.stdout, this.child.stderr]) output.on("data", (part) => (this.said += part)).unref();
    // The tests end without waiting for it.
    this.child.unref();
    this.ended = new Promise((resolve) => this.child.once("exit", resolve));
  }

  async says(words) {
    const found = () => words.exec(this.said);
    let hasEnded = false;
    void this.ended.then(() => (hasEnded = true));
    while (!found()) {
      assert.ok(!hasEnded, `it ended, and has said: ${this.said}`);
      await new Promise((resolve) => setTimeout(resolve, 20));
    }
    return found();
  }

  signal(name) {
    process.kill(-this.child.pid, name);
  }

  async kill() {
    this.signal("SIGKILL");
    await this.ended;
  }
}

const port = join(tmpdir(), `isostep-faults-${process.pid}`);
const running = {};

/** Powers the board up. Its port is at the same place each time. */
async function plugIn() {
  running.board = new Process(paths.emulator, ["emulate", "--pty", "--link", port, "--start=2,2,2"]);
  await running.board.says(/console: /);
}

/** Starts the server, at the address of the one before if there was one. */
async function serve() {
  running.server = new Process(paths.server, ["web", "--page", paths.folder, "--port", port, "--http-port", String(running.httpPort ?? 0)]);
  const [, address, httpPort] = await running.server.says(/(http:\/\/127\.0\.0\.1:(\d+)\/\S+) until/);
  Object.assign(running, { address, httpPort });
}

/** Everything that runs here ends with the tests. */
process.on("exit", () => {
  for (const each of [running.board, running.server]) if (each?.child.exitCode === null && each.child.signalCode === null) each.signal("SIGKILL");
  rmSync(port, { force: true });
});

/** A page with the board, in this browser or another. */
async function opened(from = browser) {
  const context = await from.newContext({ viewport: { width: 1440, height: 1000 } });
  context.setDefaultTimeout(PATIENCE_MS);
  const page = await context.newPage();
  await page.goto(running.address);
  return page;
}

/** Two pages, of which the second watches, with the board at rest. */
async function watched(from) {
  if (!running.board) await plugIn();
  if (!running.server) await serve();
  const pages = [await opened(from), await opened()];
  for (const page of pages) await is(page, "Idle");
  await settled(pages[1]);
  return pages;
}

/** The place of X, once the machine rests. */
const settled = (page) => rests(page, "x");

async function sends(page, program) {
  await put(page, "program", program);
  await page.locator("#send-program:enabled").click();
  await is(page, "Run");
}

/** Moves of 1 mm to and fro, which end where they began. */
const toAndFro = (moves) => `G21 G91 F600\n${"G1 X1\nG1 X-1\n".repeat(moves / 2)}`;

const text = (page, id) => page.locator(`#${id}`).textContent();

/** Holds a jog of X, until it moves. */
async function jogs(page, key = "xp", axis = "x") {
  const before = await place(page, axis);
  await page.locator(`#pad .${key}`).hover();
  await page.mouse.down();
  await page.waitForFunction(([axis, before]) => Math.abs(Number(document.getElementById(`place-${axis}`).textContent) - before) > 1, [axis, before]);
}

/** The machine stands, no farther from where it was than a page that is gone lets it come. */
async function standsNear(page, mm) {
  const stands = await settled(page);
  assert.ok(Math.abs(stands - mm) <= BEHIND_MM, `${stands} mm, and it was at ${mm} mm`);
  return stands;
}

const hang = (page, ms) => page.evaluate((ms) => {
  const until = Date.now() + ms;
  while (Date.now() < until);
}, ms);

const isLost = async (page, words) => {
  await reads(page, "link-trouble", words);
  assert.equal(await text(page, "state"), "Lost");
  assert.match(await text(page, "link-trouble"), /^The link to the machine is lost: .* What the machine was told before it may still do: look at the machine itself\.$/);
};

/** The page takes the board again. */
async function connects(page) {
  await page.locator("#connect:enabled").click();
  await page.locator("#state:not([data-state=Off]):not([data-state=Lost])").waitFor();
}

/** Stops what is being sent, so that the next test finds the machine at rest. */
async function ends(page) {
  await page.click("#stop-program");
  await reads(page, "sending-now", /Stopped by a reset, line \d+ was next/);
  await is(page, "Idle");
}

export const tests = {
  async "fault: the server is killed while a program runs: the machine makes what it has, and a new server finds it"() {
    const [page, other] = await watched();
    const from = await settled(page);
    await sends(page, toAndFro(200));
    await reads(page, "sending-now", /^line \d+ of 201/);
    await running.server.kill();
    for (const each of [page, other]) {
      await isLost(each, /the server does not answer any more: start it again, and open the address that it prints/);
      assert.match(await text(each, "sending-now"), /^The server goes on with .*, as long as it runs: connect again/);
    }
    await serve();
    await page.click("#connect");
    await reads(page, "link-trouble", /^There is no link to the machine: the server refuses: open the address that it printed when it was started last$/);
    const third = await opened();
    const stands = (await settled(third)) - from;
    assert.ok(Math.abs(stands) < 0.002 || Math.abs(stands - 1) < 0.002, `it stands at the end of a line: ${stands} mm`);
    assert.equal(await text(third, "sending-now"), "");
  },

  async "fault: the server is killed while a jog is held: the machine stops by itself"() {
    const [page] = await watched();
    await jogs(page);
    const at = await place(page, "x");
    await running.server.kill();
    await isLost(page, /the server does not answer any more/);
    await serve();
    await standsNear(await opened(), at);
  },

  async "fault: the server is stopped for 5 s: a program goes on, a jog ends by itself"() {
    const [page] = await watched();
    await sends(page, toAndFro(120));
    await reads(page, "sending-now", /^line \d+ of 121/);
    running.server.signal("SIGSTOP");
    await reads(page, "link-trouble", /^The machine has not answered for [34] s: what is shown may be old, and it may still move\.$/);
    assert.equal(await text(page, "state"), "Silent");
    await page.waitForTimeout(STOPPED_MS - 3000);
    running.server.signal("SIGCONT");
    await is(page, "Run");
    assert.ok(await page.locator("#link-trouble").isHidden());
    await reads(page, "sending-now", /Done: 121 lines\.$/);
    await jogs(page);
    const at = await place(page, "x");
    running.server.signal("SIGSTOP");
    await is(page, "Silent");
    await page.waitForTimeout(STOPPED_MS - 1500);
    await page.mouse.up();
    running.server.signal("SIGCONT");
    await standsNear(page, at);
  },

  async "fault: the cable is out and in: said on every page, and taken again by Connect"() {
    const [page, other] = await watched();
    await sends(page, toAndFro(200));
    await reads(page, "sending-now", /^line \d+ of 201/);
    await running.board.kill();
    for (const each of [page, other]) {
      await isLost(each, /the board is gone \(.+\): plug it in, then connect again/);
      assert.match(await text(each, "sending-now"), /: Stopped, line \d+ was next to be answered: the board is gone \(/);
    }
    await page.click("#connect");
    await reads(page, "link-trouble", /^There is no link to the machine: /);
    await plugIn();
    await connects(page);
    await is(page, "Idle");
    assert.equal(await settled(page), 0, "it was without power");
    await jogs(page);
    await running.board.kill();
    await isLost(page, /the board is gone/);
    await page.mouse.up();
    await plugIn();
    await connects(page);
    assert.equal(await settled(page), 0, "no jog of before comes to it");
  },

  async "fault: the tab is closed: a held jog stops, a program goes on"() {
    const [page, other] = await watched();
    await jogs(page);
    const at = await place(other, "x");
    await page.close();
    await standsNear(other, at);
    const next = await opened();
    await is(next, "Idle");
    await sends(next, toAndFro(60));
    await reads(other, "sending-now", /^line \d+ of 61/);
    await next.close();
    await reads(other, "sending-now", /Done: 61 lines\.$/);
  },

  async "fault: the page is reloaded in a program: it finds the line, the picture and the time left again"() {
    const [page, other] = await watched();
    const from = await settled(page);
    await sends(page, toAndFro(200));
    const known = /^line (\d+) of 201 is under way, about \d+ s left$/;
    await reads(page, "sending-now", known);
    const line = Number(known.exec(await text(page, "sending-now"))[1]);
    await page.reload();
    await reads(page, "sending-now", known);
    assert.ok(Number(known.exec(await text(page, "sending-now"))[1]) > line);
    assert.equal(await page.getAttribute("#path", "class"), "ahead");
    await reads(other, "sending-now", /Done: 201 lines\.$/);
    assert.ok(Math.abs((await settled(other)) - from) < 0.002);
  },

  async "fault: the script hangs for 8 s: a held jog stops by itself, a program goes on"() {
    const [page, other] = await watched();
    await jogs(page);
    const at = await place(other, "x");
    const hung = hang(page, 8_000);
    const stands = await standsNear(other, at);
    await hung;
    await isLost(page, /this page has not answered for 2 s, because its script or its computer slept: connect again/);
    await page.mouse.up();
    assert.equal(await settled(other), stands, "nothing comes behind it");
    await connects(page);
    await sends(page, toAndFro(300));
    await hang(page, 8_000);
    await isLost(page, /this page has not answered for 2 s/);
    assert.match(await text(page, "sending-now"), /^The server goes on with /);
    assert.equal(await text(other, "state"), "Run");
    await connects(page);
    await reads(page, "sending-now", /^line \d+ of 301 is under way/);
    await ends(page);
  },

  async "fault: two clients: both see the program, one holds and the other resumes"() {
    const [page, other] = await watched();
    await sends(page, toAndFro(200));
    for (const each of [page, other]) await reads(each, "sending-now", /^line \d+ of 201 is under way/);
    await other.click("#hold");
    await is(page, "Hold");
    await page.locator("#resume:enabled").click();
    await is(other, "Run");
    await other.locator("#pad .xp").hover();
    await other.mouse.down();
    await other.waitForTimeout(500);
    await other.mouse.up();
    assert.equal(await text(page, "state"), "Run", "nobody jogs in a program");
    await ends(other);
  },

  async "fault: two clients jog at once: the second is refused, and does not stop the first"() {
    const [page, other] = await watched();
    await jogs(page);
    const y = await place(other, "y");
    await other.locator("#pad .yp").hover();
    await other.mouse.down();
    await reads(other, "log", /Another page jogs: wait until it lets go/);
    await other.mouse.up();
    const x = await place(page, "x");
    await page.waitForFunction((x) => Number(document.getElementById("place-x").textContent) > x + 20, x);
    await page.mouse.up();
    await settled(other);
    assert.equal(await place(other, "y"), y);
    await jogs(other, "yp", "y");
    await other.mouse.up();
    await settled(page);
  },

  async "fault: the computer of a page sleeps for 5 s: a held jog stops by itself, a program goes on"() {
    const laptop = await chromium.launchServer({ executablePath: paths.chromium ?? "/usr/bin/chromium", args: ["--no-sandbox"] });
    const sleep = async (ms) => {
      process.kill(-laptop.process().pid, "SIGSTOP");
      await new Promise((resolve) => setTimeout(resolve, ms));
    };
    const wake = () => process.kill(-laptop.process().pid, "SIGCONT");
    try {
      const [page, other] = await watched(await chromium.connect(laptop.wsEndpoint()));
      await jogs(page);
      const at = await place(other, "x");
      await sleep(STOPPED_MS);
      const stands = await standsNear(other, at);
      wake();
      await isLost(page, /this page has not answered for 2 s, because its script or its computer slept: connect again/);
      await page.mouse.up();
      assert.equal(await settled(other), stands);
      await connects(page);
      await sends(page, toAndFro(200));
      await sleep(STOPPED_MS);
      assert.equal(await text(other, "state"), "Run");
      wake();
      await isLost(page, /this page has not answered for 2 s/);
      await connects(page);
      await reads(page, "sending-now", /^line \d+ of 201 is under way/);
      await ends(page);
    } finally {
      wake();
      await laptop.close();
    }
  },
};
