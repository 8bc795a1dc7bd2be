/** Line to a SAC's terminal, as its companion uses it: a line is typed when the prompt has come, its answer is
 * known by its echo, and the signals of soft_ops are taken out of the text with their times.
 * Source: SAC user manual, communications, soft_ops. Without a screen; time is an argument. */

export const PROMPT = "SAC>";
const DC1 = 0x11;
const DC2 = 0x12;
/** Time for a start: opening a port may start a board, and a byte in its first second restores the factory's
 * settings. */
export const START_UP_MS = 1300;
/** Maximum wait for an answer. The longest, 30 rows, takes 0.4 s at 38400 baud, 30 s at 488. */
export const ANSWER_MS = 5000;
/** Time after which text without a prompt is shown. */
const SHOWN_MS = 400;
const UNREAD_MAX = 20_000;
/** Silence after which the echo of a line without its end is not whole, or an erasure is over; a line of 80 characters
 * takes 20 ms at 38400 baud. */
export const ECHO_MS = 1000;
/** Number of times that a line is typed which comes back damaged. */
export const TRIES = 5;
/** Erasure of the longest line; there is no echo to what is beyond the line's beginning. */
const ERASE = "\b".repeat(80);
const ERASED = "\b \b";
/** Lines that ask and change nothing, as other pages type them by themselves. */
export const QUESTION = /^(q|vd|cc|cf|x)?$/;
const BANNER = /(?:^|\n)SAC \S[^\r\n]*\r\n$/;

/** `opening`: no byte is sent yet; `starting`: the board is, and no byte may be sent; `silent`: it does not
 * answer; `closed`: the port has gone. */
export type LinkState = "opening" | "starting" | "asking" | "ready" | "silent" | "closed";

export interface Operation {
  readonly kind: "begins" | "ends";
  readonly at_ms: number;
}

export interface LinkEvents {
  /** Write bytes to the board. */
  send(bytes: Uint8Array): void;
  now_ms(): number;
  state(state: LinkState, why: string): void;
  /** Text of the board as it came, without answers to the page's own questions and to those of other pages. */
  incoming(text: string): void;
  sent(line: string): void;
  /** Line that another client typed, with its answer. */
  others(line: string, answer: string[]): void;
  operation(operation: Operation): void;
}

export interface AskOptions {
  /** True: a question of the page's own, shown in no history. */
  readonly isQuiet?: boolean;
  readonly timeout_ms?: number;
  /** True: its end goes out when its echo is whole; else it is erased and typed again. For a line that must not come damaged. */
  readonly isChecked?: boolean;
}

interface Asked {
  readonly line: string;
  readonly isQuiet: boolean;
  readonly timeout_ms: number;
  readonly isChecked: boolean;
  stage: "open" | "erased" | "ended";
  tries: number;
  typed_ms: number;
  deadline_ms: number;
  readonly done: (lines: string[]) => void;
  readonly failed: (error: Error) => void;
}

/** Dialogue that did not come to its end. */
export class LinkError extends Error {}

/** Line to a board. Feed it what comes, and call `tick` some times a second. */
export class BoardLink {
  private phase: LinkState = "opening";
  private unread = "";
  private shown = 0;
  private quietSince_ms: number;
  private strange = "";
  private readonly waiting: Asked[] = [];
  private readonly inFlight: Asked[] = [];

  constructor(private readonly events: LinkEvents) {
    this.quietSince_ms = events.now_ms();
  }

  get state(): LinkState {
    return this.phase;
  }

  /** True if nothing is asked or waits to be. */
  get isIdle(): boolean {
    return this.phase === "ready" && !this.waiting.length && !this.inFlight.length;
  }

  // ---- out ----

  /** Type a line when its turn comes; answers the lines up to the prompt, without the echo. */
  ask(line: string, options: AskOptions = {}): Promise<string[]> {
    return this.put(line, options, (asked) => this.waiting.push(asked));
  }

  /** Type a line at once, before what waits: it stops a motor. What waits is given up. */
  urgent(line: string): Promise<string[]> {
    for (const asked of this.waiting.splice(0)) asked.failed(new LinkError(`"${asked.line}" was given up for ${line}`));
    return this.put(line, {}, (asked) => {
      if (this.phase === "ready" || this.phase === "asking" || this.phase === "silent") this.type(asked, this.giveUpOpen(line));
      else this.waiting.push(asked);
    });
  }

  /** Make a single pulse: `+` or `-` as the first byte of a line, without its end. */
  pulse(sign: "+" | "-"): void {
    if (!this.isIdle) throw new LinkError("the board is busy: a pulse needs an empty line");
    this.events.sent(sign);
    this.events.send(new TextEncoder().encode(sign));
  }

