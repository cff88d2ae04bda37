// What the address says behind its `#`: a view, as `#/run`, and what is handed to it, as `&program=`. The names differ from those of
// elements, to which a browser would scroll; `#run` is what addresses were before.

export const VIEWS = ["run", "operate", "settings", "profiles"] as const;
export type View = (typeof VIEWS)[number];

export const addressOf = (view: View): string => `#/${view}`;

export function viewInAddress(): View {
  const name = /^#\/?([a-z]+)/.exec(location.hash)?.[1];
  return VIEWS.find((view) => view === name) ?? "run";
}

/** What is handed over by this name. It is taken out of the address, so that a reload has what became of it. */
export function handed(name: string): string | undefined {
  const found = new RegExp(`&${name}=([^&]*)`).exec(location.hash);
  if (!found) return undefined;
  history.replaceState(null, "", location.hash.replace(found[0], ""));
  return found[1];
}
