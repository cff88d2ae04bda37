// Keeps the page in the browser, so that it opens without its server. All that a page loads later lies in a folder that is named by
// its content, so what is kept of it is right for ever. The page itself is asked of the server first: so it is never an old one while
// the server answers, and it names the folder that belongs to it.

export {};
declare const self: ServiceWorkerGlobalScope;
/** The name of the folder, and all files of the page, by build.mjs. */
declare const BUILD: string;
declare const FILES: string[];

/** A server that takes longer than this may as well not be there, ms. */
const PATIENCE_MS = 3000;
/** Another page of this origin has files of its own. */
const PREFIX = `isostep ${self.registration.scope} `;
const OWN = PREFIX + BUILD;

const OF_A_BUILD = /\/[0-9a-f]{16}\//;

async function keep(): Promise<void> {
  const cache = await caches.open(OWN);
  try {
    await cache.addAll(FILES.map((file) => new Request(file, { cache: "no-cache" })));
    const page = await (await cache.match("./"))?.text();
    if (!page?.includes(BUILD)) throw new Error("the server has another page by now");
  } catch (error) {
    await caches.delete(OWN);
    throw error;
  }
  await self.skipWaiting();
}

/** The files before these stay, as pages of theirs may be open; older ones go. */
async function forget(): Promise<void> {
  const others = (await caches.keys()).filter((name) => name.startsWith(PREFIX) && name !== OWN);
  await Promise.all(others.slice(0, -1).map((name) => caches.delete(name)));
}

async function kept(request: RequestInfo): Promise<Response | undefined> {
  return (await caches.match(request, { cacheName: OWN })) ?? caches.match(request);
}

/** What is not among the files, as the machine with A, is kept once it was wanted. */
async function keptFirst(request: Request): Promise<Response> {
  const found = await kept(request);
  if (found) return found;
  const answer = await fetch(request);
  if (answer.ok && request.url.includes(BUILD)) await (await caches.open(OWN)).put(request, answer.clone());
  return answer;
}

async function serverFirst(request: Request): Promise<Response> {
  const late = new Promise<undefined>((resolve) => setTimeout(resolve, PATIENCE_MS));
  const answer = await Promise.race([fetch(request).catch(() => undefined), late]);
  return answer ?? (await kept(request.mode === "navigate" ? "./" : request)) ?? Response.error();
}

self.addEventListener("install", (event) => event.waitUntil(keep()));
self.addEventListener("activate", (event) => event.waitUntil(forget()));
self.addEventListener("fetch", (event) => {
  const { request } = event;
  const name = request.url.slice(self.registration.scope.length);
  if (OF_A_BUILD.test(request.url)) event.respondWith(keptFirst(request));
  else if (request.mode === "navigate" || FILES.includes(name)) event.respondWith(serverFirst(request));
});
