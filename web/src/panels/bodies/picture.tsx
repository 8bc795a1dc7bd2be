/** Picture of a mechanism, drawn from fields: shafts that turn, an x-y plate, Walter's arm. */

import { useEffect, useRef, useState } from "preact/hooks";
import { givenNumber, givenText, givenTexts, type PanelRow } from "../../model/layout";
import { shown } from "../../model/numbers";
import { MM_PER_TURN, type PlateAxis, placeOf, plateAxis } from "../../model/plate";
import { boardAngleOf } from "../../model/sampled_places";
import { onFrames, Sight } from "../../parts/frames";
import { notifyError } from "../../parts/notices";
import { pastAt } from "../../past";
import { devices, link, status } from "../../store";
import { theme } from "../../theme";
import { setpointOf } from "../../views/bench/axis_fields";
import { drawing, follow } from "../../views/path/path_state";
import { changePanel, give } from "../desk";
import type { BodyProps } from "../kinds";
import { Choice } from "../panel";
import { shaftNames, useFields, valueAt } from "../values";
import { ArmPicture } from "./arm";
import { drawPlate } from "./plate";
import { drawShafts, type Shaft } from "./shafts";

const SAY_EVERY_MS = 2000;
/** More would be too small to be seen. */
const MOST_SHAFTS = 24;
const TRAIL_POINTS = 400;

export function PictureBody({ row }: BodyProps) {
  const form = givenText(row, "form", "shafts");
  if (form === "plate") return <PlatePicture row={row} />;
  if (form === "arm") return <ArmPicture arm={row.of} />;
  return <ShaftsPicture row={row} />;
}

/** Names of the shafts that a panel shows; without a choice all. */
function shaftsOf(row: PanelRow): string[] {
  const chosen = givenTexts(row, "axes");
  const there = shaftNames();
  return (chosen.length ? chosen.filter((name) => there.includes(name)) : there).slice(0, MOST_SHAFTS);
}

function ShaftsPicture({ row }: { row: PanelRow }) {
  const names = shaftsOf(row);
  const setpoints = names.map((name) => setpointOf(devices.value.get(name)!));
  useFields(names.flatMap((name, at) => [`${name}.position_deg`, ...(setpoints[at] ? [`${name}.${setpoints[at]}`] : [])]));
  const shafts = (): Shaft[] =>
    names.map((name, at) => ({
      name,
      at_deg: valueAt(`${name}.position_deg`),
      // Of a loop in velocity mode the set-point is no angle, and a board may have another zero: only ramps in degrees are shown.
      to_deg: setpoints[at] && setpoints[at] !== "r" ? valueAt(`${name}.${setpoints[at]}`) : NaN,
    }));
  const all = shaftNames().length;
  if (!names.length) return <p class="empty">No device of this bench has a shaft.</p>;
  return (
    <>
      <Picture
        say={() => shafts().map(({ name, at_deg }) => `${name} ${shown(at_deg, 1)} deg`)}
        what="Shafts"
        draw={(context, width, height) => drawShafts(context, width, height, shafts())}
      />
      {all > names.length && !givenTexts(row, "axes").length && (
        <p class="soft">
          The first {names.length} of {all} shafts.
        </p>
      )}
    </>
  );
}

/** Axes of the plate: those of the panel, else of the machine of the bench's drawing, else the first two shafts. */
function plateOf(row: PanelRow): [PlateAxis, PlateAxis] {
  const machine = drawing.value?.axes ?? [];
  const mm_per_turn = givenNumber(row, "mm_per_turn");
  const [first, second] = shaftNames();
  return [plateAxis("x", givenText(row, "x"), mm_per_turn, machine, first), plateAxis("y", givenText(row, "y"), mm_per_turn, machine, second)];
}

/** Address of an axis's angle: by the zero of its board, where a machine counts from it. */
function angleOf({ name, range_mm }: PlateAxis): string {
  const board = range_mm && boardAngleOf(devices.value.get(name)?.fields ?? []);
  return `${name}.${board || "position_deg"}`;
}

function PlatePicture({ row }: { row: PanelRow }) {
  const [x, y] = plateOf(row);
  const addresses = [angleOf(x), angleOf(y)] as const;
  const trail = useRef<[number, number][]>([]);
  const theirs = status.value.drawing;
  useEffect(() => void follow().catch(notifyError), [link.connections.value, theirs]);
  useFields(addresses);
  useEffect(() => void (trail.current = []), [JSON.stringify([x, y]), pastAt.value === null]);
  const now = (): [number, number] => [placeOf(x, valueAt(addresses[0])), placeOf(y, valueAt(addresses[1]))];
  const missing = [x.name, y.name].filter((name) => !devices.value.has(name));
  if (missing.length) return <p class="problem">This bench has no {missing.join(", ") || "two shafts"}: choose others in the settings.</p>;
  const draw = (context: CanvasRenderingContext2D, width: number, height: number) => {
    const at = now();
    const last = trail.current.at(-1);
    if (Number.isFinite(at[0]) && Number.isFinite(at[1]) && (!last || Math.hypot(at[0] - last[0], at[1] - last[1]) > 0.1)) {
      trail.current.push(at);
      if (trail.current.length > TRAIL_POINTS) trail.current.shift();
    }
    drawPlate(context, width, height, { at, trail: trail.current, x, y });
  };
  return <Picture what={`Plate of ${x.name} and ${y.name}`} say={() => now().map((mm) => `${shown(mm, 1)} mm`)} draw={draw} />;
}

