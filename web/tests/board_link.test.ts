import { describe, expect, test } from "vitest";
import { BoardLink, ECHO_MS, LinkError, START_UP_MS, TRIES, type LinkState, type Operation } from "../src/views/companion/board_link";

/** Board that echoes a line and answers it from a table; time stands until it is moved. */
class Desk {
  now_ms = 0;
  readonly typed: string[] = [];
  readonly states: LinkState[] = [];
  readonly incoming: string[] = [];
  readonly sent: string[] = [];
  readonly others: string[] = [];
  readonly operations: Operation[] = [];
  answers: Record<string, string | null> = {};
  isThere = true;
  readonly line = new BoardLink({
    send: (bytes) => this.take(new TextDecoder().decode(bytes)),
    now_ms: () => this.now_ms,
    state: (state) => this.states.push(state),
    incoming: (text) => this.incoming.push(text),
    sent: (line) => this.sent.push(line),
    others: (line) => this.others.push(line),
    operation: (operation) => this.operations.push(operation),
  });
  private readonly unsaid: string[] = [];

  say(text: string): void {
    this.line.feed(Uint8Array.from(text, (character) => character.charCodeAt(0)));
  }

  private take(text: string): void {
    this.typed.push(text);
    if (!this.isThere || !text.endsWith("\r")) return;
    const line = text.slice(0, -1);
    const answer = line in this.answers ? this.answers[line]! : "";
    if (answer !== null) this.unsaid.push(`${line}\r\n${answer}SAC>`);
  }

  /** Let the board say what it has to, and promises go on. */
  async settle(): Promise<void> {
    for (let round = 0; round < 8; round++) {
      for (const text of this.unsaid.splice(0)) this.say(text);
      await Promise.resolve();
    }
  }

  async pass(ms: number): Promise<void> {
    this.now_ms += ms;
    this.line.tick();
    await this.settle();
  }

  async ready(): Promise<this> {
    await this.pass(START_UP_MS);
    await this.settle();
    return this;
  }
}

