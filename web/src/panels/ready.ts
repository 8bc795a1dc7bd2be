/** Ready layouts, made of what a bench has. */

import { emptyLayout, type Layout, type PanelRow, panel, type Place, split, tabs } from "../model/layout";
import type { DeviceRow } from "../model/door";
import type { Hello } from "../net/protocol";
import { pinsOf, usualFields } from "../views/bench/axis_fields";
import { hasGains } from "../views/bench/gains";

interface Ready {
  id: string;
  title: string;
  about: string;
  /** Whether there is one for each of some devices. */
  of(bench: Hello): string[];
  isThere(bench: Hello): boolean;
  make(bench: Hello, of: string): { root: Place | null; isColumn: boolean; isWatch?: boolean };
}

/** So many shafts and lines are seen at a glance. */
const FEW = 6;
const SOME = 12;

const READY: Ready[] = [
  {
    id: "bench",
    title: "Bench",
    about: "Shafts, plots, verbs, a terminal, events.",
    of: () => [],
    isThere: () => true,
    make: (bench) => {
      const [first] = movers(bench);
      const ports = bench.ports.slice(0, 3).map((port) => panel("terminal", port));
      const root = split(
        [30, split([55, tabs(...shafts(bench))], [45, tabs(panel("events"), panel("faults"))])],
        [42, split([60, first ? tabs(plotOf(first, ["deg", "rpm"])) : null], [40, positions(bench)])],
        [28, split([50, first ? tabs(panel("verbs", first.name), ...pins(bench)) : null], [50, ports.length ? tabs(...ports) : null])],
      );
      return { root, isColumn: false };
    },
  },
  {
    id: "tuning",
    title: "Tuning",
    about: "One loop: its plot, figures, gains and verbs.",
    of: (bench) => bench.devices.filter(hasGains).map(({ name }) => name),
    isThere: (bench) => bench.devices.some(hasGains),
    make: (bench, of) => {
      const tuned = bench.devices.filter(hasGains);
      const device = tuned.find(({ name }) => name === of) ?? tuned[0];
      if (!device) return { root: null, isColumn: false };
      const names = device.fields.map(({ name }) => name);
      const number = (field: string): [number, Place | null] => [1, names.includes(field) ? tabs(panel("number", `${device.name}.${field}`)) : null];
      const figures = split(number("position_deg"), number("e"), number("velocity_rpm"));
      const root = split(
        [58, tabs(plotOf(device))],
        [42, split([18, figures], [52, tabs(panel("gains", device.name))], [30, tabs(panel("verbs", device.name), panel("terminal", device.name))])],
      );
      return { root, isColumn: false };
    },
  },
  {
    id: "bus",
    title: "Bus",
    about: "Packets of each wire, with terminals, faults and events.",
    of: () => [],
    isThere: (bench) => wires(bench).length > 0,
    make: (bench) => {
      const all = wires(bench);
      const lines = all.slice(0, 2).map((name): [number, Place] => [1, tabs(panel("wire", name))]);
      const more = all.slice(2, SOME).map((name) => panel("wire", name));
      if (more.length) (lines[1]![1] as { tabs: PanelRow[] }).tabs.push(...more);
      const ports = [...bench.ports].sort((one, other) => Number(isOfWire(other, all)) - Number(isOfWire(one, all)));
      const root = split(
        [64, split(...lines)],
        [36, split([45, tabs(...ports.slice(0, 3).map((port) => panel("terminal", port)))], [25, tabs(panel("faults"))], [30, tabs(panel("events"))])],
      );
      return { root, isColumn: false };
    },
  },
  {
    id: "cell",
    title: "Cell",
    about: "A machine at work: its picture, path, runs and events.",
    of: () => [],
    isThere: (bench) => movers(bench).length > 1,
    make: (bench) => {
      const path = "drawing" in bench.operations ? [panel("path")] : [];
      const root = split(
        [50, split([62, tabs(...pictures(bench))], [38, positions(bench)])],
        [50, split([50, tabs(...path)], [25, tabs(panel("runs"))], [25, tabs(panel("events"))])],
      );
      return { root, isColumn: false };
    },
  },
  {
    id: "wall",
    title: "Wall",
    about: "For a screen that many look at: nothing in it changes the bench.",
    of: () => [],
    isThere: () => true,
    make: (bench) => {
      const numbers = movers(bench)
        .slice(0, 4)
        .map((device): [number, Place] => [1, tabs(panel("number", `${device.name}.position_deg`))]);
      const lines = wires(bench).slice(0, 2);
      const root = split(
        [20, split(...numbers)],
        [50, split([45, tabs(...pictures(bench).slice(0, 1))], [55, positions(bench)])],
        [30, split([40, tabs(panel("events"))], ...lines.map((name): [number, Place] => [30, tabs(panel("wire", name))]), [30, tabs(panel("faults"))])],
      );
      return { root, isColumn: true, isWatch: true };
    },
  },
];

