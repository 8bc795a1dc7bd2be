import { describe, expect, test } from "vitest";
import { canFrame } from "../src/views/wire/can_text";
import { columnsOf, meaningOf, timeText } from "../src/views/wire/columns";
import { Conversations, conversationOf, kindOf } from "../src/views/wire/conversation";
import { fieldAt, fieldContext } from "../src/views/wire/field_context";
import { completions, packetFilter, withWord } from "../src/views/wire/packet_filter";
import { load, PacketLog, readPacket, type WirePacket } from "../src/views/wire/packet_log";
import { hexPairs, modbusCrc, readHex, sacCrc, sacPacket } from "../src/views/wire/packet_text";
import { placeOf, ShownPackets } from "../src/views/wire/shown_packets";
import { BenchClock, marksOf, moved, timeLine, zoomed } from "../src/views/wire/time_line";
import { WireCounts } from "../src/views/wire/wire_counts";

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
    times: 1,
    isUnfinished: false,
    id: "",
    isRemote: false,
    apart_s: null,
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
      times: 1,
      isUnfinished: false,
      id: "",
      isRemote: false,
      apart_s: null,
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
    expect(readPacket({ at_s: 1, from: "n1", frame: "181#01", text: "PDO" }, 1)?.id).toBe("181");
  });

  test("keeps the last ones in order", () => {
    const log = new PacketLog(3);
    for (let at_s = 1; at_s <= 5; at_s++) log.add(packet(at_s));
    expect(log.all().map(({ at_s }) => at_s)).toEqual([3, 4, 5]);
    expect([log.at(0)?.at_s, log.at(2)?.at_s, log.at(3), log.at(-1), log.count]).toEqual([3, 5, undefined, undefined, 5]);
    expect(log.between(4.05, 9).map(({ at_s }) => at_s)).toEqual([4, 5]);
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

  test("who speaks to whom, how often, and what goes wrong", () => {
    const counts = new WireCounts("sac");
    for (const each of [packet(1), packet(2), packet(4), packet(5, { from: "x", error: "collision", duration_s: 0.4 })]) counts.add(each);
    expect(counts).toMatchObject({ packets: 4, bytes: 16, longest_s: 0.4, bad: 1 });
    expect(counts.span_s).toBeCloseTo(4.4);
    const talk = counts.groups.get("s1 → 85")!;
    expect(talk).toMatchObject({ packets: 3, bytes: 12, errors: 0 });
    expect(talk.period).toMatchObject({ count: 2, mean_s: 1.5, least_s: 1, most_s: 2 });
    expect([...counts.errors]).toEqual([["collision", 1]]);
    expect(new WireCounts("can")).toMatchObject({ packets: 0, span_s: 0, bad: 0 });
  });

  test("answers are timed: late ones, and those that never came", () => {
    const counts = new WireCounts("modbus");
    const ask = (at_s: number) => counts.add(packet(at_s, { from: "bus0.master", to: "2", duration_s: 0.001 }));
    const answer = (at_s: number) => counts.add(packet(at_s, { from: "2", to: "", duration_s: 0.001 }));
    for (let at_s = 0; at_s < 10; at_s++) {
      ask(at_s);
      answer(at_s + 0.006);
    }
    ask(10);
    answer(10.101);
    ask(11);
    ask(12);
    const unit = counts.groups.get("2")!;
    expect(unit).toMatchObject({ late: 1, unanswered: 1 });
    expect(unit.answers.most_s).toBeCloseTo(0.1);
    expect(unit.period.mean_s).toBeCloseTo(1);
  });
});

describe("conversations", () => {
  const can = (id: string, more: Partial<WirePacket> = {}) => packet(1, { id, from: "m1.canopen", to: "", ...more });

  test("are those of a kind of wire", () => {
    expect([kindOf(true, undefined), kindOf(false, "sac"), kindOf(false, "modbus_rtu"), kindOf(false, "walter")]).toEqual(["can", "sac", "modbus", "lines"]);
    expect([conversationOf("can", can("585")), conversationOf("can", can("605")), conversationOf("can", can("181"))]).toEqual(["sdo:5", "sdo:5", "id:181"]);
    expect(conversationOf("can", can("00000585"))).toBe("id:00000585");
    const talks = [packet(1, { from: "1" }), packet(1, { from: "85", to: "1" })].map((each) => conversationOf("sac", each));
    expect(talks).toEqual(["talk:1+85", "talk:1+85"]);
    expect([packet(1, { from: "bus0.master", to: "2" }), packet(1, { from: "2", to: "" })].map((each) => conversationOf("modbus", each))).toEqual([
      "unit:2",
      "unit:2",
    ]);
    for (const word of ["sdo:5", "node:5", "id:585", "-id:605"]) expect(packetFilter(word)(can("585"))).toBe(true);
  });

  test("tell how far their packets are apart", () => {
    const all = new Conversations("can");
    const apart = [can("585", { at_s: 1 }), can("181", { at_s: 2 }), can("605", { at_s: 4 })].map((each) => all.placed(each).apart_s);
    expect(apart).toEqual([null, null, 3]);
  });

  test("complete the filter", () => {
    const seen = [can("585"), can("181", { error: "CRC error" })];
    expect(completions("hello -no", "can", seen)).toEqual(["hello -node:1", "hello -node:5"]);
    expect(completions("er", "can", seen)).toEqual(["error", "error:crc"]);
    expect([withWord("a", "id:1"), withWord("a id:1 b", "id:1")]).toEqual(["a id:1", "a b"]);
  });
});

