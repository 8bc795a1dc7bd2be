/** Colours of the style sheet for canvases, read once for each theme. */

import { colour, theme } from "../theme";

export interface Palette {
  traces: string[];
  ink: string;
  soft: string;
  line: string;
  grid: string;
  panel: string;
  bad: string;
  badBand: string;
  accent: string;
  mono: string;
}

let known: { theme: string; palette: Palette } | null = null;

export function palette(): Palette {
  if (known?.theme !== theme.peek()) known = { theme: theme.peek(), palette: read() };
  return known.palette;
}

function read(): Palette {
  return {
    traces: [1, 2, 3, 4, 5, 6].map((number) => colour(`--trace-${number}`)),
    ink: colour("--ink"),
    soft: colour("--ink-2"),
    line: colour("--line"),
    grid: colour("--line-soft"),
    panel: colour("--panel"),
    bad: colour("--bad"),
    badBand: colour("--bad-band"),
    accent: colour("--accent"),
    mono: colour("--mono"),
  };
}
