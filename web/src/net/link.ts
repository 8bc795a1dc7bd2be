/** The connection to the door. It comes back by itself; what was watched and open is watched and open again. */

import { signal } from "@preact/signals";
import type { LinkState, LoginKind, SampleSink, TerminalHandle, TerminalSink, WatchHandle, WatchRequest } from "./channels";
import type { Operations, TerminalAnswer, WatchAnswer } from "../model/door";
import { type Hello, readBinary, readText, Refused, terminalFrames } from "./protocol";

interface Pending {
  resolve(answer: unknown): void;
  reject(error: Refused): void;
}

interface Watching extends WatchHandle {
  number: number;
  request: WatchRequest;
  sink: SampleSink;
  isClosed: boolean;
}

interface Terminal extends TerminalHandle {
  number: number;
  port: string;
  sink: TerminalSink;
  isClosed: boolean;
}

const FIRST_WAIT_MS = 250;
const LONGEST_WAIT_MS = 4000;
/** The door tells its clock so often. */
const CLOCK_RATE_HZ = 2;
/** After this long without anything the connection is dead. */
const SILENCE_MS = 8000;
/** What the door has not begun so long after it was asked for is not carried out: nobody expects it any more. */
const DEADLINE_MS = 3000;
const AGE_EVERY_MS = 250;
const GONE = () =>
  new Refused("gone", `the connection was lost before the answer came; what the bench has not begun within ${DEADLINE_MS / 1000} s is dropped, but for a stop`);

export class Link {
  readonly state = signal<LinkState>("connecting");
  /** Description of the bench; it stays while the connection is lost. */
  readonly hello = signal<Hello | null>(null);
  readonly login = signal<LoginKind["login"]>("none");
  /** Number of connections so far: 2 and more are returns. */
  readonly connections = signal(0);
  /** Wall time at which the connection was lost, in ms since 1970. */
  readonly lostAt = signal(0);
  /** Frames that were no message of the protocol. */
  readonly garbage = signal(0);
  /** Age of the last news while there is a connection, in s: what is shown is as old. */
  readonly age_s = signal(0);

  private socket: WebSocket | null = null;
  private nextId = 1;
  private waitMs = FIRST_WAIT_MS;
  private timer = 0;
  private heardAt = 0;
  private newsAt = 0;
  /** The door's clock, and this page's when it was told. */
  private clock: { door_ms: number; at_ms: number } | null = null;
  private isTrying = false;
  private readonly pending = new Map<number, Pending>();
  private readonly watches = new Set<Watching>();
  private readonly byNumber = new Map<number, Watching>();
  private readonly terminals = new Set<Terminal>();
  private readonly terminalByNumber = new Map<number, Terminal>();

  /** `versionDiffers`: called with the server's version if it is another than this page's. */
  constructor(
    private readonly version: string,
    private readonly versionDiffers: (server: string) => void,
  ) {}

  start(): void {
    window.addEventListener("online", () => this.tryNow());
    document.addEventListener("visibilitychange", () => {
      this.heardAt = performance.now(); // timers and frames of a hidden page come late
      if (!document.hidden) this.tryNow();
    });
    window.setInterval(() => this.endIfSilent(), 1000);
    window.setInterval(() => this.tellAge(), AGE_EVERY_MS);
    this.watch({ what: "clock", rate_Hz: CLOCK_RATE_HZ }, { value: (told) => this.takeClock(told) });
    void this.connect();
  }

  /** Ask the bench for an operation of its table, now or not at all. Throws Refused. */
  ask<Name extends keyof Operations>(operation: Name, target = "", given?: Operations[Name]["given"]): Promise<Operations[Name]["answer"]> {
    const until = isStop(operation, { ...given }) ? {} : this.soon();
    return this.request({ do: "ask", operation, target, given: given ?? {}, ...until });
  }

  /** Part of a request that is made now: by when it has to begin, by the door's clock; empty where it has told none. */
  soon(): { until_ms?: number } {
    return this.clock ? { until_ms: this.clock.door_ms + (performance.now() - this.clock.at_ms) + DEADLINE_MS } : {};
  }

  private takeClock(told: unknown): void {
    if (typeof told === "number" && Number.isFinite(told)) this.clock = { door_ms: told, at_ms: performance.now() };
  }

  private tellAge(): void {
    const age_s = this.state.peek() === "open" ? (performance.now() - this.newsAt) / 1000 : 0;
    this.age_s.value = Math.max(Math.round(age_s * 10) / 10, 0);
  }

