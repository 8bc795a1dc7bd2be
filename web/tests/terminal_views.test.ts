import { describe, expect, it } from "vitest";
import { PortRecord } from "../src/model/port_record";
import { plainOf } from "../src/model/terminal_text";
import { HexView, savedText, TimesView } from "../src/model/terminal_views";

const piece = (at_s: number, text: string) => ({ at_s, bytes: new TextEncoder().encode(text) });

describe("a terminal with times", () => {
  const written = (...pieces: [number, string][]) => {
    const view = new TimesView();
    return plainOf(pieces.map(([at_s, text]) => view.next(piece(at_s, text))).join(""));
  };

  it("begins each line with the time of its first byte", () => {
    expect(written([1, "one\r\ntw"], [2.5, "o\r\n\r\n"], [3, "x"])).toBe("    1.000 one\r\n    1.000 two\r\n    2.500 \r\n    3.000 x");
  });

  it("writes it again where a return begins the line once more", () => {
    expect(written([1, "10 %\r20 %"], [2, "\r"], [3, "30 %\r\n"])).toBe("    1.000 10 %\r    1.000 20 %\r    3.000 30 %\r\n");
  });

  it("leaves the board's colours as they are", () => {
    const view = new TimesView();
    expect(view.next(piece(1, "\x1b[31mred\nstill"))).toContain("\x1b[0m\x1b[31mstill");
  });
});

describe("a terminal of bytes", () => {
  it("writes rows of sixteen, the last one again as it grows", () => {
    const view = new HexView(0x100);
    expect(view.next(piece(0, "AB\n"))).toBe(`\r000100  41 42 0a${" ".repeat(42)}AB.`);
    const [, first, second] = view.next(piece(0, "0123456789abcDEF")).split("\r");
    expect(first).toBe("000100  41 42 0a 30 31 32 33 34  35 36 37 38 39 61 62 63  AB.0123456789abc");
    expect(second).toBe("\n");
  });

  it("has what was sent in rows of its own, and no other view has it", () => {
    const pieces = [piece(1, "ABC"), { ...piece(NaN, "p"), isSent: true }, { ...piece(NaN, "\r"), isSent: true }, piece(2, "D")];
    expect(savedText("hex", pieces, 0).replace(/ {2,}/g, "  ")).toBe("000000  41 42 43  ABC\n  sent  70 0d  p.\n000003  44  D");
    const view = new HexView();
    expect(
      pieces
        .map((each) => view.next(each))
        .join("")
        .replace(/ {2,}/g, "  "),
    ).toBe("\r000000  41 42 43  ABC\r\n\r  sent  70  p\r  sent  70 0d  p.\r\n\r000003  44  D");
    expect(savedText("text", pieces, 0)).toBe("ABCD");
  });
});

describe("a saved terminal", () => {
  const pieces = [piece(1, "\x1b[1mone\x1b[0m\r\nt\x07wo, and some more"), piece(2, "\r\n")];

  it.each([
    ["text", "one\nt\\x07wo, and some more\n"],
    ["times", "    1.000 one\n    1.000 t\\x07wo, and some more\n"],
    [
      "hex",
      "000000  1b 5b 31 6d 6f 6e 65 1b  5b 30 6d 0d 0a 74 07 77  .[1mone.[0m..t.w\n" +
        "000010  6f 2c 20 61 6e 64 20 73  6f 6d 65 20 6d 6f 72 65  o, and some more\n" +
        "000020  0d 0a                                             ..",
    ],
  ] as const)("has the %s", (name, wanted) => {
    expect(savedText(name, pieces, 0)).toBe(wanted);
  });

  it("has the newest of what a port said without end", () => {
    const record = new PortRecord();
    for (let at = 0; at < 30; at++) record.add({ at_s: at, bytes: new Uint8Array(100_000).fill(at) });
    expect(record.pieces[0]?.at_s).toBe(20);
    expect(record.gone).toBe(2_000_000);
  });
});
