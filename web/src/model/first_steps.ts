/** Three things to try on a bench that one sees for the first time, each with the command that does it in a shell: of what
 * this bench really has, and nothing that would be refused. Pure. */

import type { DeviceRow, FaultKindRow, Role } from "./door";
import { snapshotOf } from "./axis_card";
import type { Status } from "./status";

export interface Request {
  operation: "do" | "inject";
  target: string;
  given: Record<string, unknown>;
}

export interface FirstStep {
  kind: "turn" | "type" | "break";
  title: string;
  about: string;
  /** Lines for a shell. */
  commands: string[];
  /** What the page asks for; none: the terminal of `device` is opened. */
  requests: Request[];
  device: string;
}

const ANGLE_DEG = 90;
const JAM = "shaft_jam";
const JAM_S = 3;

interface Bench {
  bench: string;
  devices: readonly DeviceRow[];
  ports: readonly string[];
  fault_kinds: readonly FaultKindRow[];
}

export function firstSteps(bench: Bench, status: Status, may: (role: Role) => boolean): FirstStep[] {
  const steps = [turn(bench, status, may), type(bench, status, may), breakIt(bench, status, may)];
  return steps.filter((step) => step !== null);
}

/** Turn an axis: the first simulated one whose board can be told to, switched on before. */
function turn(bench: Bench, status: Status, may: (role: Role) => boolean): FirstStep | null {
  const device = bench.devices.find((each) => isWell(each, status) && each.verbs["move_rel"] && may(each.verbs["move_rel"].role));
  const angle = device?.verbs["move_rel"]?.parameters.find(({ unit }) => unit === "deg");
  if (!device || !angle) return null;
  const { name } = device;
  const isOff = device.verbs["enable"] !== undefined;
  const verb = (verbName: string, parameters: Record<string, unknown>): Request => ({
    operation: "do",
    target: name,
    given: { name: verbName, parameters },
  });
  return {
    kind: "turn",
    title: isOff ? `Enable ${name} and turn it by ${ANGLE_DEG} degrees` : `Turn ${name} by ${ANGLE_DEG} degrees`,
    about: isOff ? "Its control loop begins, then its shaft goes on by a quarter turn." : "Its shaft goes on by a quarter turn.",
    commands: [...(isOff ? [`hil axis ${name} enable`] : []), `hil axis ${name} move-rel ${ANGLE_DEG}`],
    requests: [...(isOff ? [verb("enable", {})] : []), verb("move_rel", { [angle.name]: ANGLE_DEG })],
    device: name,
  };
}

/** What has to be done before a step that was refused: a new servo has to be calibrated, with its loop off. */
export function stepBefore({ device }: FirstStep, why: string): Pick<FirstStep, "title" | "commands" | "requests"> | null {
  if (!/calibrate/.test(why)) return null;
  const verbs = ["disable", "calibrate"];
  return {
    title: `Calibrate ${device}, 26 s`,
    commands: verbs.map((name) => `hil axis ${device} ${name}`),
    requests: verbs.map((name) => ({ operation: "do", target: device, given: { name, parameters: {} } })),
  };
}

/** Type at a board: one that answers at once, another one than is turned where there is one. */
function type(bench: Bench, status: Status, may: (role: Role) => boolean): FirstStep | null {
  if (!may("operator")) return null;
  const rows = status.devices.filter((row) => row.greeting && !row.failed && row.clients === 0 && bench.ports.includes(row.device));
  const row = rows.find(({ device }) => bench.devices.find(({ name }) => name === device)?.verbs["enable"] === undefined) ?? rows[0];
  if (!row) return null;
  const key = row.greeting.replace(/[\r\n]+$/, "");
  const enter = key === row.greeting ? "" : " --enter";
  const keys = `${key || ""}${enter ? `${key ? " and " : ""}Enter` : ""}`;
  return {
    kind: "type",
    title: `Type at ${row.device}`,
    about: `Press ${keys} in its terminal: the board answers, as at its real serial port.`,
    commands: [`hil type ${row.device} '${key}'${enter}`],
    requests: [],
    device: row.device,
  };
}

/** Break something that mends itself. */
function breakIt(bench: Bench, status: Status, may: (role: Role) => boolean): FirstStep | null {
  if (!may("admin") || !bench.fault_kinds.some(({ name }) => name === JAM)) return null;
  const shafts = bench.devices.filter((each) => isWell(each, status) && each.fields.some(({ name }) => name === "position_deg"));
  const device = shafts[0];
  if (!device) return null;
  return {
    kind: "break",
    title: "Break something",
    about: `The shaft of ${device.name} jams for ${JAM_S} s. Turn it meanwhile, and see what its board makes of it.`,
    commands: [`hil fault inject ${JAM} ${device.name} for_s=${JAM_S}`],
    requests: [{ operation: "inject", target: device.name, given: { fault: JAM, parameters: { for_s: JAM_S } } }],
    device: device.name,
  };
}

/** A simulated axis whose board runs. */
function isWell(device: DeviceRow, status: Status): boolean {
  const row = status.devices.find((each) => each.device === device.name.split(".")[0]);
  return !device.is_real && device.is_seen && row !== undefined && row.failed === null && snapshotOf(row, device.name) !== null;
}
