/** What happened on the bench, the newest first; a click shows the bench at that time. */

import { useEffect } from "preact/hooks";
import { timeText } from "../../model/past";
import { end_s, followOverview, lookAt, marks, trouble } from "../../past";

const MOST = 300;

export function EventsBody() {
  useEffect(() => followOverview(), []);
  const told = [...marks.value].sort((one, other) => other.from_s - one.from_s).slice(0, MOST);
  if (!told.length) return <p class="empty">{trouble.value || (end_s.value ? "Nothing has happened yet." : "The recording is read …")}</p>;
  return (
    <ol class="event-list">
      {told.map((mark, at) => (
        <li key={`${mark.from_s} ${mark.lane} ${at}`}>
          <button type="button" class="plain mono" title="Show the bench at this time" onClick={() => lookAt(mark.from_s)}>
            {timeText(mark.from_s)}
          </button>
          <span class="soft">{mark.lane}</span>
          <span class="event-text">
            {mark.of && !mark.text.includes(mark.of) && <strong>{mark.of} </strong>}
            {mark.text}
          </span>
        </li>
      ))}
    </ol>
  );
}
