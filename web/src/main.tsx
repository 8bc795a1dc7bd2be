import { render } from "preact";
import { App } from "./app";
import { startFeeds } from "./feeds";
import { noteHere } from "./happened";
import { startKeeping } from "./kept";
import { noticeListeners } from "./parts/notices";
import { link } from "./store";
import "./theme";
import "./styles/base.css";
import "./styles/layout.css";

const place = document.getElementById("page");
if (place) {
  startKeeping();
  startFeeds();
  noticeListeners.push(noteHere);
  link.start();
  render(<App />, place);
}
