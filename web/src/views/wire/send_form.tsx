/** Sends a packet onto a segment: bytes, or the data of a framing that is known here. */

import { KeptForms } from "../../kept";
import { notify, notifyError } from "../../parts/notices";
import { hello, link } from "../../store";
import { hexOf, hexPairs, modbusCrc, readHex, sacPacket } from "./packet_text";

type Form = "hex" | "sac" | "modbus";
const forms = new KeptForms("wire.send");
/** Form of what is sent first, by a segment's framing. */
const FORMS: Record<string, Form> = { sac: "sac", modbus_rtu: "modbus" };

/** Bytes of what was typed; a text says what is wrong. */
function bytesOf(form: Form, text: string, to: string, from: string): Uint8Array | { fault: string } {
  if (form === "sac") {
    const address = (typed: string) => (/^\d+$/.test(typed) && Number(typed) <= 255 ? Number(typed) : undefined);
    const [destination, origin] = [address(to), address(from)];
    if (destination === undefined || origin === undefined) return { fault: "addresses are 0 to 255" };
    if ([2, 3].includes(destination) || [2, 3].includes(origin)) return { fault: "2 and 3 are no addresses: they frame packets" };
    if (!/^[\x20-\x7e]+$/.test(text)) return { fault: "write a command, as m3000: printable ASCII characters" };
    return sacPacket(destination, origin, text);
  }
  const bytes = readHex(text);
  if (form === "hex" || !(bytes instanceof Uint8Array)) return bytes;
  return Uint8Array.from([...bytes, ...modbusCrc(bytes)]);
}

export function SendForm({ segment, isDisabled }: { segment: string; isDisabled: boolean }) {
  const [chosen, setForm] = forms.field(segment, "form", FORMS[hello.peek()?.lines.get(segment)?.framing ?? ""] ?? "hex");
  const form: Form = chosen === "sac" || chosen === "modbus" ? chosen : "hex";
  const [text, setText] = forms.field(segment, "text");
  const [to, setTo] = forms.field(segment, "to", "85");
  const [from, setFrom] = forms.field(segment, "from", "1");
  const bytes = bytesOf(form, text, to, from);
  const fault = bytes instanceof Uint8Array ? "" : bytes.fault;
  const send = async () => {
    if (!(bytes instanceof Uint8Array)) {
      notify(bytes.fault, true);
      return;
    }
    try {
      await link.request({ do: "send", segment, data_hex: hexOf(bytes), ...link.soon() });
    } catch (error) {
      notifyError(error);
    }
  };
  return (
    <form class="row send" onSubmit={(event) => (event.preventDefault(), void send())} noValidate>
      <label>
        Send{" "}
        <select value={form} onChange={(event) => setForm(event.currentTarget.value)}>
          <option value="sac">SAC packet</option>
          <option value="modbus">Modbus RTU, with its CRC</option>
          <option value="hex">bytes as they are</option>
        </select>
      </label>
      {form === "sac" && (
        <>
          <label>
            to <input class="address" inputMode="numeric" value={to} onInput={(event) => setTo(event.currentTarget.value)} />
          </label>
          <label>
            from <input class="address" inputMode="numeric" value={from} onInput={(event) => setFrom(event.currentTarget.value)} />
          </label>
        </>
      )}
      <label class="grow">
        <span class="out-of-sight">{form === "sac" ? "Command" : "Bytes, hexadecimal"}</span>
        <input
          class="mono"
          value={text}
          placeholder={form === "sac" ? "m3000" : "01 03 00 00 00 02"}
          autocomplete="off"
          spellcheck={false}
          aria-invalid={text !== "" && fault ? "true" : undefined}
          title={fault}
          onInput={(event) => setText(event.currentTarget.value)}
        />
      </label>
      <button type="submit" class="primary" disabled={isDisabled || !text}>
        Send
      </button>
      <span class="mono soft bytes-out">{text && bytes instanceof Uint8Array ? hexPairs(hexOf(bytes)) : text ? fault : ""}</span>
    </form>
  );
}
