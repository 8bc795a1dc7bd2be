import { describe, expect, it } from "vitest";
import { readBinary, readHello, readText, Refused, terminalFrame, terminalFrames } from "../src/net/protocol";

function samples(watch: number, lost: number, fields: number, values: number[], rows = values.length / (1 + fields)): ArrayBuffer {
  const frame = new ArrayBuffer(16 + values.length * 8);
  const head = new DataView(frame);
  head.setUint8(0, 1);
  head.setUint8(1, fields);
  head.setUint32(4, watch, true);
  head.setUint32(8, lost, true);
  head.setUint32(12, rows, true);
  new Float64Array(frame, 16).set(values);
  return frame;
}

function joined(...parts: ArrayBuffer[]): ArrayBuffer {
  const bytes = parts.flatMap((part) => [...new Uint8Array(part)]);
  return Uint8Array.from(bytes).buffer;
}

describe("binary messages", () => {
  it("reads samples", () => {
    const [block] = readBinary(samples(7, 3, 2, [0.5, 1, 2, 0.6, 3, 4])) ?? [];
    expect(block).toMatchObject({ kind: "samples", watch: 7, lost: 3, columns: 3, rows: 2 });
    expect(block?.kind === "samples" && [...block.values]).toEqual([0.5, 1, 2, 0.6, 3, 4]);
  });

  it("reads the blocks of all watches, also of other widths and without rows", () => {
    const message = joined(samples(7, 0, 2, [0.5, 1, 2]), samples(8, 1, 1, []), samples(9, 2, 1, [0.5, 6, 0.6, 7]));
    const blocks = readBinary(message) ?? [];
    expect(blocks).toMatchObject([
      { watch: 7, rows: 1 },
      { watch: 8, rows: 0, lost: 1 },
      { watch: 9, rows: 2, columns: 2 },
    ]);
    expect(blocks.map((block) => block.kind === "samples" && [...block.values])).toEqual([[0.5, 1, 2], [], [0.5, 6, 0.6, 7]]);
  });

  it.each([0, 1, 7, 12, 15, 17, 39])("takes %i bytes of a cut message for none", (length) => {
    expect(readBinary(samples(7, 0, 2, [1, 2, 3]).slice(0, length))).toBeNull();
  });

  it("takes a message whose second block is cut for none", () => {
    expect(readBinary(joined(samples(7, 0, 1, [1, 2]), samples(8, 0, 1, [1, 2]).slice(0, 24)))).toBeNull();
  });

  it("does not believe a number of rows that does not fit", () => {
    expect(readBinary(samples(7, 0, 2, [1, 2, 3], 2 ** 32 - 1))).toBeNull();
  });

  it("reads when a terminal said something, and how much it has taken", () => {
    const message = new Uint8Array(18);
    const head = new DataView(message.buffer);
    message.set([3, 0, 0, 0, 9], 0);
    head.setFloat64(8, 1.25, true);
    message.set([65, 66], 16);
    expect(readBinary(message.buffer)).toEqual([{ kind: "terminal", terminal: 9, at_s: 1.25, bytes: Uint8Array.of(65, 66) }]);
    expect(readBinary(message.buffer.slice(0, 12))).toBeNull();
    expect(readText('{"taken":{"terminal":9,"bytes":4096}}')).toEqual({ kind: "taken", terminal: 9, bytes: 4096 });
  });

  it("reads what it writes for terminals", () => {
    expect(readBinary(terminalFrame(9, Uint8Array.of(1, 255)).buffer)).toEqual([{ kind: "terminal", terminal: 9, at_s: NaN, bytes: Uint8Array.of(1, 255) }]);
  });
});

describe("messages for terminals", () => {
  it("have what was typed, in pieces that the bench takes", () => {
    const typed = Uint8Array.from({ length: 25 }, (_, at) => at);
    const frames = [...terminalFrames(9, typed, 18)];
    expect(frames.map((frame) => frame.length)).toEqual([18, 18, 13]);
    expect(frames.flatMap((frame) => [...frame.subarray(8)])).toEqual([...typed]);
    expect(frames.every((frame) => frame[4] === 9)).toBe(true);
    expect([...terminalFrames(9, new Uint8Array(0), 18)]).toEqual([]);
  });
});

describe("text frames", () => {
  it.each(["", "null", "[]", "3", '"x"', "{", "{}", '{"id":1}', '{"watch":"1"}', '{"id":"1","answer":1}'])("takes %j for unknown", (frame) => {
    expect(readText(frame).kind).toBe("unknown");
  });

  it("reads answers, refusals and pushes", () => {
    expect(readText('{"id":1,"answer":null}')).toEqual({ kind: "answer", id: 1, answer: null });
    const refused = readText('{"id":2,"error":{"code":"cannot","message":"no"}}');
    expect(refused.kind === "error" && refused.error).toBeInstanceOf(Refused);
    expect(readText('{"watch":3,"items":[1],"lost":4}')).toEqual({ kind: "push", watch: 3, items: [1], lost: 4 });
    expect(readText('{"watch":3,"value":null}')).toEqual({ kind: "push", watch: 3, value: null, lost: 0 });
    expect(readText('{"closed":{"terminal":5,"why":"gone"}}')).toEqual({ kind: "closed", what: "terminal", number: 5, why: "gone" });
    expect(readText('{"closed":{"watch":6,"why":"m1 was changed"}}')).toEqual({ kind: "closed", what: "watch", number: 6, why: "m1 was changed" });
  });

  it("reads a greeting of which everything is missing or wrong", () => {
    expect(readHello(null)).toMatchObject({ bench: "", role: "viewer", devices: [], ports: [] });
    const hello = readHello({ role: "root", devices: [3, { name: "__proto__", verbs: { __proto__: null, x: 1, y: {} } }], ports: "p" });
    expect(hello.role).toBe("viewer");
    expect(hello.devices).toHaveLength(1);
    expect(Object.keys(hello.devices[0]!.verbs)).toEqual(["y"]);
    expect(hello.ports).toEqual([]);
  });
});
