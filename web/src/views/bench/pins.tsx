/** The pins of a board as a logic view: a row for each, its level over the last seconds, and switches for inputs. */

import { useEffect, useRef } from "preact/hooks";
import { notifyError } from "../../parts/notices";
import type { DeviceRow } from "../../model/door";
import { link, may } from "../../store";
import { theme } from "../../theme";
import { write } from "../../parts/write";
import { feedOf, LOOKS_HZ } from "./axis_feed";
import { levelOf, type PinRow, pinsOf } from "./axis_fields";
import { LogicTrace } from "./logic_trace";

const VALUES_EVERY_MS = 100;

/** `isWatch`: inputs are looked at, not driven. */
export function Pins({ device, isWatch = false }: { device: DeviceRow; isWatch?: boolean }) {
  const pins = pinsOf(device);
  const fields = [...new Set(pins.map((pin) => pin.field).filter(Boolean))];
  useEffect(() => feedOf(device.name).want(fields), [device.name, fields.join(" ")]);
  return (
    <>
      <p class="soft">The last 5 s, looked at {LOOKS_HZ} times a second: shorter pulses may not be seen.</p>
      <ul class="pins" aria-label={`Pins of ${device.name}`}>
        {pins.map((pin) => (
          <PinView key={pin.name} device={device.name} pin={pin} isWatch={isWatch} />
        ))}
      </ul>
    </>
  );
}

function PinView({ device, pin, isWatch }: { device: string; pin: PinRow; isWatch: boolean }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const level = useRef<HTMLElement>(null);
  useEffect(() => {
    if (!canvas.current || !pin.field) return;
    const feed = feedOf(device);
    const trace = new LogicTrace(canvas.current, feed, pin.field, pin.bit);
    const timer = window.setInterval(() => {
      const value = levelOf(feed.ring.at(feed.column(pin.field), feed.ring.total - 1), pin.bit);
      const text = Number.isFinite(value) ? String(value) : "–";
      write(level.current, text);
    }, VALUES_EVERY_MS);
    return () => {
      window.clearInterval(timer);
      trace.end();
    };
  }, [device, pin.field, pin.bit, theme.value]);
  const drive = (to: number) => link.ask("pin", device, { pin: pin.name, level: to }).catch(notifyError);
  return (
    <li class="pin">
      <span class="mono pin-name" title={pin.meaning}>
        {pin.name}
      </span>
      <span class="mono pin-level" ref={level} />
      {pin.field ? (
        <canvas ref={canvas} class="pin-trace" role="img" aria-label={`Level of ${pin.name} in the last 5 s`} />
      ) : (
        <span class="soft pin-trace">its level is not told</span>
      )}
      {pin.isInput && !isWatch ? (
        <span class="pin-drive" role="group" aria-label={`Drive ${pin.name}`}>
          <button type="button" disabled={!may("operator")} aria-label={`${pin.name} to 0`} onClick={() => void drive(0)}>
            0
          </button>
          <button type="button" disabled={!may("operator")} aria-label={`${pin.name} to 1`} onClick={() => void drive(1)}>
            1
          </button>
        </span>
      ) : (
        <span class="soft pin-drive">{pin.isInput ? "input" : "output"}</span>
      )}
    </li>
  );
}
