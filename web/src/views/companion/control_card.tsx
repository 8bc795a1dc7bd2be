/** Stop, next, loops, continuous motion, soft_ops, calibration: what the original has as buttons. */

import type { BoardSession } from "./board_session";
import { CALIBRATION_RPM, CALIBRATION_S, factorText } from "./calibration";
import { boardForms } from "./kept_board";
import { stepAtOneRpm_us } from "./queue_row";

interface Props {
  session: BoardSession;
  isDisabled: boolean;
}

export function ControlCard({ session, isDisabled }: Props) {
  const send = (line: string, text: string, about: string) => (
    <button type="button" disabled={isDisabled} title={`${about} (${line})`} onClick={() => void session.type(line)}>
      {text}
    </button>
  );
  const pulse = (sign: "+" | "-", text: string, about: string) => (
    <button type="button" disabled={isDisabled} aria-label={`${text}: ${about}`} title={about} onClick={() => session.pulse(sign)}>
      {text}
    </button>
  );
  return (
    <section class="card" aria-labelledby="control-title">
      <h2 id="control-title" class="out-of-sight">
        Control
      </h2>
      <div class="stops">
        <button type="button" class="stop" disabled={isDisabled} title="Stop at once; nothing goes on (S)" onClick={() => void session.stop("S")}>
          Stop now
        </button>
        <button type="button" disabled={isDisabled} title="End the command at once, then the next one (N)" onClick={() => void session.type("N")}>
          Next now
        </button>
        <button type="button" disabled={isDisabled} title="Stop with the session's deceleration (s)" onClick={() => void session.stop("s")}>
          Slow stop
        </button>
        <button type="button" disabled={isDisabled} title="End the command with its deceleration, then the next one (n)" onClick={() => void session.type("n")}>
          Slow next
        </button>
      </div>
      <div class="row tools">
        {send("y", "Release sync", "Release what waits for the sync")}
        {pulse("+", "+1", "One pulse clockwise")}
        {pulse("-", "−1", "One pulse counter-clockwise")}
        <OpsSwitch session={session} isDisabled={isDisabled} />
        <GapSwitch session={session} isDisabled={isDisabled} />
      </div>
      <LoopBox session={session} isDisabled={isDisabled} />
      <RunRow session={session} isDisabled={isDisabled} />
      <Continuous session={session} isDisabled={isDisabled} />
      <Calibrate session={session} isDisabled={isDisabled} />
    </section>
  );
}

function OpsSwitch({ session, isDisabled }: Props) {
  const isOn = session.isOpsOn;
  return (
    <button
      type="button"
      aria-pressed={isOn}
      disabled={isDisabled}
      onClick={() => void session.type(isOn ? "$O0" : "$O1")}
      title="soft_ops: the board tells by DC1 and DC2 when a command begins and ends. Switching ends all motion."
    >
      Ops {isOn ? "on" : "off"}
    </button>
  );
}

function GapSwitch({ session, isDisabled }: Props) {
  const isOn = session.settings.value["GAP"] === "1";
  return (
    <button
      type="button"
      aria-pressed={isOn}
      disabled={isDisabled}
      onClick={() => void session.type("g")}
      title="GAP testing: whether a late command begins from slow speed (g)"
    >
      GAP {isOn ? "on" : "off"}
    </button>
  );
}

