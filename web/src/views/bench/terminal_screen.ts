/** What a port said, in a terminal: text that can be typed at, with times, or in hexadecimal digits. */

import { FitAddon } from "@xterm/addon-fit";
import type { SearchAddon } from "@xterm/addon-search";
import { type ITheme, Terminal } from "@xterm/xterm";
import "@xterm/xterm/css/xterm.css";
import { effect } from "@preact/signals";
import type { Piece } from "../../model/port_record";
import { type TerminalView, viewOf, type ViewName } from "../../model/terminal_views";
import { colour, theme } from "../../theme";
import { takeSpanStyles, withSheets } from "../../parts/strict_styles";
import type { TerminalPort } from "./terminal_port";

const SCROLLBACK_LINES = 10_000;
const FONT_PX = 13;
/** On a narrow screen more columns are worth more than large letters. */
const SMALL_FONT_PX = 11;
const NARROW_PX = 640;
/** A board may write black on black; what it says can be read all the same. */
const CONTRAST = 4.5;

takeSpanStyles();

export class TerminalScreen {
  private readonly fitting = new FitAddon();
  private readonly terminal: Terminal;
  private readonly encoder = new TextEncoder();
  private search: SearchAddon | null = null;
  private view: TerminalView;
  private readonly ends: (() => void)[] = [];

  constructor(
    private readonly port: TerminalPort,
    private readonly place: HTMLElement,
    private readonly name: ViewName,
  ) {
    this.terminal = new Terminal({
      screenReaderMode: true,
      scrollback: SCROLLBACK_LINES,
      fontFamily: colour("--mono"),
      fontSize: innerWidth < NARROW_PX ? SMALL_FONT_PX : FONT_PX,
      allowProposedApi: false,
      minimumContrastRatio: CONTRAST,
      linkHandler: null,
    });
    this.terminal.loadAddon(this.fitting);
    this.terminal.onData((typed) => port.type(this.encoder.encode(typed)));
    this.terminal.attachCustomKeyEventHandler((event) => this.takesKey(event));
    withSheets(() => this.terminal.open(place));
    const resize = new ResizeObserver(() => this.fitting.fit());
    resize.observe(place);
    const hear = (piece: Piece | null) => (piece ? this.terminal.write(this.view.next(piece)) : this.again());
    port.listeners.add(hear);
    this.ends.push(
      () => resize.disconnect(),
      () => port.listeners.delete(hear),
      effect(() => {
        void theme.value;
        queueMicrotask(() => (this.terminal.options.theme = themeOf()));
      }),
    );
    this.fitting.fit();
    this.view = this.newView();
    this.writeAll();
  }

  end(): void {
    for (const end of this.ends) end();
    this.terminal.dispose();
  }

  focus(): void {
    this.terminal.focus();
  }

  /** Show the next place of a text, or the one before; false: there is none. */
  async find(text: string, isBack: boolean): Promise<boolean> {
    if (!this.search) {
      const { SearchAddon } = await import("@xterm/addon-search");
      this.search = new SearchAddon();
      this.terminal.loadAddon(this.search);
    }
    return isBack ? this.search.findPrevious(text) : this.search.findNext(text);
  }

  private newView(): TerminalView {
    return viewOf(this.name, this.port.record.gone);
  }

  /** Begin with an empty screen: what was shown is gone. */
  private again(): void {
    this.terminal.reset();
    this.view = this.newView();
    this.writeAll();
  }

  private writeAll(): void {
    this.terminal.write(this.port.record.pieces.map((piece) => this.view.next(piece)).join(""));
  }

  /** Ctrl-] leaves the terminal, which otherwise keeps the Tab key. */
  private takesKey(event: KeyboardEvent): boolean {
    if (!event.ctrlKey || event.key !== "]") return true;
    this.terminal.blur();
    this.place.closest<HTMLElement>(".terminal")?.querySelector<HTMLElement>("button")?.focus();
    event.preventDefault();
    return false;
  }
}

function themeOf(): ITheme {
  return {
    background: colour("--sunk"),
    foreground: colour("--ink"),
    cursor: colour("--accent"),
    cursorAccent: colour("--sunk"),
    selectionBackground: colour("--line"),
  };
}
