// The page: a program on the machine, and the machine to operate.

import { button, part } from "./elements";
import { Operate } from "./operate/operate";
import { Run } from "./run";

const VIEWS = ["run", "operate"] as const;

const run = new Run();
const operate = new Operate(() => run.editor.value, () => run.settingsLines);

function look(view: (typeof VIEWS)[number]): void {
  for (const name of VIEWS) {
    part(`view-${name}`).hidden = name !== view;
    const tab = button(`tab-${name}`);
    tab.setAttribute("aria-selected", String(name === view));
    tab.tabIndex = name === view ? 0 : -1;
  }
  if (view === "operate") operate.look();
}

for (const name of VIEWS) {
  const tab = button(`tab-${name}`);
  tab.onclick = () => {
    location.hash = name;
  };
  tab.onkeydown = (event) => {
    if (!["ArrowLeft", "ArrowRight"].includes(event.key)) return;
    const other = VIEWS.find((view) => view !== name) ?? name;
    location.hash = other;
    button(`tab-${other}`).focus();
  };
}

const fromAddress = (): void => look(location.hash === "#operate" ? "operate" : "run");
window.addEventListener("hashchange", fromAddress);
fromAddress();