describe("the line to a board", () => {
  test("types nothing before a start would be over, then leaves a program mode", async () => {
    const desk = new Desk();
    await desk.pass(START_UP_MS - 1);
    expect(desk.typed).toEqual([]);
    await desk.pass(1);
    expect(desk.typed).toEqual(["\r", "x\r"]);
    expect(desk.line.state).toBe("ready");
    expect(desk.incoming).toEqual([]);
  });

  test("waits as long again for a board that is heard to start", async () => {
    const desk = new Desk();
    await desk.pass(500);
    desk.say("SAC 1.0\r\n");
    expect(desk.line.state).toBe("starting");
    await desk.pass(5000);
    expect(desk.typed).toEqual([]);
    desk.say("SAC>");
    await desk.settle();
    expect(desk.line.state).toBe("ready");
  });

  test("answers lines one after the other, also in pieces", async () => {
    const desk = await new Desk().ready();
    desk.answers = { vd: null, cf: "v\t100\r\nGAP\t1\r\n" };
    const speed = desk.line.ask("vd");
    const session = desk.line.ask("cf");
    expect(desk.typed.slice(2)).toEqual(["vd\r"]);
    for (const piece of ["v", "d\r", "\n0\t", "0\r\nSA", "C>"]) desk.say(piece);
    expect(await speed).toEqual(["0\t0"]);
    await desk.settle();
    expect(await session).toEqual(["v\t100", "GAP\t1"]);
    expect(desk.sent).toEqual(["vd", "cf"]);
    expect(desk.incoming.join("")).toContain("v\t100");
  });

  test("takes DC1 and DC2 out of the text, with their times", async () => {
    const desk = await new Desk().ready();
    const speed = desk.line.ask("vd", { isQuiet: true });
    desk.now_ms = 5000;
    desk.say("v\x11d\r\n150\t20");
    desk.now_ms = 5600;
    desk.say("00\x12\r\nSAC>");
    expect(await speed).toEqual(["150\t2000"]);
    expect(desk.operations).toEqual([
      { kind: "begins", at_ms: 5000 },
      { kind: "ends", at_ms: 5600 },
    ]);
    expect(desk.sent).toEqual([]);
  });

  test("stops at once, before what waits", async () => {
    const desk = await new Desk().ready();
    desk.answers = { q: null };
    const listing = desk.line.ask("q");
    const waiting = desk.line.ask("m200").catch((error: Error) => error.message);
    const stopped = desk.line.urgent("S");
    expect(desk.typed.at(-1)).toBe("S\r");
    expect(await waiting).toBe('"m200" was given up for S');
    desk.say("q\r\nrow\r\nSAC>");
    await desk.settle();
    expect([await listing, await stopped]).toEqual([["row"], []]);
  });

  test("does not stop within a board's start: a byte would restore the factory's settings", async () => {
    const desk = await new Desk().ready();
    desk.say("SAC 1.0\r\n");
    const stopped = desk.line.urgent("S");
    expect(desk.typed).not.toContain("S\r");
    desk.say("SAC>");
    await desk.settle();
    expect(await stopped).toEqual([]);
  });

  test("shows a message of the network, and no empty line of others", async () => {
    const desk = await new Desk().ready();
    desk.say("\r\nSAC>");
    expect(desk.incoming).toEqual([]);
    desk.say("\r\nhello\r\nSAC>");
    expect(desk.incoming.join("")).toBe("\r\nhello\r\nSAC>");
  });

  test("tells lines of others, and messages of the network, from its own answers", async () => {
    const desk = await new Desk().ready();
    desk.answers = { vd: null };
    const speed = desk.line.ask("vd", { isQuiet: true });
    desk.say("v\r\nhello\r\nSAC>vd\r\n0\t0\r\nSAC>m200\r\nSAC>");
    expect(await speed).toEqual(["0\t0"]);
    expect(desk.others).toEqual(["v", "m200"]);
    expect(desk.incoming.join("")).toBe("v\r\nhello\r\nSAC>m200\r\nSAC>");
  });

  test("does not show the questions of other pages", async () => {
    const desk = await new Desk().ready();
    desk.say("vd\r\n0\t0\r\nSAC>");
    expect(desk.incoming).toEqual([]);
  });

  test("a pulse needs no line end, and its echo belongs to no line", async () => {
    const desk = await new Desk().ready();
    desk.line.pulse("+");
    desk.say("+");
    const speed = desk.line.ask("vd");
    expect(desk.typed.slice(2)).toEqual(["+", "vd\r"]);
    desk.say("vd\r\n0\t0\r\nSAC>");
    expect(await speed).toEqual(["0\t0"]);
  });

  test("says that characters were lost, and goes on", async () => {
    const desk = await new Desk().ready();
    desk.answers = { q12m800v150: null };
    const failed = desk.line.ask("q12m800v150").catch((error: Error) => error.message);
    desk.say("q12800v150\r\nSAC>");
    expect(await failed).toBe('"q12m800v150" came back as "q12800v150": characters were lost on the line');
    const speed = desk.line.ask("vd");
    await desk.settle();
    expect(await speed).toEqual([]);
  });

  test("gives up what is not answered", async () => {
    const desk = await new Desk().ready();
    desk.isThere = false;
    const failed = desk.line.ask("vd").catch((error: unknown) => error);
    await desk.pass(4999);
    expect(desk.line.isIdle).toBe(false);
    await desk.pass(1);
    expect(await failed).toEqual(new LinkError('no answer to "vd" within 5 s'));
  });

  test("says who does not answer, and hears a board that comes", async () => {
    const desk = new Desk();
    desk.isThere = false;
    await desk.pass(START_UP_MS);
    await desk.pass(START_UP_MS);
    expect(desk.line.state).toBe("silent");
    desk.isThere = true;
    desk.say("SAC 1.0\r\n");
    desk.say("SAC>");
    await desk.settle();
    expect(desk.line.state).toBe("ready");
  });

  test("shows what never has a prompt, and stays within its memory", async () => {
    const desk = new Desk();
    desk.isThere = false;
    desk.say("login: \x1b[2J");
    await desk.pass(400);
    expect(desk.incoming.join("")).toBe("login: \x1b[2J");
    for (let round = 0; round < 100; round++) desk.say("garbage ".repeat(100));
    expect(desk.incoming.join("").length).toBeGreaterThan(50_000);
    await desk.pass(START_UP_MS);
    await desk.pass(START_UP_MS);
    expect(desk.line.state).toBe("silent");
  });

  test("fails all when the port goes", async () => {
    const desk = await new Desk().ready();
    const failed = desk.line.ask("vd").catch((error: Error) => error.message);
    desk.line.close("s1 has gone");
    expect(await failed).toBe("s1 has gone");
    expect(await desk.line.ask("vd").catch((error: Error) => error.message)).toBe("the port is closed");
    expect(desk.line.state).toBe("closed");
  });
});

