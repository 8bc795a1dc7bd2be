/** What an editor is told by its view, and what it tells. */

import type { DeviceRow } from "../../model/door";
import type { DocumentKind } from "../../model/document_guide";

/** Language of a text. `devices`: of the bench as it is now. */
export type TextLanguage = { kind: "gcode" } | { kind: DocumentKind; devices(): Iterable<DeviceRow> };

/** Text that is written in an editor, as a draft is. */
export interface EditedText {
  readonly value: { readonly text: string };
  peek(): { readonly text: string };
  type(text: string): void;
}

/** Place of the cursor, from 1 on, and what the word there means. */
export interface CursorPlace {
  line: number;
  column: number;
  meaning: string;
}

export interface EditorOptions {
  label: string;
  /** Id of the element with the keys, for screen readers. */
  hintId: string;
  language: TextLanguage;
  typed(text: string): void;
  moved(place: CursorPlace): void;
  focused(isFocused: boolean): void;
  /** Take a file that was dropped. */
  dropped(file: File): void;
}
