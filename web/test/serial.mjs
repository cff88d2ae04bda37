// A board by Web Serial, scripted: Chromium has no port here.
import assert from "node:assert/strict";
import { opened, put } from "./harness.mjs";

const is = (page, state) => page.locator(`#state[data-state=${state}]`).waitFor();

/** Runs in the page before its own scripts: a board at X10, which reports work positions; `window.fake` is the cable, and may withhold answers to lines of a program. */
function plugIn() {
  const fake = (window.fake = { sent: "", filters: undefined, options: undefined, signals: undefined, opened: 0, asked: 0 });
  let toPage;
  const say = (text) => toPage.enqueue(new TextEncoder().encode(text));
  const answer = (line) => {
    if (fake.isWithheld && line.startsWith("N")) return;
    if (line === "$$") say("$10=0\r\n$13=0\r\n$130=350.000\r\nok\r\n");
    else say(line.startsWith("$J=") ? "error:15\r\n" : "ok\r\n");
  };
  let partial = "";
  const take = (bytes) => {
    for (const byte of bytes) {
      const letter = String.fromCharCode(byte);
      fake.sent += letter;
      if (letter === "?") say("<Idle|WPos:7.000,0.000,0.000|FS:0,0|WCO:3.000,0.000,0.000>\r\n");
      else if (letter === "\n") {
        answer(partial);
        partial = "";
      } else if (byte < 0x80 && letter !== "!") partial += letter;
    }
  };
  let isOpen = false;
  const port = {
    getInfo: () => ({ usbVendorId: 0x2e8a, usbProductId: 0x000a }),
    readable: null,
    writable: null,
    async open(options) {
      if (fake.isTaken) throw new DOMException("Failed to open serial port.", "NetworkError");
      if (isOpen) throw new DOMException("The port is already open.", "InvalidStateError");
      isOpen = true;
      fake.options = options;
      fake.opened++;
      port.readable = new ReadableStream({ start: (controller) => (toPage = controller) });
      port.writable = new WritableStream({ write: take });
    },
    async setSignals(signals) {
      fake.signals = signals;
      if (fake.isSilent) return;
      say("\r\nGrbl 1.1h ['$' for help]\r\n");
    },
    async close() {
      if (port.readable?.locked || port.writable?.locked) throw new TypeError("locked");
      isOpen = false;
      port.readable = port.writable = null;
    },
  };
  fake.answer = (count) => say("ok\r\n".repeat(count));
  fake.spoil = () => {
    const spoilt = toPage;
    port.readable = new ReadableStream({ start: (controller) => (toPage = controller) });
    spoilt.error(new DOMException("framing", "FramingError"));
  };
  fake.unplug = () => {
    port.readable = port.writable = null;
    toPage.error(new DOMException("The device has been lost.", "NetworkError"));
  };
  const serial = {
    getPorts: async () => (fake.asked ? [port] : []),
    async requestPort({ filters }) {
      fake.asked++;
      fake.filters = filters;
      if (fake.isRefused) throw new DOMException("No port selected by the user.", "NotFoundError");
      return port;
    },
  };
  Object.defineProperty(navigator, "serial", { value: serial });
}

const withBoard = async (prepare = () => {}) => {
  const page = await opened("#operate", { before: plugIn });
  await is(page, "Idle");
  await page.evaluate(prepare);
  await page.selectOption("#which", "usb");
  await is(page, "Off");
  await page.click("#connect");
  return page;
};

