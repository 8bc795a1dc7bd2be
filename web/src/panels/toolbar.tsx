/** What can be done with a layout: open, name, save, pass on, add panels. */

import { MOST_PANELS, PANEL_KINDS, type PanelKind, panel } from "../model/layout";
import { Menu } from "../parts/menu";
import { notify } from "../parts/notices";
import { href } from "../router";
import { hello } from "../store";
import { addPanel, addressOf, forget, isChanged, layout, open, recent, rename, save, saved, showWaiting } from "./desk";
import { firstGiven, KINDS } from "./kinds";
import { readyOnes } from "./ready";

export function Toolbar({ fill }: { fill(): void }) {
  const now = layout.value;
  const isOther = now.bench !== "" && now.bench !== hello.value?.bench;
  return (
    <div class="row room-bar" role="group" aria-label="Layout">
      <h2 class="out-of-sight">Layout</h2>
      <Menu text="Layouts ▾">
        <Layouts />
      </Menu>
      <label>
        <span class="out-of-sight">Name of the layout</span>
        <input class="room-name" value={now.name} placeholder="name" maxLength={60} onInput={(event) => rename(event.currentTarget.value)} />
      </label>
      <button type="button" title="Keep it in this browser by its name" onClick={save}>
        Save
      </button>
      <Menu text="+ Panel">
        <NewPanels isWatch={now.isWatch} />
      </Menu>
      {isChanged.value && <span class="soft">changed</span>}
      {now.waiting.length > 0 && (
        <span class="row" role="status">
          {now.waiting.length} more panels wait: {MOST_PANELS} are the most at a time.
          <button type="button" onClick={showWaiting}>
            Show the next
          </button>
        </span>
      )}
      {isOther && (
        <span class="soft" role="status">
          It was made for the bench {now.bench}: panels say what is missing here.
        </span>
      )}
      <span class="push row">
        <label class="row" title="For a screen that others look at: nothing in the panels changes the bench">
          <input type="checkbox" checked={now.isWatch} onChange={(event) => setWatch(event.currentTarget.checked)} /> no controls
        </label>
        <button type="button" title="The address has the whole layout" onClick={() => void copyAddress()}>
          Copy the address
        </button>
        <button type="button" onClick={fill} title="Esc comes back">
          Full screen
        </button>
      </span>
    </div>
  );
}

/** The panels are made again: some have controls. */
function setWatch(isWatch: boolean): void {
  open({ ...layout.peek(), isWatch }, []);
}

async function copyAddress(): Promise<void> {
  const address = new URL(await addressOf(), window.location.href).href;
  try {
    await navigator.clipboard.writeText(address);
    notify("The address is copied: who opens it has this layout.");
  } catch {
    window.prompt("The address of this layout", address); // a page without TLS has no clipboard
  }
}

export function ReadyLinks() {
  const bench = hello.value;
  if (!bench) return null;
  return (
    <ul class="ready-list">
      {readyOnes(bench).map((ready) => (
        <li key={ready.id}>
          <a href={href("layout", "ready", ready.id)} data-closes>
            {ready.title}
          </a>{" "}
          <span class="soft">{ready.about}</span>
          {ready.of(bench).length > 1 && (
            <span class="row">
              {ready.of(bench).map((of) => (
                <a key={of} href={href("layout", "ready", ready.id, of)} data-closes>
                  {of}
                </a>
              ))}
            </span>
          )}
        </li>
      ))}
    </ul>
  );
}

function Layouts() {
  return (
    <>
      <h3>Ready for this bench</h3>
      <ReadyLinks />
      {saved.value.length > 0 && (
        <>
          <h3>Saved in this browser</h3>
          <ul class="ready-list">
            {saved.value.map((each) => (
              <li key={each.name} class="row">
                <a href={href("layout", "saved", each.name)} data-closes>
                  {each.name}
                </a>
                <button type="button" class="plain push" aria-label={`Forget the layout ${each.name}`} onClick={() => forget(each.name)}>
                  ×
                </button>
              </li>
            ))}
          </ul>
        </>
      )}
      {recent.value.length > 0 && (
        <>
          <h3>Before, not saved</h3>
          <ul class="ready-list">
            {recent.value.map((each, at) => (
              <li key={at}>
                <button type="button" data-closes onClick={() => open(each, [])}>
                  {each.name || "without a name"}
                </button>
              </li>
            ))}
          </ul>
        </>
      )}
    </>
  );
}

function NewPanels({ isWatch }: { isWatch: boolean }) {
  const kinds = PANEL_KINDS.filter((kind) => isOffered(kind) && !(isWatch && KINDS[kind].isControl));
  return (
    <ul class="ready-list">
      {kinds.map((kind) => (
        <li key={kind}>
          <button type="button" data-closes onClick={() => addPanel(panel(kind, KINDS[kind].targets?.()[0] ?? "", firstGiven(kind)))}>
            {KINDS[kind].title}
          </button>{" "}
          <span class="soft">{KINDS[kind].about}</span>
        </li>
      ))}
    </ul>
  );
}

function isOffered(kind: PanelKind): boolean {
  const { targets, isThere } = KINDS[kind];
  return targets ? targets().length > 0 : !isThere || isThere(panel(kind));
}
