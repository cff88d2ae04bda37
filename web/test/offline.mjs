// The page without its server, and with another one: behind a server of the test's own, which can be ended and can have another build.
import assert from "node:assert/strict";
import { once } from "node:events";
import { createServer } from "node:http";
import { complaints, hasEnded, opened, paths, run } from "./harness.mjs";

const BUILD = /[0-9a-f]{16}/g;
const GONE = "Failed to load resource: net::ERR_CONNECTION_REFUSED";

/** Serves the page as it is, or the same page by the name of another build. */
class Stand {
  build = null;

  async start(port = 0) {
    this.server = createServer((request, answer) => void this.answer(request, answer)).listen(port, "127.0.0.1");
    await once(this.server, "listening");
    this.port = this.server.address().port;
    this.address = `http://127.0.0.1:${this.port}/`;
    return this;
  }

  async answer(request, answer) {
    if (this.build && request.url.match(BUILD) && !request.url.includes(this.build)) return void answer.writeHead(404).end();
    const own = (await (await fetch(paths.page)).text()).match(BUILD)[0];
    const found = await fetch(new URL(`.${request.url.replace(BUILD, own)}`, paths.page));
    const isText = /html|service/.test(`${found.headers.get("content-type")} ${request.url}`);
    const content = isText && this.build ? (await found.text()).replaceAll(BUILD, this.build) : Buffer.from(await found.arrayBuffer());
    const headers = ["content-type", "content-security-policy"].map((name) => [name, found.headers.get(name)]).filter(([, value]) => value);
    answer.writeHead(found.status, Object.fromEntries(headers)).end(content);
  }

  async end() {
    this.server.closeAllConnections();
    await new Promise((ended) => this.server.close(ended));
  }
}

/** The builds that are kept, in the order in which they came. */
const builds = (page) => page.evaluate(async () => {
  const names = await caches.keys();
  const counts = await Promise.all(names.map(async (name) => (await (await caches.open(name)).keys()).length));
  return names.filter((_, index) => counts[index] > 0).map((name) => name.split(" ").at(-1));
});
const shown = (page) => page.locator("link[rel=stylesheet]").first().evaluate((link) => link.getAttribute("href").split("/")[0]);
const isKept = (page) => page.evaluate(async () => {
  const { waiting, installing } = await navigator.serviceWorker.ready;
  return !waiting && !installing;
});

/** Waits until these builds are kept, the last of them the one that is shown offline. */
async function keeps(page, ...expected) {
  for (let tries = 0; tries < 200; tries++) {
    if ((await isKept(page)) && String(await builds(page)) === String(expected)) return;
    await page.waitForTimeout(50);
  }
  assert.deepEqual(await builds(page), expected);
}

/** What the browser says of the one question that is for the server alone. */
function expectGone(times) {
  assert.deepEqual(complaints.splice(0), Array(times).fill(GONE));
}

export const tests = {
  async "the page opens and runs a program when its server is gone"() {
    const stand = await new Stand().start();
    const page = await opened(stand.address);
    await hasEnded(page);
    const build = await shown(page);
    await keeps(page, build);
    await stand.end();
    await page.reload();
    await hasEnded(page);
    assert.match(await page.locator("#checks-total").textContent(), /^all \d+ kept/);
    await page.selectOption("#plane", "3D");
    await page.locator("#space").waitFor();
    assert.equal(await page.evaluate(() => fetch("board.json").then(() => "answered", () => "not kept")), "not kept");
    expectGone(2);
  },

  async "the machine with A is kept once it was wanted, and not before"() {
    const stand = await new Stand().start();
    const page = await opened(stand.address);
    await hasEnded(page);
    await keeps(page, await shown(page));
    await page.reload();
    await hasEnded(page);
    const isThere = () => page.evaluate(() => caches.match(new URL("machine4_bg.wasm", document.querySelector("link[rel=stylesheet]").href)).then(Boolean));
    assert.equal(await isThere(), false);
    await run(page, "G21 G91\nG1 A90 F1200\n");
    assert.match(await page.textContent("#figures"), /A 90\.00 degrees/);
    assert.equal(await isThere(), true);
    await stand.end();
    await page.reload();
    await hasEnded(page);
    assert.match(await page.textContent("#figures"), /A 90\.00 degrees/);
    expectGone(1);
  },

  async "another build is shown as soon as it is served, and stays when the server goes"() {
    const stand = await new Stand().start();
    const page = await opened(stand.address);
    await hasEnded(page);
    const first = await shown(page);
    await keeps(page, first);
    const later = ["b", "c"].map((letter) => letter.repeat(16));
    for (const [before, build] of [[first, later[0]], later]) {
      stand.build = build;
      await page.reload();
      assert.equal(await shown(page), build);
      await hasEnded(page);
      // That of before stays, for pages that are still open.
      await keeps(page, before, build);
    }
    await stand.end();
    await page.reload();
    await hasEnded(page);
    assert.equal(await shown(page), later[1]);
    expectGone(1);
  },

  async "a page that is open goes on with its own build when another one is served"() {
    const stand = await new Stand().start();
    const page = await opened(stand.address);
    await hasEnded(page);
    const first = await shown(page);
    await keeps(page, first);
    await page.reload();
    await hasEnded(page);
    stand.build = "d".repeat(16);
    const other = await page.context().newPage();
    await other.goto(stand.address);
    await hasEnded(other);
    await keeps(other, first, stand.build);
    await page.click("#run");
    await page.locator("#run:enabled").waitFor();
    await hasEnded(page);
    await page.selectOption("#plane", "3D");
    await page.locator("#space").waitFor();
    assert.deepEqual([await shown(page), await shown(other)], [first, stand.build]);
    await stand.end();
  },

  async "it can be installed, with icons that are pictures of icon.svg"() {
    const page = await opened();
    await hasEnded(page);
    await page.evaluate(() => navigator.serviceWorker.ready);
    const session = await page.context().newCDPSession(page);
    const { url, errors } = await session.send("Page.getAppManifest");
    assert.ok(url.endsWith("/manifest.webmanifest"), url);
    assert.deepEqual(errors, []);
    const { installabilityErrors } = await session.send("Page.getInstallabilityErrors");
    // A page of a test is in a window that remembers nothing.
    assert.deepEqual(installabilityErrors.map(({ errorId }) => errorId).filter((id) => id !== "in-incognito"), []);
    const manifest = await page.request.get(new URL("manifest.webmanifest", paths.page).href);
    assert.equal(manifest.headers()["content-type"], "application/manifest+json");
    const { icons } = await manifest.json();
    for (const { src, sizes } of icons.filter(({ type }) => type === "image/png")) {
      const apart = await page.evaluate(async ([src, size]) => {
        const pixels = async (address) => {
          const image = Object.assign(new Image(), { src: address });
          await image.decode();
          const canvas = Object.assign(document.createElement("canvas"), { width: size, height: size });
          const context = canvas.getContext("2d");
          context.drawImage(image, 0, 0, size, size);
          return context.getImageData(0, 0, size, size).data;
        };
        const [one, other] = await Promise.all([pixels(src), pixels("icon.svg")]);
        return one.reduce((sum, value, index) => sum + Math.abs(value - other[index]), 0) / one.length;
      }, [src, Number(sizes.split("x")[0])]);
      assert.ok(apart < 1, `${src} differs from icon.svg by ${apart} of 255 in the mean: draw it anew`);
    }
  },
};
