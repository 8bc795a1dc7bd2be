/** A drawing in G-code: checked and planned by the bench, carried out by its axes, and drawn as they follow it. */

import { effect, untracked } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { shown } from "../../model/numbers";
import { notifyError } from "../../parts/notices";
import { TextSize } from "../../parts/text_size";
import { href } from "../../router";
import { link, may, readRuns, status } from "../../store";
import { deviation, followed, isSeenWhole, whyNotSeen } from "./path_followed";
import { checkAsTyped, fits, size, unchecked } from "./path_check";
import { PathPane } from "./path_pane";
import {
  done,
  drawing,
  feed_percent,
  follow,
  goOn,
  isChecked,
  isGood,
  isPaused,
  isPlanned,
  isPlanning,
  isUnderWay,
  mayStart,
  nextPart,
  offered,
  otherRun,
  plan,
  run,
  setPace,
  start,
  startPart,
  stop,
  takeTexts,
  verdict,
} from "./path_state";
import { PathText } from "./path_text";
import "./path.css";

/** A drawing that is more than one run goes on by itself, wherever in the page one looks. */
effect(() => {
  if (nextPart.value !== null) untracked(() => void goOn().catch(notifyError));
});

const attempt = (work: () => Promise<unknown>) => () => void work().catch(notifyError);

export function PathView() {
  const connections = link.connections.value;
  const theirs = status.value.drawing;
  useEffect(() => void readRuns(), [connections]);
  useEffect(checkAsTyped, []);
  useEffect(() => void follow().catch(notifyError), [connections, theirs, isUnderWay.value, isPlanning.value]);
  return (
    <div class="path">
      <div class="path-column">
        <PathText which="program" title="Program" />
        <PathText which="machine" title="Machine" />
      </div>
      <div class="path-column">
        <Offer />
        <Controls />
        <Figures />
        <Panes />
      </div>
    </div>
  );
}

/** What the bench draws, where the texts here are others: they stay until somebody takes its own. */
function Offer() {
  if (offered.value === null) return null;
  return (
    <section class="card row path-offer" role="status" aria-label="Drawing of the bench">
      <span>
        The bench draws <span class="mono file-name">{offered.value}</span>. The texts here are others.
      </span>
      <button type="button" onClick={takeTexts}>
        Take its texts
      </button>
    </section>
  );
}

function Controls() {
  const isOff = !may("operator") || link.state.value !== "open";
  const next = nextPart.value;
  const made = drawing.value;
  return (
    <section class="card" aria-label="Carry it out">
      <div class="row path-controls">
        <button type="button" disabled={link.state.value !== "open" || isPlanning.value || !fits.value} onClick={attempt(plan)}>
          {isPlanning.value ? "Planning …" : "Check"}
        </button>
        <label class="row">
          Feed
          <input
            class="path-feed"
            type="number"
            min={1}
            max={200}
            value={feed_percent.value}
            onInput={(event) => (feed_percent.value = Math.min(Math.max(Number(event.currentTarget.value) || 100, 1), 200))}
          />
          %
        </label>
        <button type="button" class={isPlanned.value || isGood.value ? "primary" : ""} disabled={!mayStart.value || !fits.value} onClick={attempt(start)}>
          Start
        </button>
        <span class="push row">
          {isPaused.value ? (
            <button type="button" disabled={isOff} onClick={attempt(() => setPace(1))}>
              Resume
            </button>
          ) : (
            <button type="button" disabled={isOff || !isUnderWay.value} onClick={attempt(() => setPace(0))}>
              Pause
            </button>
          )}
          <button type="button" disabled={isOff || !isUnderWay.value} title="on the path, with its ramp" onClick={attempt(() => stop("grace"))}>
            Stop
          </button>
          <button type="button" class="danger" disabled={isOff || !isUnderWay.value} title="without a ramp" onClick={attempt(() => stop("prejudice"))}>
            Stop at once
          </button>
        </span>
      </div>
      {isUnderWay.value && (
        <label class="row path-pace">
          Pace
          <input
            type="range"
            min={0}
            max={100}
            step={5}
            disabled={isOff}
            value={Math.round((run.value?.pace ?? 1) * 100)}
            onInput={(event) => void setPace(Number(event.currentTarget.value) / 100).catch(notifyError)}
          />
          <span class="mono">{Math.round((run.value?.pace ?? 1) * 100)} %</span>
        </label>
      )}
      <TextSize {...size.value} what="The program" />
      <p role="status" class={isGood.value ? "good" : "soft"}>
        {isGood.value && verdict.value}
        {!isChecked.value && unchecked.value && `Not checked: ${unchecked.value}`}
      </p>
      <Progress />
      {otherRun.value && (
        <p class="problem" role="status">
          Another run moves these axes: <a href={href("runs")}>{otherRun.value.run}</a>. Its motion is not drawn here.
        </p>
      )}
      {next !== null && made && (
        <p class="row">
          {waits(made.parts[next - 1]?.pause_line ?? null, next, made.parts.length)}
          <button type="button" class="primary" disabled={!mayStart.value} onClick={attempt(() => startPart(next))}>
            Go on
          </button>
        </p>
      )}
    </section>
  );
}

/** Words of a drawing that stands between two of its runs. */
function waits(line: number | null, next: number, count: number): string {
  return line === null ? `Run ${next} of ${count} is done.` : `The program waits at line ${line}.`;
}

