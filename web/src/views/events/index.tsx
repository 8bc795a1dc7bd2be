/** Events: the list of what happened, in a view of its own, above the time line. */

import { whenLoaded } from "../../parts/when_loaded";
import type { ViewEntry } from "../view";

const EventList = whenLoaded(async () => (await import("../../events/event_list")).EventList);

function EventsView() {
  return (
    <>
      <h2 class="out-of-sight">Events</h2>
      <EventList />
    </>
  );
}

export const eventsView: ViewEntry = { id: "events", title: "Events", View: EventsView };
