/** Things of the bench that can be broken: boards with their parts, wires with what is on them. */

import { href } from "../../router";
import { activeFaults } from "../../store";
import { type PlaceNode, type PlaceTree, sortText } from "./fault_places";

export function PlacesList({ tree, chosen }: { tree: PlaceTree; chosen: string }) {
  return (
    <nav class="card fault-places" aria-label="What to break">
      {tree.devices.length > 0 && <Group title="Boards" nodes={tree.devices} chosen={chosen} />}
      {tree.wires.length > 0 && <Group title="Wires" nodes={tree.wires} chosen={chosen} />}
    </nav>
  );
}

function Group({ title, nodes, chosen }: { title: string; nodes: readonly PlaceNode[]; chosen: string }) {
  return (
    <>
      <h3>{title}</h3>
      <ul>
        {nodes.map((node) => (
          <li key={node.row.place}>
            <Place node={node} chosen={chosen} />
            {node.parts.length > 0 && (
              <ul>
                {node.parts.map((part) => (
                  <li key={part.row.place}>
                    <Place node={part} chosen={chosen} />
                  </li>
                ))}
              </ul>
            )}
          </li>
        ))}
      </ul>
    </>
  );
}

function Place({ node, chosen }: { node: PlaceNode; chosen: string }) {
  const { place } = node.row;
  const broken = activeFaults.value.filter(({ target }) => target === place).length;
  return (
    <a href={href("faults", place)} aria-current={place === chosen ? "true" : undefined} title={place}>
      <span class="place">{node.label}</span> <span class="soft">{sortText(node.row)}</span>
      {broken > 0 && <span class="pill is-bad push">{broken}</span>}
    </a>
  );
}
