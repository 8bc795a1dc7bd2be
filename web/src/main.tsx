import { render } from "preact";
import { App } from "./app";
import { startFeeds } from "./feeds";
import { startKeeping } from "./kept";
import { link } from "./store";
import "./theme";
import "./styles/base.css";
import "./styles/layout.css";

const place = document.getElementById("page");
if (place) {
  startKeeping();
  startFeeds();
  link.start();
  render(<App />, place);
}
