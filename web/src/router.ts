// The address of what is shown: #/SCREEN or #/SCREEN/PART, so that a session has a link and the browser's Back works (DECISIONS 45).
import { useEffect, useState } from 'preact/hooks';

export interface Address {
  screen: string;
  /** The part of the screen, for example the number of a session. */
  part: string | null;
}

/** Reads the part of an address behind "#". An invalid address gives an empty screen name. */
export function readAddress(hash: string): Address {
  const [, screen = '', part = ''] = hash.replace(/^#/, '').split('?', 1)[0]!.split('/');
  try {
    return { screen: decodeURIComponent(screen), part: part === '' ? null : decodeURIComponent(part) };
  } catch {
    return { screen: '', part: null }; // a broken %-escape
  }
}

export const addressOf = (screen: string, part?: string | number | null): string =>
  `#/${screen}${part === undefined || part === null ? '' : `/${encodeURIComponent(part)}`}`;

/** Shows another address. With `replace`, Back does not lead to the present one. */
export function go(address: string, replace = false): void {
  if (replace) location.replace(address);
  else location.hash = address;
}

/** The present address; renders the component when it changes. */
export function useAddress(): Address {
  const [hash, setHash] = useState(location.hash);
  useEffect(() => {
    const change = () => setHash(location.hash);
    window.addEventListener('hashchange', change);
    change(); // it may have changed before anyone listened
    return () => window.removeEventListener('hashchange', change);
  }, []);
  return readAddress(hash);
}
