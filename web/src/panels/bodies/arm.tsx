/** Walter's arm: in space where the browser can, else from the side and from above. */

import { useEffect, useRef, useState } from "preact/hooks";
import { armAt, JOINTS, type Pose } from "../../model/arm";
import { shown } from "../../model/numbers";
import { onFrames, Sight } from "../../parts/frames";
import { palette } from "../../parts/palette";
import { theme } from "../../theme";
import { useFields, valueAt } from "../values";
import type { ArmScene } from "./arm_scene";
import { Picture } from "./picture";

const SAY_EVERY_MS = 2000;
const KEY_RAD = 0.12;

/** Address of the position of a joint; the hip's is the device's own. */
function addressOf(arm: string, joint: string): string {
  return `${joint === "hip" ? arm : `${arm}.${joint}`}.position_deg`;
}

function poseOf(arm: string): Pose {
  return Object.fromEntries(JOINTS.map((joint) => [joint, valueAt(addressOf(arm, joint))])) as Pose;
}

function inWords(arm: string): string[] {
  return Object.entries(poseOf(arm)).map(([joint, deg]) => `${joint} ${shown(deg, 1)} deg`);
}

export function ArmPicture({ arm }: { arm: string }) {
  const [isFlat, setFlat] = useState(false);
  useFields(JOINTS.map((joint) => addressOf(arm, joint)));
  if (isFlat) return <Picture what={`Arm ${arm}`} say={() => inWords(arm)} draw={(context, width, height) => drawFlat(context, width, height, poseOf(arm))} />;
  return <Scene arm={arm} flat={() => setFlat(true)} />;
}

/** `flat`: called where the browser draws nothing in space. */
function Scene({ arm, flat }: { arm: string; flat(): void }) {
  const place = useRef<HTMLDivElement>(null);
  const scene = useRef<ArmScene | null>(null);
  const [said, setSaid] = useState("");
  useEffect(() => {
    const element = place.current!;
    const sight = new Sight(element);
    let [drawn, isEnded] = ["", false];
    import("./arm_scene")
      .then(({ ArmScene }) => {
        if (isEnded) return;
        scene.current = new ArmScene(element, palette());
      })
      .catch(flat);
    const stateNow = () => `${inWords(arm).join()} ${element.clientWidth} ${element.clientHeight} ${scene.current?.turns}`;
    const end = onFrames({
      isDue: () => sight.isIn && scene.current !== null && stateNow() !== drawn,
      draw: () => {
        drawn = stateNow();
        scene.current?.draw(poseOf(arm));
      },
    });
    const tell = () => setSaid(inWords(arm).join(", "));
    tell();
    const timer = window.setInterval(tell, SAY_EVERY_MS);
    return () => {
      isEnded = true;
      window.clearInterval(timer);
      end();
      sight.end();
      scene.current?.end();
      scene.current = null;
    };
  }, [arm, theme.value]);
  const onKey = (event: KeyboardEvent) => {
    const turn = ({ ArrowLeft: [-KEY_RAD, 0], ArrowRight: [KEY_RAD, 0], ArrowUp: [0, KEY_RAD], ArrowDown: [0, -KEY_RAD] } as Record<string, [number, number]>)[
      event.key
    ];
    if (!turn || event.altKey || event.ctrlKey) return;
    event.preventDefault();
    scene.current?.turn(...turn);
  };
  return (
    <div class="arm-panel">
      <div ref={place} class="panel-canvas arm-scene" tabIndex={0} role="img" aria-label={`Arm ${arm}; arrow keys turn it: ${said}`} onKeyDown={onKey} />
      <p class="soft mono arm-angles" aria-hidden="true">
        {said}
      </p>
    </div>
  );
}

/** Draw the arm from the side, and beside it from above. */
function drawFlat(context: CanvasRenderingContext2D, width: number, height: number, pose: Pose): void {
  const { points, fingers } = armAt(pose);
  const beside = armAt({ ...pose, hip: 0 });
  const half = width / 2;
  const scale = Math.min(half, height) / 2.2;
  const side = (all: typeof points, ends: typeof fingers, x: number, across: 0 | 1, up: 0 | 1 | 2, y: number) => {
    const colours = palette();
    const at = (point: readonly number[]): [number, number] => [x + point[across]! * scale, y - point[up]! * scale];
    context.lineCap = context.lineJoin = "round";
    context.strokeStyle = colours.traces[0]!;
    context.lineWidth = 8;
    context.beginPath();
    for (const point of all) context.lineTo(...at(point));
    context.stroke();
    context.lineWidth = 3;
    for (const end of ends) {
      context.beginPath();
      context.moveTo(...at(all[4]));
      context.lineTo(...at(end));
      context.stroke();
    }
    context.fillStyle = colours.ink;
    for (const point of all) {
      context.beginPath();
      context.arc(...at(point), 4, 0, 2 * Math.PI);
      context.fill();
    }
  };
  side(beside.points, beside.fingers, half * 0.45, 0, 2, height * 0.72);
  side(points, fingers, half * 1.5, 1, 0, height * 0.6);
  context.fillStyle = palette().soft;
  context.font = `12px ${palette().mono}`;
  context.fillText("from the side", 6, 16);
  context.fillText("from above", half + 6, 16);
}
