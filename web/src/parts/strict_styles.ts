/** Style sheets of xterm.js and CodeMirror under a strict Content-Security-Policy. It makes style elements when it opens, which the
 * policy forbids; here they become sheets that the document adopts, which it allows. Colours that no sheet has it writes
 * as attributes, which the policy forbids, too; here they are set as properties. */

/** An element in the place of a style element: its text is the text of an adopted sheet. */
function sheetElement(): HTMLElement {
  const element = document.createElement("hil-sheet");
  element.hidden = true;
  const sheet = new CSSStyleSheet();
  document.adoptedStyleSheets = [...document.adoptedStyleSheets, sheet];
  let text = "";
  Object.defineProperty(element, "textContent", {
    get: () => text,
    set: (value: string) => {
      text = value;
      sheet.replaceSync(value);
    },
  });
  element.remove = () => {
    document.adoptedStyleSheets = document.adoptedStyleSheets.filter((each) => each !== sheet);
    Element.prototype.remove.call(element);
  };
  return element;
}

/** Do something meanwhile style elements that are made become adopted sheets. */
export function withSheets(work: () => void): void {
  const make = Document.prototype.createElement;
  const strict = (name: string, options?: ElementCreationOptions) => (name === "style" ? sheetElement() : make.call(document, name, options));
  const own = document as { createElement?: typeof strict };
  own.createElement = strict;
  try {
    work();
  } finally {
    delete own.createElement;
  }
}

/** Let a style that is given to a span as an attribute be set by properties. */
export function takeSpanStyles(): void {
  const usual = Element.prototype.setAttribute;
  HTMLSpanElement.prototype.setAttribute = function (this: HTMLSpanElement, name: string, value: string): void {
    if (name === "style") this.style.cssText = value;
    else usual.call(this, name, value);
  };
}