  /** Send a request of the protocol; answers its answer. Throws Refused, also where the connection goes. */
  request<T = unknown>(message: Record<string, unknown>): Promise<T> {
    const socket = this.socket;
    if (!socket || socket.readyState !== WebSocket.OPEN || this.state.peek() !== "open") {
      return Promise.reject(new Refused("gone", "there is no connection to the bench now"));
    }
    const id = this.nextId++;
    const text = JSON.stringify({ id, ...message });
    const most_bytes = this.hello.peek()?.message_bytes ?? Infinity;
    const bytes = new TextEncoder().encode(text).length;
    if (bytes > most_bytes) {
      return Promise.reject(new Refused("bad_request", `this is a message of ${bytes} bytes; the bench takes at most ${most_bytes}`));
    }
    return new Promise<T>((resolve, reject) => {
      this.pending.set(id, { resolve: resolve as (answer: unknown) => void, reject });
      socket.send(text);
    });
  }

  /** Watch something until `close`, over all connections. */
  watch(request: WatchRequest, sink: SampleSink): WatchHandle {
    const watching: Watching = {
      number: 0,
      request,
      sink,
      isClosed: false,
      close: () => this.unwatch(watching),
    };
    this.watches.add(watching);
    if (this.state.peek() === "open") void this.begin(watching);
    return watching;
  }

  /** Open a port as a client, until `close`, over all connections. */
  open(port: string, sink: TerminalSink): TerminalHandle {
    const terminal: Terminal = {
      number: 0,
      port,
      sink,
      isClosed: false,
      send: (bytes) => {
        const { socket } = this;
        if (!terminal.number || socket?.readyState !== WebSocket.OPEN) return false;
        const most_bytes = this.hello.peek()?.message_bytes ?? Infinity;
        for (const frame of terminalFrames(terminal.number, bytes, most_bytes)) socket.send(frame);
        return true;
      },
      close: () => this.closeTerminal(terminal),
    };
    this.terminals.add(terminal);
    if (this.state.peek() === "open") void this.beginTerminal(terminal);
    return terminal;
  }

  /** Log in; returns why not, or null. */
  async logIn(given: Record<string, string>): Promise<string | null> {
    try {
      const answer = await fetch("api/login", {
        method: "POST",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify(given),
      });
      if (answer.status === 429) return "Too many attempts. Wait a little, then try again.";
      if (answer.status === 401 || answer.status === 403) return "That is not known here.";
      if (!answer.ok) return `The server answered ${answer.status}.`;
    } catch {
      return "The server does not answer.";
    }
    this.tryNow(true);
    return null;
  }

  async logOut(): Promise<void> {
    await fetch("api/logout", { method: "POST" }).catch(() => undefined);
    this.socket?.close();
  }

  /** Try to connect now instead of after the wait. */
  tryNow(isLoggedIn = false): void {
    if (this.state.peek() === "open" || (this.state.peek() === "login" && !isLoggedIn)) return;
    window.clearTimeout(this.timer);
    this.waitMs = FIRST_WAIT_MS;
    void this.connect();
  }

  private async connect(): Promise<void> {
    if (this.isTrying) return;
    this.isTrying = true;
    try {
      const answer = await fetch("api/hello", { cache: "no-store" });
      const told = (await answer.json()) as { version?: string; login?: LoginKind["login"] };
      this.login.value = told.login ?? "none";
      this.checkVersion(told.version);
    } catch {
      this.isTrying = false;
      this.lost();
      return;
    }
    this.openSocket();
  }

  private checkVersion(server: string | undefined): void {
    if (server && server !== this.version) this.versionDiffers(server);
  }

  private openSocket(): void {
    const url = new URL("ws", document.baseURI);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(url, "hil.v1");
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    let isGreeted = false;
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => {
      if (socket !== this.socket) return;
      this.heardAt = this.newsAt = performance.now();
      if (typeof event.data !== "string") this.takeBinary(event.data);
      else isGreeted = this.takeText(event.data) || isGreeted;
    };
    socket.onclose = () => {
      this.isTrying = false;
      if (socket !== this.socket) return;
      this.socket = null;
      const wantsLogin = !isGreeted && this.login.peek() !== "none";
      this.forget();
      if (wantsLogin) this.state.value = "login";
      else this.lost();
    };
  }

  /** The connection is gone: requests fail, watches and terminals wait for the next one. */
  private forget(): void {
    this.clock = null; // of another door, perhaps
    for (const request of this.pending.values()) request.reject(GONE());
    this.pending.clear();
    this.byNumber.clear();
    this.terminalByNumber.clear();
    for (const watching of this.watches) watching.number = 0;
    for (const terminal of this.terminals) {
      if (terminal.number) terminal.sink.closed("the connection to the bench was lost");
      terminal.number = 0;
    }
  }

  private lost(): void {
    if (this.state.peek() !== "lost") {
      this.lostAt.value = Date.now();
      this.state.value = "lost";
    }
    window.clearTimeout(this.timer);
    this.timer = window.setTimeout(() => void this.connect(), this.waitMs * (0.75 + Math.random() / 2));
    this.waitMs = Math.min(this.waitMs * 2, LONGEST_WAIT_MS);
  }

  private endIfSilent(): void {
    if (this.state.peek() !== "open" || document.hidden) return;
    if (performance.now() - this.heardAt > SILENCE_MS) {
      const socket = this.socket;
      this.socket = null;
      socket?.close();
      this.isTrying = false;
      this.forget();
      this.lost();
    }
  }

