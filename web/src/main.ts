// The page: a program on the machine, and the machine to operate.

import { addressOf, type View, viewInAddress, VIEWS } from "./address";
import { button, part } from "./elements";
import { stayHere } from "./offline";
import { Picture } from "./picture/picture";
import { SpeedProfiles } from "./profiles";
import { Operate } from "./operate/operate";
import { Run } from "./run";
import { SettingsView } from "./settings/settings";

/** Those of the machine, which have its bar of buttons always; others have it while the machine may move, or something is wrong with it. */
const OF_MACHINE = ["operate", "settings"];

const picture = new Picture();
const operate: Operate = new Operate(picture, () => ({ name: run.title, text: run.editor.value }), () => run.settingsLines);
const run = new Run(picture, () => operate.programChanged());
new SettingsView(operate.machine);
const speedProfiles = new SpeedProfiles();

let viewed: View = "run";

function showBar(): void {
  part("bar").hidden = !OF_MACHINE.includes(viewed) && !operate.machine.mayMove && part("bar-trouble").hidden;
}
operate.machine.watch({ reported: showBar, attached: showBar, alarmed: showBar, linked: showBar });

function look(view: View): void {
  viewed = view;
  for (const name of VIEWS) {
    part(`view-${name}`).hidden = name !== view;
    const tab = button(`tab-${name}`);
    tab.setAttribute("aria-selected", String(name === view));
    tab.tabIndex = name === view ? 0 : -1;
  }
  showBar();
  // There is one picture: of the run, or of the machine.
  if (view === "operate") part("picture-of-machine").append(part("picture"));
  if (view === "run") part("picture-of-run").append(part("picture"));
  part("playback").hidden = view === "operate";
  run.showRun(view === "run");
  operate.look(view === "operate");
  if (view === "settings") operate.attach();
  if (view === "profiles") speedProfiles.look();
}

for (const name of VIEWS) {
  const tab = button(`tab-${name}`);
  tab.onclick = () => {
    location.hash = addressOf(name);
  };
  tab.onkeydown = (event) => {
    if (!["ArrowLeft", "ArrowRight"].includes(event.key)) return;
    const step = event.key === "ArrowLeft" ? VIEWS.length - 1 : 1;
    const other = VIEWS[(VIEWS.indexOf(name) + step) % VIEWS.length] ?? name;
    location.hash = addressOf(other);
    button(`tab-${other}`).focus();
  };
}

const fromAddress = (): void => {
  run.openLink();
  look(viewInAddress());
};
window.addEventListener("hashchange", fromAddress);
fromAddress();
stayHere();
