// Order of the site's search results: how-tos before the reference, and what was decided or changed once behind both.
// With var: what Sphinx has declares it again.
var Scorer = {
  score: ([name, , , , score]) =>
    score + (name.startsWith("docs/how-to/") ? 3 : /^docs\/decisions\/|^CHANGELOG$/.test(name) ? -12 : 0),
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
