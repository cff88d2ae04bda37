// The settings of the machine: entered or loaded, looked at, and sent.

import { axesOf } from "../axes";
import { area, button, input, made, part, save, select } from "../elements";
import type { SettingRow } from "../messages";
import type { Machine } from "../operate/machine";
import { Form } from "./form";
import { differences, file, isNumber, read, reason } from "./lines";
import type { Row } from "./row";
import { mayBeSet, send } from "./send";
import { refusal, rows } from "./table";

export class SettingsView {
  /** How many axes the rows are of. */
  private axes = 0;
  private readonly form = new Form(() => this.showPending());
  private rows: SettingRow[] = [];
  private isSending = false;

  constructor(private readonly machine: Machine) {
    button("send-settings").onclick = () => void this.send();
    button("discard-settings").onclick = () => this.discard();
    button("save-settings").onclick = () => save("settings.txt", new Blob([file(machine.settings)], { type: "text/plain" }));
    button("save-differences").onclick = () => save("settings.txt", new Blob([this.differences], { type: "text/plain" }));
    button("settings-for-run").onclick = () => this.useForRun();
    this.offerFile();
    this.offerDefaults();
    machine.watch({
      set: () => this.follow(),
      reported: (report, before) => report.state !== before.state && this.showPending(),
    });
  }

  /** The rows are asked for when there is a machine that they are of. Another machine may have another number of axes, and so other settings. */
  private follow(): void {
    if (!this.machine.settings.size) return;
    const axes = axesOf(this.machine.settings);
    if (axes === this.axes) return this.show();
    this.axes = axes;
    this.rows = [];
    void this.ask(axes);
  }

  private async ask(axes: number): Promise<void> {
    const found = await rows(axes);
    if (axes !== this.axes) return;
    this.rows = found;
    this.show();
  }

  private get differences(): string {
    return file(differences(this.rows, this.machine.settings));
  }

  private get pending(): Row[] {
    return this.form.rows.filter((row) => row.isChanged);
  }

  private say(words: string): void {
    part("settings-status").textContent = words;
  }

  private show(): void {
    if (!this.machine.settings.size || !this.rows.length) return;
    this.form.show(this.rows, this.machine.settings);
    this.showPending();
  }

  private showPending(): void {
    const { pending } = this;
    part("pending").hidden = pending.length === 0;
    part("pending-list").replaceChildren(...pending.map((row) => made("li", row.change)));
    button("send-settings").textContent = `Send ${pending.length === 1 ? "this change" : `these ${pending.length} changes`}`;
    const may = mayBeSet(this.machine.state);
    button("send-settings").disabled = this.isSending || !may;
    button("restore-settings").disabled = this.isSending || !may;
    part("settings-when").textContent = may ? "" : `The machine takes settings in Idle and Alarm; it is in ${this.machine.state}.`;
  }

  private discard(): void {
    for (const row of this.form.rows) row.discard();
    this.say("");
    this.showPending();
  }

  private async send(): Promise<void> {
    const { pending } = this;
    this.isSending = true;
    this.showPending();
    if (await this.areTogether(pending)) {
      const sent = await send(this.machine, pending.map((row) => [row.about.number, row.value]));
      await new Promise<void>((resolve) => this.machine.readSettings(resolve));
      for (const row of pending) row.refuse(sent.refused.get(row.about.number) ?? "");
      this.say([`${sent.taken.length} set.`, ...sent.refused.values(), sent.remark].filter(Boolean).join(" "));
    }
    this.isSending = false;
    this.showPending();
  }

  /** Nothing is sent of what no machine would take. */
  private async areTogether(pending: Row[]): Promise<boolean> {
    for (const row of pending) row.refuse(isNumber(row.value) ? "" : `\`${row.value}\` is no number.`);
    if (!pending.every((row) => isNumber(row.value))) return this.refuse("a value is no number.");
    const known = new Set(this.rows.map((row) => row.number));
    const wanted = new Map(this.machine.settings);
    // What changes comes last, so that a refusal names it.
    for (const row of pending) {
      wanted.delete(row.about.number);
      wanted.set(row.about.number, row.value);
    }
    const lines = [...wanted].filter(([number]) => known.has(number));
    const trouble = await refusal(file(lines), this.axes);
    if (!trouble) return true;
    const number = lines[(trouble.line ?? 0) - 1]?.[0];
    const words = reason(trouble.words);
    this.form.rows.find((row) => row.about.number === number)?.refuse(words);
    return this.refuse(words);
  }

  private refuse(words: string): false {
    this.say(`Nothing was sent: ${words}`);
    return false;
  }

  private offerFile(): void {
    const chosen = input("settings-file");
    button("load-settings").onclick = () => chosen.click();
    chosen.onchange = async () => {
      const [found] = chosen.files ?? [];
      if (found) this.load(found.name, await found.text());
      chosen.value = "";
    };
  }

  /** Enters the values of a file. They are sent when a person has looked at them. */
  private load(name: string, text: string): void {
    const wanted = read(text);
    if (!wanted.size) return this.say(`${name} has no $n=v line.`);
    for (const row of this.form.rows) row.enter(wanted.get(row.about.number) ?? row.value);
    const has = new Set(this.form.rows.map((row) => row.about.number));
    const unknown = [...wanted.keys()].filter((number) => !has.has(number)).map((number) => `$${number}`);
    const left = unknown.length ? ` Left out, because this machine does not have them: ${unknown.join(", ")}.` : "";
    this.say(`${name}: ${this.pending.length} of ${wanted.size} values are not in force.${left}`);
    this.showPending();
  }

  private offerDefaults(): void {
    const ask = part("restore-ask");
    button("restore-settings").onclick = () => {
      ask.hidden = false;
      button("restore-no").focus();
    };
    button("restore-no").onclick = () => (ask.hidden = true);
    button("restore-yes").onclick = () => {
      ask.hidden = true;
      this.discard();
      this.machine.command("$RST=$", (answer) => this.say(answer === "ok" ? "All settings are at their defaults." : "Refused: see the console."));
    };
  }

  private useForRun(): void {
    select("axes").value = String(this.axes);
    area("settings").value = this.differences;
    area("settings").dispatchEvent(new Event("input"));
    this.say("The settings that differ from the defaults stand on the page of programs now, and count from the next run and power-up on.");
  }
}
