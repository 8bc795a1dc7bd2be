/** The wire view: packets of a segment, or frames of a bus, as they pass. */

import { useEffect, useMemo, useState } from "preact/hooks";
import { signal } from "@preact/signals";
import { notify, notifyError } from "../../parts/notices";
import { go } from "../../router";
import { askPast, LANE, pastAt } from "../../past";
import { hello, link, may } from "../../store";
import type { Hello } from "../../net/protocol";
import type { ViewEntry } from "../view";
import { saveFile } from "../../parts/files";
import { FILTER_HELP, load, readPacket, statistics, type WirePacket } from "./packet_log";
import { PacketDetail, PacketList } from "./packet_list";
import { SendForm } from "./send_form";
import { TimeLinePane } from "./time_line_pane";
import { wireFeed, type WireFeed, type WirePlace } from "./wire_feed";
import "./wire.css";

/** Interval at which list and figures are drawn anew. */
const REDRAW_MS = 250;
const redraw = signal(0);

function wirePlaces(bench: Hello): WirePlace[] {
  return [...bench.segments.map((name) => ({ name, kind: "segment" as const })), ...bench.buses.map((name) => ({ name, kind: "bus" as const }))];
}

function WireView({ path }: { path: string[] }) {
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
  const turn = redraw.value;
  const packets = useMemo(() => feed.shown, [turn, isPaused, feed.filter.value, feed]);
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
        {feed.refused.value && (
          <span class="problem" role="alert">
            {feed.refused.value}
          </span>
        )}
      </div>
      <section class="card" aria-labelledby="line-title">
        <h2 id="line-title">The last second</h2>
        <TimeLinePane feed={feed} isPaused={isPaused} />
      </section>
      <section class="card" aria-labelledby="packets-title">
        <ListHead feed={feed} shown={packets.length} isPaused={isPaused} />
        <PacketList packets={packets} isPaused={isPaused} chosen={chosen?.number} choose={setChosen} />
        {chosen && <PacketDetail packet={chosen} close={() => setChosen(undefined)} />}
        {place.kind === "segment" && <SendForm segment={place.name} isDisabled={!may("operator")} />}
      </section>
      <Figures feed={feed} />
    </div>
  );
}

/** Show the packets before the time of the past that the page shows, as if the list were paused then. */
function usePast(feed: WireFeed): void {
  const at_s = pastAt.value;
  useEffect(() => {
    if (at_s === null) return;
    let isThere = true;
    askPast("past_packets", { wire: feed.place.name, at_s, lane: LANE })
      .then((told) => {
        const packets = told?.items.map((item, at) => readPacket(item, at + 1)).filter((packet) => packet !== undefined);
        if (packets && isThere) feed.paused.value = packets;
      })
      .catch(notifyError);
    return () => void (isThere = false);
  }, [feed, at_s]);
  const isPast = at_s !== null;
  useEffect(() => (isPast ? () => feed.setPaused(false) : undefined), [feed, isPast]);
}

function Line({ name }: { name: string }) {
  const line = hello.value?.lines.get(name);
  if (!line) return null;
  const parts = [line.framing, line.baud ? `${line.baud} baud` : "", line.format];
  return <span class="soft">{parts.filter(Boolean).join(", ")}</span>;
}

function ListHead({ feed, shown, isPaused }: { feed: WireFeed; shown: number; isPaused: boolean }) {
  void redraw.value; // the log is no signal, and equal props draw nothing anew
  const fresh = isPaused ? feed.log.count - (feed.paused.value!.at(-1)?.number ?? 0) : 0;
  return (
    <div class="card-head">
      <h2 id="packets-title">Packets</h2>
      <input
        type="search"
        class="filter"
        placeholder="filter, as m3000 from:1 -error"
        aria-label="Filter the packets"
        title={FILTER_HELP}
        value={feed.filter.value}
        onInput={(event) => (feed.filter.value = event.currentTarget.value)}
      />
      <button type="button" aria-pressed={isPaused} onClick={() => feed.setPaused(!isPaused)}>
        {isPaused ? "Go on" : "Pause"}
      </button>
      <button type="button" onClick={() => feed.clear()}>
        Clear
      </button>
      <button type="button" title="What has passed, for Wireshark" onClick={() => void exportPackets(feed)}>
        Export pcapng
      </button>
      <span class="soft push" role="status">
        {shown} shown of {feed.log.count}
        {isPaused && fresh > 0 ? `, ${fresh} since the pause` : ""}
        {feed.lost.value > 0 ? `, ${feed.lost.value} lost` : ""}
      </span>
    </div>
  );
}

