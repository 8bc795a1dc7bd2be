/** The queue as a table of 30 rows that is edited in place. */

import { useEffect, useRef, useState } from "preact/hooks";
import { memo } from "../../parts/memo";
import type { BoardSession } from "./board_session";
import type { KeptBoard } from "./kept_board";
import { CELLS, cellText, setRow, unsent, withCell, type Cell } from "./queue_model";
import { sameRow, seedRow, type QueueRow } from "./queue_row";
import { isEditKey, type Selection } from "./queue_keys";

interface Props {
  session: BoardSession;
  selection: Selection;
  isDisabled: boolean;
}

export function QueueEditor({ session, selection, isDisabled }: Props) {
  const { rows, board, steps_per_rev } = session.queue.value;
  const { running, next, loop } = session.motion.value;
  const missing = new Set(board ? unsent(session.queue.value) : []);
  const seed = seedRow(steps_per_rev);
  const { from, to } = selection.range.value;
  const table = useRef<HTMLTableElement>(null);
  useClipboard(table, selection);
  const focus = (position: number, column: string) => {
    const cell = table.current?.querySelector<HTMLElement>(`[data-at="${position}.${column}"]`);
    cell?.focus();
    if (cell instanceof HTMLInputElement) cell.select();
  };
  return (
    <div class="scroll-x queue-scroll">
      <table class="queue" ref={table} onKeyDown={(event) => onKey(event, selection, focus)}>
        <caption class="out-of-sight">
          Queue of {session.port}: 30 rows. Arrows up and down change the row; Alt with them moves it. Insert adds a row above, Delete on a row's number deletes
          it.
        </caption>
        <thead>
          <tr>
            <th scope="col">Q</th>
            <th scope="col">Steps</th>
            <th scope="col" class="mid">
              Dir
            </th>
            <th scope="col" class="mid">
              Unit
            </th>
            <th scope="col">RPM</th>
            <th scope="col" title="period of a step in us">
              Cycle
            </th>
            <th scope="col" class="mid">
              Ramp
            </th>
            <th scope="col">Acc</th>
            <th scope="col">Dec</th>
            <th scope="col" title="pulses added to the cruise">
              usteps
            </th>
            <th scope="col" class="mid">
              Sync
            </th>
            <th scope="col" title="wait before the start in us">
              deltaT
            </th>
          </tr>
        </thead>
        <tbody>
          {rows.map((row, index) => (
            <RowLine
              key={index}
              position={index + 1}
              row={row}
              stepsPerRev={steps_per_rev}
              isRunning={running === index + 1}
              isNext={running === undefined && next === index + 1}
              isLoopStart={loop.isOn && loop.start === index + 1}
              isLoopFinish={loop.isOn && loop.finish === index + 1}
              isSelected={index + 1 >= from && index + 1 <= to}
              isUnsent={missing.has(index + 1)}
              isSeed={sameRow(row, seed)}
              isDisabled={isDisabled}
              session={session}
              selection={selection}
            />
          ))}
        </tbody>
      </table>
    </div>
  );
}

interface RowProps {
  position: number;
  row: QueueRow;
  stepsPerRev: number;
  isRunning: boolean;
  isNext: boolean;
  isLoopStart: boolean;
  isLoopFinish: boolean;
  isSelected: boolean;
  isUnsent: boolean;
  isSeed: boolean;
  isDisabled: boolean;
  session: BoardSession;
  selection: Selection;
}

