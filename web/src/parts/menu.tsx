/** A button that opens a small window with further buttons: Esc and a click elsewhere close it. */

import type { ComponentChildren } from "preact";
import { useId, useRef, useState } from "preact/hooks";

interface MenuProps {
  /** What the button says. */
  text: string;
  /** Name of the button and of what it opens, where the text says little. */
  label?: string;
  class?: string;
  children: ComponentChildren;
}

const EDGE_PX = 6;

export function Menu({ text, label, class: name = "", children }: MenuProps) {
  const id = useId();
  const button = useRef<HTMLButtonElement>(null);
  const window_ = useRef<HTMLDivElement>(null);
  const [isOpen, setOpen] = useState(false);
  return (
    <>
      <button
        ref={button}
        type="button"
        class={name}
        aria-expanded={isOpen}
        aria-controls={id}
        aria-label={label}
        title={label}
        onClick={() => window_.current?.togglePopover()}
      >
        {text}
      </button>
      <div
        ref={window_}
        id={id}
        popover="auto"
        class="menu"
        role="group"
        aria-label={label ?? text}
        onToggle={(event) => {
          const isNow = (event as unknown as ToggleEvent).newState === "open";
          setOpen(isNow);
          if (isNow && button.current && window_.current) beside(window_.current, button.current);
        }}
        onClickCapture={(event) => {
          // Before the button does its work, which may move the focus.
          if ((event.target as HTMLElement).closest("[data-closes]")) window_.current?.hidePopover();
        }}
      >
        {isOpen && children}
      </div>
    </>
  );
}

/** Put a window below a button, within the page. */
function beside(window_: HTMLElement, button: HTMLElement): void {
  requestAnimationFrame(() => {
    const at = button.getBoundingClientRect();
    const size = window_.getBoundingClientRect();
    const left = Math.min(at.left, innerWidth - size.width - EDGE_PX);
    const below = at.bottom + 2;
    const top = below + size.height > innerHeight ? Math.max(innerHeight - size.height - EDGE_PX, EDGE_PX) : below;
    window_.style.left = `${Math.max(left, EDGE_PX)}px`;
    window_.style.top = `${top}px`;
    window_.querySelector<HTMLElement>("button, a, input, select")?.focus();
  });
}