describe("the list", () => {
  test("has the packets that a filter leaves, as they come", () => {
    const log = new PacketLog(4);
    const shown = new ShownPackets(log);
    const numbers = () => {
      const rows = shown.rows("error");
      return Array.from({ length: rows.length }, (_, at) => rows.at(at)!.number);
    };
    const add = (isBad: boolean, isUnfinished = false) => log.add(packet(log.count, { number: log.count + 1, error: isBad ? "crc" : null, isUnfinished }));
    add(true);
    add(false);
    add(true, true);
    expect(numbers()).toEqual([1, 3]);
    log.dropUnfinished();
    add(false);
    expect(numbers()).toEqual([1]);
    for (let more = 0; more < 4; more++) add(more % 2 === 0);
    expect(numbers()).toEqual([4, 6]);
    expect(shown.rows(" ").length).toBe(4);
    expect([placeOf(log, 5), placeOf(log, 1), placeOf(log, undefined)]).toEqual([1, -1, -1]);
  });

  test("has columns by the kind of wire, and says nothing twice", () => {
    const frame = packet(1, { id: "585", hex: "4300100092010200", text: "SDO from 5: 1000h Device type is 131474 (00020192h)" });
    expect(columnsOf("can").map(({ text }) => text(frame))).toEqual(["585", "8", "s1"]);
    expect(meaningOf("can", frame)).toBe(frame.text);
    expect(meaningOf("sac", packet(1))).toBe("m3000");
    expect(meaningOf("modbus", packet(1, { text: "to 2: read coil 1" }))).toBe("read coil 1");
    expect(meaningOf("lines", packet(1, { text: "23 30 0d  #0." }))).toBe("#0.");
    expect(meaningOf("lines", packet(1, { text: "move 1" }))).toBe("move 1");
    expect(meaningOf("sac", packet(1, { text: "crc", error: "crc" }))).toBe("");
    expect([0, 2.5e-6, 1.5e-4, 0.0125, 1.5].map(timeText)).toEqual(["0.0 µs", "2.5 µs", "150 µs", "12.50 ms", "1.500 s"]);
  });
});

test("a window of the time line zooms, and goes back to the first packet", () => {
  const live = { span_s: 1, end_s: null };
  expect(zoomed(live, 2)).toEqual({ span_s: 2, end_s: null });
  expect(zoomed({ span_s: 1, end_s: 10 }, 0.5, 0.5)).toEqual({ span_s: 0.5, end_s: 9.75 });
  expect(zoomed(live, 1e-9).span_s).toBeGreaterThan(0);
  expect(moved(live, -2, 100, 0)).toEqual({ span_s: 1, end_s: 98 });
  expect(moved({ span_s: 1, end_s: 99.5 }, 1, 100, 0)).toEqual(live);
  expect(moved(live, -1e9, 100, 40)).toEqual({ span_s: 1, end_s: 40.9 });
  expect(marksOf(-1, 0, 5)).toMatchObject({ step_s: 0.2 });
  expect(marksOf(-1, 0, 5).times_s).toHaveLength(6);
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

test("frames of CAN are made of what was typed", () => {
  const made = (id: string, data: string, isExtended = false, isRemote = false) => canFrame({ id, data, isExtended, isRemote });
  expect(made("605", "40 00 10")).toEqual({ frame: "605#400010" });
  expect(made("0x5h", "")).toEqual({ frame: "005#" });
  expect(made("cafe", "", true)).toEqual({ frame: "0000CAFE#" });
  expect(made("123", "2", false, true)).toEqual({ frame: "123#R2" });
  const faults = [made("", ""), made("cafe", ""), made("20000000", "", true), made("1", "0"), made("1", "00".repeat(9)), made("1", "9", false, true)];
  for (const each of faults) expect(each).toHaveProperty("fault");
});

test("a packet's fields are asked for with what it answers", () => {
  const can = (id: string, hex: string) => packet(1, { id, hex, isRemote: hex === "" });
  const frames = [can("605", "40"), can("606", "41"), can("585", "43"), can("185", "01ab"), can("701", "")];
  const rows = { length: frames.length, at: (at: number) => frames[at] };
  expect(fieldContext("can", rows, 3, frames[3]!)).toEqual(["605#40", "585#43", "185#01AB"]);
  expect(fieldContext("can", rows, 4, frames[4]!)).toEqual(["701#R"]);
  const line = [packet(1, { from: "m", to: "2", hex: "0203" }), packet(2, { from: "m", to: "3" }), packet(3, { from: "2", to: "", hex: "0204" })];
  const asked = { length: 3, at: (at: number) => line[at] };
  expect(fieldContext("modbus", asked, 2, line[2]!)).toEqual(["1 0203", "3 0204"]);
  expect(fieldContext("sac", asked, 2, line[2]!)).toEqual(["3 0204"]);
  expect(fieldContext("sac", asked, 2, packet(3, { hex: "" }))).toEqual([]);
  const fields = [
    { begin: 0, end: 0, level: 0 },
    { begin: 0, end: 4, level: 0 },
    { begin: 1, end: 2, level: 1 },
  ];
  expect([0, 1, 3, 4].map((byte) => fieldAt(fields, byte))).toEqual([1, 2, 1, -1]);
});
