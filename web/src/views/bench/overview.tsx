/** All axes of the bench at a glance: state, rate, lag, a strip of the last seconds. */

import { useEffect, useRef } from "preact/hooks";
import { byteRate, shown } from "../../model/numbers";
import type { DeviceRow } from "../../model/door";
import { href } from "../../router";
import { devices } from "../../store";
import { theme } from "../../theme";
import { feedOf } from "./axis_feed";
import { figuresOf } from "./figures";
import { Strip } from "./strip";

const VALUES_EVERY_MS = 150;

export function Overview() {
  const all = [...devices.value.values()];
  if (!all.length) return <p class="empty">This bench has no devices.</p>;
  return (
    <ul class="cards" aria-label="Devices of the bench">
      {all.map((device) => (
        <li key={device.name}>
          <DeviceCard device={device} />
        </li>
      ))}
    </ul>
  );
}

function DeviceCard({ device }: { device: DeviceRow }) {
  const figures = figuresOf(device.name);
  return (
    <article class={`card device is-${figures.state}`} aria-label={device.name}>
      <div class="device-head">
        <a class="device-name" href={href("bench", device.name)} title={device.name}>
          {device.name}
        </a>
        <span class="soft">
          {device.profile}
          {device.is_real && " · real"}
        </span>
        <span class={`pill push is-${figures.state}`} title={figures.why}>
          {figures.stateText}
        </span>
      </div>
      <Live device={device} />
      <dl class="figures">
        <div title="bytes from and to the board each second">
          <dt>rate</dt>
          <dd class="mono">{byteRate(figures.bytes_per_s)}</dd>
        </div>
        <div title="how far the board is behind the simulated time">
          <dt>lag</dt>
          <dd class="mono">{figures.lag_ms === null ? "–" : `${figures.lag_ms.toFixed(1)} ms`}</dd>
        </div>
        <div title="programs that have its ports open">
          <dt>clients</dt>
          <dd class="mono">{figures.clients}</dd>
        </div>
      </dl>
    </article>
  );
}

/** Position and speed of an axis as numbers, and a strip of its position. */
function Live({ device }: { device: DeviceRow }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const position = useRef<HTMLElement>(null);
  const velocity = useRef<HTMLElement>(null);
  const names = device.fields.map((field) => field.name);
  const wanted = ["position_deg", "velocity_rpm"].filter((name) => names.includes(name));
  useEffect(() => {
    if (!wanted.length || !canvas.current) return;
    const feed = feedOf(device.name);
    const end = feed.want(wanted);
    const strip = new Strip(canvas.current, feed, "position_deg");
    const say = () => {
      tell(position.current, feed.ring.at(feed.column("position_deg"), feed.ring.total - 1), 2);
      tell(velocity.current, feed.ring.at(feed.column("velocity_rpm"), feed.ring.total - 1), 1);
    };
    const timer = window.setInterval(say, VALUES_EVERY_MS);
    let frame = 0;
    const first = () => {
      say();
      if (!feed.ring.total) frame = requestAnimationFrame(first); // the first values are there at once
    };
    first();
    return () => {
      window.clearInterval(timer);
      cancelAnimationFrame(frame);
      strip.end();
      end();
    };
  }, [device.name, wanted.join(" "), theme.value]);
  if (!wanted.length) return <p class="soft strip-none">no shaft that could be watched</p>;
  return (
    <>
      <div class="readings">
        <span>
          <span class="mono reading" ref={position} /> deg
        </span>
        <span>
          <span class="mono reading" ref={velocity} /> rpm
        </span>
      </div>
      <canvas ref={canvas} class="strip" role="img" aria-label={`Position of ${device.name} in the last 10 s`} />
    </>
  );
}

function tell(place: HTMLElement | null, value: number, digits: number): void {
  const text = shown(value, digits);
  if (place && place.textContent !== text) place.textContent = text;
}
