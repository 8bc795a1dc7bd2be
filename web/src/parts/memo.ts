/** A component that is drawn again only where a property has changed. That of `preact/compat` does the same, but who imports it
 * changes how all elements of the page take their properties. */

import { Component, type FunctionComponent, h } from "preact";

export function memo<Props extends object>(Inner: FunctionComponent<Props>) {
  return class Memo extends Component<Props> {
    override shouldComponentUpdate(next: Props): boolean {
      const keys = new Set([...Object.keys(next), ...Object.keys(this.props)]) as Set<keyof Props>;
      return [...keys].some((key) => next[key] !== (this.props as Props)[key]);
    }

    render() {
      return h(Inner, this.props as Props);
    }
  };
}
