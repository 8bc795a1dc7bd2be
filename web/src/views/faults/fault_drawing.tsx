/** Small drawings of what can fail, one for each family of faults. */

import type { Family } from "./fault_places";

/** Lines of each, in a box of 48 by 32; what is broken is drawn in the second. */
const DRAWINGS: Record<Family, [plain: string, broken: string]> = {
  encoder: ["M24 4a12 12 0 1 0 .01 0M24 12a4 4 0 1 0 .01 0M24 1v6M24 25v6M9 16h6M33 16h6", "M30 22l8 8M38 22l-8 8"],
  shaft: ["M4 10h16v12H4zM20 13h12v6H20zM32 8h6v16h-6z", "M41 6a14 14 0 0 1 0 20M38 24l3 3 3-4"],
  coil: ["M4 20h6c0-10 6-10 6 0 0-10 6-10 6 0 0-10 6-10 6 0", "M28 20h4M36 20h8M31 26l6-12"],
  supply: ["M8 10h22v14H8zM30 14h4v6h-4M13 14v6M10 17h6M22 17h5", "M41 4l-5 10h6l-5 12"],
  board: ["M12 6h24v20H12zM17 6V2M24 6V2M31 6V2M17 30v-4M24 30v-4M31 30v-4", "M18 11l12 10M30 11L18 21"],
  cable: ["M2 16h10M12 10h8v12h-8zM28 10h8v12h-8zM36 16h10", "M22 12l4 8M26 12l-4 8"],
  packet: ["M4 8h40v16H4zM14 8v16M34 8v16", "M19 12l10 8M29 12l-10 8"],
  wire: ["M2 12h16M30 12h16M2 20h44", "M19 6l3 6-3 0 4 6M27 7l-2 5 3 0-3 5"],
};

export function FaultDrawing({ family }: { family: Family }) {
  const [plain, broken] = DRAWINGS[family];
  return (
    <svg class="fault-drawing" viewBox="0 0 48 32" width="48" height="32" aria-hidden="true" focusable="false">
      <path class="plain-line" d={plain} />
      <path class="broken-line" d={broken} />
    </svg>
  );
}
