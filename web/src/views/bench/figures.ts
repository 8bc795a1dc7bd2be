/** What the page says of a device or an axis beside its plots, from the bench's status. */

import { computed } from "@preact/signals";
import { happened } from "../../happened";
import { type AxisCard, cardOf, ownerOf } from "../../model/axis_card";
import { marksBefore } from "../../model/bench_events";
import type { DeviceRow } from "../../model/door";
import type { DeviceStatus, Status } from "../../model/status";
import { activeFaults, devices, faultMarks, link, status, statusBefore } from "../../store";

/** Faults that the page saw, and, where it came later, those that the bench tells of before. */
const lastMarks = computed(() => [...marksBefore(happened.value.rows), ...faultMarks.value]);

/** Say how a device or an axis does, by its address. */
export function figuresOf(address: string): AxisCard {
  const device = devices.value.get(address) ?? { name: address, profile: "" };
  return cardFor(device);
}

export function cardFor(device: Pick<DeviceRow, "name" | "profile">): AxisCard {
  const owner = ownerOf(device.name);
  const now = rowOf(status.value, owner);
  const before = rowOf(statusBefore.value, owner);
  return cardOf(device, now, {
    faults: activeFaults.value,
    marks: lastMarks.value,
    problems: status.value.health?.problems ?? [],
    bytes_per_s: now && before ? rate_Hz(now, before) : 0,
    isOpen: link.state.value === "open",
  });
}

function rowOf(told: Status, name: string): DeviceStatus | undefined {
  return told.devices.find((row) => row.device === name);
}

function rate_Hz(now: DeviceStatus, before: DeviceStatus): number {
  const seconds = ((status.value.elapsed_ns ?? 0) - (statusBefore.value.elapsed_ns ?? 0)) / 1e9;
  const bytes = now.rx_bytes + now.tx_bytes - before.rx_bytes - before.tx_bytes;
  return seconds > 0 && bytes > 0 ? bytes / seconds : 0;
}
