// The table of settings, from the machine's own code.

import { worker } from "../job";
import type { FromWorker, SettingRow, ToWorker, Trouble } from "../messages";

export class Table {
  private readonly worker: Worker;
  private readonly waiting: ((answer: FromWorker) => void)[] = [];

  /** Of a machine with so many axes. */
  constructor(readonly axes: number) {
    this.worker = worker(axes);
    this.worker.onmessage = ({ data }: MessageEvent<FromWorker>) => this.waiting.shift()?.(data);
  }

  /** It is wanted no more. */
  end(): void {
    this.worker.terminate();
  }

  async rows(): Promise<SettingRow[]> {
    const answer = await this.ask({ do: "setting-rows" });
    return answer.is === "setting-rows" ? answer.rows : [];
  }

  /** Why these settings cannot be together, on whichever board. */
  async refusal(lines: string): Promise<Trouble | null> {
    const answer = await this.ask({ do: "check-settings", lines });
    if (answer.is === "trouble") return answer.trouble;
    return answer.is === "settings-checked" ? answer.refusal : null;
  }

  private ask(question: ToWorker): Promise<FromWorker> {
    this.worker.postMessage(question);
    return new Promise((resolve) => this.waiting.push(resolve));
  }
}
