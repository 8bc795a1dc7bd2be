/** What was typed and what came: the command line, both histories, the times of commands. */

import { useEffect, useLayoutEffect, useRef, useState } from "preact/hooks";
import type { BoardSession } from "./board_session";
import { boardForms } from "./kept_board";
import { lineFault } from "./oneshot_file";
import { recalled } from "./text_log";

interface Props {
  session: BoardSession;
  isDisabled: boolean;
}

export function TrafficCard({ session, isDisabled }: Props) {
  return (
    <section class="card traffic" aria-labelledby="traffic-title">
      <h2 id="traffic-title" class="out-of-sight">
        Traffic
      </h2>
      <CommandLine session={session} isDisabled={isDisabled} />
      <Incoming session={session} />
      <Outgoing session={session} isDisabled={isDisabled} />
    </section>
  );
}

function CommandLine({ session, isDisabled }: Props) {
  const [text, setText] = boardForms.field(session.port, "command");
  const [back, setBack] = useState(-1);
  const fault = lineFault(text);
  const send = () => {
    if (fault || isDisabled) return;
    void session.type(text);
    setText("");
    setBack(-1);
  };
  const recall = (by: number) => {
    const lines = recalled(session.sent.peek());
    const place = Math.min(Math.max(back + by, -1), lines.length - 1);
    setBack(place);
    setText(place < 0 ? "" : lines[place]!);
  };
  return (
    <form class="row command-line" onSubmit={(event) => (event.preventDefault(), send())}>
      <label class="grow">
        Command
        <input
          class="mono"
          value={text}
          disabled={isDisabled}
          aria-invalid={fault ? "true" : undefined}
          title={fault ?? "Arrow up: what was typed before"}
          autocomplete="off"
          spellcheck={false}
          enterKeyHint="send"
          onInput={(event) => setText(event.currentTarget.value)}
          onKeyDown={(event) => {
            const by = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
            if (by) {
              event.preventDefault();
              recall(by);
            }
          }}
        />
      </label>
      <button type="submit" class="primary" disabled={isDisabled || fault !== undefined}>
        Send
      </button>
    </form>
  );
}

function Incoming({ session }: { session: BoardSession }) {
  const box = useRef<HTMLPreElement>(null);
  const isAtEnd = useRef(true);
  const [isLarge, setLarge] = useState(false);
  const text = session.incoming.value;
  useEffect(() => {
    if (box.current && isAtEnd.current) box.current.scrollTop = box.current.scrollHeight;
  }, [text]);
  return (
    <div>
      <div class="row">
        <h3>Incoming</h3>
        <button type="button" class="plain push" onClick={() => setLarge(true)}>
          Enlarge
        </button>
        <button type="button" class="plain" onClick={() => (session.incoming.value = "")}>
          Clear
        </button>
      </div>
      <pre
        ref={box}
        class="history incoming"
        tabIndex={0}
        role="log"
        aria-label="Incoming"
        title="A click enlarges it"
        onClick={() => window.getSelection()?.isCollapsed !== false && setLarge(true)}
        onScroll={(event) => {
          const { scrollTop, scrollHeight, clientHeight } = event.currentTarget;
          isAtEnd.current = scrollHeight - clientHeight - scrollTop < 20;
        }}
      >
        {text}
      </pre>
      {isLarge && <LargeIncoming session={session} close={() => setLarge(false)} />}
    </div>
  );
}

/** What came, in a window for long listings. A double click in it closes it, as in the original. */
function LargeIncoming({ session, close }: { session: BoardSession; close(): void }) {
  const dialog = useRef<HTMLDialogElement>(null);
  const box = useRef<HTMLPreElement>(null);
  useLayoutEffect(() => {
    dialog.current!.showModal();
    box.current!.scrollTop = box.current!.scrollHeight;
  }, []);
  return (
    <dialog ref={dialog} class="large-incoming" aria-labelledby="large-incoming-title" onClose={close}>
      <div class="dialog-head">
        <h2 id="large-incoming-title">Incoming of {session.port}</h2>
        <button type="button" onClick={() => dialog.current!.close()}>
          Close
        </button>
      </div>
      <pre
        ref={box}
        class="history"
        tabIndex={0}
        role="region"
        aria-label="All that came"
        title="A double click closes it"
        onDblClick={() => dialog.current!.close()}
      >
        {session.incoming.value}
      </pre>
    </dialog>
  );
}

function Outgoing({ session, isDisabled }: Props) {
  const sent = [...session.sent.value].reverse();
  return (
    <div>
      <div class="row">
        <h3>Commands</h3>
        <button type="button" class="plain push" onClick={() => (session.sent.value = [])}>
          Clear
        </button>
      </div>
      <ul class="history sent" aria-label="Commands that were sent, the last first" tabIndex={0}>
        {sent.map(({ number, at_ms, line }) => (
          <li key={number}>
            <span class="soft mono">{new Date(at_ms).toLocaleTimeString()}</span>{" "}
            <button type="button" class="plain mono" disabled={isDisabled} title="Send it again" onClick={() => void session.type(line)}>
              {line || "(empty)"}
            </button>
          </li>
        ))}
      </ul>
    </div>
  );
}

export function TimesCard({ session }: { session: BoardSession }) {
  const times = [...session.times.value].reverse();
  return (
    <section class="card" aria-labelledby="times-title">
      <div class="card-head">
        <h2 id="times-title">Command times</h2>
        <button type="button" class="plain push" onClick={() => (session.times.value = [])}>
          Clear
        </button>
      </div>
      {!times.length && (
        <p class="soft">
          {session.isOpsOn ? "No command has begun yet." : "The board tells no times: switch Ops on. A command is then timed from DC1 to DC2."}
        </p>
      )}
      {times.length > 0 && (
        <div class="history times" tabIndex={0} role="region" aria-label="Times of commands, the last first">
          <table>
            <thead>
              <tr>
                <th scope="col">No</th>
                <th scope="col">What</th>
                <th scope="col">Begun</th>
                <th scope="col">Took</th>
              </tr>
            </thead>
            <tbody>
              {times.map(({ number, what, begun_ms, duration_ms }) => (
                <tr key={number}>
                  <td class="num">{number}</td>
                  <td>{what || "–"}</td>
                  <td class="num">{session.age_s(begun_ms).toFixed(3)} s</td>
                  <td class="num">{duration_ms === undefined ? "runs" : `${(duration_ms / 1000).toFixed(3)} s`}</td>
                </tr>
              ))}
            </tbody>
          </table>
        </div>
      )}
    </section>
  );
}
