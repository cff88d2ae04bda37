// The program of this tab, which outlives a reload.

export interface KeptProgram {
  name: string;
  isChanged: boolean;
  text: string;
  settings: string;
  /** Pages of before A have not kept it. */
  axes?: number;
}

const KEPT = "program";

export function keepProgram(program: KeptProgram): void {
  try {
    sessionStorage.setItem(KEPT, JSON.stringify(program));
  } catch {
    // Too long for the browser: then a reload begins with the demonstration, and nothing else is lost.
    sessionStorage.removeItem(KEPT);
  }
}

/** The program of before a reload, if there is one. */
export function keptProgram(): KeptProgram | undefined {
  const found = sessionStorage.getItem(KEPT);
  return found ? (JSON.parse(found) as KeptProgram) : undefined;
}
