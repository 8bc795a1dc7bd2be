/** The docking library at work: it has the panels of the layout, splits and tabs, and tells what was moved. */

import { createDockview, type DockviewApi, type DockviewGroupPanel, type IContentRenderer, type IDockviewPanel, type SerializedDockview } from "dockview-core";
import { effect } from "@preact/signals";
import { h } from "preact";
import { type DockGrid, gridOf, placeOf } from "../model/dock_tree";
import { type PanelRow, panelsOf } from "../model/layout";
import { sizedAs } from "../model/layout_change";
import { type Arranger, change, layout, openings, rowOf } from "./desk";
import { titleOf } from "./kinds";
import { mount, newKey } from "./mounts";
import { PanelActions, PanelBody } from "./panel";
import "./dockview.css";

export type Direction = "left" | "right" | "above" | "below";

const COMPONENT = "panel";
const LEAST_PX = 80;
/** Part of the room by which a key changes a size. */
const KEY_SHARE = 0.04;

export class Dock implements Arranger {
  private readonly api: DockviewApi;
  private readonly endTitles: () => void;
  private readonly opening = openings.peek();
  private readonly ended = new AbortController();
  private isRestoring = false;
  /** Whether somebody has changed a size. */
  private isSized = false;

  constructor(private readonly place: HTMLElement) {
    this.api = createDockview(place, {
      theme: { name: "hil", className: "hil-dock", dndOverlayMounting: "relative", dndPanelOverlay: "content", tabGroupIndicator: "none" },
      disableFloatingGroups: true,
      tabGroupAccent: "off",
      scrollbars: "native",
      announcements: false,
      createComponent: ({ id }) => new Content(id),
      createTabComponent: ({ id }) => new Tab(id),
      createRightHeaderActionComponent: (group) => new Actions(group, this),
    });
    this.restore();
    this.endTitles = effect(() => {
      for (const row of panelsOf(layout.value.root)) {
        const panel = this.api.getPanel(row.id);
        if (panel && panel.title !== titleOf(row)) panel.api.setTitle(titleOf(row));
      }
    });
    place.addEventListener(
      "pointerdown",
      (event) => {
        if ((event.target as HTMLElement).closest(".dv-sash")) this.isSized = true;
      },
      { signal: this.ended.signal },
    );
    place.addEventListener("keydown", (event) => this.onTabKey(event), { capture: true, signal: this.ended.signal });
    this.api.onDidLayoutChange(() => this.tell());
    this.api.onDidActivePanelChange(() => this.tell());
  }

  end(): void {
    this.isRestoring = true;
    this.endTitles();
    this.ended.abort();
    this.api.dispose();
  }

  private restore(): void {
    const { root, isColumn } = layout.peek();
    if (!root) return;
    const { clientWidth, clientHeight } = this.place;
    const panels = Object.fromEntries(panelsOf(root).map((row) => [row.id, describe(row)]));
    const grid = gridOf(root, isColumn, Math.max(clientWidth, 600), Math.max(clientHeight, 400));
    this.isRestoring = true;
    this.api.fromJSON({ grid, panels } as unknown as SerializedDockview);
    this.isRestoring = false;
  }

  private tell(): void {
    // The library tells changes a moment later: another layout may have been opened.
    if (this.isRestoring || this.opening !== openings.peek() || this.api.hasMaximizedGroup()) return;
    const before = layout.peek();
    const { root, isColumn } = placeOf(this.api.toJSON().grid as unknown as DockGrid, rowOf);
    const isSized = this.isSized || panelsOf(root).length !== panelsOf(before.root).length;
    const next = { ...before, root: isSized ? root : sizedAs(root, before.root), isColumn };
    if (JSON.stringify(next) !== JSON.stringify(before)) change(next);
  }

  // ---- what can be done with panels ----

  add(row: PanelRow): void {
    const beside = this.api.activePanel;
    const isWide = (beside?.api.width ?? 0) > (beside?.api.height ?? 0);
    const position = beside ? { position: { referencePanel: beside.id, direction: isWide ? ("right" as const) : ("below" as const) } } : {};
    const { contentComponent: component, tabComponent, id, title } = describe(row);
    this.api.addPanel({ id, title, component, tabComponent, ...position });
    this.show(row.id);
  }

  close(id: string): void {
    const panel = this.api.getPanel(id);
    const group = panel?.group;
    panel?.api.close();
    const next = group?.activePanel ?? this.api.activePanel;
    if (next) this.show(next.id);
  }

  show(id: string): void {
    const panel = this.api.getPanel(id);
    panel?.api.setActive();
    this.tabOf(id)?.focus();
  }

  /** Move a panel beside its neighbour in a direction, or along the edge; of several in a place it gets one of its own. */
  move(id: string, to: Direction): void {
    const panel = this.api.getPanel(id);
    if (!panel) return;
    const { group } = panel;
    const position = { left: "left", right: "right", above: "top", below: "bottom" }[to] as "left" | "right" | "top" | "bottom";
    const beside = this.neighbour(group, to);
    if (group.panels.length > 1) panel.api.moveTo({ group, position });
    else if (beside) panel.api.moveTo({ group: beside, position });
    else if (this.api.groups.length > 1) panel.api.moveTo({ group: this.api.addGroup({ direction: to }), position: "center" });
    this.show(id);
  }

  /** Put a panel behind another as a tab: into the neighbour in any direction. */
  asTab(id: string): void {
    const panel = this.api.getPanel(id);
    if (!panel) return;
    const beside = (["left", "right", "above", "below"] as const).map((to) => this.neighbour(panel.group, to)).find(Boolean);
    if (beside) panel.api.moveTo({ group: beside, position: "center" });
    this.show(id);
  }

