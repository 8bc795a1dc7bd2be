/** The hundred one-shots: commands to be sent by a click. */

import { notify } from "../../parts/notices";
import type { BoardSession } from "./board_session";
import { readFile } from "./board_texts";
import { LoadButton, saveFile } from "../../parts/files";
import { lineFault, writeOneShots } from "./oneshot_file";

export function OneShotCard({ session, isDisabled }: { session: BoardSession; isDisabled: boolean }) {
  const { oneShots } = session.kept;
  const shots = oneShots.value.lines;
  const put = (index: number, line: string) => {
    oneShots.value = { lines: shots.map((old, at) => (at === index ? line : old)), isSaved: false };
  };
  const save = () => {
    saveFile("oneShot.txt", writeOneShots(oneShots.peek().lines));
    oneShots.value = { ...oneShots.peek(), isSaved: true };
  };
  const load = async (name: string, bytes: Uint8Array) => {
    const read = await readFile(session.port, "one_shots", bytes, name);
    if (!read) return;
    oneShots.value = { lines: read.lines, isSaved: true };
    notify(`${name}: ${read.lines.filter((line) => line.trim()).length} commands`);
  };
  return (
    <section class="card" aria-labelledby="oneshot-title">
      <div class="card-head">
        <h2 id="oneshot-title">One-shots</h2>
        <span class="push" />
        <LoadButton label="Load one-shots" take={load} />
        <button type="button" onClick={save}>
          Save one-shots
        </button>
      </div>
      <ol class="oneshots" aria-label="One-shot commands" tabIndex={0}>
        {shots.map((line, index) => (
          <li key={index}>
            <span class="num soft" aria-hidden="true">
              {index + 1}
            </span>
            <input
              value={line}
              class="mono"
              aria-label={`One-shot ${index + 1}`}
              autocomplete="off"
              spellcheck={false}
              aria-invalid={lineFault(line) ? "true" : undefined}
              title={lineFault(line) ?? ""}
              onInput={(event) => put(index, event.currentTarget.value)}
              onKeyDown={(event) => event.key === "Enter" && !isDisabled && fire(session, event.currentTarget.value)}
            />
            <button
              type="button"
              disabled={isDisabled || !line.trim() || lineFault(line) !== undefined}
              aria-label={`Send one-shot ${index + 1}`}
              onClick={() => fire(session, line)}
            >
              Send
            </button>
          </li>
        ))}
      </ol>
    </section>
  );
}

function fire(session: BoardSession, line: string): void {
  const text = line.trim();
  if (text && lineFault(text) === undefined) void session.type(text);
}
