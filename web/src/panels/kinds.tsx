/** Kinds of panels: what each shows, of what, and what can be chosen. */

import type { ComponentType } from "preact";
import { givenText, givenTexts, type PanelKind, type PanelRow } from "../model/layout";
import { devices, hello } from "../store";
import { fieldAt, pinsOf, usualFields } from "../views/bench/axis_fields";
import { Fields } from "../views/bench/fields";
import { Gains, hasGains } from "../views/bench/gains";
import { Pins } from "../views/bench/pins";
import { SignalPlot } from "../views/bench/signal_plot";
import { Terminal } from "../views/bench/terminal";
import { Verbs } from "../views/bench/verbs";
import { RunList } from "../views/runs/run_list";
import { EventsBody } from "./bodies/events";
import { FaultsBody } from "./bodies/faults";
import { NumberBody, NumberSettings } from "./bodies/number";
import { PathBody } from "./bodies/path";
import { PictureBody, PictureSettings } from "./bodies/picture";
import { WireBody } from "./bodies/wire";
import { changePanel, keyOf, layout } from "./desk";

export interface BodyProps {
  row: PanelRow;
  /** Without controls: nothing in it changes the bench. */
  isWatch: boolean;
}

export interface Kind {
  title: string;
  about: string;
  Body: ComponentType<BodyProps>;
  Settings?: ComponentType<{ row: PanelRow }>;
  /** Things of this bench that it can show; undefined: it is of the bench. */
  targets?: () => string[];
  /** Whether what it shows is on this bench, where that is not one of the targets. */
  isThere?: (row: PanelRow) => boolean;
  /** Whether it is there to change the bench: a layout without controls has none. */
  isControl?: boolean;
}

const named = (is: (name: string) => boolean) => () => [...devices.value.keys()].filter(is);
const deviceOf = (row: PanelRow) => devices.value.get(row.of)!;

export const KINDS: Record<PanelKind, Kind> = {
  plot: {
    title: "Plot",
    about: "signals of any devices over the time",
    Body: ({ row }) => (
      <SignalPlot
        id={keyOf(row, layout.value)}
        signals={givenTexts(row, "signals")}
        given={row.given}
        onChosen={(settings) => changePanel(row.id, { given: { ...settings } })}
      />
    ),
  },
  number: {
    title: "Number",
    about: "one field, large, with a range that it should keep",
    Body: NumberBody,
    Settings: NumberSettings,
    targets: () => [...devices.value.values()].flatMap(({ name, fields }) => (fields[0] ? [`${name}.${usualField(fields)}`] : [])),
    isThere: (row) => fieldAt(devices.value, row.of) !== null,
  },
  picture: {
    title: "Picture",
    about: "turning shafts, an x-y plate, Walter's arm",
    Body: PictureBody,
    Settings: PictureSettings,
    isThere: (row) => row.of === "" || devices.value.has(row.of),
  },
  events: { title: "Events", about: "what happened, the newest first", Body: EventsBody },
  wire: { title: "Wire", about: "packets of a segment or a CAN bus", Body: WireBody, targets: () => wireNames() },
  terminal: {
    title: "Terminal",
    about: "a port of a board, as a client",
    Body: ({ row }) => <Terminal port={row.of} place={row.id} />,
    targets: () => hello.value?.ports ?? [],
    isControl: true,
  },
  verbs: {
    title: "Verbs",
    about: "what can be asked of a device",
    Body: ({ row }) => <Verbs device={deviceOf(row)} />,
    targets: named((name) => Object.keys(devices.value.get(name)!.verbs).length > 0),
    isControl: true,
  },
  gains: {
    title: "Gains",
    about: "gains of a loop, and its step response",
    Body: ({ row }) => <Gains device={deviceOf(row)} />,
    targets: named((name) => hasGains(devices.value.get(name)!)),
    isControl: true,
  },
  pins: {
    title: "Pins",
    about: "levels of a device's pins",
    Body: ({ row, isWatch }) => <Pins device={deviceOf(row)} isWatch={isWatch} />,
    targets: named((name) => pinsOf(devices.value.get(name)!).length > 0),
  },
  fields: {
    title: "Fields",
    about: "all fields of a device, now",
    Body: ({ row }) => <Fields device={deviceOf(row)} />,
    targets: named((name) => devices.value.get(name)!.fields.length > 0),
    isControl: true,
  },
  faults: { title: "Faults", about: "faults that are active", Body: FaultsBody },
  path: { title: "Path", about: "the bench's drawing, and what its axes follow", Body: PathBody, isThere: () => "drawing" in (hello.value?.operations ?? {}) },
  runs: { title: "Runs", about: "progress of runs", Body: RunList, isControl: true },
};

/** What a new panel is given. */
export function firstGiven(kind: PanelKind): Record<string, unknown> {
  const first = [...devices.peek().values()].find(({ fields }) => fields.length > 0);
  return kind === "plot" && first ? { signals: usualFields(first).map((field) => `${first.name}.${field}`) } : {};
}

function usualField(fields: { name: string }[]): string {
  return (fields.find(({ name }) => name === "position_deg") ?? fields[0]!).name;
}

export function wireNames(): string[] {
  return [...(hello.value?.segments ?? []), ...(hello.value?.buses ?? [])];
}

/** Whether what a panel shows is on this bench. */
export function isThere(row: PanelRow): boolean {
  const { isThere: own, targets } = KINDS[row.kind];
  return own ? own(row) : !targets || targets().includes(row.of);
}

/** Unit at the end of a field's name: the panel has it. */
const UNIT = /_(deg|rpm|Nm|A|V)$/;

/** What stands on a panel's tab. */
export function titleOf(row: PanelRow): string {
  const { title } = KINDS[row.kind];
  if (row.kind === "number") return row.of.replace(UNIT, "") || title;
  if (row.kind === "picture") return row.of || ({ plate: "Plate", arm: "Arm" }[givenText(row, "form")] ?? "Shafts");
  if (row.kind === "plot") return `${title} ${axesText(givenTexts(row, "signals"))}`.trim();
  return row.of ? `${title} ${row.of}` : title;
}

function axesText(signals: string[]): string {
  const axes = [...new Set(signals.map((address) => address.slice(0, address.lastIndexOf("."))))];
  return axes.length > 2 ? `${axes[0]} and ${axes.length - 1} more` : axes.join(", ");
}
