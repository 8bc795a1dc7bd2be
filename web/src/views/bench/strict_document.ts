/** A document for xterm.js that keeps to the Content-Security-Policy. xterm.js makes style elements and style
 * attributes, which the policy forbids; here they become sheets and declarations of the CSSOM, which it allows. */

/** An element in the place of a style element: its text is a sheet that the document adopts. */
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

function element(name: string): HTMLElement {
  if (name === "style") return sheetElement();
  const made = document.createElement(name);
  made.setAttribute = (attribute: string, value: string) => {
    if (attribute === "style") made.style.cssText = value;
    else Element.prototype.setAttribute.call(made, attribute, value);
  };
  return made;
}

export const strictDocument: Document = new Proxy(document, {
  get(target, name) {
    if (name === "createElement") return element;
    const value: unknown = Reflect.get(target, name, target);
    return typeof value === "function" ? (value as (...given: unknown[]) => unknown).bind(target) : value;
  },
  set: (target, name, value) => Reflect.set(target, name, value, target),
});
