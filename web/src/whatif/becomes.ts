// "8:39 becomes 6:12, 2:27 less (29 %)".

/** Seconds as a clock shows them; below a minute to the millisecond. */
export function clock(seconds: number): string {
  if (seconds < 60) return `${seconds.toFixed(3)} s`;
  const whole = Math.round(seconds);
  const [hours, minutes, rest] = [Math.floor(whole / 3600), Math.floor((whole % 3600) / 60), whole % 60];
  const two = (number: number): string => String(number).padStart(2, "0");
  return hours ? `${hours}:${two(minutes)}:${two(rest)}` : `${minutes}:${two(rest)}`;
}

/** What is shown of it, so that what is shown adds up. */
const shown = (seconds: number): number => (seconds < 60 ? Number(seconds.toFixed(3)) : Math.round(seconds));

export function becomes(beforeS: number, afterS: number): string {
  const [from, to] = [clock(beforeS), clock(afterS)];
  if (from === to) return `${from}, as before`;
  const difference = shown(afterS) - shown(beforeS);
  const percent = (100 * Math.abs(difference)) / beforeS;
  const share = beforeS > 0 ? ` (${percent.toFixed(percent < 1 ? 1 : 0)} %)` : "";
  return `${from} becomes ${to}, ${clock(Math.abs(difference))} ${difference < 0 ? "less" : "more"}${share}`;
}
