/** A part of the page whose own faults are told in its place: the rest of the page stays. */

import { Component, type ComponentChildren } from "preact";

interface State {
  fault: string | null;
}

export class Guarded extends Component<{ children: ComponentChildren }, State> {
  override state: State = { fault: null };

  override componentDidCatch(error: unknown): void {
    console.error(error);
    this.setState({ fault: error instanceof Error ? error.message : String(error) });
  }

  override render() {
    if (this.state.fault === null) return this.props.children;
    return (
      <div class="card" role="alert">
        <p class="problem">This view met a fault of the page's own: {this.state.fault}</p>
        <button type="button" onClick={() => this.setState({ fault: null })}>
          Try again
        </button>
      </div>
    );
  }
}
