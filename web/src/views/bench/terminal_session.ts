/** A terminal at a port: it stays open, with what it shows, while the page is there, in sight or not. */

import { FitAddon } from "@xterm/addon-fit";
import { type ITheme, Terminal } from "@xterm/xterm";
import "@xterm/xterm/css/xterm.css";
import { effect, signal } from "@preact/signals";
import { TerminalText } from "../../model/terminal_text";
import type { TerminalHandle } from "../../net/channels";
import { link } from "../../store";
import { colour, theme } from "../../theme";
import { withSheets } from "./strict_styles";

const SCROLLBACK_LINES = 5000;

export class TerminalSession {
  /** What is to be said of the port: its baud, or why it is closed. */
  readonly note = signal("");
  readonly isOpen = signal(false);
  private readonly text = new TerminalText();
  private readonly fitting = new FitAddon();
  private readonly terminal: Terminal;
  private readonly element = document.createElement("div");
  private readonly encoder = new TextEncoder();
  private handle: TerminalHandle | null = null;
  private isShown = false;

  constructor(readonly port: string) {
    this.element.className = "terminal-screen";
    this.terminal = new Terminal({
      screenReaderMode: true,
      scrollback: SCROLLBACK_LINES,
      fontFamily: colour("--mono"),
      fontSize: 13,
      allowProposedApi: false,
      linkHandler: null,
    });
    this.terminal.loadAddon(this.fitting);
    this.terminal.onData((typed) => this.handle?.send(this.encoder.encode(typed)));
    this.terminal.attachCustomKeyEventHandler((event) => this.takesKey(event));
    effect(() => {
      void theme.value;
      queueMicrotask(() => (this.terminal.options.theme = themeOf()));
    });
    this.open();
  }

  /** Open the port, again after it was closed. */
  open(): void {
    this.handle?.close();
    this.note.value = "opening";
    this.handle = link.open(this.port, {
      bytes: (bytes) => this.terminal.write(this.text.next(bytes)),
      opened: ({ clients }) => {
        this.isOpen.value = true;
        const others = clients ? `, ${clients} other client${clients > 1 ? "s" : ""}` : "";
        this.note.value = `open${others}`;
      },
      closed: (why) => {
        this.isOpen.value = false;
        this.note.value = `closed: ${why}`;
      },
    });
  }

  close(): void {
    this.handle?.close();
    this.handle = null;
    this.isOpen.value = false;
    this.note.value = "closed";
  }

  clear(): void {
    this.terminal.clear();
  }

  send(text: string): void {
    this.handle?.send(this.encoder.encode(text));
  }

  /** Show the terminal in a place of the page; answers the function that takes it out. */
  show(place: HTMLElement): () => void {
    place.append(this.element);
    if (!this.isShown) withSheets(() => this.terminal.open(this.element));
    this.isShown = true;
    const resize = new ResizeObserver(() => this.fitting.fit());
    resize.observe(place);
    this.fitting.fit();
    return () => {
      resize.disconnect();
      this.element.remove();
    };
  }

  /** Ctrl-] leaves the terminal, which otherwise keeps the Tab key. */
  private takesKey(event: KeyboardEvent): boolean {
    if (!event.ctrlKey || event.key !== "]") return true;
    this.terminal.blur();
    this.element.closest<HTMLElement>(".terminal")?.querySelector<HTMLElement>("button")?.focus();
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

const sessions = new Map<string, TerminalSession>();

export function sessionOf(port: string): TerminalSession {
  let session = sessions.get(port);
  if (!session) sessions.set(port, (session = new TerminalSession(port)));
  return session;
}
