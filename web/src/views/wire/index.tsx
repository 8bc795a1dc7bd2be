/** The wire view: packets of a segment, or frames of a bus, as they pass. */

import { useEffect, useState } from "preact/hooks";
import { signal } from "@preact/signals";
import { notifyError } from "../../parts/notices";
import { go, href } from "../../router";
import { askPast, LANE, pastAt } from "../../past";
import { hello, may, status } from "../../store";
import type { Hello } from "../../net/protocol";
import { BusState } from "./bus_state";
import { CanSend } from "./can_send";
import { apartOf, ListHead } from "./list_head";
import { PacketDetail } from "./packet_detail";
import { load, type WirePacket } from "./packet_log";
import { PacketList } from "./packet_list";
import { SendForm } from "./send_form";
import { TimeLinePane } from "./time_line_pane";
import { wireFeed, type WireFeed, type WirePlace } from "./wire_feed";
import { Figures } from "./wire_figures";
import "./wire.css";

/** Interval at which list and figures are drawn anew. */
const REDRAW_MS = 250;
const redraw = signal(0);

function wirePlaces(bench: Hello): WirePlace[] {
  return [...bench.segments.map((name) => ({ name, kind: "segment" as const })), ...bench.buses.map((name) => ({ name, kind: "bus" as const }))];
}

export function WireView({ path }: { path: string[] }) {
  const places = hello.value ? wirePlaces(hello.value) : [];
  const place = places.find(({ name }) => name === path[0]) ?? places[0];
  if (!place) return <p class="empty">There is no segment and no CAN bus on this bench.</p>;
  return (
    <>
      {path[0] !== undefined && path[0] !== place.name && (
        <p class="problem no-place">
          There is no wire “{path[0]}”. This is {place.name}.
        </p>
      )}
      <Wire key={`${place.kind} ${place.name}`} place={place} places={places} />
    </>
  );
}

function Wire({ place, places }: { place: WirePlace; places: WirePlace[] }) {
  const feed = wireFeed(place);
  const [chosen, setChosen] = useState<WirePacket | undefined>(undefined);
  useEffect(() => feed.attach(), [feed]);
  useEffect(() => {
    let seen = -1;
    const timer = window.setInterval(() => {
      if (seen === feed.news.peek() && Date.now() % 1000 > REDRAW_MS) return;
      seen = feed.news.peek();
      redraw.value += 1;
    }, REDRAW_MS);
    return () => window.clearInterval(timer);
  }, [feed]);
  usePast(feed);
  const isPaused = feed.paused.value !== undefined;
  const turn = redraw.value; // the log is no signal: what shows it is drawn again with each turn
  const rows = feed.rows();
  return (
    <div class="wire">
      <div class="row wire-head">
        <label>
          Wire{" "}
          <select value={place.name} onChange={(event) => go("wire", event.currentTarget.value)}>
            {places.map(({ name }) => (
              <option key={name}>{name}</option>
            ))}
          </select>
        </label>
        <Line name={place.name} />
        <LoadMeter feed={feed} />
        <a class="button" href={href("faults", place.name)}>
          Break…
        </a>
        {feed.refused.value && (
          <span class="problem" role="alert">
            {feed.refused.value}
          </span>
        )}
      </div>
      <section class="card" aria-labelledby="line-title">
        <TimeLinePane feed={feed} isPaused={isPaused} chosen={chosen?.number} choose={setChosen} />
      </section>
      <section class="card" aria-labelledby="packets-title">
        <ListHead feed={feed} turn={turn} shown={rows.length} isPaused={isPaused} />
        <PacketList
          kind={feed.kind}
          rows={rows}
          turn={turn}
          isPaused={isPaused}
          chosen={chosen?.number}
          apart={apartOf()}
          marked={feed.marked.value}
          choose={setChosen}
        />
        {chosen && <PacketDetail feed={feed} packet={chosen} close={() => setChosen(undefined)} />}
        {place.kind === "segment" ? (
          <SendForm segment={place.name} isDisabled={!may("operator")} />
        ) : (
          <CanSend bus={place.name} isDisabled={!may("operator")} />
        )}
      </section>
      {place.kind === "bus" && <BusState name={place.name} />}
      <Figures feed={feed} turn={turn} />
    </div>
  );
}

/** Show the packets before the time of the past that the page shows, as if the list were paused then. */
export function usePast(feed: WireFeed): void {
  const at_s = pastAt.value;
  useEffect(() => {
    if (at_s === null) return;
    let isThere = true;
    askPast("past_packets", { wire: feed.place.name, at_s, lane: LANE })
      .then((told) => {
        if (told && isThere) feed.showPast(told.items, at_s);
      })
      .catch(notifyError);
    return () => void (isThere = false);
  }, [feed, at_s]);
  const isPast = at_s !== null;
  useEffect(() => (isPast ? () => feed.setPaused(false) : undefined), [feed, isPast]);
}

function Line({ name }: { name: string }) {
  const line = hello.value?.lines.get(name);
  const bus = status.value.buses?.find((each) => each.bus === name);
  const parts = line ? [line.framing, line.baud ? `${line.baud} baud` : "", line.format] : bus ? ["CAN", bitRate(bus.bit_rate)] : [];
  return <span class="soft">{parts.filter(Boolean).join(", ")}</span>;
}

function bitRate(rate: number): string {
  return rate >= 1e6 ? `${rate / 1e6} Mbit/s` : `${rate / 1e3} kbit/s`;
}

/** Part of the last second, and of the last ten, in which the wire was busy. */
function LoadMeter({ feed }: { feed: WireFeed }) {
  void redraw.value;
  const now_s = feed.now_s();
  const recent = feed.log.between(now_s - 10, now_s);
  const one = load(recent, now_s - 1, now_s);
  const ten = load(recent, now_s - 10, now_s);
  const percent = (part: number) => `${(part * 100).toFixed(part < 0.1 ? 1 : 0)} %`;
  return (
    <span class="row load">
      <span class="soft">Load</span>
      <meter min={0} max={1} low={0.5} high={0.8} optimum={0} value={one} aria-label="Load of the last second" />
      <span class="mono load-figure">{percent(one)}</span>
      <span class="soft">
        10 s: <span class="mono">{percent(ten)}</span>
      </span>
    </span>
  );
}