  /** Put a panel before the tab before it, or with 1 behind the next. */
  reorder(id: string, by: 1 | -1): void {
    const panel = this.api.getPanel(id);
    if (!panel) return;
    const { group } = panel;
    const index = group.panels.indexOf(panel) + by;
    if (index >= 0 && index < group.panels.length) panel.api.moveTo({ group, position: "center", index });
    this.show(id);
  }

  resize(id: string, wider: number, taller: number): void {
    const panel = this.api.getPanel(id);
    if (!panel) return;
    this.isSized = true;
    const { width, height } = panel.group.api;
    const by_px = (parts: number, whole: number) => parts * KEY_SHARE * whole;
    panel.group.api.setSize({
      width: Math.max(width + by_px(wider, this.place.clientWidth), LEAST_PX),
      height: Math.max(height + by_px(taller, this.place.clientHeight), LEAST_PX),
    });
  }

  /** Let a panel fill the room, or bring the others back. */
  fill(id: string): void {
    const panel = this.api.getPanel(id);
    if (!panel) return;
    if (panel.api.isMaximized()) panel.api.exitMaximized();
    else panel.api.maximize();
    this.show(id);
  }

  /** Go to the next panel, over all groups, or with -1 to the one before. */
  goOn(by: 1 | -1): void {
    const all = panelsOf(layout.peek().root);
    const here = document.activeElement?.closest<HTMLElement>("[data-panel]")?.dataset["panel"] ?? this.api.activePanel?.id;
    const at = all.findIndex(({ id }) => id === here);
    const next = all[(at + by + all.length) % all.length];
    if (next) this.show(next.id);
  }

  private neighbour(group: DockviewGroupPanel, to: Direction): DockviewGroupPanel | undefined {
    const from = group.element.getBoundingClientRect();
    const [x, y] = [(from.left + from.right) / 2, (from.top + from.bottom) / 2];
    const others = this.api.groups.filter((each) => each !== group);
    const beyond = others.filter((each) => {
      const at = each.element.getBoundingClientRect();
      if (to === "left") return at.right <= from.left + 2;
      if (to === "right") return at.left >= from.right - 2;
      return to === "above" ? at.bottom <= from.top + 2 : at.top >= from.bottom - 2;
    });
    const far = (each: DockviewGroupPanel) => {
      const at = each.element.getBoundingClientRect();
      return Math.hypot((at.left + at.right) / 2 - x, (at.top + at.bottom) / 2 - y);
    };
    return beyond.sort((one, other) => far(one) - far(other))[0];
  }

  private tabOf(id: string): HTMLElement | null {
    const own = this.place.querySelector<HTMLElement>(`.dv-tab [data-panel="${CSS.escape(id)}"]`);
    return own?.closest<HTMLElement>(".dv-tab") ?? null;
  }

  /** The library makes the element of a tab again when it moves: the keys of all are heard here. */
  private onTabKey(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    const id = target.classList.contains("dv-tab") && target.querySelector<HTMLElement>("[data-panel]")?.dataset["panel"];
    if (!id || event.ctrlKey || event.metaKey) return;
    const to = ({ ArrowLeft: "left", ArrowRight: "right", ArrowUp: "above", ArrowDown: "below" } as const)[event.key];
    if (to && event.altKey) this.move(id, to);
    else if (to && event.shiftKey) this.resize(id, to === "right" ? 1 : to === "left" ? -1 : 0, to === "below" ? 1 : to === "above" ? -1 : 0);
    else if (event.altKey && event.key === "PageUp") this.reorder(id, -1);
    else if (event.altKey && event.key === "PageDown") this.reorder(id, 1);
    else if (event.key === "Delete") this.close(id);
    else if (event.key === "Enter") this.fill(id);
    else return;
    event.preventDefault();
    event.stopPropagation();
  }
}

function describe(row: PanelRow) {
  return { id: row.id, title: titleOf(row), contentComponent: COMPONENT, tabComponent: COMPONENT };
}

/** What a panel shows, while it is the one in sight of its tabs. */
class Content implements IContentRenderer {
  readonly element = document.createElement("div");
  private readonly key = newKey();

  constructor(private readonly id: string) {
    this.element.className = "panel-place";
    this.element.dataset["panel"] = id;
  }

  init({ api }: { api: IDockviewPanel["api"] }): void {
    const draw = () => mount(this.key, this.element, api.isVisible ? h(PanelBody, { id: this.id }) : null);
    api.onDidVisibilityChange(draw);
    draw();
  }

  dispose(): void {
    mount(this.key, this.element, null);
  }
}

class Tab {
  readonly element = document.createElement("span");

  constructor(id: string) {
    this.element.className = "panel-tab";
    this.element.dataset["panel"] = id;
  }

  init({ title, api }: { title: string; api: IDockviewPanel["api"] }): void {
    this.element.textContent = title;
    api.onDidTitleChange(({ title: next }) => (this.element.textContent = next));
  }
}

/** Buttons of the panel in sight, at the right of the tabs. */
class Actions {
  readonly element = document.createElement("div");
  private readonly key = newKey();

  constructor(
    private readonly group: DockviewGroupPanel,
    private readonly dock: Dock,
  ) {
    this.element.className = "panel-actions";
  }

  init(): void {
    const draw = () => {
      const id = this.group.activePanel?.id;
      mount(this.key, this.element, id ? h(PanelActions, { key: id, id, dock: this.dock }) : null);
    };
    this.group.model.onDidActivePanelChange(draw);
    draw();
  }

  dispose(): void {
    mount(this.key, this.element, null);
  }
}
