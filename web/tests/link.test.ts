import { afterAll, beforeEach, describe, expect, it, vi } from "vitest";
import { Link } from "../src/net/link";

/** A socket that a test speaks through. */
class Socket {
  static readonly OPEN = 1;
  static last: Socket;
  readonly readyState = Socket.OPEN;
  readonly sent: Record<string, unknown>[] = [];
  onmessage: (event: { data: string }) => void = () => undefined;
  onclose: () => void = () => undefined;

  constructor() {
    Socket.last = this;
  }

  send(text: string): void {
    this.sent.push(JSON.parse(text) as Record<string, unknown>);
  }

  say(said: unknown): void {
    this.onmessage({ data: JSON.stringify(said) });
  }

  close(): void {
    this.onclose();
  }
}

const timers: (() => void)[] = [];
vi.stubGlobal("WebSocket", Socket);
vi.stubGlobal("window", {
  addEventListener: () => undefined,
  setInterval: (work: () => void) => timers.push(work),
  setTimeout: () => 0,
  clearTimeout: () => undefined,
});
vi.stubGlobal("document", { addEventListener: () => undefined, hidden: false, baseURI: "http://here/" });
vi.stubGlobal("fetch", () => Promise.resolve({ json: () => Promise.resolve({ version: "v", login: "none" }) }));
let now_ms = 0;
vi.spyOn(performance, "now").mockImplementation(() => now_ms);
afterAll(() => vi.unstubAllGlobals());

/** A link that is open, and its socket. */
async function opened(): Promise<[Link, Socket]> {
  timers.length = 0;
  const link = new Link("v", () => undefined);
  link.start();
  await vi.waitFor(() => expect(Socket.last).toBeDefined());
  const socket = Socket.last;
  socket.say({ hello: { version: "v", bench: "t", message_bytes: 65536 } });
  return [link, socket];
}

const asked = (socket: Socket) => socket.sent.filter((message) => message["do"] === "ask").at(-1)!;

/** Tell the door's clock by the link's own watch of it. */
async function tellClock(socket: Socket, door_ms: number): Promise<void> {
  const watch = socket.sent.find((message) => message["what"] === "clock")!;
  socket.say({ id: watch["id"], answer: { watch: 9 } });
  await Promise.resolve();
  await Promise.resolve();
  socket.say({ watch: 9, value: door_ms });
}

beforeEach(() => {
  now_ms = 1000;
  Socket.last = undefined as unknown as Socket;
});

describe("a request", () => {
  it("has until three seconds later, by the door's clock", async () => {
    const [link, socket] = await opened();
    void link.ask("do", "m1", { name: "enable", parameters: {} });
    expect(asked(socket)["until_ms"]).toBeUndefined(); // no clock was told yet
    await tellClock(socket, 500_000);
    now_ms = 1250;
    void link.ask("do", "m1", { name: "enable", parameters: {} });
    expect(asked(socket)["until_ms"]).toBe(503_250);
    await tellClock(socket, Number.NaN);
    void link.ask("runs", "");
    expect(asked(socket)["until_ms"]).toBe(503_250);
  });

  it("that stops something has any time", async () => {
    const [link, socket] = await opened();
    await tellClock(socket, 500_000);
    for (const ask of [
      () => link.ask("do", "m1", { name: "stop", parameters: {} }),
      () => link.ask("cancel_run", "r", { how: "grace" }),
      () => link.ask("pace_run", "r", { pace: 0 }),
      () => link.ask("pause", ""),
    ]) {
      void ask();
      expect(asked(socket)["until_ms"]).toBeUndefined();
    }
    void link.ask("pace_run", "r", { pace: 0.5 });
    expect(asked(socket)["until_ms"]).toBe(503_000);
  });

  it("fails with the connection, and says what becomes of it", async () => {
    const [link, socket] = await opened();
    const asking = link.ask("do", "m1", { name: "enable", parameters: {} });
    socket.close();
    await expect(asking).rejects.toThrow("what the bench has not begun within 3 s is dropped, but for a stop");
  });
});

describe("the age of the news", () => {
  it("grows until something comes", async () => {
    const [link, socket] = await opened();
    now_ms += 1640;
    for (const work of timers) work();
    expect(link.age_s.value).toBe(1.6);
    socket.say({ watch: 3, value: 1 });
    for (const work of timers) work();
    expect(link.age_s.value).toBe(0);
  });
});
