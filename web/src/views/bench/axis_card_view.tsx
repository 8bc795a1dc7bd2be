/** Card of an axis: where it is, where it should be, what it does, and a strip of the last seconds. */

import { Fragment } from "preact";
import { useEffect, useRef } from "preact/hooks";
import { type AxisCard, errorShare, words } from "../../model/axis_card";
import { byteRate, digitsOf, shown } from "../../model/numbers";
import { write } from "../../parts/write";
import { href } from "../../router";
import { devices, isPast } from "../../store";
import { theme } from "../../theme";
import { feedOf } from "./axis_feed";
import { ownFields } from "./axis_fields";
import { Strip } from "./strip";

/** Errors from here on are drawn as bad, by their units. */
const LARGE: Record<string, number> = { deg: 5, rpm: 20, steps: 4 };

export function AxisCardView({ card }: { card: AxisCard }) {
  const device = devices.value.get(card.name);
  const look = `card device is-${card.state}${card.moves ? " is-moving" : ""}`;
  const isTold = card.state !== "ok" && card.why !== "" && card.why !== card.stateText;
  return (
    <article class={look} aria-label={card.name}>
      <div class="device-head">
        <a class="device-name" href={href("bench", card.name)} title={card.name}>
          {card.name}
        </a>
        <span class="soft">
          {card.profile}
          {device?.is_real && " · real"}
        </span>
        {!isPast.value && card.mode && (
          <span class="mode" title="mode of its control law, or what it does">
            {card.mode}
          </span>
        )}
        <span class={`pill push is-${card.state}`} title={card.why}>
          {card.stateText}
        </span>
      </div>
      {isTold && (
        <span class="card-why" title={card.why}>
          {card.why}
        </span>
      )}
      <Live name={card.name} />
      {!isPast.value && <Facts card={card} />}
      {!isPast.value && !device?.is_real && <BreakLink name={card.name} />}
    </article>
  );
}

/** Link to the faults of a thing, over its card's own link: it shows while the card is pointed at or has the focus. */
export function BreakLink({ name }: { name: string }) {
  return (
    <a class="card-break button" href={href("faults", name)} aria-label={`Break ${name}…`}>
      Break…
    </a>
  );
}

function Facts({ card }: { card: AxisCard }) {
  const { setPoint, setPointUnit, error, errorUnit, lastFault, clients, bytes_per_s } = card;
  return (
    <dl class="card-facts">
      {setPoint !== null && (
        <>
          <dt>set-point</dt>
          <dd class="mono">
            {shown(setPoint, digitsOf(setPointUnit))} {setPointUnit}
          </dd>
        </>
      )}
      {error !== null && (
        <>
          <dt>error</dt>
          <dd>
            <ErrorBar error={error} unit={errorUnit} />
          </dd>
        </>
      )}
      {lastFault && (
        <>
          <dt>last fault</dt>
          <dd>{lastFault}</dd>
        </>
      )}
      {clients > 0 && (
        <>
          <dt>port</dt>
          <dd>
            {clients} {clients === 1 ? "client" : "clients"}, {byteRate(bytes_per_s)}
          </dd>
        </>
      )}
    </dl>
  );
}

/** Following error as a bar: small ones show, too. */
function ErrorBar({ error, unit }: { error: number; unit: string }) {
  const isLarge = Math.abs(error) > (LARGE[unit] ?? Infinity);
  return (
    <span class={`error-bar${isLarge ? " is-large" : ""}`}>
      <svg viewBox="0 0 100 10" preserveAspectRatio="none" aria-hidden="true">
        <rect x="0" y="0" height="10" width={errorShare(error) * 100} />
      </svg>
      <span class="mono">
        {shown(error, 2)} {words(unit)}
      </span>
    </span>
  );
}

const MOST_READINGS = 8;
const READ_MS = 200;

/** Fields of a board without a motor as numbers. */
function Readings({ name, fields }: { name: string; fields: readonly string[] }) {
  const list = useRef<HTMLDListElement>(null);
  useEffect(() => {
    const feed = feedOf(name);
    const end = feed.want([...fields]);
    const say = () => {
      list.current?.querySelectorAll("dd").forEach((place, at) => {
        const field = fields[at] ?? "";
        const digits = devices.value
          .get(name)
          ?.fields.find((each) => each.name === field)
          ?.type.startsWith("i")
          ? 0
          : 2;
        write(place, shown(feed.ring.at(feed.column(field), feed.ring.total - 1), digits));
      });
    };
    const timer = setInterval(say, READ_MS);
    return () => {
      clearInterval(timer);
      end();
    };
  }, [name, fields.join(" ")]);
  return (
    <dl class="card-facts" ref={list}>
      {fields.map((field) => (
        <Fragment key={field}>
          <dt>{field}</dt>
          <dd class="mono" />
        </Fragment>
      ))}
    </dl>
  );
}

/** Position and speed of an axis as numbers, and a strip of its position. */
function Live({ name }: { name: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const position = useRef<HTMLElement>(null);
  const velocity = useRef<HTMLElement>(null);
  const names = (devices.value.get(name)?.fields ?? []).map((field) => field.name);
  const wanted = ["position_deg", "velocity_rpm"].filter((each) => names.includes(each));
  useEffect(() => {
    if (!wanted.length || !canvas.current) return;
    const feed = feedOf(name);
    const end = feed.want(wanted);
    const say = () => {
      write(position.current, shown(feed.ring.at(feed.column("position_deg"), feed.ring.total - 1), 2));
      write(velocity.current, shown(feed.ring.at(feed.column("velocity_rpm"), feed.ring.total - 1), 1));
    };
    const strip = new Strip(canvas.current, feed, "position_deg", say);
    let frame = 0;
    const first = () => {
      say();
      if (!feed.ring.total) frame = requestAnimationFrame(first); // the first values are there at once
    };
    first();
    return () => {
      cancelAnimationFrame(frame);
      strip.end();
      end();
    };
  }, [name, wanted.join(" "), theme.value]);
  const device = devices.value.get(name);
  const own = device && !wanted.length ? ownFields(device).slice(0, MOST_READINGS) : [];
  if (own.length) return <Readings name={name} fields={own} />;
  if (!wanted.length) return <p class="soft strip-none">no shaft that could be watched</p>;
  return (
    <>
      <div class="reading-line">
        <span>
          <span class="mono reading is-big" ref={position} /> deg
        </span>
        <span>
          <span class="mono reading" ref={velocity} /> rpm
        </span>
      </div>
      <canvas ref={canvas} class="strip" role="img" aria-label={`Position of ${name} in the last 10 s`} />
    </>
  );
}
