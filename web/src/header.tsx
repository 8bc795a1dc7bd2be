/** The head of the page: the bench, its views, how it does in words, and Stop all. */

import { computed } from "@preact/signals";
import { movesIn, snapshotOf } from "./model/axis_card";
import { problemText, reasonText } from "./model/status";
import { openHelp } from "./parts/help";
import { href } from "./router";
import { StopAll, StopSite } from "./stop_all";
import { activeFaults, devices, hello, link, status } from "./store";
import { theme, toggleTheme } from "./theme";
import type { ViewEntry } from "./views/view";
import "./header.css";

/** News are old from here on: the clock comes twice a second. */
const OLD_s = 1.5;
const isOld = computed(() => link.state.value === "open" && link.age_s.value > OLD_s);
const PROBLEMS = "problems-of-the-bench";

/** Axes of the bench, and those of them that move. */
const axes = computed(() => {
  const rows = new Map(status.value.devices.map((row) => [row.device, row]));
  const shots = [...devices.value.values()].map(({ name }) => snapshotOf(rows.get(name.split(".")[0]!), name)).filter((shot) => shot !== null);
  return { count: shots.length, moving: shots.filter(movesIn).length };
});

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

/** Health of the bench with its first reason in words; a click lists all. */
function Health() {
  const health = status.value.health;
  if (!health) return null;
  const [first, ...others] = health.problems;
  if (!first) {
    return (
      <span class={`pill is-${health.state}`} title={`late ${health.late_ms} ms`}>
        {health.state}
      </span>
    );
  }
  return (
    <>
      <button type="button" class={`pill health is-${health.state}`} popovertarget={PROBLEMS}>
        <span>{health.state}</span>
        <span class="out-of-sight">: all problems; the first: </span>
        <span class="health-reason">{reasonText(first)}</span>
        {others.length > 0 && <span>+{others.length}</span>}
      </button>
      <div id={PROBLEMS} class="card popover problems" popover="auto" role="dialog" aria-label="Problems of the bench">
        <ul>
          {health.problems.map((problem) => (
            <li key={problemText(problem)}>{problemText(problem)}</li>
          ))}
        </ul>
      </div>
    </>
  );
}

/** What there is and what goes on: axes, those that move, faults. */
function Counts() {
  const { count, moving } = axes.value;
  const faults = activeFaults.value.length;
  if (!count) return null;
  return (
    <span class="counts">
      {count} {count === 1 ? "axis" : "axes"}, <span class={moving ? "is-moving" : ""}>{moving} moving</span>
      {faults > 0 && (
        <>
          ,{" "}
          <a class="problem" href={href("faults")}>
            {faults} {faults === 1 ? "fault" : "faults"}
          </a>
        </>
      )}
    </span>
  );
}

/** Who has the bench, and until when, if somebody has it. */
function LeaseHolder() {
  const lease = status.value.lease;
  if (!lease) return null;
  const until = new Date(lease.until_wall_ns / 1e6).toLocaleTimeString([], { hour: "2-digit", minute: "2-digit" });
  return (
    <span class="counts" title={lease.why}>
      leased by {lease.user} until {until}
    </span>
  );
}

export function Header({ current, views }: { current: ViewEntry | undefined; views: ViewEntry[] }) {
  const bench = hello.value;
  const other = theme.value === "dark" ? "light" : "dark";
  const time_s = (status.value.sim_ns ?? 0) / 1e9;
  return (
    <header class="top">
      <h1>
        <span class="brand">hil</span> <span class="bench-name">{bench?.bench ?? ""}</span>
      </h1>
      <nav aria-label="Views">
        {views.map((view) => (
          <a key={view.id} href={href(view.id)} aria-current={view === current ? "page" : undefined}>
            {view.title}
          </a>
        ))}
      </nav>
      <div class={isOld.value ? "state is-old" : "state"}>
        <Counts />
        <LeaseHolder />
        <Health />
        {status.value.health && (
          <span class="clock" title="simulated time">
            {time_s.toFixed(1)} s
          </span>
        )}
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
        <StopSite />
        <StopAll />
      </div>
    </header>
  );
}
