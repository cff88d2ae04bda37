// A link that has a program and its settings in itself, behind the `#`, which browsers do not send.

import { addressOf } from "./address";
import { AXES } from "./axes";

export interface Shared {
  name: string;
  text: string;
  settings: string;
  axes: number;
}

/** By this name a link has what it shares. */
export const SHARED = "program";
/** What mail, chats and browsers take as one link. */
export const LINK_MAX = 8_000;
/** A link of that length can unfold to a thousand times as much. */
const UNFOLDED_MAX_BYTES = 1_000_000;

export async function linkOf({ name, text, settings, axes }: Shared): Promise<string> {
  const plain = new Blob([JSON.stringify([name, text, settings, axes])]);
  const folded = await new Response(plain.stream().pipeThrough(new CompressionStream("deflate-raw"))).arrayBuffer();
  const page = location.href.replace(/#.*$/, "");
  return `${page}${addressOf("run")}&${SHARED}=${asText(new Uint8Array(folded))}`;
}

/** What a link shares. Throws an error in words for what is none. */
export async function sharedBy(text: string): Promise<Shared> {
  const plain = await unfolded(asBytes(text));
  try {
    // Links of before A have no number of axes.
    const [name, program, settings, axes = AXES] = JSON.parse(plain) as unknown[];
    const isWhole = [name, program, settings].every((each) => typeof each === "string") && [AXES, AXES + 1].includes(axes as number);
    if (isWhole) return { name, text: program, settings, axes } as Shared;
  } catch {
    // No JSON is no program either.
  }
  throw new Error("The link has no program in it: it is damaged, or of another page.");
}

async function unfolded(bytes: Uint8Array<ArrayBuffer>): Promise<string> {
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate-raw")).getReader();
  const decoder = new TextDecoder("utf-8", { fatal: true });
  let [text, length] = ["", 0];
  for (;;) {
    const piece = await read(reader);
    if (piece.done) return text;
    length += piece.value.length;
    if (length > UNFOLDED_MAX_BYTES) {
      void reader.cancel();
      throw new Error(`The link unfolds to more than ${UNFOLDED_MAX_BYTES / 1e6} MB, which no link of this page does: it was not opened.`);
    }
    text += decoded(decoder, piece.value);
  }
}

const DAMAGED = "The link is damaged: a part of it is missing or changed. Copy it again, whole.";

async function read(reader: ReadableStreamDefaultReader<Uint8Array>): Promise<ReadableStreamReadResult<Uint8Array>> {
  try {
    return await reader.read();
  } catch {
    throw new Error(DAMAGED);
  }
}

function decoded(decoder: TextDecoder, bytes: Uint8Array): string {
  try {
    return decoder.decode(bytes, { stream: true });
  } catch {
    throw new Error(DAMAGED);
  }
}

/** In letters that an address has: base64url. */
function asText(bytes: Uint8Array): string {
  const letters = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  return btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

function asBytes(text: string): Uint8Array<ArrayBuffer> {
  try {
    return Uint8Array.from(atob(text.replaceAll("-", "+").replaceAll("_", "/")), (letter) => letter.charCodeAt(0));
  } catch {
    throw new Error(DAMAGED);
  }
}