/** Start and finish are registered one by one, by a double click or Enter in their box, or both by Start. */
function LoopBox({ session, isDisabled }: Props) {
  const [start, setStart] = boardForms.field(session.port, "start", "1");
  const [finish, setFinish] = boardForms.field(session.port, "finish", "2");
  const [passes, setPasses] = boardForms.field(session.port, "loop passes", "0");
  const { loop } = session.motion.value;
  const isRow = (text: string) => /^\d+$/.test(text) && Number(text) >= 1 && Number(text) <= 30;
  const isGood = isRow(start) && isRow(finish) && Number(start) !== Number(finish);
  const arePassesGood = /^\d+$/.test(passes) && Number(passes) <= 65535;
  const register = (line: string, text: string) => isRow(text) && void session.type(line + Number(text));
  const run = async () => {
    await session.type(`ln${Number(passes)}`);
    await session.type(`ls${Number(start)}`);
    await session.type(`lf${Number(finish)}`);
  };
  const box = (label: string, line: string, text: string, put: (text: string) => void) => (
    <label>
      {label}
      <input
        class="small"
        inputMode="numeric"
        value={text}
        disabled={isDisabled}
        aria-invalid={!isRow(text)}
        title={`1 to 30; Enter or a double click registers it (${line})`}
        onInput={(event) => put(event.currentTarget.value)}
        onDblClick={() => register(line, text)}
        onKeyDown={(event) => event.key === "Enter" && register(line, text)}
      />
    </label>
  );
  return (
    <fieldset>
      <legend>Loop{loop.isOn ? ` ${loop.start} to ${loop.finish} runs` : ""}</legend>
      <div class="row">
        {box("Start", "ls", start, setStart)}
        {box("Finish", "lf", finish, setFinish)}
        <label>
          Passes
          <input
            class="small"
            inputMode="numeric"
            value={passes}
            disabled={isDisabled}
            aria-invalid={!arePassesGood}
            title="0: until it is stopped; up to 65535"
            onInput={(event) => setPasses(event.currentTarget.value)}
          />
        </label>
        <button type="button" class="primary" disabled={isDisabled || !isGood || !arePassesGood} onClick={() => void run()}>
          Start loop
        </button>
        <button type="button" disabled={isDisabled} title="The loop ends with the command that runs (l)" onClick={() => void session.type("l")}>
          Finish loop
        </button>
        <button type="button" disabled={isDisabled} title="Loop over the whole queue (la)" onClick={() => void session.type("la")}>
          All
        </button>
      </div>
    </fieldset>
  );
}

/** Rows at once, and lists of rows: xRef. */
function RunRow({ session, isDisabled }: Props) {
  const [row, setRow] = boardForms.field(session.port, "row", "1");
  const [list, setList] = boardForms.field(session.port, "list");
  const [passes, setPasses] = boardForms.field(session.port, "list passes", "1");
  const isRow = /^\d+$/.test(row) && Number(row) >= 1 && Number(row) <= 30;
  const rows = list
    .split(/[\s,]+/)
    .filter(Boolean)
    .map(Number);
  const isList = rows.length > 0 && rows.length <= 30 && rows.every((each) => Number.isInteger(each) && each >= 1 && each <= 30);
  const arePassesGood = /^\d+$/.test(passes) && Number(passes) <= 65535;
  const runList = async () => {
    const lines = ["xp", ...[...rows, 0].slice(0, 30).map((each, index) => `${index},${each}`), "x", `xl${Number(passes)}`];
    for (const line of lines) if (!(await session.type(line))) return;
  };
  return (
    <fieldset>
      <legend>Rows at once (xRef)</legend>
      <div class="row">
        <label>
          Row
          <input
            class="small"
            inputMode="numeric"
            value={row}
            disabled={isDisabled}
            aria-invalid={!isRow}
            onInput={(event) => setRow(event.currentTarget.value)}
          />
        </label>
        <button type="button" disabled={isDisabled || !isRow} title="Run this row now, then go on (x)" onClick={() => void session.type(`x${Number(row)}`)}>
          Run row
        </button>
        <label>
          List
          <input
            value={list}
            placeholder="1 3 7 5"
            disabled={isDisabled}
            aria-invalid={list !== "" && !isList}
            title="up to 30 rows, in any order"
            onInput={(event) => setList(event.currentTarget.value)}
          />
        </label>
        <label>
          Passes
          <input
            class="small"
            inputMode="numeric"
            value={passes}
            disabled={isDisabled}
            aria-invalid={!arePassesGood}
            title="0: until it is stopped"
            onInput={(event) => setPasses(event.currentTarget.value)}
          />
        </label>
        <button
          type="button"
          disabled={isDisabled || !isList || !arePassesGood}
          title="Program the xRef array and run it (xp, xl)"
          onClick={() => void runList()}
        >
          Run list
        </button>
      </div>
    </fieldset>
  );
}

