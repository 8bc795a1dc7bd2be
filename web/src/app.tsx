import { computed } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { Guarded } from "./parts/guarded";
import { Notices } from "./parts/notices";
import { HelpDialog, openHelp } from "./parts/help";
import { go, href, path } from "./router";
import { notKept, unsaved } from "./kept";
import { hello, link, loadVersion, newVersion, otherVersion, status } from "./store";
import { showTabIcon, tabTitle, tabTrouble } from "./tab_head";
import { theme, toggleTheme } from "./theme";
import { Login } from "./login";
import { HAS_PAST } from "./past";
import { VIEWS } from "./views";
import { PastBanner, TimeLine } from "./views/past";
import type { ViewEntry } from "./views/view";

function shownViews(): ViewEntry[] {
  const bench = hello.value;
  return VIEWS.filter((view) => !view.isShown || (bench !== null && view.isShown(bench)));
}

/** News are old from here on: the clock comes twice a second. */
const OLD_s = 1.5;
const isOld = computed(() => link.state.value === "open" && link.age_s.value > OLD_s);

/** Age of what is shown. */
function NewsAge() {
  if (link.state.value !== "open") return null;
  const age = link.age_s.value.toFixed(1);
  return (
    <>
      <span class="clock news" title="age of the last news from the bench">
        {isOld.value ? `no news for ${age} s` : `news ${age} s old`}
      </span>
      {isOld.value && (
        <span class="out-of-sight" role="alert">
          The bench says nothing: what you see is old.
        </span>
      )}
    </>
  );
}

function LinkState() {
  const state = link.state.value;
  const words = { connecting: "connecting", open: "connected", lost: "no connection", login: "login" };
  return (
    <span class={`pill is-${state}`} role="status" aria-label={`Connection: ${words[state]}`}>
      {words[state]}
    </span>
  );
}

/** Health of the bench; a click lists its problems. */
function Health() {
  const health = status.value.health;
  if (!health) return null;
  const time_s = (status.value.sim_ns ?? 0) / 1e9;
  const pill = `pill is-${health.state}`;
  return (
    <>
      {health.problems.length > 0 ? (
        <details class="health">
          <summary class={pill} aria-label={`Health: ${health.state}; its problems`}>
            {health.state}
          </summary>
          <ul class="card" aria-label="Problems of the bench">
            {health.problems.map((problem) => (
              <li key={problem}>{problem}</li>
            ))}
          </ul>
        </details>
      ) : (
        <span class={pill} title={`late ${health.late_ms} ms`}>
          {health.state}
        </span>
      )}
      <span class="clock" title="simulated time">
        {time_s.toFixed(1)} s
      </span>
    </>
  );
}

function Header({ current }: { current: ViewEntry | undefined }) {
  const bench = hello.value;
  const other = theme.value === "dark" ? "light" : "dark";
  return (
    <header class="top">
      <h1>
        <span class="brand">hil</span> <span class="bench-name">{bench?.bench ?? ""}</span>
      </h1>
      <nav aria-label="Views">
        {shownViews().map((view) => (
          <a key={view.id} href={href(view.id)} aria-current={view === current ? "page" : undefined}>
            {view.title}
          </a>
        ))}
      </nav>
      <div class={isOld.value ? "state is-old" : "state"}>
        <Health />
        <NewsAge />
        <LinkState />
        {bench && link.login.value !== "none" && (
          <button type="button" class="plain" onClick={() => void link.logOut()} title={`Log out ${bench.user}`}>
            {bench.user} ({bench.role})
          </button>
        )}
        <button type="button" class="plain" aria-label={`Change to ${other}`} title={`Change to ${other}`} onClick={toggleTheme}>
          ◐
        </button>
        <button type="button" class="plain" aria-label="Help: what the words mean" title="Help (?)" onClick={openHelp}>
          ?
        </button>
      </div>
    </header>
  );
}

/** What is said across the page: the connection is gone, or page and server do not belong together. */
function Banner() {
  if (otherVersion.value) {
    return (
      <div class="banner" role="alert">
        This page is of another version than the server. Load it again without the cache (Ctrl-Shift-R).
      </div>
    );
  }
  if (newVersion.value) return <NewVersion server={newVersion.value} />;
  if (notKept.value.size > 0 && unsaved.value.length > 0) {
    return (
      <div class="banner" role="alert">
        This browser has no room to keep what you type: it is lost with this tab. Save it to a file.
      </div>
    );
  }
  if (link.state.value !== "lost") return null;
  const since = link.lostAt.value ? new Date(link.lostAt.value).toLocaleTimeString() : "";
  return (
    <div class="banner" role="alert">
      No connection to the bench since {since}. What you see is from then; the page connects again by itself.{" "}
      <button type="button" onClick={() => link.tryNow()}>
        Try now
      </button>
    </div>
  );
}

function NewVersion({ server }: { server: string }) {
  const drafts = unsaved.value.join(", ");
  return (
    <div class="banner is-news" role="status">
      There is a new version of this page.{" "}
      <button type="button" onClick={() => loadVersion(server)}>
        Load it
      </button>{" "}
      {drafts && `Not saved: ${drafts}. It is kept, and comes back with the new version.`}
    </div>
  );
}

/** Keys of the whole page: ? for help, 1 to 9 for the views. Not while something is typed. */
function onKey(event: KeyboardEvent): void {
  const target = event.target as HTMLElement;
  if (event.ctrlKey || event.altKey || event.metaKey || isTyping(target)) return;
  if (event.key === "?") openHelp();
  const view = /^[1-9]$/.test(event.key) ? shownViews()[Number(event.key) - 1] : undefined;
  if (view) go(view.id);
  if (event.key === "?" || view) event.preventDefault();
}

function isTyping(element: HTMLElement): boolean {
  return element.matches?.("input, textarea, select, [contenteditable]") || element.closest?.(".terminal") !== null;
}

export function App() {
  useEffect(() => {
    window.addEventListener("keydown", onKey);
    return () => window.removeEventListener("keydown", onKey);
  }, []);
  const views = shownViews();
  const current = views.find((view) => view.id === path.value[0]) ?? views[0];
  const main = useRef<HTMLElement>(null);
  const trouble = tabTrouble(link.state.value, status.value.health?.state);
  const title = tabTitle(hello.value?.bench ?? "", trouble);
  useEffect(() => {
    document.title = title;
  }, [title]);
  useEffect(() => showTabIcon(trouble), [trouble]);
  const isLogin = link.state.value === "login";
  return (
    <>
      <a class="skip" href="#main" onClick={(event) => (event.preventDefault(), main.current?.focus())}>
        Skip to the content
      </a>
      <Header current={current} />
      <Banner />
      <PastBanner />
      <main id="main" ref={main} tabIndex={-1}>
        {isLogin && <Login />}
        {!isLogin && !hello.value && <p class="empty">Waiting for the bench …</p>}
        {hello.value && current && (
          <div class="view" hidden={isLogin}>
            <Guarded key={current.id}>
              <current.View path={path.value.slice(1)} />
            </Guarded>
            {HAS_PAST.includes(current.id) && (
              <Guarded>
                <TimeLine />
              </Guarded>
            )}
          </div>
        )}
      </main>
      <HelpDialog />
      <Notices />
    </>
  );
}
