// "Copy a link": the program and its settings in an address.

import { button, input, part } from "./elements";
import { LINK_MAX, linkOf, type Shared } from "./link";

export function offerLink(shared: () => Shared): void {
  const shown = input("link");
  const say = (words: string): void => void (part("link-state").textContent = words);
  button("copy-link").onclick = async () => {
    shown.hidden = true;
    const link = await linkOf(shared());
    const length = link.length.toLocaleString("en");
    if (link.length > LINK_MAX) return say(`A link to this would have ${length} characters, and at most ${LINK_MAX.toLocaleString("en")} are sure to travel: send the file instead.`);
    try {
      await navigator.clipboard.writeText(link);
      say(`Copied: ${length} characters, which have the program and its settings in them.`);
    } catch {
      // The browser does not let a page write there: a person can.
      shown.hidden = false;
      shown.value = link;
      shown.select();
      say(`This is the link, ${length} characters: copy it.`);
    }
  };
}