/** Continuous motion: the slider retargets it, by the RPM or finely by the cycle. */
function Continuous({ session, isDisabled }: Props) {
  const [rpmText, setRpm] = boardForms.field(session.port, "rpm", "100");
  const [trimText, setTrim] = boardForms.field(session.port, "trim_us", "0");
  const [rpm, trim_us] = [Math.max(Number(rpmText) || 100, 1), Number(trimText) || 0];
  const isOn = session.motion.value.running === "continuous";
  const cycle_us = Math.max(Math.floor(stepAtOneRpm_us(session.queue.value.steps_per_rev) / rpm) + trim_us, 2);
  const slide = (nextRpm: number, nextTrim_us: number) => {
    setRpm(String(nextRpm));
    setTrim(String(nextTrim_us));
    if (!isOn || isDisabled) return;
    const cycle = Math.max(Math.floor(stepAtOneRpm_us(session.queue.value.steps_per_rev) / nextRpm) + nextTrim_us, 2);
    session.retarget(nextTrim_us ? `vc${cycle}` : `v${nextRpm}`);
  };
  return (
    <fieldset>
      <legend>Continuous{isOn ? " runs" : ""}</legend>
      <div class="row sliders">
        <label>
          {rpm} RPM
          <input
            type="range"
            min={1}
            max={600}
            value={rpm}
            disabled={isDisabled}
            aria-label="Velocity in RPM"
            onInput={(event) => slide(Number(event.currentTarget.value), 0)}
          />
        </label>
        <label>
          {cycle_us} us
          <input
            type="range"
            min={-100}
            max={100}
            value={trim_us}
            disabled={isDisabled}
            aria-label="Fine adjustment of the cycle in us"
            onInput={(event) => slide(rpm, Number(event.currentTarget.value))}
          />
        </label>
        <button
          type="button"
          disabled={isDisabled}
          title="Turn clockwise until it is stopped"
          onClick={() => void session.type(`xm0v${trim_us ? `c${cycle_us}` : rpm}`)}
        >
          CW
        </button>
        <button
          type="button"
          disabled={isDisabled}
          title="Turn counter-clockwise until it is stopped"
          onClick={() => void session.type(`xm-0v${trim_us ? `c${cycle_us}` : rpm}`)}
        >
          CCW
        </button>
      </div>
    </fieldset>
  );
}

function Calibrate({ session, isDisabled }: Props) {
  const now = session.calibrator.running.value;
  const board = session.configuration.value;
  const found = session.calibrator.results.value;
  const remedies = [...found.values()].filter(({ remedy }) => remedy);
  const last = remedies.at(-1);
  return (
    <fieldset>
      <legend>Calibrate: one minute at</legend>
      <div class="row">
        {CALIBRATION_RPM.map((rpm) => {
          const result = found.get(rpm);
          const caption = now?.rpm === rpm ? `${Math.floor(now.elapsed_s)} of ${CALIBRATION_S} s` : result ? result.factor.toFixed(6) : String(rpm);
          return (
            <button
              key={rpm}
              type="button"
              disabled={isDisabled || now !== undefined}
              onClick={() => board && void session.calibrator.run(rpm, board)}
              aria-label={`Calibrate at ${rpm} RPM${result ? `: factor ${factorText(result)}` : ""}`}
              title={result ? `${rpm} RPM: factor ${factorText(result)}; ${result.judgement}` : `Run a minute at ${rpm} RPM without a ramp, and time it`}
            >
              {caption}
            </button>
          );
        })}
        {now && <progress value={now.elapsed_s} max={CALIBRATION_S} aria-label={`Calibration at ${now.rpm} RPM`} />}
        {last && (
          <button
            type="button"
            disabled={isDisabled || now !== undefined}
            title={`${last.judgement}: sent to the board, which starts anew`}
            onClick={() => void session.correct(last.remedy)}
          >
            Correct: {last.remedy}
          </button>
        )}
      </div>
      {last && (
        <p class="soft">
          {last.rpm} RPM: {last.judgement}.
        </p>
      )}
    </fieldset>
  );
}
