// The colours of G-code.

import { HighlightStyle, StreamLanguage, syntaxHighlighting } from "@codemirror/language";
import { tags } from "@lezer/highlight";
import type { Extension } from "@codemirror/state";

const WORDS: Record<string, string> = { G: "keyword", M: "controlKeyword", F: "typeName", S: "typeName", T: "typeName", N: "meta", O: "meta" };

const language = StreamLanguage.define<null>({
  name: "gcode",
  languageData: { commentTokens: { line: ";", block: { open: "(", close: ")" } } },
  token(stream) {
    if (stream.eatSpace()) return null;
    if (stream.sol() && stream.match(/^\$[^;(]*/)) return "macroName";
    if (stream.match(/^;.*/) || stream.match(/^\([^)]*\)?/)) return "comment";
    const word = stream.match(/^([A-Za-z])\s*[-+]?[\d.]+/) as RegExpMatchArray | null;
    if (word) return WORDS[word[1]?.toUpperCase() ?? ""] ?? "propertyName";
    stream.next();
    return "meta";
  },
});

const style = HighlightStyle.define([
  { tag: tags.keyword, color: "var(--accent)", fontWeight: "600" },
  { tag: tags.controlKeyword, color: "var(--tool)", fontWeight: "600" },
  { tag: tags.typeName, color: "var(--y)" },
  { tag: tags.propertyName, color: "var(--ink)" },
  { tag: tags.macroName, color: "var(--good)" },
  { tag: [tags.comment, tags.meta], color: "var(--muted)" },
]);

export const gcode: Extension = [language, syntaxHighlighting(style)];
