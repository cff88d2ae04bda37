// What is marked in the editor: lines that were refused, with the words, and the line that moves the machine.

import { type EditorState, RangeSet, RangeSetBuilder, StateEffect, type StateEffectType, StateField, type Transaction } from "@codemirror/state";
import { Decoration, type DecorationSet, EditorView, GutterMarker, gutterLineClass, WidgetType } from "@codemirror/view";

export interface Reported {
  line: number;
  words: string;
}

export const setReported = StateEffect.define<Reported[]>();
export const setCurrent = StateEffect.define<number>();

class Words extends WidgetType {
  constructor(private readonly words: string) {
    super();
  }

  override eq(other: Words): boolean {
    return other.words === this.words;
  }

  toDOM(): HTMLElement {
    const reported = document.createElement("div");
    reported.className = "cm-reported";
    reported.textContent = this.words;
    return reported;
  }
}

class LineClass extends GutterMarker {
  constructor(override readonly elementClass: string) {
    super();
  }
}

interface Marked {
  lines: DecorationSet;
  gutter: RangeSet<GutterMarker>;
}

const refused = { line: Decoration.line({ class: "cm-refused" }), gutter: new LineClass("cm-refused") };
const current = { line: Decoration.line({ class: "cm-current" }), gutter: new LineClass("cm-current") };

/** Marks that move with the text, until new ones come. */
function field(make: (transaction: Transaction) => Marked | undefined): StateField<Marked> {
  return StateField.define<Marked>({
    create: () => ({ lines: Decoration.none, gutter: RangeSet.empty }),
    update(value, transaction) {
      const made = make(transaction);
      if (made) return made;
      const { changes } = transaction;
      return changes.empty ? value : { lines: value.lines.map(changes), gutter: value.gutter.map(changes) };
    },
    provide: (self) => [
      EditorView.decorations.from(self, (value) => value.lines),
      gutterLineClass.from(self, (value) => value.gutter),
    ],
  });
}

function reported(state: EditorState, all: Reported[]): Marked {
  const [lines, gutter] = [new RangeSetBuilder<Decoration>(), new RangeSetBuilder<GutterMarker>()];
  const inOrder = all.filter(({ line }) => line >= 1 && line <= state.doc.lines).sort((one, other) => one.line - other.line);
  for (const { line, words } of inOrder) {
    const { from, to } = state.doc.line(line);
    lines.add(from, from, refused.line);
    lines.add(to, to, Decoration.widget({ widget: new Words(words), block: true, side: 1 }));
    gutter.add(from, from, refused.gutter);
  }
  return { lines: lines.finish(), gutter: gutter.finish() };
}

function moving(state: EditorState, line: number): Marked {
  if (!line) return { lines: Decoration.none, gutter: RangeSet.empty };
  const { from } = state.doc.line(line);
  return { lines: Decoration.set(current.line.range(from)), gutter: RangeSet.of(current.gutter.range(from)) };
}

/** What an effect of a transaction makes of its state. */
function by<T>(type: StateEffectType<T>, make: (state: EditorState, value: T) => Marked) {
  return ({ effects, state }: Transaction): Marked | undefined => {
    const found = effects.find((effect) => effect.is(type));
    return found && make(state, found.value as T);
  };
}

export const marks = [field(by(setReported, reported)), field(by(setCurrent, moving))];
