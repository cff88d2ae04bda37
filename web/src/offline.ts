// The page stays in the browser, so that it opens without its server, and can be installed. service/service.ts does the work.

export function stayHere(): void {
  // Browsers offer it to pages of https and of this computer alone.
  if (!("serviceWorker" in navigator)) return;
  // Behind the first picture, with which it would compete. A browser that keeps nothing shows the page all the same.
  window.addEventListener("load", () => void navigator.serviceWorker.register("service.js").catch(() => undefined));
}
