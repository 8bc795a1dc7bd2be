import { describe, expect, it } from "vitest";
import { plainOf, TerminalText } from "../src/model/terminal_text";

const shown = (...parts: number[][]) => {
  const decoder = new TerminalText();
  return parts.map((part) => plainOf(decoder.next(Uint8Array.from(part)))).join("");
};
const bytes = (text: string) => [...new TextEncoder().encode(text)];

describe("TerminalText", () => {
  it("lets text and line ends through", () => {
    expect(shown(bytes("SAC>vd\r\n150\t2000\b"))).toBe("SAC>vd\r\n150\t2000\b");
    expect(shown(bytes("µ°😀"))).toBe("µ°😀");
  });

  it("shows escape sequences instead of carrying them out", () => {
    const text = new TerminalText().next(Uint8Array.from(bytes("\x1b]0;title\x07\x1b[2J")));
    expect(plainOf(text)).toBe("\\x1b]0;title\\x07\\x1b[2J");
    expect(text.replaceAll(/\x1b\[2?7m/g, "")).not.toContain("\x1b");
  });

  it("shows controls of C1 and those that turn text around", () => {
    expect(shown(bytes("a\u009bb\u202ec\u007f"))).toBe("a\\u009bb\\u202ec\\x7f");
  });

  it.each([
    [[0xff, 0x41], "\\xffA"],
    [[0xc0, 0xaf], "\\xc0\\xaf"],
    [[0xed, 0xa0, 0x80, 0x42], "\\xed\\xa0\\x80B"],
    [[0xf4, 0x90, 0x80, 0x80], "\\xf4\\x90\\x80\\x80"],
    [[0xe2, 0x82, 0x41], "\\xe2\\x82A"],
  ])("shows invalid UTF-8 %j as its bytes", (given, wanted) => {
    expect(shown(given)).toBe(wanted);
  });

  it("joins a character that is cut between frames", () => {
    expect(shown([0xe2], [0x82], [0xac, 0x41])).toBe("€A");
    expect(shown([0xf0, 0x9f], [0x41])).toBe("\\xf0\\x9fA");
  });

  const raw = (...parts: string[]) => {
    const decoder = new TerminalText();
    return parts.map((part) => decoder.next(Uint8Array.from(bytes(part)))).join("");
  };

  it.each(["\x1b[m", "\x1b[31;1mred\x1b[0m", "\x1b[38;5;200;48;2;1;2;255mx", "\x1b[97;104m"])("lets colours %j through", (given) => {
    expect(raw(given)).toBe(given);
    expect(raw(...given)).toBe(given); // byte by byte
  });

  it.each(["\x1b[8m", "\x1b[5m", "\x1b[31;8m", "\x1b[38;5;256m", "\x1b[38;2;1;2m", "\x1b[?25m", "\x1b[6n", "\x1b[31", `\x1b[${"1;".repeat(40)}m`])(
    "shows %j, which hides, asks or goes on without end",
    (given) => {
      expect(plainOf(raw(given, "\n"))).toBe(`\\x1b${given.slice(1)}\n`);
    },
  );

  it("tells escapes from text that is reversed itself", () => {
    expect(raw("\x1b[7ma\x01\x1b[27m\x01")).toBe("\x1b[7ma\x1b[27m\\x01\x1b[7m\x1b[27m\x1b[7m\\x01\x1b[27m");
  });
});
