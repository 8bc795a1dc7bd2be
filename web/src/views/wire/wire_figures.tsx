/** What is counted on a wire: all together, by identifier, unit or addresses, and what was wrong. */

import { timeText } from "./columns";
import type { WireKind } from "./conversation";
import { withWord } from "./packet_filter";
import type { GroupCounts, WireCounts } from "./wire_counts";
import type { WireFeed } from "./wire_feed";

const MOST_ROWS = 200;
const NAMES: Record<WireKind, string> = { can: "Identifier", modbus: "Unit", sac: "Addresses", lines: "Station" };
const CAPTIONS: Record<WireKind, string> = {
  can: "By identifier",
  modbus: "By unit; the period is that of questions",
  sac: "By sender and receiver",
  lines: "By station",
};

/** `turn`: another one where there is more to count. */
export function Figures({ feed, turn }: { feed: WireFeed; turn: number }) {
  const { counts } = feed.source;
  const perSecond = (count: number) => (counts.span_s > 0 ? (count / counts.span_s).toFixed(1) : "–");
  const figures: [string, string, boolean?][] = [
    ["packets", String(counts.packets)],
    ["bytes", String(counts.bytes)],
    ["errors", String(counts.bad), counts.bad > 0],
    ["over", `${counts.span_s.toFixed(1)} s`],
    ["packets/s", perSecond(counts.packets)],
    ["bytes/s", perSecond(counts.bytes)],
    ["mean", timeText(counts.packets ? counts.busy_s / counts.packets : 0)],
    ["longest", timeText(counts.longest_s)],
  ];
  return (
    <section class="card" aria-labelledby="figures-title">
      <h2 id="figures-title">Statistics</h2>
      <dl class="figures">
        {figures.map(([name, value, isBad]) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd class={isBad ? "mono problem" : "mono"}>{value}</dd>
          </div>
        ))}
      </dl>
      {counts.groups.size > 0 && <Groups feed={feed} turn={turn} />}
      {counts.errors.size > 0 && <Errors counts={counts} turn={turn} />}
    </section>
  );
}

function Groups({ feed, turn }: { feed: WireFeed; turn: number }) {
  const { kind } = feed;
  const { counts } = feed.source;
  const groups = [...counts.groups.values()].sort((one, other) => one.name.localeCompare(other.name, "en", { numeric: kind !== "can" }));
  const haveAnswers = groups.some(({ answers, unanswered }) => answers.count + unanswered > 0);
  return (
    <div class="scroll-x wire-groups" tabIndex={0} role="region" aria-label={CAPTIONS[kind]}>
      <table>
        <caption class="out-of-sight">{CAPTIONS[kind]}</caption>
        <thead>
          <tr>
            <th scope="col">{NAMES[kind]}</th>
            {["Packets", "Bytes", "Errors", "Period", "least", "most", "jitter"].map((title) => (
              <th key={title} scope="col" class="num">
                {title}
              </th>
            ))}
            {haveAnswers &&
              ["Answer after", "at most", "late", "none"].map((title) => (
                <th key={title} scope="col" class="num">
                  {title}
                </th>
              ))}
          </tr>
        </thead>
        <tbody>
          {groups.slice(0, MOST_ROWS).map((group) => (
            <Group key={group.name} feed={feed} group={group} turn={turn} haveAnswers={haveAnswers} />
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Group({ feed, group, haveAnswers }: { feed: WireFeed; group: GroupCounts; turn: number; haveAnswers: boolean }) {
  const { period, answers } = group;
  const word = wordOf(feed.kind, group.name);
  const time = (time_s: number, isThere: boolean) => (isThere ? timeText(time_s) : "");
  const bad = (count: number) => <td class={count ? "num problem" : "num"}>{count}</td>;
  return (
    <tr>
      <th scope="row" class="mono">
        <button type="button" class="plain" title={`Filter by ${word}`} onClick={() => (feed.filter.value = withWord(feed.filter.value, word))}>
          {group.name}
        </button>
      </th>
      <td class="num">{group.packets}</td>
      <td class="num">{group.bytes}</td>
      {bad(group.errors)}
      <td class="num">{time(period.mean_s, period.count > 0)}</td>
      <td class="num">{time(period.least_s, period.count > 0)}</td>
      <td class="num">{time(period.most_s, period.count > 0)}</td>
      <td class="num">{time(period.spread_s, period.count > 1)}</td>
      {haveAnswers && (
        <>
          <td class="num">{time(answers.mean_s, answers.count > 0)}</td>
          <td class="num">{time(answers.most_s, answers.count > 0)}</td>
          {bad(group.late)}
          {bad(group.unanswered)}
        </>
      )}
    </tr>
  );
}

function wordOf(kind: WireKind, name: string): string {
  if (kind === "can") return `id:${name.toLowerCase()}`;
  if (kind === "modbus") return `unit:${name}`;
  return kind === "sac"
    ? `talk:${name
        .split(" → ")
        .sort((one, other) => one.localeCompare(other, "en", { numeric: true }))
        .join("+")}`
    : `by:${name}`;
}

function Errors({ counts }: { counts: WireCounts; turn: number }) {
  return (
    <div class="scroll-x" tabIndex={0} role="region" aria-label="Table of errors">
      <table>
        <caption class="out-of-sight">What was wrong</caption>
        <thead>
          <tr>
            <th scope="col">Error</th>
            <th scope="col" class="num">
              Count
            </th>
          </tr>
        </thead>
        <tbody>
          {[...counts.errors].map(([error, count]) => (
            <tr key={error}>
              <td class="problem">{error}</td>
              <td class="num">{count}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
