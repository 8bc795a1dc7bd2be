/** Long file: rows that are streamed into the queue as it has room. */

import type { BoardSession } from "./board_session";
import { readLongFile } from "./board_texts";
import { LoadButton } from "../../parts/files";

export function StreamTools({ session, isDisabled }: { session: BoardSession; isDisabled: boolean }) {
  const { streamer } = session;
  const state = streamer.state.value;
  const isBusy = state !== undefined && state.phase !== "rests";
  const stepsPerRev = session.configuration.value?.steps_per_rev;
  const load = async (name: string, bytes: Uint8Array) => {
    const read = await readLongFile(session.port, stepsPerRev!, bytes, name);
    if (read) streamer.take(name, read.moves);
  };
  return (
    <div class="row tools" role="toolbar" aria-label="Long file">
      <LoadButton label="Load long file" isDisabled={isDisabled || isBusy || stepsPerRev === undefined} take={load} />
      {state && (
        <>
          <button
            type="button"
            class="primary"
            disabled={isDisabled || state.phase === "pauses" || (!isBusy && state.ended === state.moves.length)}
            title={isBusy ? "End behind the row that runs (l)" : "Send the rows as the board's queue has room"}
            onClick={() => (isBusy ? streamer.pause() : void streamer.run())}
          >
            {isBusy ? "Pause" : state.ended ? "Go on" : "Run rows"}
          </button>
          <button type="button" disabled={isBusy} onClick={() => streamer.take("", [])}>
            Forget
          </button>
          <progress max={state.moves.length} value={state.ended} aria-label={`Rows of ${state.file}`} />
          <span class="soft">
            {state.file}: {state.ended.toLocaleString("en")} of {state.moves.length.toLocaleString("en")} rows
          </span>
        </>
      )}
    </div>
  );
}
