/** Tooltip with what a word means. */

import type { Tooltip } from "@codemirror/view";

export function meaningTooltip(pos: number, end: number, text: string): Tooltip {
  return {
    pos,
    end,
    above: true,
    create() {
      const dom = document.createElement("div");
      dom.className = "editor-meaning";
      dom.textContent = text;
      return { dom };
    },
  };
}
