// Files of a run. It is made once more for each: equal runs are equal to the byte.

import { button, save } from "./elements";
import { run, type Task, type Watcher } from "./job";
import type { Kept, Trouble } from "./messages";

export interface Source {
  /** The program's file name. */
  name: string;
  program: () => Uint8Array;
  settings: string;
}

/** Who shows how far it is. */
export interface Teller {
  busy(isBusy: boolean): void;
  say(words: string): void;
  trouble(trouble: Trouble): void;
}

export class Downloads {
  constructor(
    private readonly task: Task,
    private readonly source: () => Source,
    private readonly teller: Teller,
    picture: () => Promise<Blob | null>,
  ) {
    button("save-trace").onclick = () => this.rows("trace", "csv", "text/csv");
    button("save-waves").onclick = () => this.rows("waves", "vcd", "text/plain");
    button("save-report").onclick = () => this.report();
    button("save-picture").onclick = () => void picture().then((file) => file && save(this.file("png"), file));
  }

  private file(ending: string): string {
    return `${this.source().name.replace(/\.[^.]*$/, "")}.${ending}`;
  }

  private rows(kept: Kept, ending: string, type: string): void {
    const { program, settings } = this.source();
    const made: Uint8Array[] = [];
    const watcher: Watcher = {
      motion: () => {},
      lines: () => {},
      progress: (answered, lines) => this.teller.say(`The ${ending.toUpperCase()} file: ${answered} of ${lines} lines`),
      rows: (more) => void made.push(more),
      ended: () => this.done(ending, new Blob(made as BlobPart[], { type })),
      trouble: (trouble) => this.teller.trouble(trouble),
    };
    this.teller.busy(true);
    run(this.task, program(), settings, kept, watcher);
  }

  private report(): void {
    const { name, program, settings } = this.source();
    this.teller.busy(true);
    this.teller.say("The report is being made.");
    this.task.ask(
      { do: "report", name, program: program(), settings },
      (said) => {
        if (said.is === "reported") this.done("json", new Blob([said.report], { type: "application/json" }));
        return true;
      },
      (trouble) => this.teller.trouble(trouble),
    );
  }

  private done(ending: string, file: Blob): void {
    this.teller.busy(false);
    save(this.file(ending), file);
    this.teller.say(`${this.file(ending)} is saved.`);
  }
}
