// Arrow keys within a group of choices, as in other programs. They only move the focus: choosing needs Enter, because some choices go to the
// hoist at once. Space is STOP (stop_button.tsx).

/** Target of an arrow key among `count` choices; null: not an arrow. */
export function stepTo(key: string, at: number, count: number): number | null {
  const step = key === 'ArrowRight' || key === 'ArrowDown' ? 1 : key === 'ArrowLeft' || key === 'ArrowUp' ? -1 : 0;
  return step === 0 || count === 0 ? null : (at + step + count) % count;
}

/** onKeyDown of the group. */
export function radioKeys(event: KeyboardEvent & { currentTarget: HTMLElement }): void {
  const choices = [...event.currentTarget.querySelectorAll<HTMLElement>('[role=radio]:not(:disabled)')];
  const to = stepTo(event.key, choices.indexOf(event.target as HTMLElement), choices.length);
  if (to === null) return;
  event.preventDefault();
  choices[to]!.focus();
}
