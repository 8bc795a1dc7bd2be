/** Write a text into an element that has nothing else, if it is another one: into the text that is there, which costs less than a new
 * one. */
export function write(place: Element | null | undefined, text: string): void {
  const there = place?.firstChild;
  if (!there) place?.append(text);
  else if (there.nodeValue !== text) there.nodeValue = text;
}