const RowLine = memo(function RowLine(props: RowProps) {
  const { position, row, session, selection, isRunning, isNext } = props;
  const said = [
    isRunning ? "runs now" : "",
    isNext ? "the next command goes here" : "",
    props.isUnsent ? "not sent yet" : "",
    props.isLoopStart ? "loop start" : "",
    props.isLoopFinish ? "loop finish" : "",
  ]
    .filter(Boolean)
    .join(", ");
  const put = (changed: QueueRow) => session.sync.edit(setRow(session.queue.peek(), position, changed));
  const numbers = new Map(
    CELLS.map((cell) => [
      cell.name,
      <NumberCell
        key={cell.name}
        cell={cell}
        position={position}
        row={row}
        stepsPerRev={props.stepsPerRev}
        put={put}
        isDisabled={props.isDisabled}
        kept={session.kept}
      />,
    ]),
  );
  const faults = CELLS.flatMap((cell) => {
    const text = leftText(session.kept, position, row, cell);
    const fault = text === undefined ? "" : withCell(row, cell.name, text, props.stepsPerRev);
    return typeof fault === "string" && fault ? [{ cell, fault }] : [];
  });
  const toggle = (name: string, label: string, text: string, about: string, change: Partial<QueueRow>) => (
    <td>
      <button
        type="button"
        class="cell-toggle"
        data-at={`${position}.${name}`}
        disabled={props.isDisabled}
        aria-label={`Row ${position} ${label}: ${text}, ${about}`}
        title={about}
        onClick={() => put({ ...row, ...change })}
      >
        {text}
      </button>
    </td>
  );
  const classes = [
    isRunning && "is-running",
    isNext && "is-next",
    props.isSelected && "is-selected",
    props.isUnsent && "is-unsent",
    props.isSeed && "is-seed",
    props.isLoopStart && "is-loop-start",
    props.isLoopFinish && "is-loop-finish",
  ];
  const line = (
    <tr class={classes.filter(Boolean).join(" ")} aria-current={isRunning ? "step" : undefined}>
      <th scope="row">
        <button
          type="button"
          class="row-head"
          data-at={`${position}.head`}
          aria-pressed={props.isSelected}
          aria-label={`Row ${position}${said ? `, ${said}` : ""}`}
          title={said || "select the row"}
          onClick={(event) => selection.select(position, event.shiftKey)}
        >
          <span class="mark" aria-hidden="true">
            {isRunning ? "▶" : isNext ? "▷" : props.isUnsent ? "●" : ""}
          </span>
          {position}
          <span class="loop-mark" aria-hidden="true">
            {props.isLoopStart ? "↱" : props.isLoopFinish ? "↲" : ""}
          </span>
        </button>
      </th>
      {numbers.get("steps")}
      {toggle("dir", "direction", row.is_ccw ? "CCW" : "CW", row.is_ccw ? "counter-clockwise" : "clockwise", { is_ccw: !row.is_ccw })}
      {toggle("unit", "unit", row.is_full ? "step" : "+ pulse", row.is_full ? "full steps" : "pulses", { is_full: !row.is_full })}
      {numbers.get("rpm")}
      {numbers.get("cycle_us")}
      {toggle("ramp", "ramp", row.is_linear ? "* linear" : "harm.", row.is_linear ? "linear ramp" : "harmonic curve", { is_linear: !row.is_linear })}
      {numbers.get("acc")}
      {numbers.get("dec")}
      {numbers.get("extra_pulses")}
      {toggle("sync", "sync", row.is_sync ? "s sync" : "–", row.is_sync ? "waits for the sync" : "does not wait for the sync", { is_sync: !row.is_sync })}
      {numbers.get("wait_us")}
    </tr>
  );
  return (
    <>
      {line}
      {faults.length > 0 && (
        <tr class="cell-faults">
          <td colSpan={12}>
            {faults.map(({ cell, fault }) => (
              <p key={cell.name} id={faultId(position, cell)} class="problem" role="alert">
                Row {position}: {fault}. It is not taken; Escape in the cell takes it back.
              </p>
            ))}
          </td>
        </tr>
      )}
    </>
  );
});

function faultId(position: number, cell: Cell): string {
  return `queue-fault-${position}-${cell.name}`;
}

/** Text that was left in a cell and could not be taken; undefined: there is none for what the row has now. */
function leftText(kept: KeptBoard, position: number, row: QueueRow, cell: Cell): string | undefined {
  const left = kept.cells.value[`${position}.${cell.name}`];
  return left?.was === cellText(row, cell.name) ? left.text : undefined;
}

interface NumberProps {
  cell: Cell;
  position: number;
  row: QueueRow;
  stepsPerRev: number;
  put: (row: QueueRow) => void;
  isDisabled: boolean;
  kept: KeptBoard;
}

