import { effect } from "@preact/signals";
import { render } from "preact";
import { App } from "./app";
import { startFeeds } from "./feeds";
import { noteHere } from "./happened";
import { notKept, startKeeping, unsaved } from "./kept";
import { noticeListeners, notify } from "./parts/notices";
import { loadAhead } from "./parts/when_loaded";
import { link } from "./store";
import "./theme";
import "./styles/base.css";
import "./styles/layout.css";

/** The first view is there by then. */
const FIRST_MS = 2000;

let isToldNotKept = false;

/** Say once that what is typed and chosen is not kept; of a draft the banner says it as long as it holds. */
function tellNotKept(): void {
  if (isToldNotKept || notKept.value.size === 0 || unsaved.value.length > 0) return;
  isToldNotKept = true;
  notify("This browser has no room to keep what you type and choose: it is lost with this tab.", true);
}

const place = document.getElementById("page");
if (place) {
  startKeeping();
  startFeeds();
  noticeListeners.push(noteHere);
  effect(tellNotKept);
  link.start();
  render(<App />, place);
  setTimeout(loadAhead, FIRST_MS);
}
