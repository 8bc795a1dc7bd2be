/** Head of the list of packets: its filter, and what is done with the list. */

import { useId } from "preact/hooks";
import { saveFile } from "../../parts/files";
import { notify, notifyError } from "../../parts/notices";
import { link } from "../../store";
import { keptText } from "../../kept";
import { completions, filterHelp } from "./packet_filter";
import type { Apart } from "./packet_list";
import type { WireFeed } from "./wire_feed";

/** Packets at the end of the log from which the filter's words are completed. */
const SEEN = 400;
const APARTS: [Apart, string][] = [
  ["shown", "the row before"],
  ["talk", "the one before of its conversation"],
  ["mark", "the marked one"],
];
const keptApart = keptText("wire.apart", "shown");

export function apartOf(): Apart {
  return APARTS.find(([each]) => each === keptApart.value)?.[0] ?? "shown";
}

interface Props {
  feed: WireFeed;
  /** Another one where the log has changed. */
  turn: number;
  shown: number;
  isPaused: boolean;
}

export function ListHead({ feed, shown, isPaused }: Props) {
  const list = useId();
  const { log } = feed.source;
  const seen = Array.from({ length: Math.min(SEEN, log.length) }, (_, back) => log.at(log.length - 1 - back)!);
  const fresh = isPaused ? feed.log.count - (log.at(log.length - 1)?.number ?? 0) : 0;
  return (
    <div class="card-head">
      <h2 id="packets-title">Packets</h2>
      <input
        type="search"
        class="filter"
        list={list}
        placeholder="filter, as m3000 -error"
        aria-label="Filter the packets"
        title={filterHelp(feed.kind)}
        autocomplete="off"
        spellcheck={false}
        value={feed.filter.value}
        onInput={(event) => (feed.filter.value = event.currentTarget.value)}
      />
      <datalist id={list}>
        {completions(feed.filter.value, feed.kind, seen).map((each) => (
          <option key={each} value={each} />
        ))}
      </datalist>
      <label class="apart">
        <span class="soft">Apart from</span>{" "}
        <select value={apartOf()} onChange={(event) => (keptApart.value = event.currentTarget.value)}>
          {APARTS.map(([value, text]) => (
            <option key={value} value={value}>
              {text}
            </option>
          ))}
        </select>
      </label>
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
