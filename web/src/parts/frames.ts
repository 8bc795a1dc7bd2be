/** One loop of animation frames for all that is drawn. Each frame has a budget: what does not fit waits for the
 * next, in turn, so that a page full of plots stays usable on a slow computer. */

export interface Drawer {
  /** False while it is out of sight or nothing has changed: it is passed over. */
  isDue(): boolean;
  draw(now_ms: number): void;
}

const BUDGET_MS = 5;

const drawers: Drawer[] = [];
let next = 0;
let request = 0;

/** Draw something from now on; answers the function that ends it. */
export function onFrames(drawer: Drawer): () => void {
  drawers.push(drawer);
  if (!request) request = requestAnimationFrame(frame);
  return () => {
    const at = drawers.indexOf(drawer);
    if (at >= 0) drawers.splice(at, 1);
  };
}

function frame(now_ms: number): void {
  request = drawers.length ? requestAnimationFrame(frame) : 0;
  const begin = performance.now();
  for (let turn = drawers.length; turn > 0; turn--) {
    if (next >= drawers.length) next = 0;
    const drawer = drawers[next++]!;
    if (!drawer.isDue()) continue;
    drawer.draw(now_ms);
    if (performance.now() - begin > BUDGET_MS) break;
  }
}

/** Whether an element is in sight, kept up to date. */
export class Sight {
  isIn = false;
  private readonly observer: IntersectionObserver;

  constructor(element: Element) {
    this.observer = new IntersectionObserver((entries) => {
      this.isIn = entries[entries.length - 1]?.isIntersecting ?? false;
    });
    this.observer.observe(element);
  }

  end(): void {
    this.observer.disconnect();
  }
}
