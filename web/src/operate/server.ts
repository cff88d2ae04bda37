// What the page knows of its server: whether it has a board, and the token by which it lends it.

const KEPT = "token";

/** Whether there is a board to ask for. A plain file server has a file that says no. */
export async function serverHasBoard(): Promise<boolean> {
  try {
    const answer: { has_board?: boolean } = await (await fetch("board.json")).json();
    return answer.has_board === true;
  } catch {
    return false;
  }
}

/** The token of the address that the server printed. It is taken out of the address, and kept as long as the tab. */
export function serversToken(): string | null {
  const found = /&token=([0-9a-f]+)/.exec(location.hash);
  if (found?.[1]) {
    sessionStorage.setItem(KEPT, found[1]);
    history.replaceState(null, "", location.hash.replace(found[0], ""));
  }
  return sessionStorage.getItem(KEPT);
}