export const tests = {
  async "a board by Web Serial is chosen among RP2040s and RP2350s, and asked for its settings and its place"() {
    const page = await withBoard();
    await is(page, "Idle");
    const { filters, options, signals } = await page.evaluate(() => window.fake);
    assert.deepEqual(filters, [0x000a, 0x0009].map((usbProductId) => ({ usbVendorId: 0x2e8a, usbProductId })));
    assert.equal(options.baudRate, 115_200);
    assert.equal(signals.dataTerminalReady, true);
    await page.waitForFunction(() => document.getElementById("place-x").textContent === "10.000");
    assert.equal(await page.locator("#homed-now").textContent(), "unknown");
    assert.match(await page.locator("#what").textContent(), /^A board by USB/);
    await page.waitForFunction(() => window.fake.sent.includes("$$\n"));
    await page.evaluate(() => window.fake.spoil());
    await page.fill("#line", "G4 P0");
    await page.keyboard.press("Enter");
    await page.locator("#log", { hasText: "ok" }).waitFor();
    await page.click("#connect");
    await is(page, "Off");
    await page.waitForFunction(() => window.fake.sent.endsWith("\x85"));
    await page.click("#connect");
    await is(page, "Idle");
    assert.equal(await page.evaluate(() => window.fake.opened), 2);
  },

  async "a board that says no welcome is asked for its settings too"() {
    const page = await withBoard(() => (window.fake.isSilent = true));
    await is(page, "Idle");
    await page.waitForFunction(() => window.fake.sent.includes("$$\n"));
    assert.equal((await page.evaluate(() => window.fake.sent)).split("$$").length, 2, "asked once");
  },

  async "a program has 128 bytes under way and no more, as many lines as fit"() {
    const page = await withBoard();
    await is(page, "Idle");
    await page.waitForFunction(() => window.fake.sent.includes("$G\n"));
    await page.evaluate(() => (window.fake.isWithheld = true));
    await put(page, "program", "N1 G1 X12 F1200\n".repeat(40));
    await page.locator("#send-program:enabled").click();
    await page.waitForFunction(() => window.fake.sent.includes("N1"));
    /** Lines that are sent once the page has asked for two more reports. */
    const sent = async () => {
      const asked = () => window.fake.sent.split("?").length;
      const before = await page.evaluate(asked);
      await page.waitForFunction((before) => window.fake.sent.split("?").length > before + 1, before);
      return page.evaluate(() => window.fake.sent.split("N1").length - 1);
    };
    assert.equal(await sent(), 8, "lines of 16 bytes");
    await page.evaluate(() => window.fake.answer(1));
    assert.equal(await sent(), 9);
    await page.evaluate(() => window.fake.answer(8));
    assert.equal(await sent(), 17);
    await page.locator("#sending-now", { hasText: "9 of 40 lines answered" }).waitFor();
    await page.evaluate(() => Object.assign(window.fake, { isWithheld: false }).answer(8));
    await page.locator("#sending-now", { hasText: "Done: 40 lines." }).waitFor();
    assert.equal(await sent(), 40);
  },

  async "a board that is unplugged is reported, and taken again"() {
    const page = await withBoard();
    await is(page, "Idle");
    await page.evaluate(() => window.fake.unplug());
    await is(page, "Lost");
    assert.equal(await page.locator("#place-x").textContent(), "–", "a place that is not known is not shown");
    assert.match(await page.locator("#link-trouble").textContent(), /^The link to the machine is lost: it was unplugged/);
    assert.equal(await page.locator("#connect").textContent(), "Connect again");
    await page.click("#connect");
    await is(page, "Idle");
    assert.ok(await page.locator("#link-trouble").isHidden());
    assert.equal(await page.evaluate(() => window.fake.asked), 1, "it is known");
  },

  async "a port that is taken or not chosen is reported with the remedy"() {
    const page = await withBoard(() => (window.fake.isTaken = true));
    await page.locator("#link-trouble", { hasText: "Close other programs that use it, then connect again" }).waitFor();
    const other = await withBoard(() => (window.fake.isRefused = true));
    await other.locator("#which-trouble", { hasText: "No board was chosen" }).waitFor();
  },

  async "a browser without Web Serial is told of isostep web"() {
    const page = await opened("#operate", { before: () => delete Navigator.prototype.serial });
    await is(page, "Idle");
    await page.selectOption("#which", "usb");
    await page.locator("#which-trouble", { hasText: "no Web Serial" }).waitFor();
    assert.ok(await page.locator("#connect").isDisabled());
  },
};
