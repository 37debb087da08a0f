// Whether this browser was ever signed in: then STOP is offered also without being signed in.
const storageKey = 'hoist.known';
export function wasSignedIn(): boolean {
  try {
    return localStorage.getItem(storageKey) !== null;
  } catch {
    return false; // storage is switched off
  }
}
export function rememberSignedIn(): void {
  try {
    localStorage.setItem(storageKey, '1');
  } catch {
    // Then only this page knows.
  }
}
