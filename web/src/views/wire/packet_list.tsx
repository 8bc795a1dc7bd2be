/** Packets as rows, the newest below. Only the rows in sight are made. */

import { useEffect, useId, useLayoutEffect, useRef, useState } from "preact/hooks";
import { columnsOf, meaningOf, timeText } from "./columns";
import type { WireKind } from "./conversation";
import type { WirePacket } from "./packet_log";
import { hexPairs } from "./packet_text";
import { placeOf, type PacketRows } from "./shown_packets";

const ROW_PX = 22;
const SPARE_ROWS = 8;
const PAGE_ROWS = 15;

/** What the column of differences tells. */
export type Apart = "shown" | "talk" | "mark";

interface Props {
  kind: WireKind;
  rows: PacketRows;
  /** Another one where the rows have changed. */
  turn: number;
  isPaused: boolean;
  chosen: number | undefined;
  apart: Apart;
  marked: WirePacket | undefined;
  choose(packet: WirePacket | undefined): void;
}

export function PacketList({ kind, rows, isPaused, chosen, apart, marked, choose }: Props) {
  const id = useId();
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
  });
  const reveal = (at: number) => {
    const element = box.current!;
    const row_px = at * ROW_PX;
    if (row_px < element.scrollTop) element.scrollTop = row_px;
    else if (row_px + 2 * ROW_PX > element.scrollTop + element.clientHeight) element.scrollTop = row_px + 2 * ROW_PX - element.clientHeight;
  };
  const place = placeOf(rows, chosen);
  useEffect(() => {
    if (place >= 0) reveal(place);
  }, [chosen]);
  const first = Math.max(0, Math.floor(top_px / ROW_PX) - SPARE_ROWS);
  const last = Math.min(rows.length, Math.ceil((top_px + height_px) / ROW_PX) + SPARE_ROWS);
  const columns = columnsOf(kind);
  const inSight = Array.from({ length: Math.max(last - first, 0) }, (_, index) => first + index);
  return (
    <div
      ref={box}
      class={`packets of-${kind}`}
      data-none={rows.length ? undefined : "No packets here yet."}
      role="grid"
      aria-label="Packets"
      aria-rowcount={rows.length + 1}
      tabIndex={0}
      aria-activedescendant={place >= first && place < last ? `${id}-${chosen}` : undefined}
      onScroll={(event) => {
        const { scrollTop, scrollHeight, clientHeight } = event.currentTarget;
        isAtEnd.current = scrollHeight - clientHeight - scrollTop < ROW_PX;
        setTop(scrollTop);
      }}
      onKeyDown={(event) => {
        const by = { ArrowDown: 1, ArrowUp: -1, PageDown: PAGE_ROWS, PageUp: -PAGE_ROWS, Home: -rows.length, End: rows.length }[event.key];
        if (by === undefined || !rows.length) return;
        event.preventDefault();
        choose(rows.at(Math.min(Math.max(place < 0 ? rows.length - 1 : place + by, 0), rows.length - 1)));
      }}
    >
      <div role="row" class="packet head" aria-rowindex={1}>
        <span role="columnheader">Time s</span>
        <span role="columnheader" class="num wide-only">
          Apart
        </span>
        {columns.map(({ title, look }) => (
          <span key={title} role="columnheader" class={look.replace("mono", "")} aria-label={title || "Way"}>
            {title}
          </span>
        ))}
        <span role="columnheader">Meaning</span>
        <span role="columnheader" class="bytes">
          Bytes
        </span>
      </div>
      <div role="rowgroup" class="packet-rows" style={{ height: `${rows.length * ROW_PX}px` }}>
        {inSight.map((at) => {
          const packet = rows.at(at)!;
          const isChosen = packet.number === chosen;
          return (
            <div
              key={packet.number}
              id={`${id}-${packet.number}`}
              role="row"
              aria-rowindex={at + 2}
              aria-selected={isChosen}
              class={`packet${packet.error === null ? "" : " is-bad"}${isChosen ? " is-chosen" : ""}${packet === marked ? " is-marked" : ""}`}
              style={{ top: `${at * ROW_PX}px` }}
              onClick={() => choose(packet)}
            >
              <span role="gridcell" class="mono">
                {packet.at_s.toFixed(6)}
              </span>
              <span role="gridcell" class="mono soft num wide-only">
                {apartText(apart, packet, rows.at(at - 1), marked)}
              </span>
              {columns.map(({ title, look, text }) => (
                <span key={title} role="gridcell" class={look}>
                  {text(packet)}
                </span>
              ))}
              <span role="gridcell" class="mono meaning" title={meaningOf(kind, packet)}>
                {packet.error !== null && <strong>{packet.error}</strong>} {meaningOf(kind, packet)}
              </span>
              <span role="gridcell" class="mono soft bytes">
                {hexPairs(packet.hex)}
              </span>
            </div>
          );
        })}
      </div>
    </div>
  );
}

function apartText(apart: Apart, packet: WirePacket, before: WirePacket | undefined, marked: WirePacket | undefined): string {
  if (apart === "talk") return packet.apart_s === null ? "" : timeText(packet.apart_s);
  const from = apart === "mark" ? marked : before;
  return from ? timeText(packet.at_s - from.at_s) : "";
}
