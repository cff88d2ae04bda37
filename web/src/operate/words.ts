// What `error:N` means, in the machine's words. It is asked for once.

type Query = (line: string, then: (printed: string[]) => void) => void;

export class Words {
  private readonly known = new Map<string, string>();

  constructor(private readonly query: Query) {}

  /** An answer with its words; as it is if the machine does not explain it. */
  of(answer: string, then: (words: string) => void): void {
    const known = this.known.get(answer);
    if (known !== undefined) return then(known);
    const code = /^error:(\d+)$/.exec(answer)?.[1];
    if (!code) return then(answer);
    this.query(`$E${code}`, (printed) => {
      const words = printed.map((line) => /^\[MSG:(.*)\]$/.exec(line)?.[1] ?? "").join(" ").trim();
      if (words) this.known.set(answer, `${answer}: ${words}`);
      then(words ? `${answer}: ${words}` : answer);
    });
  }
}
