/** A board of the companion: its line, and all that its view shows. It outlives the view, so that nothing is lost
 * when another one is looked at. */

import { signal } from "@preact/signals";
import { notify, notifyError } from "../../parts/notices";
import { link as door } from "../../store";
import type { TerminalHandle } from "../../net/channels";
import { BoardLink, LinkError, QUESTION, type AskOptions, type LinkState, type Operation } from "./board_link";
import { readText, type Configuration, type Listing, type Screens, type Speed } from "./board_texts";
import { Calibrator } from "./calibrator";
import { withName, withOperation, type CommandTime } from "./command_times";
import { QueueSync } from "./queue_sync";
import { RowStreamer } from "./row_streamer";
import { isDraft, keptFor } from "../../kept";
import { KeptBoard } from "./kept_board";
import { afterBegin, afterEnd, afterLine, afterListing, runningText, STANDING, type Motion } from "./running_row";
import { withIncoming, withSent, type SentLine } from "./text_log";

const TICK_MS = 100;
/** Interval of looks at a moving board that does not tell by soft_ops when it is done. */
const LOOK_MS = 700;
/** Time without motion after which nobody looks any more. */
const STANDS_MS = 10_000;
/** Pause after which what could not be read is read again. */
const AGAIN_MS = 2000;
/** Pause after which the queue is read again, when something was typed. */
const SETTLED_MS = 250;
/** While stops wait for their answers, another one is typed so much later. */
const STOP_AGAIN_MS = 300;
/** Lines after which a queue is another one, or a board's settings. */
const CHANGES_QUEUE = /^(m|z|q(\d|[rc]))/i;
const CHANGES_SETTINGS = /^[$gab]|^[vdl]\d?/i;

export class BoardSession {
  readonly state = signal<{ state: LinkState; why: string }>({ state: "opening", why: "" });
  readonly kept: KeptBoard;
  readonly sync: QueueSync;
  readonly queue: QueueSync["queue"];
  readonly motion = signal<Motion>(STANDING);
  readonly configuration = signal<Configuration | undefined>(undefined);
  /** Defaults and flags of `cf`. */
  readonly settings = signal<Readonly<Record<string, string>>>({});
  readonly incoming = signal("");
  readonly sent = signal<readonly SentLine[]>([]);
  readonly times = signal<readonly CommandTime[]>([]);
  readonly calibrator = new Calibrator(this);
  readonly streamer = new RowStreamer(this);

  private line: BoardLink;
  private terminal: TerminalHandle | undefined;
  private timer = 0;
  private readonly sinceStart_ms = performance.now();
  private lookedAt_ms = 0;
  private movedAt_ms = -Infinity;
  private isStale = false;
  private areSettingsStale = false;
  private typedAt_ms = 0;
  private isWorking = false;

  constructor(readonly port: string) {
    this.kept = new KeptBoard(port);
    this.sync = new QueueSync(
      this.kept,
      (line) => this.ask(line),
      () => this.screen("q"),
      () => this.stepsPerRev,
      () => (this.isStale = false),
    );
    this.queue = this.sync.queue;
    isDraft(`rows of ${port}`, () => this.sync.missing > 0 || Object.keys(this.kept.cells.value).length > 0);
    isDraft(`one-shots of ${port}`, () => !this.kept.oneShots.value.isSaved);
    this.line = this.newLine();
    this.line.close("the port is not open yet");
  }

  /** Open the port; what was shown before stays. */
  attach(): void {
    if (this.terminal) return;
    this.terminal = door.open(this.port, {
      bytes: (bytes) => this.line.feed(bytes),
      opened: () => {
        this.line = this.newLine();
        this.setState("opening", "");
      },
      closed: (why) => this.line.close(why),
    });
    this.timer = window.setInterval(() => this.tick(), TICK_MS);
  }

  /** Close the port for other programs, unless a calibration or a stream has to end first. */
  detach(): void {
    if (this.calibrator.running.peek() || this.streamer.isBusy) return;
    window.clearInterval(this.timer);
    this.terminal?.close();
    this.terminal = undefined;
    this.line.close("the port is not open");
  }

  private newLine(): BoardLink {
    const line: BoardLink = new BoardLink({
      send: (bytes) => this.terminal?.send(bytes),
      now_ms: () => performance.now(),
      state: (state, why) => line === this.line && this.setState(state, why),
      incoming: (text) => (this.incoming.value = withIncoming(this.incoming.peek(), text)),
      others: (text, answer) => this.heardOthers(text, answer),
      sent: (text) => {
        this.sent.value = withSent(this.sent.peek(), text, Date.now());
        this.typed(text);
      },
      operation: (operation) => this.operate(operation),
    });
    return line;
  }

