/** Files that are chosen or dropped, and saved. */

import { useRef } from "preact/hooks";

/** Offer bytes as a file. */
export function saveFile(name: string, bytes: Uint8Array, type = "text/plain"): void {
  const url = URL.createObjectURL(new Blob([bytes as Uint8Array<ArrayBuffer>], { type }));
  const anchor = document.createElement("a");
  anchor.href = url;
  anchor.download = name;
  document.body.append(anchor);
  anchor.click();
  anchor.remove();
  window.setTimeout(() => URL.revokeObjectURL(url), 10_000);
}

interface LoadProps {
  label: string;
  isDisabled?: boolean;
  take(name: string, bytes: Uint8Array): void;
}

/** Button that lets a file be chosen. */
export function LoadButton({ label, isDisabled = false, take }: LoadProps) {
  const input = useRef<HTMLInputElement>(null);
  const chosen = async (files: FileList | null) => {
    const file = files?.[0];
    if (!file) return;
    take(file.name, new Uint8Array(await file.arrayBuffer()));
    if (input.current) input.current.value = "";
  };
  return (
    <>
      <button type="button" disabled={isDisabled} onClick={() => input.current?.click()}>
        {label}
      </button>
      <input
        ref={input}
        type="file"
        class="out-of-sight"
        tabIndex={-1}
        accept=".txt,.csv,text/plain"
        aria-label={label}
        onChange={(event) => void chosen(event.currentTarget.files)}
      />
    </>
  );
}