/** Number that is typed: it is taken when the cell is left or Enter pressed; Escape takes it back. What cannot be taken
 * stays in the cell, and the reason stands below its row. */
function NumberCell({ cell, position, row, stepsPerRev, put, isDisabled, kept }: NumberProps) {
  const shown = cellText(row, cell.name);
  const at = `${position}.${cell.name}`;
  const left = leftText(kept, position, row, cell);
  const [typed, setTyped] = useState<string | undefined>(undefined);
  const text = typed ?? left;
  const changed = text === undefined ? row : withCell(row, cell.name, text, stepsPerRev);
  const fault = typeof changed === "string" ? changed : "";
  const done = () => {
    if (typed === undefined) return;
    kept.putCell(at, typeof changed === "string" ? { text: typed, was: shown } : null);
    if (typeof changed !== "string") put(changed);
    setTyped(undefined);
  };
  const takeBack = () => {
    kept.putCell(at, null);
    setTyped(undefined);
  };
  return (
    <td class="num">
      <input
        class={`cell-${cell.name}`}
        data-at={at}
        value={text ?? shown}
        disabled={isDisabled}
        inputMode="decimal"
        autocomplete="off"
        spellcheck={false}
        aria-label={`Row ${position} ${cell.label}${cell.unit ? ` in ${cell.unit}` : ""}`}
        aria-invalid={fault ? "true" : undefined}
        aria-describedby={left !== undefined && fault ? faultId(position, cell) : undefined}
        title={fault || cell.about}
        onInput={(event) => setTyped(event.currentTarget.value)}
        onBlur={done}
        onKeyDown={(event) => {
          if (event.key === "Enter") done();
          if (event.key === "Escape") takeBack();
        }}
      />
    </td>
  );
}

// ---- keys ----

function onKey(event: KeyboardEvent, selection: Selection, focus: (position: number, column: string) => void): void {
  const at = (event.target as HTMLElement).dataset["at"];
  if (!at) return;
  const [row, column] = at.split(".") as [string, string];
  const position = Number(row);
  if (isEditKey(event)) {
    if (!selection.contains(position)) selection.select(position, false);
    if (!selection.key(event, column === "head")) return;
    event.preventDefault();
    focus(selection.range.peek().from, column);
    return;
  }
  const step = event.key === "ArrowDown" || (event.key === "Enter" && column !== "head" && !isToggle(event)) ? 1 : event.key === "ArrowUp" ? -1 : 0;
  if (step === 0 || event.ctrlKey || event.metaKey) return;
  const target = Math.min(Math.max(position + step, 1), 30);
  if (column === "head" || event.shiftKey) selection.select(target, event.shiftKey);
  event.preventDefault();
  focus(target, column);
}

function isToggle(event: KeyboardEvent): boolean {
  return event.target instanceof HTMLButtonElement;
}

/** Copy, cut and paste rows by the browser's own commands, where no text of a cell is meant. */
function useClipboard(table: { current: HTMLTableElement | null }, selection: Selection): void {
  useEffect(() => {
    const isMeant = () => {
      const focused = document.activeElement;
      return focused instanceof HTMLButtonElement && table.current?.contains(focused) === true;
    };
    const copy = (event: ClipboardEvent) => {
      if (!isMeant() || !event.clipboardData) return;
      event.clipboardData.setData("text/plain", selection.copy());
      if (event.type === "cut") selection.remove();
      event.preventDefault();
    };
    const paste = (event: ClipboardEvent) => {
      const text = event.clipboardData?.getData("text/plain") ?? "";
      const cell = document.activeElement as HTMLElement | null;
      if (!text || !table.current?.contains(cell)) return;
      if (cell instanceof HTMLInputElement) {
        if (!/[\t,]/.test(text)) return; // a number, for this cell
        selection.select(Number(cell.dataset["at"]?.split(".")[0]), false);
      }
      void selection.paste(text);
      event.preventDefault();
    };
    document.addEventListener("copy", copy);
    document.addEventListener("cut", copy);
    document.addEventListener("paste", paste);
    return () => {
      document.removeEventListener("copy", copy);
      document.removeEventListener("cut", copy);
      document.removeEventListener("paste", paste);
    };
  }, [selection]);
}
