// Whether this browser was ever signed in: then STOP is offered also without being signed in.
const storageKey = 'hoist.known';
let onThisPage = false;
export function wasSignedIn(): boolean {
  try {
    return onThisPage || localStorage.getItem(storageKey) !== null;
  } catch {
    return false; // storage is switched off
  }
}
export function rememberSignedIn(): void {
  onThisPage = true;
  try {
    localStorage.setItem(storageKey, '1');
  } catch {
    // Then only this page knows.
  }
}
