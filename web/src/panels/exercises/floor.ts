// The free floor that lines are drawn on, kept in this browser: the next line is drawn in the same room.
import { floorSide, type Floor } from './draft';

const storageKey = 'hoist.floor';
/** Holds while the page is open where storage is switched off. */
let chosen: Partial<Floor> = {};

function stored(): Partial<Floor> {
  try {
    return (JSON.parse(localStorage.getItem(storageKey) ?? '{}') as Partial<Floor> | null) ?? {};
  } catch {
    return {}; // storage is switched off, or holds something else
  }
}

export function keptFloor(): Floor {
  const kept = { ...stored(), ...chosen };
  const side = (value: unknown) => (typeof value === 'number' && value >= floorSide.least && value <= floorSide.most ? value : floorSide.usual);
  return { along_m: side(kept.along_m), across_m: side(kept.across_m) };
}

export function keepFloor(floor: Floor): Floor {
  chosen = floor;
  try {
    localStorage.setItem(storageKey, JSON.stringify(floor));
  } catch {
    // Then it lasts until the page is closed.
  }
  return floor;
}
