/** Problems of a text; each leads to its place. */

import type { DocumentProblem } from "../../model/problems";
import { goTo } from "./text_editor";

const LISTED = 200;

/** `of`: name of the editor; `title`: of the list. */
export function ProblemList({ of, title, problems }: { of: string; title: string; problems: readonly DocumentProblem[] }) {
  if (!problems.length) return null;
  return (
    <ul class="problem-list" role="list" aria-label={title}>
      {problems.slice(0, LISTED).map((problem, at) => (
        <li key={at}>
          {problem.line > 0 && (
            <button type="button" class="mono" aria-label={`${problem.line}:${problem.column}, go to this line and column`} onClick={() => goTo(of, problem)}>
              {problem.line}:{problem.column}
            </button>
          )}
          <span class="problem">{problem.text}</span>
        </li>
      ))}
      {problems.length > LISTED && <li class="soft">and {problems.length - LISTED} more</li>}
    </ul>
  );
}
