import { describe, expect, test } from "vitest";
import { load, packetFilter, PacketLog, readPacket, statistics, type WirePacket } from "../src/views/wire/packet_log";
import { hexPairs, modbusCrc, readHex, sacCrc, sacPacket } from "../src/views/wire/packet_text";
import { BenchClock, timeLine } from "../src/views/wire/time_line";

function packet(at_s: number, more: Partial<WirePacket> = {}): WirePacket {
  return {
    number: 1,
    at_s,
    from: "s1",
    to: "85",
    by: ["s1"],
    hex: "02550103",
    text: "1 -> 85 m3000",
    error: null,
    duration_s: 0.1,
    isUnfinished: false,
    ...more,
  };
}

describe("the log", () => {
  test("reads what the door tells, and passes over what is no packet", () => {
    const told = { at_s: 1.5, from: 1, to: null, hex: "02", text: "x", error: null, duration_s: -1 };
    expect(readPacket(told, 7)).toEqual({
      number: 7,
      at_s: 1.5,
      from: "1",
      to: "",
      by: ["1"],
      hex: "02",
      text: "x",
      error: null,
      duration_s: 0,
      isUnfinished: false,
    });
    for (const item of [null, 5, "x", {}, { at_s: "soon" }]) expect(readPacket(item, 1)).toBeUndefined();
    expect(readPacket({ at_s: 1, error: "" }, 1)?.error).toBe("error");
  });

  test("knows who drove the wire", () => {
    const by = (item: object) => readPacket({ at_s: 1, ...item }, 1)?.by;
    expect(by({ from: 85, by: "s1.network", error: null })).toEqual(["s1.network"]);
    expect(by({ from: null, by: "", error: "collision of s1.network and bus0.master" })).toEqual(["s1.network", "bus0.master"]);
    expect(by({ from: null, by: "" })).toEqual([]);
    expect(readPacket({ at_s: 1, from: null, error: "collision of a and b" }, 1)?.from).toBe("a and b");
    expect(readPacket({ at_s: 1, from: null, by: "bus0.master" }, 1)?.from).toBe("bus0.master");
    expect(readPacket({ at_s: 1, from: "n1", frame: "181#01", text: "PDO" }, 1)?.text).toBe("181#01  PDO");
  });

  test("keeps the last ones in order", () => {
    const log = new PacketLog(3);
    for (let at_s = 1; at_s <= 5; at_s++) log.add(packet(at_s));
    expect(log.all().map(({ at_s }) => at_s)).toEqual([3, 4, 5]);
    expect([log.at(0)?.at_s, log.at(2)?.at_s, log.at(3), log.at(-1), log.count]).toEqual([3, 5, undefined, undefined, 5]);
    expect(log.since(4.05).map(({ at_s }) => at_s)).toEqual([4, 5]);
    log.clear();
    expect([log.length, log.all()]).toEqual([0, []]);
  });
});

test("what is unfinished goes when something follows", () => {
  const log = new PacketLog(3);
  log.dropUnfinished();
  for (let at_s = 1; at_s <= 4; at_s++) log.add(packet(at_s, { number: log.count + 1 }));
  log.dropUnfinished();
  expect(log.count).toBe(4);
  log.add(packet(5, { number: 5, isUnfinished: true }));
  log.dropUnfinished();
  expect([log.count, log.all().map(({ at_s }) => at_s)]).toEqual([4, [3, 4]]);
  for (let at_s = 6; at_s <= 8; at_s++) log.add(packet(at_s));
  expect(log.all().map(({ at_s }) => at_s)).toEqual([6, 7, 8]);
});

describe("the filter", () => {
  const seen = (text: string, more: Partial<WirePacket> = {}) => packetFilter(text)(packet(1, more));

  test("wants all words", () => {
    expect(seen("")).toBe(true);
    expect(seen("m3000 85")).toBe(true);
    expect(seen("M3000 86")).toBe(false);
    expect(seen("from:s1 to:85")).toBe(true);
    expect(seen("from:s")).toBe(false);
    expect(seen("hex:0255")).toBe(true);
    expect(seen("-m3000")).toBe(false);
    expect(seen("-")).toBe(true);
    expect([seen("error"), seen("error", { error: "crc" }), seen("error:col", { error: "crc" })]).toEqual([false, true, false]);
    expect(seen("-error", { error: "crc" })).toBe(false);
  });
});

