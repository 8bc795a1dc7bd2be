/** The bench's drawing: the path asked for, and what its axes follow. */

import { useEffect, useRef } from "preact/hooks";
import { notifyError } from "../../parts/notices";
import { href } from "../../router";
import { link, readRuns, status } from "../../store";
import { deviation, followed } from "../../views/path/path_followed";
import { PathPane } from "../../views/path/path_pane";
import { done, drawing, follow, isPlanning, isUnderWay } from "../../views/path/path_state";
import "../../views/path/path.css";

export function PathBody() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const pane = useRef<PathPane | null>(null);
  const connections = link.connections.value;
  const theirs = status.value.drawing;
  const [made, way] = [drawing.value, followed.value];
  useEffect(() => void readRuns(), [connections]);
  useEffect(() => void follow().catch(notifyError), [connections, theirs, isUnderWay.value, isPlanning.value]);
  const up = made && made.axes.length > 1 ? 1 : 0;
  useEffect(() => {
    if (!canvas.current) return;
    const it = (pane.current = new PathPane(canvas.current, 0, up));
    return () => it.close();
  }, [up, made === null]);
  useEffect(() => pane.current?.show(made, way), [made, way, up]);
  if (!made) {
    return (
      <p class="empty">
        Nothing is drawn here yet: <a href={href("path")}>check a program in Path</a>.
      </p>
    );
  }
  const how = done.value;
  return (
    <div class="path-panel">
      <p class="row">
        <a href={href("path")}>{made.file ?? made.machine}</a>
        <span class="mono soft" role="status">
          {isUnderWay.value && how ? `${(how.share * 100).toFixed(0)} %, line ${how.line}` : "not under way"}
        </span>
        <span class="push soft">
          largest deviation <span class="mono">{deviation.value ? `${deviation.value.largest.toFixed(3)} mm` : "–"}</span>
        </span>
      </p>
      <canvas ref={canvas} class="panel-canvas" role="img" aria-label="Path asked for and path followed" />
    </div>
  );
}