  private setState(state: LinkState, why: string): void {
    this.state.value = { state, why };
    if (state === "closed" || state === "starting") this.giveUp(why);
    if (state === "starting") this.motion.value = STANDING;
    if (state === "ready") {
      this.isStale = true;
      this.areSettingsStale = true;
      this.typedAt_ms = 0;
    }
  }

  private giveUp(why: string): void {
    this.calibrator.giveUp(why);
    this.streamer.giveUp(why);
  }

  get isReady(): boolean {
    return this.state.value.state === "ready";
  }

  get isOpsOn(): boolean {
    return this.settings.value["soft_ops"] === "1";
  }

  // ---- what is typed ----

  /** Type a line; answers what the board says to it. Throws LinkError. */
  ask(line: string, options?: AskOptions): Promise<string[]> {
    return this.line.ask(line, options);
  }

  /** Type a line, and tell when it goes wrong. Answers whether it went. */
  async type(text: string): Promise<boolean> {
    try {
      await this.line.ask(text);
      return true;
    } catch (error) {
      notifyError(error);
      return false;
    }
  }

  /** Stop: `S` at once, `s` with the session's deceleration. Of many clicks that have no answer yet some are typed, and of
   * what goes wrong with them the last is told. */
  async stop(letter: "S" | "s"): Promise<void> {
    this.giveUp("stopped");
    const now_ms = performance.now();
    if (this.stops > 1 && letter === this.lastStop && now_ms - this.stoppedAt_ms < STOP_AGAIN_MS) return;
    this.stops += 1;
    this.lastStop = letter;
    this.stoppedAt_ms = now_ms;
    let why: unknown;
    try {
      await this.line.urgent(letter);
    } catch (error) {
      why = error;
    }
    this.stops -= 1;
    if (why !== undefined && this.stops === 0) notifyError(why);
  }

  /** Stops that have no answer yet. */
  private stops = 0;
  private lastStop = "";
  private stoppedAt_ms = 0;

  private target = "";

  /** Type the last velocity that a slider has, when the one before has been taken. */
  retarget(line: string): void {
    const isTyping = this.target !== "";
    this.target = line;
    if (!isTyping) void this.typeTargets();
  }

  private async typeTargets(): Promise<void> {
    for (let typed = ""; typed !== this.target; ) {
      typed = this.target;
      if (!(await this.type(typed))) break;
    }
    this.target = "";
  }

  /** Keep the board's queue in its EEPROM. */
  async keep(): Promise<void> {
    if (await this.type("qs")) notify("The board's queue is in its EEPROM");
  }

  /** Correct the board's clock, and let it take the correction. */
  async correct(remedy: string): Promise<void> {
    if ((await this.type(remedy)) && (await this.type("$R"))) this.calibrator.results.value = new Map();
  }

  pulse(sign: "+" | "-"): void {
    try {
      this.line.pulse(sign);
    } catch (error) {
      notifyError(error);
    }
  }

  retry(): void {
    this.line.knock();
  }

  /** A line was typed, here or elsewhere: look at the board again if it changes something. */
  private typed(text: string): void {
    const now_ms = performance.now();
    this.typedAt_ms = now_ms;
    this.movedAt_ms = now_ms;
    this.motion.value = afterLine(this.motion.peek(), text);
    if (CHANGES_QUEUE.test(text)) this.isStale = true;
    if (CHANGES_SETTINGS.test(text)) this.areSettingsStale = true;
  }

  /** Another client's line: its listing serves here too, and its commands move the same motor. */
  private heardOthers(text: string, answer: string[]): void {
    if (text === "q") void this.takeListing(answer);
    else if (!QUESTION.test(text)) {
      this.streamer.giveUp(`somebody else has typed "${text}"`);
      this.typed(text);
    }
  }

  private async takeListing(lines: string[]): Promise<void> {
    const listing = await this.listing(lines).catch(() => undefined);
    if (listing && typeof listing !== "string") this.sync.seen(listing.rows);
  }

  private get stepsPerRev(): number {
    return this.configuration.peek()?.steps_per_rev ?? this.queue.peek().steps_per_rev;
  }

  private operate(operation: Operation): void {
    this.movedAt_ms = operation.at_ms;
    const motion = this.motion.peek();
    this.motion.value = operation.kind === "begins" ? afterBegin(motion) : afterEnd(motion);
    const what = runningText(this.motion.peek().running);
    this.times.value = withOperation(this.times.peek(), operation, what);
    this.calibrator.hear(operation);
    this.streamer.hear(operation);
  }

  // ---- looking at the board ----