  private greet(hello: Hello, isChange: boolean): void {
    this.checkVersion(hello.version);
    this.hello.value = hello;
    if (isChange) return;
    this.isTrying = false;
    this.waitMs = FIRST_WAIT_MS;
    this.state.value = "open";
    this.connections.value += 1;
    for (const watching of this.watches) {
      if (this.connections.peek() > 1) watching.sink.again?.();
      void this.begin(watching);
    }
    for (const terminal of this.terminals) void this.beginTerminal(terminal);
  }

  private async begin(watching: Watching): Promise<void> {
    const socket = this.socket;
    try {
      const answer = await this.request<WatchAnswer>({ do: "watch", ...watching.request });
      if (socket !== this.socket) return;
      watching.number = answer.watch;
      if (watching.isClosed) this.endWatch(watching);
      else this.byNumber.set(answer.watch, watching);
    } catch (error) {
      if (error instanceof Refused && error.code !== "gone") watching.sink.refused?.(error);
    }
  }

  private unwatch(watching: Watching): void {
    watching.isClosed = true;
    this.watches.delete(watching);
    if (watching.number) this.endWatch(watching);
  }

  private endWatch(watching: Watching): void {
    this.byNumber.delete(watching.number);
    this.request({ do: "unwatch", watch: watching.number }).catch(() => undefined);
    watching.number = 0;
  }

  private async beginTerminal(terminal: Terminal): Promise<void> {
    const socket = this.socket;
    try {
      const answer = await this.request<TerminalAnswer>({ do: "open", port: terminal.port, ...(terminal.sink.taken && { details: true }) });
      if (socket !== this.socket) return;
      terminal.number = answer.terminal;
      if (terminal.isClosed) return this.endTerminal(terminal);
      this.terminalByNumber.set(answer.terminal, terminal);
      terminal.sink.opened(answer);
    } catch (error) {
      if (error instanceof Refused && error.code !== "gone") terminal.sink.closed(error.message);
    }
  }

  private closeTerminal(terminal: Terminal): void {
    terminal.isClosed = true;
    this.terminals.delete(terminal);
    if (terminal.number) this.endTerminal(terminal);
  }

  private endTerminal(terminal: Terminal): void {
    this.terminalByNumber.delete(terminal.number);
    this.request({ do: "close", terminal: terminal.number }).catch(() => undefined);
    terminal.number = 0;
  }

  /** Take a text frame; true if it was the greeting. */
  private takeText(frame: string): boolean {
    const message = readText(frame);
    switch (message.kind) {
      case "hello":
        this.greet(message.hello, message.isChange);
        return true;
      case "answer":
        this.take(message.id)?.resolve(message.answer);
        break;
      case "error":
        this.take(message.id)?.reject(message.error);
        break;
      case "push": {
        const sink = this.byNumber.get(message.watch)?.sink;
        if (message.items) sink?.items?.(message.items, message.lost);
        else sink?.value?.(message.value);
        break;
      }
      case "taken":
        this.terminalByNumber.get(message.terminal)?.sink.taken?.(message.bytes);
        break;
      case "closed":
        if (message.what === "watch") this.watchEnded(message.number);
        else this.terminalEnded(message.number, message.why);
        break;
      default:
        this.garbage.value += 1;
    }
    return false;
  }

  private take(id: number): Pending | undefined {
    const request = this.pending.get(id);
    this.pending.delete(id);
    return request;
  }

  /** The bench has ended a watch, as its device was exchanged: it begins anew, or is refused. */
  private watchEnded(number: number): void {
    const watching = this.byNumber.get(number);
    if (!watching) return;
    this.byNumber.delete(number);
    watching.number = 0;
    watching.sink.again?.();
    void this.begin(watching);
  }

  private terminalEnded(number: number, why: string): void {
    const terminal = this.terminalByNumber.get(number);
    if (!terminal) return;
    this.terminalByNumber.delete(number);
    terminal.number = 0;
    terminal.sink.closed(why);
  }

  private takeBinary(data: ArrayBuffer): void {
    const parts = readBinary(data);
    if (!parts) this.garbage.value += 1;
    for (const part of parts ?? []) {
      if (part.kind === "terminal") this.terminalByNumber.get(part.terminal)?.sink.bytes(part.bytes, part.at_s);
      else this.byNumber.get(part.watch)?.sink.samples?.(part.values, part.rows, part.columns, part.lost);
    }
  }
}

/** True for what stops something: it is right at any time, and has no deadline. */
function isStop(operation: string, given: Record<string, unknown>): boolean {
  if (operation === "do") return given["name"] === "stop";
  return (
    operation === "halt" ||
    operation === "stop_site" ||
    operation === "cancel_run" ||
    operation === "pause" ||
    (operation === "pace_run" && given["pace"] === 0)
  );
}
