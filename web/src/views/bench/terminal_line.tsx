/** A line that is written as a whole before it goes to a board, with those that were sent before. */

import { useRef, useState } from "preact/hooks";
import { Kept, keptTexts, ownOf } from "../../kept";
import { type Ending, ENDING_NAMES, ENDINGS, withLine } from "../../model/sent_lines";
import type { TerminalPort } from "./terminal_port";

/** Lines that were sent to each port. */
const sent = new Kept<Readonly<Record<string, readonly string[]>>>(
  "terminal.sent",
  () => ({}),
  (raw) =>
    typeof raw === "object" && raw !== null
      ? Object.fromEntries(Object.entries(raw).map(([port, lines]) => [port, Array.isArray(lines) ? lines.filter((line) => typeof line === "string") : []]))
      : undefined,
);
const drafts = keptTexts("terminal.line");
const endings = keptTexts("terminal.ending");
const USUAL: Ending = "CR";

/** What ends the lines for a board of this profile. */
export function endingOf(profile: string): Ending {
  return ENDING_NAMES.find((each) => each === endings.value[profile]) ?? USUAL;
}

export function SendLine({ port, profile }: { port: TerminalPort; profile: string }) {
  const text = ownOf(drafts.value, port.port) ?? "";
  const setText = (to: string) => (drafts.value = { ...drafts.value, [port.port]: to });
  const input = useRef<HTMLInputElement>(null);
  /** How far back in the lines that were sent; 0: it is a new one. */
  const [back, setBack] = useState(0);
  const [written, setWritten] = useState("");
  const lines = ownOf(sent.value, port.port) ?? [];
  const ending = endingOf(profile);
  const isOpen = port.isOpen.value;
  const send = (all: string[]) => {
    port.type(new TextEncoder().encode(all.map((line) => line + ENDINGS[ending]).join("")));
    sent.value = { ...sent.peek(), [port.port]: all.reduce<readonly string[]>(withLine, lines) };
    setBack(0);
  };
  const goBack = (by: number) => {
    const to = Math.min(Math.max(back + by, 0), lines.length);
    if (back === 0) setWritten(text);
    setBack(to);
    setText(to ? lines.at(-to)! : back ? written : text);
  };
  const paste = (event: ClipboardEvent) => {
    const pasted = event.clipboardData?.getData("text/plain") ?? "";
    if (!/[\r\n]/.test(pasted) || !isOpen) return;
    event.preventDefault();
    const box = event.currentTarget as HTMLInputElement;
    const whole = text.slice(0, box.selectionStart ?? text.length) + pasted + text.slice(box.selectionEnd ?? text.length);
    const all = whole.split(/\r\n|\r|\n/);
    setText(all.pop() ?? "");
    send(all);
  };
  return (
    <form
      class="row terminal-line"
      onSubmit={(event) => {
        event.preventDefault();
        if (!isOpen) return;
        send([text]);
        setText("");
        input.current?.focus();
      }}
    >
      <input
        ref={input}
        class="mono"
        type="text"
        autocomplete="off"
        spellcheck={false}
        aria-label={`Line to ${port.port}; arrow up brings back what was sent`}
        placeholder="a line; ↑ brings back what was sent"
        value={text}
        onInput={(event) => {
          setBack(0);
          setText(event.currentTarget.value);
        }}
        onPaste={paste}
        onKeyDown={(event) => {
          const by = { ArrowUp: 1, ArrowDown: -1 }[event.key];
          if (!by || event.altKey || event.ctrlKey) return;
          event.preventDefault();
          goBack(by);
        }}
      />
      <label>
        <span class="out-of-sight">End of a line</span>
        <select value={ending} title="What ends a line" onChange={(event) => (endings.value = { ...endings.peek(), [profile]: event.currentTarget.value })}>
          {ENDING_NAMES.map((each) => (
            <option key={each} value={each}>
              {each === "none" ? "no end" : each}
            </option>
          ))}
        </select>
      </label>
      <button type="submit" disabled={!isOpen}>
        Send
      </button>
    </form>
  );
}
