// The page: a program on the machine, and the machine to operate.

import { button, part } from "./elements";
import { stayHere } from "./offline";
import { SpeedProfiles } from "./profiles";
import { Operate } from "./operate/operate";
import { Run } from "./run";
import { SettingsView } from "./settings/settings";

const VIEWS = ["run", "operate", "settings", "profiles"] as const;
/** Those of the machine, which have its bar of buttons always; others have it while the machine may move. */
const OF_MACHINE = ["operate", "settings"];

const run = new Run();
const operate = new Operate(() => ({ name: run.title, text: run.editor.value }), () => run.settingsLines);
new SettingsView(operate.machine);
const speedProfiles = new SpeedProfiles();

let viewed: (typeof VIEWS)[number] = "run";

function showBar(): void {
  part("bar").hidden = !OF_MACHINE.includes(viewed) && !operate.machine.mayMove;
}
operate.machine.watch({ reported: showBar, attached: showBar });

function look(view: (typeof VIEWS)[number]): void {
  viewed = view;
  for (const name of VIEWS) {
    part(`view-${name}`).hidden = name !== view;
    const tab = button(`tab-${name}`);
    tab.setAttribute("aria-selected", String(name === view));
    tab.tabIndex = name === view ? 0 : -1;
  }
  showBar();
  if (OF_MACHINE.includes(view)) operate.look();
  if (view === "profiles") speedProfiles.look();
}

for (const name of VIEWS) {
  const tab = button(`tab-${name}`);
  tab.onclick = () => {
    location.hash = name;
  };
  tab.onkeydown = (event) => {
    if (!["ArrowLeft", "ArrowRight"].includes(event.key)) return;
    const step = event.key === "ArrowLeft" ? VIEWS.length - 1 : 1;
    const other = VIEWS[(VIEWS.indexOf(name) + step) % VIEWS.length] ?? name;
    location.hash = other;
    button(`tab-${other}`).focus();
  };
}

const fromAddress = (): void => look(VIEWS.find((view) => location.hash === `#${view}`) ?? "run");
window.addEventListener("hashchange", fromAddress);
fromAddress();
stayHere();
