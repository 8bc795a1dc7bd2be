/** Sends frames on a CAN bus, from a node of the page's own, which is put there with the first frame. */

import { KeptForms } from "../../kept";
import { notify, notifyError } from "../../parts/notices";
import { link, status } from "../../store";
import { canFrame } from "./can_text";

/** Name of the node on the bus, which all pages share. */
const NODE = "page";
const forms = new KeptForms("wire.can_send");

export function CanSend({ bus, isDisabled }: { bus: string; isDisabled: boolean }) {
  const [id, setId] = forms.field(bus, "id");
  const [data, setData] = forms.field(bus, "data");
  const [extended, setExtended] = forms.field(bus, "extended");
  const [remote, setRemote] = forms.field(bus, "remote");
  const [isExtended, isRemote] = [extended === "true", remote === "true"];
  const label = `${bus}.${NODE}`;
  const isThere = status.value.buses?.some((each) => each.bus === bus && each.nodes.some(({ node, state }) => node === label && state !== "off")) ?? false;
  const made = canFrame({ id, data, isExtended, isRemote });
  const fault = "fault" in made ? made.fault : "";
  const send = async () => {
    if (!("frame" in made)) {
      notify(made.fault, true);
      return;
    }
    try {
      await link.ask("attach", bus, { node: NODE });
      const { refused } = await link.ask("transmit", label, { frames: [made.frame] });
      if (refused) notify(`${label} has no room for the frame: those before it wait. Does another node acknowledge them?`, true);
    } catch (error) {
      notifyError(error);
    }
  };
  return (
    <form class="row send" onSubmit={(event) => (event.preventDefault(), void send())} noValidate>
      <label>
        Identifier{" "}
        <input
          class="mono identifier"
          value={id}
          placeholder={isExtended ? "0000CAFE" : "605"}
          autocomplete="off"
          spellcheck={false}
          aria-invalid={id !== "" && fault ? "true" : undefined}
          onInput={(event) => setId(event.currentTarget.value)}
        />
      </label>
      <label>
        <input type="checkbox" checked={isExtended} onChange={(event) => setExtended(String(event.currentTarget.checked))} /> 29 bits
      </label>
      <label>
        <input type="checkbox" checked={isRemote} onChange={(event) => setRemote(String(event.currentTarget.checked))} /> remote
      </label>
      <label class="grow">
        <span class="out-of-sight">{isRemote ? "Number of bytes" : "Data, hexadecimal"}</span>
        <input
          class="mono"
          value={data}
          placeholder={isRemote ? "0 to 8 bytes" : "40 00 10 00 00 00 00 00"}
          autocomplete="off"
          spellcheck={false}
          aria-invalid={data !== "" && fault ? "true" : undefined}
          onInput={(event) => setData(event.currentTarget.value)}
        />
      </label>
      <button type="submit" class="primary" disabled={isDisabled || !id}>
        Send
      </button>
      {isThere && (
        <button
          type="button"
          disabled={isDisabled}
          title={`The page sends as ${label}, which also acknowledges what others send`}
          onClick={() => void link.ask("detach", label, {}).catch(notifyError)}
        >
          Take {label} off
        </button>
      )}
      <span class={`mono bytes-out ${fault ? "problem" : "soft"}`}>{id ? ("frame" in made ? made.frame : fault) : ""}</span>
    </form>
  );
}
