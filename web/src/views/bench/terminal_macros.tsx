/** Texts that are sent by a button, kept for each profile of a board. */

import { useState } from "preact/hooks";
import { KeptTogether, ownOf } from "../../kept";
import { bytesOfMacro, ENDING_NAMES, type Ending, type Macro, moved, NEW_MACRO, readMacros, titleOf } from "../../model/sent_lines";
import { endingOf } from "./terminal_line";
import type { TerminalPort } from "./terminal_port";

const kept = new KeptTogether<Readonly<Record<string, readonly Macro[]>>>(
  "terminal.macros",
  () => ({}),
  (raw) =>
    typeof raw === "object" && raw !== null ? Object.fromEntries(Object.entries(raw).map(([profile, macros]) => [profile, readMacros(macros)])) : undefined,
);

export function Macros({ port, profile }: { port: TerminalPort; profile: string }) {
  const [isEdited, setEdited] = useState(false);
  const macros = ownOf(kept.value, profile) ?? [];
  const put = (next: readonly Macro[]) => (kept.value = { ...kept.peek(), [profile]: next });
  const edit = () => {
    if (!isEdited && !macros.length) put([{ ...NEW_MACRO, ending: endingOf(profile) }]);
    setEdited(!isEdited);
  };
  return (
    <>
      <div class="row terminal-macros" role="group" aria-label="Macros">
        {macros.map((macro, at) => (
          <button
            key={at}
            type="button"
            disabled={!port.isOpen.value}
            title={`Send ${macro.text || "nothing"}${macro.ending === "none" ? "" : `, then ${macro.ending}`}`}
            onClick={() => port.type(bytesOfMacro(macro))}
          >
            {titleOf(macro)}
          </button>
        ))}
        <button type="button" class="plain" aria-expanded={isEdited} title="Texts that are sent by a button" onClick={edit}>
          {isEdited ? "Done" : macros.length ? "Edit macros" : "Add a macro"}
        </button>
      </div>
      {isEdited && <MacroList macros={macros} profile={profile} put={put} />}
    </>
  );
}

interface ListProps {
  macros: readonly Macro[];
  profile: string;
  put(macros: readonly Macro[]): void;
}

function MacroList({ macros, profile, put }: ListProps) {
  const change = (at: number, by: Partial<Macro>) => put(macros.map((macro, each) => (each === at ? { ...macro, ...by } : macro)));
  return (
    <div class="macro-list" role="group" aria-label={`Macros of ${profile}`}>
      {macros.map((macro, at) => (
        <div key={at} class="row" role="group" aria-label={`Macro ${at + 1}`}>
          <input
            class="macro-name"
            aria-label={`Name of macro ${at + 1}`}
            placeholder="name"
            maxLength={40}
            value={macro.name}
            onInput={(event) => change(at, { name: event.currentTarget.value })}
          />
          <input
            class="mono macro-text"
            aria-label={`Text of macro ${at + 1}`}
            placeholder="text; \r \n \t \xHH are bytes"
            maxLength={4000}
            spellcheck={false}
            value={macro.text}
            onInput={(event) => change(at, { text: event.currentTarget.value })}
          />
          <select aria-label={`End of macro ${at + 1}`} value={macro.ending} onChange={(event) => change(at, { ending: event.currentTarget.value as Ending })}>
            {ENDING_NAMES.map((each) => (
              <option key={each} value={each}>
                {each === "none" ? "no end" : each}
              </option>
            ))}
          </select>
          <button type="button" disabled={at === 0} aria-label={`Move macro ${at + 1} up`} title="Up" onClick={() => put(moved(macros, at, -1))}>
            ↑
          </button>
          <button
            type="button"
            disabled={at === macros.length - 1}
            aria-label={`Move macro ${at + 1} down`}
            title="Down"
            onClick={() => put(moved(macros, at, 1))}
          >
            ↓
          </button>
          <button type="button" aria-label={`Delete macro ${at + 1}`} title="Delete" onClick={() => put(macros.filter((_, each) => each !== at))}>
            ×
          </button>
        </div>
      ))}
      <button type="button" onClick={() => put([...macros, { ...NEW_MACRO, ending: endingOf(profile) }])}>
        Add
      </button>
    </div>
  );
}
