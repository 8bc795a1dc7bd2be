/** List of what happened, the newest first: who asked for what, faults, runs, refusals, clients, reloads, lateness, the log's warnings. */

import { useState } from "preact/hooks";
import { happened, instance } from "../happened";
import { keptText, keptTexts } from "../kept";
import { countsOf, EVENT_KINDS, type EventKind, type EventRow, filtered } from "../model/bench_events";
import { timeText } from "../model/past";
import { end_s, HAS_PAST, lookAt } from "../past";
import { go, path } from "../router";
import { devices } from "../store";
import "./events.css";

/** Rows that are shown before somebody asks for more. */
const SHOWN = 200;
const BAD: readonly EventKind[] = ["faults", "refusals", "trouble"];

const filter = keptText("events.filter");
/** Kinds that are hidden, by name. */
const hidden = keptTexts("events.hidden");

/** The list, for a view or a panel. */
export function EventList() {
  const [most, setMost] = useState(SHOWN);
  const { rows, leftOut } = happened.value;
  const hiddenKinds = EVENT_KINDS.filter((kind) => hidden.value[kind]);
  const shown = filtered(rows, hiddenKinds, filter.value);
  return (
    <div class="events">
      <div class="row events-bar">
        <input
          type="search"
          placeholder="m1 refused"
          aria-label="Filter the events by their words"
          value={filter.value}
          onInput={(event) => (filter.value = event.currentTarget.value)}
        />
        <Kinds />
      </div>
      <p class="soft events-count" role="status">
        {shown.length} of {rows.length} events{leftOut > 0 && `; ${leftOut} older ones are left out`}
      </p>
      <ol class="event-rows" aria-label="Events, the newest first">
        {shown.slice(0, most).map((row) => (
          <Row key={row.key} row={row} />
        ))}
      </ol>
      {shown.length > most && (
        <button type="button" onClick={() => setMost(most + SHOWN)}>
          Show more: {shown.length - most} are older
        </button>
      )}
    </div>
  );
}

function Kinds() {
  const counts = countsOf(happened.value.rows);
  return (
    <div class="row" role="group" aria-label="Kinds of events">
      {EVENT_KINDS.filter((kind) => counts[kind] > 0 || hidden.value[kind]).map((kind) => (
        <button
          key={kind}
          type="button"
          class="event-kind-button"
          aria-pressed={!hidden.value[kind]}
          onClick={() => (hidden.value = { ...hidden.value, [kind]: hidden.value[kind] ? "" : "hidden" })}
        >
          {kind} {counts[kind]}
        </button>
      ))}
    </div>
  );
}

function Row({ row }: { row: EventRow }) {
  const { kind, at_s, to_s, of, who, text, count } = row;
  const isNow = row.instance === instance();
  const time = timeText(at_s);
  return (
    <li class={BAD.includes(kind) ? "is-bad" : ""}>
      {isNow && end_s.value > 0 ? (
        <button type="button" class="plain mono event-time" title="Look at this time" onClick={() => visit(row)}>
          {time}
        </button>
      ) : (
        <span class="mono soft event-time" title={isNow ? "" : "of an earlier start of the bench"}>
          {time}
        </span>
      )}
      <span class="event-kind">{kind}</span>
      <span class="event-of mono">{of}</span>
      <span class="event-text">
        {text}
        {count > 1 && (
          <span class="soft">
            {" "}
            ×{count} in {(to_s - at_s).toFixed(1)} s
          </span>
        )}
      </span>
      <span class="event-who soft">{who === of || who === "bench" ? "" : who}</span>
    </li>
  );
}

/** Show the time of an event: in the view that is open, or at the plots of its device. */
function visit({ at_s, of }: EventRow): void {
  const view = path.peek()[0] ?? "bench";
  if (view === "events" || !HAS_PAST.includes(view)) {
    const owner = of.split(", ")[0] ?? "";
    go("bench", ...(devices.peek().has(owner) ? [owner] : []));
  }
  window.setTimeout(() => lookAt(at_s)); // the address changes first
}
