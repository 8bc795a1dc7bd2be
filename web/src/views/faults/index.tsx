/** Faults: choose a thing of the bench, and see only what can fail there. */

import { signal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { keptText } from "../../kept";
import type { FaultKindRow } from "../../model/door";
import { notifyError } from "../../parts/notices";
import { hello, link } from "../../store";
import { ActiveFaults } from "./active_faults";
import { FaultDrawing } from "./fault_drawing";
import { FaultForm, Presets } from "./fault_form";
import { FAMILIES, type Family, fitting, type PlaceRow, placeTree } from "./fault_places";
import { PlacesList } from "./places_list";
import "./faults.css";

const chosenKind = keptText("faults.kind");
const chosenPlace = keptText("faults.place");
/** Places of the bench; undefined: they were not told yet. */
const places = signal<readonly PlaceRow[] | undefined>(undefined);

export function FaultsView({ path }: { path: string[] }) {
  const bench = hello.value;
  useEffect(() => {
    link
      .ask("fault_places", "", {})
      .then((told) => (places.value = told))
      .catch(notifyError);
  }, [bench]);
  const named = path[0] ?? "";
  useEffect(() => {
    if (named) chosenPlace.value = named;
  }, [named]);
  return (
    <div class="faults">
      <ActiveFaults />
      <Presets choose={(kind) => (chosenKind.value = kind)} />
      {bench && places.value && <Break rows={places.value} named={named || chosenPlace.value} isNamed={named !== ""} kinds={bench.fault_kinds} />}
    </div>
  );
}

interface BreakProps {
  rows: readonly PlaceRow[];
  named: string;
  isNamed: boolean;
  kinds: readonly FaultKindRow[];
}

function Break({ rows, named, isNamed, kinds }: BreakProps) {
  const form = useRef<HTMLDivElement>(null);
  const row = rows.find(({ place }) => place === named) ?? (isNamed ? undefined : rows[0]);
  const found = fitting(row, kinds);
  const all = found.flatMap(([, each]) => each);
  const kind = all.find(({ name }) => name === chosenKind.value) ?? all[0];
  const choose = (name: string) => {
    chosenKind.value = name;
    requestAnimationFrame(() => form.current?.scrollIntoView({ block: "nearest" }));
  };
  return (
    <div class="fault-choice">
      <PlacesList tree={placeTree(rows)} chosen={row?.place ?? ""} />
      {row ? (
        <section class="card" aria-label={`What can fail on ${row.place}`}>
          <h2>What can fail on {row.place}</h2>
          {found.map(([family, each]) => (
            <Kinds key={family} family={family} kinds={each} chosen={kind?.name} choose={choose} />
          ))}
        </section>
      ) : (
        <p class="problem">There is no place “{named}” on this bench where a fault can be.</p>
      )}
      <div ref={form}>{row && kind ? <FaultForm key={`${kind.name} ${row.place}`} kind={kind} place={row.place} /> : null}</div>
    </div>
  );
}

interface KindsProps {
  family: Family;
  kinds: readonly FaultKindRow[];
  chosen: string | undefined;
  choose(kind: string): void;
}

function Kinds({ family, kinds, chosen, choose }: KindsProps) {
  return (
    <div role="group" aria-label={FAMILIES[family]}>
      <h3>{FAMILIES[family]}</h3>
      <ul class="fault-kinds">
        {kinds.map((kind) => (
          <li key={kind.name}>
            <button type="button" class="fault-kind" aria-pressed={kind.name === chosen} onClick={() => choose(kind.name)}>
              <FaultDrawing family={family} />
              <span>
                <strong>{kind.title}</strong>
                <span class="kind-about">{kind.summary}</span>
                <span class="mono kind-name">{kind.name}</span>
              </span>
            </button>
          </li>
        ))}
      </ul>
    </div>
  );
}
