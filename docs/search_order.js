// Order of the site's search results: how-tos before the reference, and what was decided or changed once after both.
// A title in which the query stands only within a word, as "lease" in "A release", counts less.
// With var: what Sphinx has declares it again.
var Scorer = {
  score: ([name, title, , , score]) => {
    const query = (new URLSearchParams(location.search).get("q") || "").trim().toLowerCase();
    const words = ` ${title.toLowerCase()}`;
    const within = query && words.includes(query) && !words.includes(` ${query}`) ? -10 : 0;
    return score + within + (name.startsWith("docs/how-to/") ? 3 : /^docs\/decisions\/|^CHANGELOG$/.test(name) ? -12 : 0);
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