  private put(line: string, options: AskOptions, place: (asked: Asked) => void): Promise<string[]> {
    return new Promise((done, failed) => {
      if (this.phase === "closed") {
        failed(new LinkError("the port is closed"));
        return;
      }
      const { isQuiet = false, timeout_ms = ANSWER_MS, isChecked = false } = options;
      const begun = { stage: "ended", tries: 0, typed_ms: 0, deadline_ms: Infinity } as const;
      place({ line, isQuiet, timeout_ms, isChecked, ...begun, done, failed });
      this.pump();
    });
  }

  private pump(): void {
    if (this.phase !== "ready" || this.inFlight.length) return;
    const next = this.waiting.shift();
    if (next) this.type(next);
  }

  /** `before`: what has to be typed first. */
  private type(asked: Asked, before = ""): void {
    this.inFlight.push(asked);
    if (!asked.isQuiet) this.events.sent(asked.line);
    if (asked.isChecked) this.open(asked);
    else this.end(asked, before + asked.line);
  }

  /** Type a line whose end is still to come. */
  private open(asked: Asked): void {
    asked.stage = "open";
    asked.tries += 1;
    this.write(asked, asked.line);
  }

  /** Type the end of a line. `text`: what of it was not typed yet. */
  private end(asked: Asked, text = ""): void {
    asked.stage = "ended";
    asked.deadline_ms = this.events.now_ms() + asked.timeout_ms;
    this.write(asked, `${text}\r`);
  }

  private write(asked: Asked, text: string): void {
    asked.typed_ms = this.events.now_ms();
    this.events.send(new TextEncoder().encode(text));
  }

  /** Give up a line that has no end yet; answers what erases it. */
  private giveUpOpen(why: string): string {
    const open = this.inFlight.filter(({ stage }) => stage !== "ended");
    for (const asked of open) this.fail(asked, `"${asked.line}" was given up for ${why}`);
    return open.length ? ERASE : "";
  }

  private fail(asked: Asked, why: string): void {
    this.inFlight.splice(this.inFlight.indexOf(asked), 1);
    asked.failed(new LinkError(why));
  }

  // ---- in ----

  feed(bytes: Uint8Array): void {
    const at_ms = this.events.now_ms();
    let text = "";
    for (const byte of bytes) {
      if (byte === DC1) this.events.operation({ kind: "begins", at_ms });
      else if (byte === DC2) this.events.operation({ kind: "ends", at_ms });
      else text += String.fromCharCode(byte);
    }
    if (!text || this.phase === "closed") return;
    this.quietSince_ms = at_ms;
    this.unread += text;
    this.takeBlocks();
    const whole = this.inFlight.find(({ line, stage }) => stage === "open" && line === this.unread);
    if (whole) this.end(whole);
    if (BANNER.test(this.unread)) this.starting();
    if (this.unread.length > UNREAD_MAX) this.dropUnread();
    this.pump();
  }

  private takeBlocks(): void {
    let end: number;
    while ((end = promptEnd(this.unread)) > 0) {
      const block = this.unread.slice(0, end);
      const text = block.slice(0, -PROMPT.length);
      const asked = this.askedIn(text);
      const isQuiet = asked ? asked.isQuiet : QUESTION.test(echoOf(text)) && !isMessage(text);
      if (!isQuiet || this.shown) this.events.incoming(block.slice(this.shown));
      this.unread = this.unread.slice(end);
      this.shown = 0;
      this.take(text, asked);
    }
  }

  private take(text: string, asked: Asked | undefined): void {
    if (asked) {
      this.inFlight.splice(this.inFlight.indexOf(asked), 1);
      asked.done(text.split("\r\n").slice(1, -1));
      return;
    }
    const [echo, ...answer] = text.split("\r\n");
    this.failIfGarbled(echo!);
    if (this.phase === "ready") this.events.others(echo!, answer.slice(0, -1));
    if (this.phase === "starting" || this.phase === "silent") this.leaveModes();
  }

  private askedIn(text: string): Asked | undefined {
    const echo = withoutErased(echoOf(text));
    const typed = echo.replace(/^[+-]+/, "");
    return this.inFlight.find(({ line }) => line === echo || line === typed);
  }

  /** Fail what was asked if its echo lacks characters. Another echo is another client's line; and a message of
   * the network cuts an echo, which is then drawn again. */
  private failIfGarbled(echo: string): void {
    this.strange = echo;
    const [head] = this.inFlight;
    if (!head || echo.length * 2 < head.line.length) return;
    if (head.line.startsWith(echo) || !isPartOf(echo, head.line)) return;
    this.inFlight.shift();
    head.failed(new LinkError(`"${head.line}" came back as "${echo.slice(0, 80)}": characters were lost on the line`));
  }

  private starting(): void {
    this.failAll("the board has started again");
    this.setState("starting", "the board is starting");
  }