/** Board that echoes each character, takes a backspace, and loses the characters that it is told to, by their number. */
class EchoingBoard {
  now_ms = 0;
  /** Lines that came into force. */
  readonly taken: string[] = [];
  readonly lost = new Set<number>();
  /** Numbers of characters whose echo is lost. */
  readonly unechoed = new Set<number>();
  count = 0;
  private typed = "";
  readonly line = new BoardLink({
    send: (bytes) => queueMicrotask(() => this.take(new TextDecoder().decode(bytes))),
    now_ms: () => this.now_ms,
    state: () => {},
    incoming: () => {},
    sent: () => {},
    others: () => {},
    operation: () => {},
  });

  private take(text: string): void {
    let echo = "";
    for (const character of text) {
      this.count += 1;
      if (!this.lost.has(this.count)) {
        const back = this.took(character);
        if (!this.unechoed.has(this.count)) echo += back;
      }
    }
    if (echo) this.line.feed(new TextEncoder().encode(echo));
  }

  private took(character: string): string {
    if (character === "\r") {
      if (this.typed) this.taken.push(this.typed);
      this.typed = "";
      return "\r\nSAC>";
    }
    if (character !== "\b") {
      this.typed += character;
      return character;
    }
    const isEmpty = this.typed === "";
    this.typed = this.typed.slice(0, -1);
    return isEmpty ? "" : "\b \b";
  }

  async pass(ms: number): Promise<void> {
    this.now_ms += ms;
    this.line.tick();
    for (let round = 0; round < 20; round++) await Promise.resolve();
  }

  async ready(): Promise<this> {
    await this.pass(START_UP_MS);
    this.taken.length = this.count = 0;
    return this;
  }

  /** Ask a line that must not come damaged; answers what came of it. */
  row(): Promise<string> {
    return this.line.ask("m200v300", { isQuiet: true, isChecked: true }).then(
      () => "taken",
      (error: Error) => error.message,
    );
  }
}

describe("a line that must not come damaged", () => {
  test("goes into force when its echo is whole", async () => {
    const board = await new EchoingBoard().ready();
    const row = board.row();
    await board.pass(0);
    expect(await row).toBe("taken");
    expect(board.taken).toEqual(["m200v300"]);
  });

  test.each([1, 3, 8])("is erased and typed again when character %i is lost", async (number) => {
    const board = await new EchoingBoard().ready();
    board.lost.add(number);
    const row = board.row();
    for (let look = 0; look < 3; look++) await board.pass(ECHO_MS);
    expect(await row).toBe("taken");
    expect(board.taken).toEqual(["m200v300"]);
  });

  test("is typed again when its echo alone is damaged", async () => {
    const board = await new EchoingBoard().ready();
    board.unechoed.add(2);
    const row = board.row();
    for (let look = 0; look < 3; look++) await board.pass(ECHO_MS);
    expect(await row).toBe("taken");
    expect(board.taken).toEqual(["m200v300"]);
  });

  test("has its end typed again when that is lost", async () => {
    const board = await new EchoingBoard().ready();
    board.lost.add(9);
    const row = board.row();
    for (let look = 0; look < 2; look++) await board.pass(ECHO_MS);
    expect(await row).toBe("taken");
    expect(board.taken).toEqual(["m200v300"]);
  });

  test("is given up after some tries, and never comes into force", async () => {
    const board = await new EchoingBoard().ready();
    for (let number = 3; number < 2000; number += 88) board.lost.add(number);
    const row = board.row();
    for (let look = 0; look <= 2 * TRIES; look++) await board.pass(ECHO_MS);
    expect(await row).toBe(`"m200v300" came back damaged ${TRIES} times: characters are lost on the line`);
    expect(board.taken).toEqual([]);
    board.lost.clear();
    const asked = board.line.ask("vd");
    await board.pass(0);
    await asked;
    expect(board.taken).toEqual(["vd"]);
  });

  test("does not come before a stop", async () => {
    const board = await new EchoingBoard().ready();
    board.unechoed.add(8);
    const row = board.row();
    await board.pass(0);
    const stopped = board.line.urgent("S");
    await board.pass(0);
    expect([await row, await stopped]).toEqual(['"m200v300" was given up for S', []]);
    expect(board.taken).toEqual(["S"]);
  });
});
