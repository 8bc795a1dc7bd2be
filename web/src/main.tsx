import { render } from "preact";
import { App } from "./app";
import { startFeeds } from "./feeds";
import { noteHere } from "./happened";
import { startKeeping } from "./kept";
import { noticeListeners } from "./parts/notices";
import { loadAhead } from "./parts/when_loaded";
import { link } from "./store";
import "./theme";
import "./styles/base.css";
import "./styles/layout.css";

/** The first view is there by then. */
const FIRST_MS = 2000;

const place = document.getElementById("page");
if (place) {
  startKeeping();
  startFeeds();
  noticeListeners.push(noteHere);
  link.start();
  render(<App />, place);
  setTimeout(loadAhead, FIRST_MS);
}
