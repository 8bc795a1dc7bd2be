/** Packets of a wire: its lanes, and below them the list. */

import { useEffect, useMemo, useState } from "preact/hooks";
import { href } from "../../router";
import { hello } from "../../store";
import { usePast } from "../../views/wire";
import { PacketDetail } from "../../views/wire/packet_detail";
import { PacketList } from "../../views/wire/packet_list";
import type { WirePacket } from "../../views/wire/packet_log";
import { TimeLinePane } from "../../views/wire/time_line_pane";
import { wireFeed } from "../../views/wire/wire_feed";
import type { BodyProps } from "../kinds";

const REDRAW_MS = 250;

export function WireBody({ row, isWatch }: BodyProps) {
  const kind = hello.value?.buses.includes(row.of) ? ("bus" as const) : ("segment" as const);
  const feed = useMemo(() => wireFeed({ name: row.of, kind }), [row.of, kind]);
  const [turn, setTurn] = useState(0);
  const [chosen, setChosen] = useState<WirePacket | undefined>(undefined);
  useEffect(() => feed.attach(), [feed]);
  useEffect(() => {
    let seen = -1;
    const timer = window.setInterval(() => {
      if (seen === feed.news.peek()) return;
      seen = feed.news.peek();
      setTurn(seen);
    }, REDRAW_MS);
    return () => window.clearInterval(timer);
  }, [feed]);
  usePast(feed);
  const isPaused = feed.paused.value !== undefined;
  const rows = feed.rows();
  return (
    <div class="wire-panel">
      {feed.refused.value && <p class="problem">{feed.refused.value}</p>}
      <TimeLinePane feed={feed} isPaused={isPaused} chosen={chosen?.number} choose={setChosen} />
      {!isWatch && (
        <div class="row">
          <input
            type="search"
            placeholder="filter, as m3000 from:1 -error"
            aria-label={`Filter the packets of ${row.of}`}
            value={feed.filter.value}
            onInput={(event) => (feed.filter.value = event.currentTarget.value)}
          />
          <button type="button" aria-pressed={isPaused} onClick={() => feed.setPaused(!isPaused)}>
            {isPaused ? "Go on" : "Pause"}
          </button>
          <a href={href("wire", row.of)}>All of {row.of}</a>
          <span class="soft push">
            {rows.length} shown of {feed.log.count}
          </span>
        </div>
      )}
      <PacketList
        kind={feed.kind}
        rows={rows}
        turn={turn}
        isPaused={isPaused}
        chosen={chosen?.number}
        apart="shown"
        marked={feed.marked.value}
        choose={setChosen}
      />
      {chosen && <PacketDetail feed={feed} packet={chosen} close={() => setChosen(undefined)} />}
    </div>
  );
}
