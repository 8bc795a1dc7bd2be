import { afterAll, beforeEach, describe, expect, it, vi } from "vitest";

/** A store of a browser with room for so many characters. */
class Store {
  readonly texts = new Map<string, string>();
  room = Infinity;

  getItem = (key: string) => this.texts.get(key) ?? null;
  removeItem = (key: string) => void this.texts.delete(key);
  setItem = (key: string, text: string) => {
    const others = [...this.texts].filter(([each]) => each !== key).reduce((sum, [each, value]) => sum + each.length + value.length, 0);
    if (others + key.length + text.length > this.room) throw new DOMException("full", "QuotaExceededError");
    this.texts.set(key, text);
  };
}

const tab = new Store();
const shared = new Store();
const originals = new Map([tab, shared].map((store) => [store, { ...store }]));
vi.stubGlobal("sessionStorage", tab);
vi.stubGlobal("localStorage", shared);
/** What the page does when another tab has written. */
const heard: ((event: { key: string; newValue: string }) => void)[] = [];
vi.stubGlobal("addEventListener", (_: string, listener: (typeof heard)[number]) => void heard.push(listener));
afterAll(() => vi.unstubAllGlobals());

const { Kept, KeptForms, KeptTogether, flush, isDraft, keptFor, keptText, notKept, unsaved } = await import("../src/kept");

/** A kind of state as a page has it that was loaded just now. */
const windowOf = () =>
  new Kept(
    "window",
    () => 10,
    (raw) => (typeof raw === "number" ? raw : undefined),
  );

beforeEach(() => {
  flush();
  for (const store of [tab, shared]) {
    store.texts.clear();
    store.room = Infinity;
  }
  keptFor.value = "demo";
});

describe("what is kept", () => {
  it("comes back after the page is loaded again, for its own bench", () => {
    windowOf().value = 60;
    flush();
    expect(windowOf().value).toBe(60);
    keptFor.value = "other / bench";
    expect(windowOf().value).toBe(10);
    windowOf().value = 30;
    flush();
    keptFor.value = "demo";
    expect(windowOf().value).toBe(60);
  });

  it("follows the bench in a page that stays", () => {
    const kept = windowOf();
    kept.value = 60;
    keptFor.value = "other";
    expect(kept.value).toBe(10);
    keptFor.value = "demo";
    expect(kept.peek()).toBe(60);
  });

  it("is not written before the bench is known", () => {
    keptFor.value = "";
    windowOf().value = 60;
    flush();
    expect(shared.texts.size + tab.texts.size).toBe(0);
  });

  it.each(["", "{", "null", '"60"', "[]", '{"version":7}', "\u0000"])("is as new where %j stands there", (text) => {
    windowOf().value = 60;
    flush();
    for (const store of [tab, shared]) for (const key of store.texts.keys()) store.texts.set(key, text);
    expect(windowOf().value).toBe(10);
  });

  it("is that of all tabs where the tab's own is damaged", () => {
    windowOf().value = 60;
    flush();
    for (const key of tab.texts.keys()) tab.texts.set(key, "{");
    expect(windowOf().value).toBe(60);
  });

  it("is each tab's own, and the last one's for a new tab", () => {
    const mine = keptText("run");
    mine.value = "mine";
    flush();
    for (const key of shared.texts.keys()) shared.texts.set(key, '"theirs"'); // another tab writes, as 20 may
    expect(keptText("run").value).toBe("mine");
    tab.texts.clear();
    expect(keptText("run").value).toBe("theirs");
  });
});

describe("what all tabs have together", () => {
  const listOf = () =>
    new KeptTogether<readonly string[]>(
      "list",
      () => [],
      (raw) => (Array.isArray(raw) ? raw.map(String) : undefined),
    );
  const KEY = "hil.kept.1/demo/list";

  it("is written at once, and taken from the store of all tabs", () => {
    listOf().value = ["a"];
    expect(shared.getItem(KEY)).toBe('["a"]');
    shared.setItem(KEY, '["a","b"]');
    expect(listOf().value).toEqual(["a", "b"]);
  });

  it("follows another tab, and nothing that is none of it", () => {
    const list = listOf();
    const tell = heard.at(-1)!;
    list.value = ["a"];
    tell({ key: KEY, newValue: '["a","b"]' });
    expect(list.value).toEqual(["a", "b"]);
    tell({ key: KEY, newValue: "{" });
    tell({ key: "hil.kept.1/other/list", newValue: '["c"]' });
    expect(list.value).toEqual(["a", "b"]);
  });
});

describe("a store that refuses everything", () => {
  it("is as none, and what was not kept is known", () => {
    const refuse = () => {
      throw new DOMException("refused", "SecurityError");
    };
    for (const store of [tab, shared]) Object.assign(store, { getItem: refuse, setItem: refuse, removeItem: refuse });
    try {
      const first = windowOf();
      first.value = 60;
      keptText("name").value = "a";
      flush();
      expect(first.value).toBe(60);
      expect(notKept.value.size).toBe(2);
    } finally {
      for (const store of [tab, shared]) Object.assign(store, originals.get(store));
      notKept.value = new Set();
    }
  });
});

describe("a full store", () => {
  it("leaves no older text, and is told; the tab keeps the newest", () => {
    const run = keptText("run");
    run.value = "old";
    flush();
    shared.room = 60;
    run.value = "x".repeat(100);
    flush();
    expect([...shared.texts.values()]).toEqual([]);
    expect(notKept.value.size).toBe(1);
    expect(keptText("run").value).toBe(run.value);
    run.value = "short";
    flush();
    expect(notKept.value.size).toBe(0);
  });

  it("may be none at all", () => {
    vi.stubGlobal("localStorage", undefined);
    const run = keptText("run");
    run.value = "typed";
    flush();
    expect([run.value, notKept.value.size]).toEqual(["typed", 1]);
    vi.stubGlobal("localStorage", shared);
  });
});

describe("forms", () => {
  it("have what was typed into each of them", () => {
    const forms = new KeptForms("forms");
    forms.put("m1 move_abs", { position_deg: "1,5" });
    forms.put("m1 velocity", { velocity_rpm: "9" });
    forms.put("m1 velocity", {});
    flush();
    const again = new KeptForms("forms");
    expect([again.of("m1 move_abs"), again.of("m1 velocity")]).toEqual([{ position_deg: "1,5" }, {}]);
    for (const store of [tab, shared]) for (const key of store.texts.keys()) store.texts.set(key, '{"m1 move_abs":{"x":5,"y":"6"},"z":[]}');
    expect(new KeptForms("forms").of("m1 move_abs")).toEqual({ y: "6" });
  });
});

describe("what is not saved", () => {
  it("is told by name while it is", () => {
    const run = keptText("run");
    isDraft("the run", () => run.value !== "");
    expect(unsaved.value).toEqual([]);
    run.value = "x";
    expect(unsaved.value).toEqual(["the run"]);
    keptFor.value = "other";
    expect(unsaved.value).toEqual([]);
  });
});