/** Ready layouts that this bench has something for. */
export function readyOnes(bench: Hello): Ready[] {
  return READY.filter((ready) => ready.isThere(bench));
}

/** Make a ready layout, for a device where it is of one; null: there is none such. */
export function readyLayout(bench: Hello, id: string, of: string): Layout | null {
  const ready = readyOnes(bench).find((each) => each.id === id);
  if (!ready || (of && !ready.of(bench).includes(of))) return null;
  const made = ready.make(bench, of);
  return { ...emptyLayout(bench.bench, of ? `${ready.title} ${of}` : ready.title), isWatch: false, ...made };
}

/** Devices and axes with a shaft; joints of an arm are behind the others: they are one machine. */
function movers(bench: Hello): DeviceRow[] {
  const all = bench.devices.filter(({ fields }) => fields.some(({ name }) => name === "position_deg"));
  return [...all.filter((device) => device.profile !== "walter"), ...all.filter((device) => device.profile === "walter")];
}

function arms(bench: Hello): string[] {
  return bench.devices.filter(({ name, profile }) => profile === "walter" && !name.includes(".")).map(({ name }) => name);
}

function wires(bench: Hello): string[] {
  return [...bench.segments, ...bench.buses];
}

function isOfWire(port: string, all: string[]): boolean {
  return all.some((wire) => port === wire || port.startsWith(`${wire}.`));
}

/** Plot of an axis; `units`: of those alone. */
function plotOf(device: DeviceRow, units?: readonly string[]): PanelRow {
  const isShown = (name: string) => !units || units.includes(device.fields.find((field) => field.name === name)?.unit ?? "");
  const names = usualFields(device).filter(isShown);
  return panel("plot", "", { signals: names.map((field) => `${device.name}.${field}`) });
}

/** One plot of the positions of some axes. */
function positions(bench: Hello): Place | null {
  const signals = movers(bench)
    .slice(0, FEW)
    .map(({ name }) => `${name}.position_deg`);
  return signals.length ? tabs(panel("plot", "", { signals })) : null;
}

function shafts(bench: Hello): PanelRow[] {
  return movers(bench).length ? [panel("picture", "", { form: "shafts" }), ...arms(bench).map((name) => panel("picture", name, { form: "arm" }))] : [];
}

function pictures(bench: Hello): PanelRow[] {
  const arm = arms(bench).map((name) => panel("picture", name, { form: "arm" }));
  const [x, y] = movers(bench).filter(({ profile }) => profile !== "walter");
  const plate = x && y ? [panel("picture", "", { form: "plate", x: x.name, y: y.name })] : [];
  return [...arm, ...plate, panel("picture", "", { form: "shafts" })];
}

function pins(bench: Hello): PanelRow[] {
  return bench.devices
    .filter((device) => pinsOf(device).length > 0)
    .slice(0, 1)
    .map(({ name }) => panel("pins", name));
}
