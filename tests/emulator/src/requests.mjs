import { readSync, writeFileSync } from 'node:fs';

/** File descriptors are used by number, because after process.stdin is used, reads no longer block. */
const [STDIN, STDOUT] = [0, 1];

/** What has been read and not asked for yet: its first line may be for who reads next. */
let rest = '';

/** The lines on stdin, until the other program has closed it. */
export function* requests() {
  const chunk = Buffer.alloc(65536);
  for (;;) {
    for (let end = rest.indexOf('\n'); end >= 0; end = rest.indexOf('\n')) {
      const line = rest.slice(0, end);
      rest = rest.slice(end + 1);
      yield line;
    }
    const count = readSync(STDIN, chunk);
    if (count === 0) return;
    rest += chunk.toString('latin1', 0, count);
  }
}

/** Writes a line, and waits until all of it is written. */
export function print(line) {
  writeFileSync(STDOUT, `${line}\n`);
}
