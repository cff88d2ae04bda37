// The program as text: G-code in colours, with what was refused reported below its line, and the line marked that moves the
// machine.

import { defaultKeymap, history, historyKeymap } from "@codemirror/commands";
import { searchKeymap } from "@codemirror/search";
import { EditorState, type Extension, type Text } from "@codemirror/state";
import { drawSelection, EditorView, highlightActiveLine, keymap, lineNumbers } from "@codemirror/view";
import { part } from "./elements";
import { bytes } from "./job";
import { gcode } from "./gcode";
import { tooLong } from "./long";
import { marks, setCurrent, setReported, type Reported } from "./marks";

const theme = EditorView.theme({
  "&": { height: "100%", color: "var(--ink)", backgroundColor: "var(--card)", fontSize: "13px" },
  "&.cm-focused": { outline: "3px solid var(--accent)", outlineOffset: "-3px" },
  ".cm-scroller": { fontFamily: 'ui-monospace, "DejaVu Sans Mono", monospace', lineHeight: "1.5" },
  ".cm-content": { caretColor: "var(--ink)" },
  ".cm-cursor": { borderLeftColor: "var(--ink)" },
  ".cm-gutters": { color: "var(--muted)", backgroundColor: "var(--paper)", border: "0" },
  ".cm-activeLine": { backgroundColor: "transparent" },
  "&.cm-focused .cm-activeLine": { backgroundColor: "color-mix(in srgb, var(--accent) 8%, transparent)" },
  "& .cm-selectionBackground, &.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground": {
    backgroundColor: "color-mix(in srgb, var(--accent) 28%, transparent)",
  },
  ".cm-panels": { color: "var(--ink)", backgroundColor: "var(--paper)" },
  ".cm-panel input, .cm-panel button": { font: "inherit", color: "var(--ink)", background: "var(--card)", border: "1px solid var(--bound)" },
  ".cm-line.cm-current": { backgroundColor: "color-mix(in srgb, var(--tool) 18%, transparent)" },
  ".cm-gutterElement.cm-current": { color: "var(--tool)", fontWeight: "700" },
  ".cm-line.cm-refused": { backgroundColor: "var(--bad-paper)" },
  ".cm-gutterElement.cm-refused": { color: "var(--card)", backgroundColor: "var(--bad)", fontWeight: "700" },
  ".cm-reported": { contain: "inline-size", padding: "0.1rem 0.6rem 0.3rem", color: "var(--bad)", backgroundColor: "var(--bad-paper)", whiteSpace: "pre-wrap", fontFamily: "system-ui, sans-serif" },
});

export class Editor {
  /** In a shadow root of its own, because only there its styles need no permission of the content security policy. */
  private readonly view: EditorView;
  private marked = 0;
  private text: { doc: Text; value: string } | undefined;

  /** `changed` hears of every change that a person makes, and `refused` why what was pasted is not taken. */
  constructor(
    private readonly changed: () => void,
    private readonly refused: (words: string) => void,
  ) {
    const root = part("program").attachShadow({ mode: "open" });
    this.view = new EditorView({ state: this.state(""), parent: root, root });
  }

  private state(doc: string): EditorState {
    const extensions: Extension = [
      lineNumbers(),
      history(),
      drawSelection(),
      highlightActiveLine(),
      keymap.of([...defaultKeymap, ...searchKeymap, ...historyKeymap]),
      gcode,
      marks,
      theme,
      EditorView.updateListener.of((update) => update.docChanged && this.changed()),
      EditorView.contentAttributes.of({ "aria-label": "G-code; a file may be dropped here", spellcheck: "false", autocapitalize: "off", tabindex: "0" }),
      // The page takes files.
      EditorView.domEventHandlers({
        drop: (event) => (event.dataTransfer?.files.length ?? 0) > 0,
        paste: (event) => this.refuses(event.clipboardData?.getData("text/plain") ?? ""),
      }),
    ];
    return EditorState.create({ doc, extensions });
  }

  private refuses(pasted: string): boolean {
    const words = tooLong(pasted);
    if (words) this.refused(`nothing was pasted: ${words}.`);
    return words !== undefined;
  }

  /** The text in UTF-8. It may be megabytes, so no string is made of it if it can be without. */
  get bytes(): Uint8Array {
    const { doc } = this.view.state;
    const made = new Uint8Array(doc.length);
    let length = 0;
    for (const piece of doc.iter()) {
      for (let index = 0; index < piece.length; index++) {
        const code = piece.charCodeAt(index);
        if (code > 127) return bytes(doc.toString());
        made[length++] = code;
      }
    }
    return made;
  }

  /** The text, which is made once for each change: it is asked for with every report of a machine. */
  get value(): string {
    const { doc } = this.view.state;
    if (this.text?.doc !== doc) this.text = { doc, value: doc.toString() };
    return this.text.value;
  }

  load(text: string): void {
    this.view.setState(this.state(text));
    this.marked = 0;
  }

  /** Tells these below their lines. */
  tell(reported: Reported[]): void {
    this.view.dispatch({ effects: setReported.of(reported) });
  }

  /** Marks a line, from 1, or none, and brings it into view if that is wanted. */
  mark(line: number, follow: boolean): void {
    if (line === this.marked) return;
    this.marked = line;
    const place = this.place(line);
    const scroll = place && follow ? [EditorView.scrollIntoView(place.from)] : [];
    this.view.dispatch({ effects: [setCurrent.of(place ? line : 0), ...scroll] });
  }

  /** Selects a line, from 1, and brings it into view. */
  go(line: number): void {
    const place = this.place(line);
    if (!place) return;
    this.view.dispatch({
      selection: { anchor: place.from, head: place.to },
      effects: EditorView.scrollIntoView(place.from, { y: "center" }),
    });
    this.view.focus();
    this.view.dom.scrollIntoView({ block: "nearest" });
  }

  private place(line: number): { from: number; to: number } | undefined {
    const { doc } = this.view.state;
    return line >= 1 && line <= doc.lines ? doc.line(line) : undefined;
  }
}
