/** State that outlives the page: what is typed and chosen is kept in the browser, by the bench's name.
 *
 * It is written twice. The tab's own store brings it back after the page is loaded again, whatever other tabs of
 * the bench do; the store that all tabs share has it for the next one. What is kept was written by anybody: each
 * `Kept` reads it through a check, and begins as new where it is none of its own. */

import { computed, signal, type Signal } from "@preact/signals";

/** Bench whose state this is; empty: it is not known yet, and nothing is kept. */
export const keptFor = signal("");

/** Keys whose state found no room in the store of all tabs: it ends with this tab at the latest. */
export const notKept = signal<ReadonlySet<string>>(new Set());

/** Another form of what is kept has another number: an older page leaves it alone. */
const PREFIX = "hil.kept.1";
/** What is typed is written so much later, not with each key. */
const WRITE_MS = 250;
/** A long text is written later: it takes the browser a tenth of a second. */
const LONG_WRITE_MS = 1500;
const LONG_CHARACTERS = 200_000;
/** Lengths of the texts that were written last, by key. */
const lengths = new Map<string, number>();

const waiting = new Map<string, unknown>();
let timer: ReturnType<typeof setTimeout> | undefined;

/** State of one kind: a signal for each bench. `read` makes it of what was kept; undefined: that is none. */
export class Kept<T> {
  private readonly ofBenches = new Map<string, Signal<T>>();

  constructor(
    protected readonly name: string,
    private readonly initial: () => T,
    private readonly read: (raw: unknown) => T | undefined,
  ) {}

  get value(): T {
    return this.of(keptFor.value).value;
  }

  set value(next: T) {
    const bench = keptFor.peek();
    this.of(bench).value = next;
    if (bench) this.write(this.key(bench), next);
  }

  peek(): T {
    return this.of(keptFor.peek()).peek();
  }

  protected write(key: string, next: T): void {
    later(key, next);
  }

  protected stores(): (Storage | null)[] {
    return [own(), shared()];
  }

  /** Take what is kept in the place of what is known. */
  protected readAgain(text: string | null): void {
    const found = this.readText(text);
    if (found !== undefined) this.of(keptFor.peek()).value = found;
  }

  private of(bench: string): Signal<T> {
    let known = this.ofBenches.get(bench);
    if (!known) this.ofBenches.set(bench, (known = signal(bench ? this.kept(bench) : this.initial())));
    return known;
  }

  private kept(bench: string): T {
    for (const store of this.stores()) {
      const found = this.readText(getItem(store, this.key(bench)));
      if (found !== undefined) return found;
    }
    return this.initial();
  }

  private readText(text: string | null): T | undefined {
    try {
      return text === null ? undefined : this.read(JSON.parse(text));
    } catch {
      return undefined;
    }
  }

  protected key(bench: string): string {
    return `${PREFIX}/${encodeURIComponent(bench.replace(/\p{Surrogate}/gu, "\ufffd"))}/${this.name}`;
  }
}

/** What all tabs have together, such as a list that each may add to: a change is there at once in all of them. */
export class KeptTogether<T> extends Kept<T> {
  constructor(name: string, initial: () => T, read: (raw: unknown) => T | undefined) {
    super(name, initial, read);
    globalThis.addEventListener?.("storage", ({ key, newValue }: StorageEvent) => {
      if (key === this.key(keptFor.peek())) this.readAgain(newValue);
    });
  }

  protected override write(key: string, next: T): void {
    put(key, next, [shared(), own()]);
  }

  protected override stores(): (Storage | null)[] {
    return [shared(), own()];
  }
}

/** A choice that is one of some texts, or any text. */
export function keptText(name: string, initial = ""): Kept<string> {
  return new Kept(
    name,
    () => initial,
    (raw) => (typeof raw === "string" ? raw : undefined),
  );
}

/** Value of a name, which may be any text: "constructor" has none of its own. */
export function ownOf<T>(values: Readonly<Record<string, T>>, name: string): T | undefined {
  return Object.hasOwn(values, name) ? values[name] : undefined;
}

/** Texts by name, such as those of fields of a form. */
export function keptTexts(name: string): Kept<Readonly<Record<string, string>>> {
  return new Kept(
    name,
    () => ({}),
    (raw) => (isObject(raw) ? textsOf(raw) : undefined),
  );
}

/** What is typed into forms, by form and field, until it is put away. */
export class KeptForms {
  private readonly kept: Kept<Readonly<Record<string, Readonly<Record<string, string>>>>>;

  constructor(name: string) {
    this.kept = new Kept(
      name,
      () => ({}),
      (raw) =>
        isObject(raw)
          ? Object.fromEntries(
              Object.entries(raw)
                .filter(([, form]) => isObject(form))
                .map(([form, texts]) => [form, textsOf(texts as object)]),
            )
          : undefined,
    );
  }

  of(form: string): Readonly<Record<string, string>> {
    return ownOf(this.kept.value, form) ?? NOTHING;
  }

  /** Text of a field of a form, and what puts another one. */
  field(form: string, name: string, initial = ""): [string, (text: string) => void] {
    return [ownOf(this.of(form), name) ?? initial, (text) => this.put(form, { ...this.of(form), [name]: text })];
  }

  put(form: string, texts: Readonly<Record<string, string>>): void {
    const { [form]: _, ...others } = this.kept.peek();
    this.kept.value = Object.keys(texts).length ? { ...others, [form]: texts } : others;
  }
}

