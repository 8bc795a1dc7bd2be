/** What happened on the bench, the newest first; a click shows the bench at that time. */

import { useEffect } from "preact/hooks";
import { EventList } from "../../events/event_list";
import { followOverview } from "../../past";

export function EventsBody() {
  useEffect(() => followOverview(), []);
  return <EventList />;
}
