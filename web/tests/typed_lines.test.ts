import { describe, expect, it } from "vitest";
import { bytesOfMacro, moved, readMacros, titleOf, withLine } from "../src/model/sent_lines";
import { TypedQueue, WINDOW_BYTES } from "../src/model/typed_queue";

describe("a long text that is typed", () => {
  const board = () => {
    const sent: number[] = [];
    const queue = new TypedQueue((bytes) => (sent.push(...bytes), true));
    return { sent, queue };
  };

  it("goes as fast as the port takes it, whole and in order", () => {
    const { sent, queue } = board();
    const text = Uint8Array.from({ length: 200_000 }, (_, at) => at % 251);
    queue.put(text);
    expect(sent.length).toBe(WINDOW_BYTES);
    while (sent.length < text.length) {
      const before = sent.length;
      queue.took(before - 100);
      expect(sent.length - before).toBeLessThanOrEqual(WINDOW_BYTES);
      expect(queue.state).toEqual({ of: text.length, taken: before - 100 });
    }
    expect(sent.length).toBe(text.length);
    expect(sent.every((byte, at) => byte === text[at])).toBe(true);
  });

  it("can be stopped: what is under way is taken, and the next text is counted by itself", () => {
    const { sent, queue } = board();
    queue.put(new Uint8Array(50_000));
    expect(queue.stop()).toEqual({ of: 50_000, taken: 0 });
    expect(queue.state).toEqual({ of: WINDOW_BYTES, taken: 0 });
    queue.took(WINDOW_BYTES);
    queue.put(Uint8Array.of(1));
    expect(queue.state).toEqual({ of: 1, taken: 0 });
    expect(sent.length).toBe(WINDOW_BYTES + 1);
  });

  it("is given up where there is no way to send", () => {
    const queue = new TypedQueue(() => false);
    queue.put(new Uint8Array(9));
    expect(queue.state.of).toBe(0);
  });
});

describe("lines that were sent", () => {
  it("are kept once, the newest at the end", () => {
    expect(withLine(["a", "b"], "a")).toEqual(["b", "a"]);
    expect(withLine(["a"], "")).toEqual(["a"]);
    expect(withLine(Array.from({ length: 100 }, String), "x")).toHaveLength(100);
  });
});

describe("macros", () => {
  const text = (given: string, ending: "none" | "CR LF" = "none") => [...bytesOfMacro({ name: "", text: given, ending })];

  it("send what escapes stand for", () => {
    expect(text("q\\r\\x03\\\\n\\q", "CR LF")).toEqual([...new TextEncoder().encode("q\r\x03\\n\\q\r\n")]);
    expect(text("\\xé")).toEqual([...new TextEncoder().encode("\\xé")]);
  });

  it("are read as far as they are some", () => {
    const kept = [{ name: "go", text: "q", ending: "LF" }, { name: 1 }, null, { name: "", text: "vd", ending: "?" }];
    expect(readMacros(kept)).toEqual([
      { name: "go", text: "q", ending: "LF" },
      { name: "", text: "vd", ending: "CR" },
    ]);
    expect(readMacros(kept).map(titleOf)).toEqual(["go", "vd"]);
    expect(readMacros("all")).toEqual([]);
  });

  it("are moved", () => {
    expect(moved(["a", "b", "c"], 2, -1)).toEqual(["a", "c", "b"]);
    expect(moved(["a", "b"], 0, -1)).toEqual(["a", "b"]);
  });
});
