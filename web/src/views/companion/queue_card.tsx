/** The queue with what is done to it: rows, board, files. */

import { useMemo } from "preact/hooks";
import { notify } from "../../parts/notices";
import type { BoardSession } from "./board_session";
import { readFile } from "./board_texts";
import { LoadButton, saveFile } from "../../parts/files";
import { QueueEditor } from "./queue_editor";
import { writeQueue } from "./queue_file";
import { Selection } from "./queue_keys";
import { cleared, unsent } from "./queue_model";
import { StreamTools } from "./stream_tools";

export function QueueCard({ session, isDisabled }: { session: BoardSession; isDisabled: boolean }) {
  const selection = useMemo(() => new Selection(session), [session]);
  return (
    <section class="card companion-queue" aria-labelledby="queue-title">
      <div class="card-head">
        <h2 id="queue-title">Queue</h2>
        <QueueState session={session} />
      </div>
      <RowTools session={session} selection={selection} isDisabled={isDisabled} />
      <QueueEditor session={session} selection={selection} isDisabled={isDisabled} />
      <BoardTools session={session} isDisabled={isDisabled} />
      <StreamTools session={session} isDisabled={isDisabled} />
      <p class="soft legend">▶ runs · ▷ next place · ● not sent yet · + pulse · * linear · s sync · ↱ ↲ loop</p>
    </section>
  );
}

function QueueState({ session }: { session: BoardSession }) {
  const { board } = session.queue.value;
  const missing = unsent(session.queue.value).length;
  const { running } = session.motion.value;
  const wrong = Object.keys(session.kept.cells.value).length;
  const runs = typeof running === "number" ? `row ${running} runs` : running && running !== "unknown" ? `${running} runs` : "";
  const words = !board ? "not read yet" : session.sync.isSending.value ? `sending, ${missing} left` : missing ? `${missing} not sent` : "as in the board";
  return (
    <span class="row" role="status">
      <span class={missing && board ? "pill is-running" : "pill"}>{words}</span>
      {wrong > 0 && <span class="pill is-bad">{wrong === 1 ? "1 cell not taken" : `${wrong} cells not taken`}</span>}
      {runs && <span class="pill is-ok">{runs}</span>}
    </span>
  );
}

function RowTools({ session, selection, isDisabled }: { session: BoardSession; selection: Selection; isDisabled: boolean }) {
  const tool = (text: string, about: string, does: () => void, off = false) => (
    <button type="button" title={about} aria-label={about} disabled={isDisabled || off} onClick={does}>
      {text}
    </button>
  );
  const of = selection.text;
  const { undo, redo } = session.queue.value;
  return (
    <div class="row tools" role="toolbar" aria-label="Rows of the queue">
      {tool("Add", `Add a row below ${of}`, () => selection.add())}
      {tool("Insert", `Insert a row above ${of}`, () => selection.insert())}
      {tool("Delete", `Delete ${of}`, () => selection.remove())}
      {tool("↑", `Move ${of} up`, () => selection.move(-1))}
      {tool("↓", `Move ${of} down`, () => selection.move(1))}
      {tool("Cut", `Cut ${of}`, () => selection.cut())}
      {tool("Copy", `Copy ${of}`, () => void selection.copy())}
      {tool("Paste", `Paste over ${of}`, () => void selection.pasteByButton(false))}
      {tool("Paste above", `Paste above ${of} what was copied`, () => void selection.pasteByButton(true))}
      {tool("Undo", "Undo the last change", () => selection.undo(), !undo.length)}
      {tool("Redo", "Redo the change", () => selection.redo(), !redo.length)}
      {tool("Clear", "Clear all rows", () => session.sync.edit(cleared(session.queue.peek())))}
      <span class="soft" aria-live="polite">
        {of}
      </span>
    </div>
  );
}

function BoardTools({ session, isDisabled }: { session: BoardSession; isDisabled: boolean }) {
  const missing = unsent(session.queue.value).length;
  const hasBoard = session.queue.value.board !== undefined;
  const isSending = session.sync.isSending.value;
  const load = async (name: string, bytes: Uint8Array) => {
    const read = await readFile(session.port, "queue", bytes, name);
    if (!read) return;
    session.sync.take(read.rows);
    notify(`${name}: 30 rows`);
  };
  return (
    <div class="row tools" role="toolbar" aria-label="Queue and board">
      <label class="row check">
        <input type="checkbox" checked={session.sync.isOffline.value} onChange={(event) => session.sync.setOffline(event.currentTarget.checked)} />
        Offline
      </label>
      <button
        type="button"
        class="primary"
        disabled={isDisabled || !hasBoard || isSending || !missing}
        title="Send the rows that the board does not have yet, and read them back"
        onClick={() => void session.sync.sendRows()}
      >
        Update queue
      </button>
      <button
        type="button"
        disabled={isDisabled || isSending}
        title="Read the board's queue; what was not sent is lost"
        onClick={() => void session.sync.revert()}
      >
        Read
      </button>
      <button type="button" disabled={isDisabled || isSending} title="Keep the board's queue in its EEPROM (qs)" onClick={() => void session.keep()}>
        Store
      </button>
      <button type="button" disabled={isDisabled || isSending} title="Take the board's queue back from its EEPROM (qr)" onClick={() => void session.type("qr")}>
        Restore
      </button>
      <span class="push" />
      <LoadButton label="Load queue file" isDisabled={isDisabled} take={load} />
      <button type="button" onClick={() => saveFile("queue.txt", writeQueue(session.queue.peek().rows))}>
        Save queue file
      </button>
    </div>
  );
}
