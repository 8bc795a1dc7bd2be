/** Packets as rows, the newest below. Only the rows in sight are made. */

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import type { WirePacket } from "./packet_log";
import { hexPairs } from "./packet_text";

const ROW_PX = 22;
const SPARE_ROWS = 8;

interface Props {
  packets: readonly WirePacket[];
  isPaused: boolean;
  chosen: number | undefined;
  choose(packet: WirePacket | undefined): void;
}

export function PacketList({ packets, isPaused, chosen, choose }: Props) {
  const box = useRef<HTMLDivElement>(null);
  const [top_px, setTop] = useState(0);
  const [height_px, setHeight] = useState(400);
  const isAtEnd = useRef(true);
  useLayoutEffect(() => {
    const element = box.current!;
    const observer = new ResizeObserver(() => setHeight(element.clientHeight));
    observer.observe(element);
    return () => observer.disconnect();
  }, []);
  useEffect(() => {
    const element = box.current!;
    if (isAtEnd.current && !isPaused) element.scrollTop = element.scrollHeight;
  }, [packets, isPaused]);
  const first = Math.max(0, Math.floor(top_px / ROW_PX) - SPARE_ROWS);
  const last = Math.min(packets.length, Math.ceil((top_px + height_px) / ROW_PX) + SPARE_ROWS);
  const place = packets.findIndex(({ number }) => number === chosen);
  const go = (by: number) => {
    const at = Math.min(Math.max(place < 0 ? packets.length - 1 : place + by, 0), packets.length - 1);
    choose(packets[at]);
    const element = box.current!;
    const row_px = at * ROW_PX;
    if (row_px < element.scrollTop) element.scrollTop = row_px;
    else if (row_px + 2 * ROW_PX > element.scrollTop + element.clientHeight) element.scrollTop = row_px + 2 * ROW_PX - element.clientHeight;
  };
  return (
    <div
      ref={box}
      class="packets"
      role="grid"
      aria-label="Packets"
      aria-rowcount={packets.length + 1}
      tabIndex={0}
      aria-activedescendant={place >= first && place < last ? `packet-${chosen}` : undefined}
      onScroll={(event) => {
        const { scrollTop, scrollHeight, clientHeight } = event.currentTarget;
        isAtEnd.current = scrollHeight - clientHeight - scrollTop < ROW_PX;
        setTop(scrollTop);
      }}
      onKeyDown={(event) => {
        const by = { ArrowDown: 1, ArrowUp: -1, PageDown: 15, PageUp: -15, Home: -packets.length, End: packets.length }[event.key];
        if (by === undefined || !packets.length) return;
        event.preventDefault();
        go(by);
      }}
    >
      <div role="row" class="packet head" aria-rowindex={1}>
        <span role="columnheader">Time s</span>
        <span role="columnheader">From</span>
        <span role="columnheader">To</span>
        <span role="columnheader">Meaning</span>
        <span role="columnheader">Bytes</span>
      </div>
      <div role="rowgroup" class="packet-rows" style={{ height: packets.length * ROW_PX }}>
        {packets.slice(first, last).map((packet, index) => (
          <div
            key={packet.number}
            id={`packet-${packet.number}`}
            role="row"
            aria-rowindex={first + index + 2}
            aria-selected={packet.number === chosen}
            class={`packet${packet.error === null ? "" : " is-bad"}${packet.number === chosen ? " is-chosen" : ""}`}
            style={{ top: (first + index) * ROW_PX }}
            onClick={() => choose(packet)}
          >
            <span role="gridcell" class="mono">
              {packet.at_s.toFixed(6)}
            </span>
            <span role="gridcell">{packet.from || "?"}</span>
            <span role="gridcell">{packet.to || "–"}</span>
            <span role="gridcell" class="mono meaning">
              {packet.error !== null && <strong>{packet.error}</strong>} {packet.text === packet.error ? "" : packet.text}
            </span>
            <span role="gridcell" class="mono soft bytes">
              {hexPairs(packet.hex)}
            </span>
          </div>
        ))}
      </div>
    </div>
  );
}

/** All that is known of a packet. */
export function PacketDetail({ packet, close }: { packet: WirePacket; close(): void }) {
  const rows: [string, string][] = [
    ["at", `${packet.at_s.toFixed(9)} s`],
    ["on the wire", `${(packet.duration_s * 1000).toFixed(3)} ms`],
    ["driven by", packet.by.join(" and ") || "unknown"],
    ["from", packet.from || "unknown"],
    ["to", packet.to || "unknown"],
    ["meaning", packet.text],
    ["error", packet.error ?? "none"],
    ["bytes", hexPairs(packet.hex) || "none"],
  ];
  return (
    <div class="packet-detail" role="region" aria-label="The chosen packet">
      <dl>
        {rows.map(([name, value]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd class={name === "error" && packet.error !== null ? "mono problem" : "mono"}>{value}</dd>
          </div>
        ))}
      </dl>
      <button type="button" class="plain" aria-label="Close the packet" onClick={close}>
        ×
      </button>
    </div>
  );
}
