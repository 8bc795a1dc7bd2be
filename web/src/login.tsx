import { useState } from "preact/hooks";
import { link } from "./store";

/** Form for a token or a user's password, as the server wants it. */
export function Login() {
  const [problem, setProblem] = useState<string | null>(null);
  const isToken = link.login.value === "token";
  const submit = async (event: SubmitEvent) => {
    event.preventDefault();
    const form = new FormData(event.currentTarget as HTMLFormElement);
    const given = Object.fromEntries([...form].map(([name, value]) => [name, String(value)]));
    setProblem(await link.logIn(given));
  };
  return (
    <form class="login card" onSubmit={(event) => void submit(event)}>
      <h2>Log in</h2>
      {isToken ? (
        <label>
          Token, as the daemon printed it at its start
          <input name="token" type="password" autocomplete="current-password" required autofocus />
        </label>
      ) : (
        <>
          <label>
            User
            <input name="user" autocomplete="username" required autofocus />
          </label>
          <label>
            Password
            <input name="password" type="password" autocomplete="current-password" required />
          </label>
        </>
      )}
      {problem && (
        <p class="problem" role="alert">
          {problem}
        </p>
      )}
      <button type="submit" class="primary">
        Log in
      </button>
    </form>
  );
}