  private tick(): void {
    this.line.tick();
    const now_ms = performance.now();
    if (!this.line.isIdle || this.isWorking || this.calibrator.running.peek() || this.streamer.isBusy) return;
    const isSettled = now_ms - this.typedAt_ms >= SETTLED_MS;
    if (this.areSettingsStale && isSettled)
      void this.work(
        () => this.readSettings(),
        () => (this.areSettingsStale = true),
      );
    else if (this.isStale && isSettled && !this.isTimed())
      void this.work(
        () => this.readQueue(),
        () => (this.isStale = true),
      );
    else if (this.wantsLook(now_ms)) void this.work(() => this.look(now_ms));
  }

  /** True while a command is timed by soft_ops: a listing would hold up the signal of its end. */
  private isTimed(): boolean {
    const { running } = this.motion.peek();
    return this.isOpsOn && running !== undefined && running !== "unknown";
  }

  private wantsLook(now_ms: number): boolean {
    const { running, loop } = this.motion.peek();
    if (this.isOpsOn) return running === "unknown" && now_ms - this.lookedAt_ms >= LOOK_MS;
    const mayMove = loop.isOn || running !== undefined || now_ms - this.movedAt_ms < STANDS_MS;
    return mayMove && now_ms - this.lookedAt_ms >= LOOK_MS;
  }

  /** `again`: called where the line failed, so that it is tried anew. */
  private async work(does: () => Promise<void>, again?: () => void): Promise<void> {
    this.isWorking = true;
    try {
      await does();
    } catch (error) {
      if (!(error instanceof LinkError)) return notifyError(error);
      again?.();
      this.typedAt_ms = performance.now() + AGAIN_MS;
    } finally {
      this.isWorking = false;
    }
  }

  private async look(now_ms: number): Promise<void> {
    this.lookedAt_ms = now_ms;
    const speed = await this.speed();
    if (typeof speed === "string") return;
    const motion = this.motion.peek();
    if (speed.rpm === 0 && speed.period_us === 0) {
      if (!this.isOpsOn && motion.running !== undefined) this.motion.value = afterEnd(motion);
      return;
    }
    this.movedAt_ms = performance.now();
    if (!this.isOpsOn && motion.running === undefined)
      this.motion.value = { ...motion, running: motion.urgent[0] ?? "unknown", urgent: motion.urgent.slice(1) };
    await this.readQueue(true);
    this.times.value = withName(this.times.peek(), runningText(this.motion.peek().running));
  }

  private async readSettings(): Promise<void> {
    this.areSettingsStale = false;
    const found = await this.screen("cc");
    if (typeof found === "string") throw new Error(`${this.port}: its answers are no SAC's; is another board there?`);
    this.configuration.value = found;
    const settings = await this.screen("cf");
    if (typeof settings !== "string") this.settings.value = settings;
  }

  /** Read the queue: the editor follows it, but for what was edited and not sent. */
  private async readQueue(isMoving?: boolean): Promise<void> {
    this.isStale = false;
    const speed = isMoving === undefined ? await this.speed() : "";
    const listing = await this.listing(await this.line.ask("q", { isQuiet: true }));
    if (typeof listing === "string") throw new Error(`${this.port}: ${listing}`);
    if (!listing) {
      this.isStale = true;
      return;
    }
    this.sync.seen(listing.rows);
    this.motion.value = afterListing(this.motion.peek(), listing.at, isMoving ?? (typeof speed !== "string" && speed.period_us > 0));
  }

  /** Read a listing; undefined: it is older than what was sent or told while the bench read it. */
  private async listing(lines: string[]): Promise<Listing | string | undefined> {
    const { board } = this.queue.peek();
    const motion = this.motion.peek();
    const listing = await readText(this.port, "q", lines.join("\n"));
    return board === this.queue.peek().board && motion === this.motion.peek() ? listing : undefined;
  }

  /** Show a screen, and read it; a text says why it is none. Throws LinkError. */
  private async screen<Name extends keyof Screens>(line: Name): Promise<Screens[Name] | string> {
    return readText(this.port, line, (await this.line.ask(line, { isQuiet: true })).join("\n"));
  }

  /** Ask for the speed of now. Throws LinkError. */
  speed(): Promise<Speed | string> {
    return this.screen("vd");
  }

  /** Seconds since the page knows the board, for the list of times. */
  age_s(at_ms: number): number {
    return (at_ms - this.sinceStart_ms) / 1000;
  }
}

const sessions = new Map<string, BoardSession>();

/** Session of a port, opened when it is first looked at. */
export function boardSession(port: string): BoardSession {
  const key = `${keptFor.peek()}/${port}`;
  const known = sessions.get(key) ?? new BoardSession(port);
  sessions.set(key, known);
  return known;
}