const NOTHING = {};

function isObject(raw: unknown): raw is object {
  return typeof raw === "object" && raw !== null && !Array.isArray(raw);
}

function textsOf(raw: object): Record<string, string> {
  return Object.fromEntries(Object.entries(raw).filter((each): each is [string, string] => typeof each[1] === "string"));
}

/** The text of a key for all benches, such as the theme; null: there is none. */
export function remembered(key: string): string | null {
  return getItem(shared(), key);
}

export function remember(key: string, text: string): void {
  setItem(shared(), key, text);
}

/** The text of a key for this tab alone, over its loads; null: there is none. */
export function rememberedByTab(key: string): string | null {
  return getItem(own(), key);
}

/** Keep a text for this tab; false: it keeps none. */
export function rememberByTab(key: string, text: string): boolean {
  return setItem(own(), key, text);
}

// ---- what is not saved ----

/** A text that somebody writes. `isOwn`: it was typed or opened here, so nothing else may take its place;
 * `isSaved`: it is as it was opened, started or put into a file. */
export interface DraftText {
  text: string;
  file: string;
  isOwn: boolean;
  isSaved: boolean;
}

/** A draft of a bench. `what`: its name in words. */
export class Draft {
  private readonly kept: Kept<DraftText>;

  constructor(name: string, what: string, initial: () => { text: string; file: string }) {
    this.kept = new Kept(name, () => ({ ...initial(), isOwn: false, isSaved: true }), readDraft);
    isDraft(what, () => !this.kept.value.isSaved);
  }

  get value(): DraftText {
    return this.kept.value;
  }

  peek(): DraftText {
    return this.kept.peek();
  }

  type(text: string): void {
    if (text !== this.peek().text) this.kept.value = { ...this.peek(), text, isOwn: true, isSaved: false };
  }

  open(text: string, file: string): void {
    this.kept.value = { text, file, isOwn: true, isSaved: true };
  }

  /** Take a text that the bench has. */
  take(text: string, file: string): void {
    this.kept.value = { text, file, isOwn: false, isSaved: true };
  }

  /** Note that this text is in a file now, or at the bench; what was typed meanwhile is not. */
  saved(text: string): void {
    if (text === this.peek().text) this.kept.value = { ...this.peek(), isSaved: true };
  }
}

function readDraft(raw: unknown): DraftText | undefined {
  const { text, file, isOwn, isSaved } = (raw ?? {}) as Partial<DraftText>;
  if (typeof text !== "string" || typeof file !== "string") return undefined;
  return { text, file, isOwn: isOwn !== false, isSaved: isSaved === true };
}

const drafts = signal<ReadonlyMap<string, () => boolean>>(new Map());

/** Name a draft, such as "the run", that somebody would not like to lose while `isUnsaved`. */
export function isDraft(what: string, isUnsaved: () => boolean): void {
  drafts.value = new Map(drafts.peek()).set(what, isUnsaved);
}

/** Drafts that are neither sent, started nor in a file. */
export const unsaved = computed(() => [...drafts.value].filter(([, isUnsaved]) => isUnsaved()).map(([what]) => what));

/** Keep what is typed when the page goes, and ask before what could not be kept is lost. */
export function startKeeping(): void {
  window.addEventListener("pagehide", flush);
  document.addEventListener("visibilitychange", flush);
  window.addEventListener("beforeunload", (event) => {
    flush();
    if (notKept.peek().size && unsaved.peek().length) event.preventDefault();
  });
}

// ---- writing ----

function later(key: string, value: unknown): void {
  waiting.set(key, value);
  timer ??= setTimeout(flush, (lengths.get(key) ?? 0) > LONG_CHARACTERS ? LONG_WRITE_MS : WRITE_MS);
}

/** Write what waits. */
export function flush(): void {
  clearTimeout(timer);
  timer = undefined;
  for (const [key, value] of waiting) put(key, value, [own(), shared()]);
  waiting.clear();
}

/** Write a value into stores, and note whether it is in the one of all tabs. */
function put(key: string, value: unknown, into: (Storage | null)[]): void {
  const text = JSON.stringify(value);
  lengths.set(key, text.length);
  const isThere = into.map((store) => setItem(store, key, text))[into.indexOf(shared())] === true;
  if (isThere !== notKept.peek().has(key)) return;
  const failed = new Set(notKept.peek());
  if (isThere) failed.delete(key);
  else failed.add(key);
  notKept.value = failed;
}

/** Put a text into a store; false: it has no room. The text before goes in any case: it would come back as the
 * newest. */
function setItem(store: Storage | null, key: string, text: string): boolean {
  for (let tries = 0; tries < 2; tries++) {
    try {
      store?.setItem(key, text);
      return store !== null;
    } catch {
      removeItem(store, key);
    }
  }
  return false;
}

function removeItem(store: Storage | null, key: string): void {
  try {
    store?.removeItem(key);
  } catch {
    // A store that refuses this has nothing of the page.
  }
}

function getItem(store: Storage | null, key: string): string | null {
  try {
    return store?.getItem(key) ?? null;
  } catch {
    return null;
  }
}

function own(): Storage | null {
  return storeOf(() => sessionStorage);
}

function shared(): Storage | null {
  return storeOf(() => localStorage);
}

/** A browser may refuse the very question. */
function storeOf(find: () => Storage | undefined): Storage | null {
  try {
    return find() ?? null;
  } catch {
    return null;
  }
}
