/** Types of what the door tells. */

export interface ParameterRow {
  name: string;
  about?: string;
  type?: string;
  unit?: string;
  minimum?: number | null;
  maximum?: number | null;
  default?: unknown;
  choices?: string[];
  is_text?: boolean;
  is_whole?: boolean;
  is_optional?: boolean;
  limits?: string;
}

export interface VerbRow {
  summary: string;
  role: Role;
  parameters: ParameterRow[];
}

export interface FieldRow {
  name: string;
  type: string;
  unit: string;
  meaning: string;
  is_settable: boolean;
  is_state: boolean;
}

export interface DeviceRow {
  name: string;
  profile: string;
  is_real: boolean;
  verbs: Record<string, VerbRow>;
  fields: FieldRow[];
  /** Pins that may be driven, and the field that tells each one's level; empty: none does. */
  inputs: Record<string, string>;
}

export interface FaultKindRow {
  name: string;
  layer: string;
  target: string;
  about: string;
  is_once?: boolean;
  parameters: ParameterRow[];
}

/** Segment: `framing` is "sac" or "modbus_rtu", or another that a profile brings. */
export interface LineRow {
  name: string;
  framing: string;
  baud: number;
  format: string;
}

export type Role = "viewer" | "operator" | "admin";

export interface Hello {
  protocol: number;
  version: string;
  bench: string;
  /** Another one for each start of the bench. */
  instance: string;
  /** Bytes that a message of this page may have. */
  message_bytes: number;
  user: string;
  role: Role;
  devices: DeviceRow[];
  segments: string[];
  /** Framing and speed of each segment, by its name. */
  lines: ReadonlyMap<string, LineRow>;
  buses: string[];
  ports: string[];
  operations: Record<string, unknown>;
  fault_kinds: FaultKindRow[];
}
