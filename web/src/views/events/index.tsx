/** Events: the list of what happened, in a view of its own, above the time line. */

import { EventList } from "../../events/event_list";
import type { ViewEntry } from "../view";

function EventsView() {
  return (
    <>
      <h2 class="out-of-sight">Events</h2>
      <EventList />
    </>
  );
}

export const eventsView: ViewEntry = { id: "events", title: "Events", View: EventsView };
