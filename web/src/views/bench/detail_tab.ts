/** The tab that was used last, on all devices alike. */

import { keptText } from "../../kept";

export const detailTab = keptText("bench.tab", "verbs");