function Progress() {
  const [now, how] = [run.value, done.value];
  if (!now || !how) return <p class="soft">{drawing.value ? "Not started." : "Nothing is planned."}</p>;
  const state = isPaused.value ? "paused" : now.state;
  return (
    <>
      <progress aria-label="Progress of the drawing" max={1} value={how.share} />
      <p role="status">
        <span class={`pill is-${now.state}`}>{state}</span>{" "}
        <span class="mono">
          {(how.share * 100).toFixed(0)} %{isUnderWay.value && `, line ${how.line}, ${how.left_s.toFixed(1)} s left as planned`}
        </span>
      </p>
      {now.why && <p class="problem">{now.why}</p>}
    </>
  );
}

function Figures() {
  const made = drawing.value;
  if (!made) return null;
  const { figures } = made;
  const units = new Map(made.axes.map(({ letter, unit }) => [letter, unit]));
  const off = deviation.value;
  return (
    <section class="card" aria-label="Figures of the drawing">
      {!isPlanned.value && offered.value === null && <p class="soft">The texts have changed since this was planned.</p>}
      <dl class="path-figures">
        <dt>path</dt>
        <dd class="mono">
          {shown(figures.feed_mm, 1)} mm at a feed, {shown(figures.rapid_mm, 1)} mm rapid
        </dd>
        <dt>time</dt>
        <dd class="mono">
          {shown(figures.duration_s, 1)} s, {figures.lines} lines
        </dd>
        {figures.range.map(([letter, low, high]) => (
          <>
            <dt>{letter.toUpperCase()}</dt>
            <dd class="mono">
              {shown(low, 3)} to {shown(high, 3)} {units.get(letter)}
            </dd>
          </>
        ))}
        <dt>largest deviation</dt>
        <dd class="mono" data-testid="deviation">
          {off ? `${off.largest.toFixed(3)} mm` : "–"}
          {off && !isSeenWhole.value && " of what was seen"}
        </dd>
      </dl>
      {whyNotSeen.value && <p class="problem">{whyNotSeen.value}</p>}
      {!made.isWhole && <p class="soft">Only the beginning of this long path is drawn and compared.</p>}
      {made.remarks.length > 0 && (
        <details>
          <summary>{made.remarks.length === 1 ? "1 remark" : `${made.remarks.length} remarks`}</summary>
          <ul class="problem-list">
            {made.remarks.slice(0, 100).map((remark, at) => (
              <li key={at}>
                <span class="mono">
                  {remark.line}:{remark.column}
                </span>
                <span>{remark.text}</span>
              </li>
            ))}
          </ul>
        </details>
      )}
    </section>
  );
}

/** Views of the path: from above, and from the sides where something moves there. */
function Panes() {
  const made = drawing.value;
  const moves = new Set(made?.figures.range.filter(([, low, high]) => high - low > 1e-9).map(([letter]) => letter));
  const at = (letter: string) => made?.axes.findIndex((axis) => axis.letter === letter) ?? -1;
  const [x, y, z] = [at("x"), at("y"), at("z")];
  const pairs: [number, number][] = [];
  if (x >= 0 && y >= 0) pairs.push([x, y]);
  if (z >= 0 && moves.has("z") && x >= 0) pairs.push([x, z]);
  if (z >= 0 && moves.has("z") && y >= 0) pairs.push([y, z]);
  if (!pairs.length) pairs.push([0, made && made.axes.length > 1 ? 1 : 0]);
  return (
    <>
      {pairs.map(([across, up], number) => (
        <Pane key={`${across} ${up}`} across={across} up={up} isSide={number > 0} />
      ))}
    </>
  );
}

function Pane({ across, up, isSide }: { across: number; up: number; isSide: boolean }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const pane = useRef<PathPane | null>(null);
  const made = drawing.value;
  const way = followed.value;
  useEffect(() => {
    if (!canvas.current) return;
    const it = (pane.current = new PathPane(canvas.current, across, up));
    return () => it.close();
  }, [across, up]);
  useEffect(() => pane.current?.show(made, way), [made, way, across, up]);
  const name = made ? `${made.axes[across]?.letter.toUpperCase()}${made.axes[up]?.letter.toUpperCase()}` : "XY";
  const onKey = (event: KeyboardEvent) => {
    const moves: Record<string, [number, number]> = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] };
    const move = moves[event.key];
    if (move) pane.current?.move(...move);
    else if (event.key === "+") pane.current?.zoom(1.5);
    else if (event.key === "-") pane.current?.zoom(1 / 1.5);
    else if (event.key === "0") pane.current?.fit();
    else return;
    event.preventDefault();
  };
  return (
    <section class={isSide ? "card path-pane is-side" : "card path-pane"} aria-label={`View ${name}`}>
      <div class="card-head">
        <h2>{name}</h2>
        {!isSide && (
          <span class="path-legend soft">
            <i class="is-asked" /> asked for <i class="is-followed" /> followed
          </span>
        )}
        <span class="push row">
          <button type="button" aria-label={`Zoom in, ${name}`} onClick={() => pane.current?.zoom(1.5)}>
            +
          </button>
          <button type="button" aria-label={`Zoom out, ${name}`} onClick={() => pane.current?.zoom(1 / 1.5)}>
            −
          </button>
          <button type="button" aria-label={`Fit ${name}: show all of it`} onClick={() => pane.current?.fit()}>
            Fit
          </button>
        </span>
      </div>
      <canvas ref={canvas} tabIndex={0} role="img" aria-label={`Path asked for and path followed, ${name}; arrows move it, + and − zoom`} onKeyDown={onKey} />
    </section>
  );
}