async function exportPackets(feed: WireFeed): Promise<void> {
  try {
    const answer = await link.request<{ pcapng_base64: string; events: number }>({ do: "export", watch: feed.watch });
    const bytes = Uint8Array.from(atob(answer.pcapng_base64), (character) => character.charCodeAt(0));
    saveFile(`${feed.place.name.replace(/[^\w.-]/g, "_")}.pcapng`, bytes, "application/octet-stream");
    notify(`${answer.events} events of ${feed.place.name}`);
  } catch (error) {
    notifyError(error);
  }
}

/** Part of the last second, and of the last ten, in which the wire was busy. */
function LoadMeter({ feed }: { feed: WireFeed }) {
  void redraw.value;
  const now_s = feed.now_s();
  const recent = feed.log.since(now_s - 10);
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

function Figures({ feed }: { feed: WireFeed }) {
  void redraw.value;
  const found = statistics(feed.paused.value ?? feed.log.all());
  const perSecond = (count: number) => (found.span_s > 0 ? (count / found.span_s).toFixed(1) : "–");
  const errors = [...found.errors];
  const bad = errors.reduce((sum, [, count]) => sum + count, 0);
  return (
    <section class="card" aria-labelledby="figures-title">
      <h2 id="figures-title">Statistics</h2>
      <dl class="figures">
        <div>
          <dt>packets</dt>
          <dd class="mono">{found.packets}</dd>
        </div>
        <div>
          <dt>bytes</dt>
          <dd class="mono">{found.bytes}</dd>
        </div>
        <div>
          <dt>errors</dt>
          <dd class={bad ? "mono problem" : "mono"}>{bad}</dd>
        </div>
        <div>
          <dt>over</dt>
          <dd class="mono">{found.span_s.toFixed(1)} s</dd>
        </div>
        <div>
          <dt>packets/s</dt>
          <dd class="mono">{perSecond(found.packets)}</dd>
        </div>
        <div>
          <dt>bytes/s</dt>
          <dd class="mono">{perSecond(found.bytes)}</dd>
        </div>
        <div>
          <dt>mean</dt>
          <dd class="mono">{(found.mean_duration_s * 1000).toFixed(2)} ms</dd>
        </div>
        <div>
          <dt>longest</dt>
          <dd class="mono">{(found.longest_s * 1000).toFixed(2)} ms</dd>
        </div>
      </dl>
      <div class="wire-tables">
        <div class="scroll-x">
          <table>
            <caption class="out-of-sight">Who speaks to whom</caption>
            <thead>
              <tr>
                <th scope="col">From</th>
                <th scope="col">To</th>
                <th scope="col" class="num">
                  Packets
                </th>
                <th scope="col" class="num">
                  Bytes
                </th>
                <th scope="col" class="num">
                  Errors
                </th>
              </tr>
            </thead>
            <tbody>
              {found.talks.slice(0, 30).map(({ from, to, packets, bytes, errors: wrong }) => (
                <tr key={`${from}\n${to}`}>
                  <td>{from || "?"}</td>
                  <td>{to || "–"}</td>
                  <td class="num">{packets}</td>
                  <td class="num">{bytes}</td>
                  <td class={wrong ? "num problem" : "num"}>{wrong}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
        {errors.length > 0 && (
          <div class="scroll-x">
            <table>
              <caption class="out-of-sight">What was wrong</caption>
              <thead>
                <tr>
                  <th scope="col">Error</th>
                  <th scope="col" class="num">
                    Count
                  </th>
                </tr>
              </thead>
              <tbody>
                {errors.map(([error, count]) => (
                  <tr key={error}>
                    <td class="problem">{error}</td>
                    <td class="num">{count}</td>
                  </tr>
                ))}
              </tbody>
            </table>
          </div>
        )}
      </div>
    </section>
  );
}

export const wireView: ViewEntry = {
  id: "wire",
  title: "Wire",
  View: WireView,
  isShown: (bench) => bench.segments.length > 0 || bench.buses.length > 0,
};