  private dropUnread(): void {
    this.events.incoming(this.unread.slice(this.shown));
    this.unread = "";
    this.shown = 0;
  }

  /** Show text that no prompt follows: what somebody is typing, or a board that is no SAC. */
  private show(): void {
    if (this.inFlight.some(({ isQuiet }) => isQuiet)) return;
    if (this.unread.length > this.shown) this.events.incoming(this.unread.slice(this.shown));
    this.shown = this.unread.length;
  }

  // ---- time ----

  /** Let time pass: the opening ends, and what has had no answer fails. */
  tick(): void {
    const now_ms = this.events.now_ms();
    if (this.phase === "opening" && now_ms - this.quietSince_ms >= START_UP_MS) this.knock();
    for (const asked of this.inFlight.filter(({ deadline_ms }) => now_ms >= deadline_ms)) {
      const instead = this.strange && this.strange !== asked.line ? `; it said "${this.strange.slice(0, 80)}"` : "";
      this.fail(asked, `no answer to "${asked.line}" within ${asked.timeout_ms / 1000} s${instead}`);
    }
    for (const asked of this.inFlight.filter(({ isChecked }) => isChecked)) {
      if (now_ms - Math.max(this.quietSince_ms, asked.typed_ms) >= ECHO_MS) this.mend(asked);
    }
    if (this.unread && now_ms - this.quietSince_ms >= SHOWN_MS) this.show();
    this.pump();
  }

  /** Go on with a line after a silence: erase what came back damaged and type it again, or type its end again, which does
   * nothing if the first one came. */
  private mend(asked: Asked): void {
    if (asked.stage === "ended") {
      this.write(asked, "\r");
      return;
    }
    this.unread = "";
    this.shown = 0;
    if (asked.stage === "open") {
      asked.stage = "erased";
      this.write(asked, ERASE);
    } else if (asked.tries < TRIES) this.open(asked);
    else this.fail(asked, `"${asked.line}" came back damaged ${TRIES} times: characters are lost on the line`);
  }

  /** Try again whether somebody answers. */
  knock(): void {
    this.setState("asking", "");
    const options = { isQuiet: true, timeout_ms: START_UP_MS };
    this.askNow("", options).then(
      () => this.leaveModes(),
      () => this.silent(),
    );
  }

  /** Leave a program mode; `x` means nothing outside one. */
  private leaveModes(): void {
    this.setState("asking", "");
    this.askNow("x", { isQuiet: true }).then(
      () => this.ready(),
      () => this.silent(),
    );
  }

  private askNow(line: string, options: AskOptions): Promise<string[]> {
    return this.put(line, options, (asked) => this.type(asked));
  }

  private ready(): void {
    if (this.phase !== "asking") return;
    this.setState("ready", "");
    this.pump();
  }

  private silent(): void {
    if (this.phase !== "asking") return;
    const heard = this.unread || this.strange;
    const why = heard
      ? `the answer is not from a SAC at its prompt: "${heard.slice(-60)}"`
      : "nothing answers: is it on, is this its terminal, is the baud right?";
    this.failAll(why);
    this.setState("silent", why);
  }

  /** Take note that the port has gone. */
  close(why: string): void {
    this.failAll(why);
    this.setState("closed", why);
  }

  private failAll(why: string): void {
    const all = [...this.inFlight.splice(0), ...this.waiting.splice(0)];
    for (const asked of all) asked.failed(new LinkError(why));
  }

  private setState(state: LinkState, why: string): void {
    if (this.phase === state || this.phase === "closed") return;
    this.phase = state;
    this.events.state(state, why);
  }
}

/** Place behind the first prompt, 0 if there is none. A prompt stands at a line's beginning. */
function promptEnd(text: string): number {
  for (let at = text.indexOf(PROMPT); at >= 0; at = text.indexOf(PROMPT, at + 1)) {
    if (at === 0 || text[at - 1] === "\n") return at + PROMPT.length;
  }
  return 0;
}

/** True if a text stands behind no echo: a message of the network. */
function isMessage(text: string): boolean {
  return echoOf(text) === "" && text.trim() !== "";
}

function echoOf(text: string): string {
  return text.split("\r\n", 1)[0]!;
}

/** Text as it stands when what was erased is gone. */
function withoutErased(text: string): string {
  let left = "";
  for (let at = 0; at < text.length; ) {
    const isErased = text.startsWith(ERASED, at);
    left = isErased ? left.slice(0, -1) : left + text[at]!;
    at += isErased ? ERASED.length : 1;
  }
  return left;
}

/** True if a text is what is left of another one when some of its characters are lost. */
function isPartOf(text: string, whole: string): boolean {
  let at = 0;
  for (const character of whole) if (character === text[at]) at += 1;
  return at === text.length;
}
