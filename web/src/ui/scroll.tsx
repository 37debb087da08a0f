// A list with its own scroll area: reachable and scrollable by keyboard, named for screen readers.
import type { ComponentChildren } from 'preact';
import './scroll.css';

export function Scroll({ label, class: kind, children }: { label: string; class: string; children: ComponentChildren }) {
  return (
    <div class={kind} role="region" aria-label={label} tabIndex={0}>
      {children}
    </div>
  );
}
