import { useEffect, useRef } from "preact/hooks";
import { Guarded } from "./parts/guarded";
import { Notices } from "./parts/notices";
import { HelpDialog, openHelp } from "./parts/help";
import { Header } from "./header";
import { go, path } from "./router";
import { notKept, unsaved } from "./kept";
import { hello, link, loadVersion, newVersion, otherVersion, status } from "./store";
import { showTabIcon, tabTitle, tabTrouble } from "./tab_head";
import { onStopKey } from "./stop_all";
import { Login } from "./login";
import { HAS_PAST } from "./past";
import { VIEWS } from "./views";
import { PastBanner, TimeLine } from "./views/past";
import type { ViewEntry } from "./views/view";

function shownViews(): ViewEntry[] {
  const bench = hello.value;
  return VIEWS.filter((view) => !view.isShown || (bench !== null && view.isShown(bench)));
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
    const endStop = onStopKey();
    return () => {
      window.removeEventListener("keydown", onKey);
      endStop();
    };
  }, []);
  const views = shownViews();
  const current = views.find((view) => view.id === path.value[0]) ?? views[0];
  const main = useRef<HTMLElement>(null);
  const trouble = tabTrouble(link.state.value, status.value.health);
  const title = tabTitle(hello.value?.bench ?? "", trouble);
  useEffect(() => {
    document.title = title;
  }, [title]);
  useEffect(() => showTabIcon(trouble.kind), [trouble.kind]);
  const isLogin = link.state.value === "login";
  return (
    <>
      <a class="skip" href="#main" onClick={(event) => (event.preventDefault(), main.current?.focus())}>
        Skip to the content
      </a>
      <Header current={current} views={views} />
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