interface PictureProps {
  what: string;
  /** What stands there, in words. */
  say(): string[];
  draw(context: CanvasRenderingContext2D, width: number, height: number): void;
}

/** A canvas that is drawn again while it is in sight and something has changed. */
export function Picture({ what, say, draw }: PictureProps) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const [said, setSaid] = useState("");
  const newest = useRef({ say, draw });
  newest.current = { say, draw };
  useEffect(() => {
    const element = canvas.current!;
    const sight = new Sight(element);
    let drawn = "";
    const stateNow = () => `${newest.current.say().join()} ${element.clientWidth} ${element.clientHeight} ${theme.peek()}`;
    const end = onFrames({
      isDue: () => sight.isIn && stateNow() !== drawn,
      draw: () => {
        drawn = stateNow();
        const context = fitted(element);
        if (context) newest.current.draw(context, element.clientWidth, element.clientHeight);
      },
    });
    const tell = () => setSaid(newest.current.say().join(", "));
    tell();
    const timer = window.setInterval(tell, SAY_EVERY_MS);
    return () => {
      window.clearInterval(timer);
      end();
      sight.end();
    };
  }, [theme.value]);
  return <canvas ref={canvas} class="panel-canvas" role="img" aria-label={`${what}: ${said}`} />;
}

/** Context of a canvas in pixels of the page, empty. */
function fitted(canvas: HTMLCanvasElement): CanvasRenderingContext2D | null {
  const ratio = window.devicePixelRatio || 1;
  const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const context = canvas.getContext("2d");
  context?.setTransform(ratio, 0, 0, ratio, 0, 0);
  context?.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  return context;
}

const FORMS = { shafts: "turning shafts", plate: "x-y plate", arm: "Walter's arm" };

export function PictureSettings({ row }: { row: PanelRow }) {
  const form = givenText(row, "form", "shafts") as keyof typeof FORMS;
  const arms = [...devices.value.values()].filter(({ name, profile }) => profile === "walter" && !name.includes(".")).map(({ name }) => name);
  const forms = Object.keys(FORMS).filter((each) => each !== "arm" || arms.length > 0) as (keyof typeof FORMS)[];
  const byText = new Map(forms.map((each) => [FORMS[each], each]));
  const chooseForm = (text: string) => {
    const next = byText.get(text) ?? "shafts";
    changePanel(row.id, { of: next === "arm" ? (arms[0] ?? "") : "", given: { ...row.given, form: next } });
  };
  const [x, y] = plateOf(row);
  return (
    <>
      <Choice label="Picture" value={FORMS[form] ?? ""} options={[...byText.keys()]} onChange={chooseForm} />
      {form === "arm" && <Choice label="Arm" value={row.of} options={arms} onChange={(of) => changePanel(row.id, { of })} />}
      {form === "plate" && (
        <>
          <Choice label="x" value={x.name} options={shaftNames()} onChange={(name) => give(row, { x: name })} />
          <Choice label="y" value={y.name} options={shaftNames()} onChange={(name) => give(row, { y: name })} />
          <label class="row">
            mm a turn
            <input
              class="mono is-bound"
              inputMode="decimal"
              placeholder={x.range_mm ? "of the machine" : String(MM_PER_TURN)}
              value={String(givenNumber(row, "mm_per_turn") ?? "")}
              onInput={(event) => {
                const number = Number(event.currentTarget.value);
                if (!event.currentTarget.value.trim()) give(row, { mm_per_turn: undefined });
                else if (number > 0 && Number.isFinite(number)) give(row, { mm_per_turn: number });
              }}
            />
          </label>
        </>
      )}
      {form === "shafts" && <ShaftChoice row={row} />}
    </>
  );
}

/** Which shafts are shown. */
function ShaftChoice({ row }: { row: PanelRow }) {
  const chosen = shaftsOf(row);
  const toggle = (name: string) => give(row, { axes: chosen.includes(name) ? chosen.filter((each) => each !== name) : [...chosen, name] });
  return (
    <fieldset class="row">
      <legend class="out-of-sight">Shafts</legend>
      {shaftNames().map((name) => (
        <label key={name}>
          <input type="checkbox" checked={chosen.includes(name)} onChange={() => toggle(name)} /> {name}
        </label>
      ))}
    </fieldset>
  );
}