describe("load and statistics", () => {
  test("packets over each other count once", () => {
    expect(load([], 0, 1)).toBe(0);
    expect(load([packet(0.5), packet(0.55), packet(0.95)], 0, 1)).toBeCloseTo(0.2);
    expect(load([packet(-0.05, { duration_s: 2 })], 0, 1)).toBe(1);
    expect(load([packet(0)], 1, 1)).toBe(0);
  });

  test("who speaks to whom, and what goes wrong", () => {
    const found = statistics([packet(1), packet(2), packet(3, { from: "x", error: "collision", duration_s: 0.4 })]);
    expect(found).toMatchObject({ packets: 3, bytes: 12, longest_s: 0.4 });
    expect(found.talks[0]).toEqual({ from: "s1", to: "85", packets: 2, bytes: 8, errors: 0 });
    expect([...found.errors]).toEqual([["collision", 1]]);
    expect(found.span_s).toBeCloseTo(2.4);
    expect(statistics([])).toMatchObject({ packets: 0, span_s: 0, mean_duration_s: 0 });
  });
});

describe("the time line", () => {
  test("has a lane for each speaker, and shows where several speak", () => {
    const line = timeLine([packet(9.2), packet(9.25, { by: ["s2"] }), packet(9.7, { error: "collision of s1 and s3", by: ["s1", "s3"] })], 10, ["s9"]);
    expect(line.lanes).toEqual(["s9", "s1", "s2", "s3"]);
    expect(line.bars.map(({ lane }) => lane)).toEqual([1, 2, 1, 3]);
    expect(line.bars[0]!.begin).toBeCloseTo(0.2);
    expect(line.collisions).toHaveLength(2);
    expect(line.collisions[0]!.begin).toBeCloseTo(0.25);
    expect(line.collisions[0]!.end).toBeCloseTo(0.3);
  });

  test("leaves out what is over, and cuts what has begun before", () => {
    const line = timeLine([packet(8), packet(8.95), packet(10.5)], 10, []);
    expect(line.bars).toHaveLength(1);
    expect(line.bars[0]!.begin).toBe(0);
  });

  test("its clock goes on by itself and never back", () => {
    const clock = new BenchClock();
    clock.tell(10, 1000);
    expect(clock.now_s(1500)).toBe(10.5);
    clock.tell(10.2, 1500);
    expect(clock.now_s(1500)).toBe(10.5);
    expect(clock.now_s(2000)).toBe(10.7);
    clock.tell(1, 2000);
    expect(clock.now_s(2000)).toBe(1);
    clock.tell(2, 3000, 0);
    expect(clock.now_s(9000)).toBe(2);
  });
});

describe("bytes to send", () => {
  test("are read as people write them", () => {
    expect(readHex("02 55,0x01:ff")).toEqual(Uint8Array.of(2, 0x55, 1, 255));
    expect(readHex("")).toEqual({ fault: "write bytes as 02 55 01" });
    expect(readHex("0g")).toEqual({ fault: '"g" is no hexadecimal digit' });
    expect(readHex("021")).toEqual({ fault: "a byte has two digits; one is missing" });
    expect(readHex("00".repeat(1025))).toHaveProperty("fault");
    expect(hexPairs("025501")).toBe("02 55 01");
  });

  test("have the checksums of their protocols", () => {
    const bytes = (text: string) => new TextEncoder().encode(text);
    expect(sacCrc(bytes("123456789"))).toBe(0xa1);
    expect(sacCrc(bytes("m3000"))).toBe(0x70);
    expect(sacPacket(85, 1, "y")).toEqual(Uint8Array.of(2, 85, 1, 0x79, 3, sacCrc(bytes("y")), 0));
    expect(modbusCrc(bytes("123456789"))).toEqual([0x37, 0x4b]);
  });
});
