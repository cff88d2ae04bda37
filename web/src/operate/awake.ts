// The screen stays on while the machine may move: a computer that sleeps sends nothing.

import type { Machine } from "./machine";

export function keepAwake(machine: Machine): void {
  let lock: Promise<WakeLockSentinel | undefined> | undefined;
  const look = (): void => {
    const isWanted = machine.isAttached && machine.mayMove && !document.hidden;
    if (isWanted && !lock) lock = navigator.wakeLock?.request("screen").catch(() => undefined);
    if (isWanted || !lock) return;
    void lock.then((held) => held?.release());
    lock = undefined;
  };
  machine.watch({ reported: look, attached: look });
  document.addEventListener("visibilitychange", () => {
    // A hidden page has lost it.
    lock = undefined;
    look();
  });
}
