/** Faults that are active, and their end. */

import { notifyError } from "../../parts/notices";
import { pastAt, shownFaults } from "../../past";
import { href } from "../../router";
import { activeFaults, link, may, whyNot } from "../../store";
import type { BodyProps } from "../kinds";

export function FaultsBody({ isWatch }: BodyProps) {
  const at_s = pastAt.value;
  const faults = at_s === null ? activeFaults.value : shownFaults.value.filter((mark) => mark.begin_s <= at_s && (mark.end_s === null || mark.end_s > at_s));
  const isAllowed = may("admin");
  return (
    <>
      {!faults.length && <p class="soft">No fault is active{at_s === null ? "" : " at this time"}.</p>}
      <ul class="fault-list">
        {faults.map((fault) => (
          <li key={fault.number}>
            <strong class="mono problem">{fault.kind}</strong> on {fault.target}
            {fault.begin_s !== null && <span class="soft mono"> since {fault.begin_s.toFixed(1)} s</span>}
            {!isWatch && (
              <button
                type="button"
                disabled={!isAllowed}
                title={isAllowed ? undefined : whyNot("admin")}
                aria-label={`Clear ${fault.kind} on ${fault.target}`}
                onClick={() => void link.ask("clear", "", { number: fault.number }).catch(notifyError)}
              >
                Clear
              </button>
            )}
          </li>
        ))}
      </ul>
      {!isWatch && <a href={href("faults")}>Inject a fault</a>}
    </>
  );
}
