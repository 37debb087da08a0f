// Columns that a chart offers, with the names and units of the contract. Written out, because the whole table of signals would cost 4 kB of
// page; a test compares them with it.
import type { Words } from '../../contract/params.gen';
import type { SignalName } from '../../contract/signals.gen';

export interface Curve {
  name: SignalName;
  unit: string;
  title: Words;
}
export const curves: readonly Curve[] = [
  { name: 'speed_m_s', unit: 'm/s', title: { en: 'Speed', de: 'Tempo' } },
  { name: 'speed_command_m_s', unit: 'm/s', title: { en: 'Commanded speed', de: 'Befohlenes Tempo' } },
  { name: 'lean_norm', unit: '', title: { en: 'Intent to move', de: 'Absicht zu gehen' } },
  { name: 'turn_norm', unit: '', title: { en: 'Intent to turn', de: 'Absicht zu drehen' } },
  { name: 'yaw_rate_rad_s', unit: 'rad/s', title: { en: 'Turn rate', de: 'Drehrate' } },
  { name: 'dx_m', unit: 'm', title: { en: 'Lean of the harness', de: 'Neigung des Gurts' } },
  { name: 'dy_m', unit: 'm', title: { en: 'Sway of the harness', de: 'Seitliches Pendeln' } },
  { name: 'left_alpha_rad', unit: 'rad', title: { en: 'Left strut, forward', de: 'Linke Strebe, vor' } },
  { name: 'right_alpha_rad', unit: 'rad', title: { en: 'Right strut, forward', de: 'Rechte Strebe, vor' } },
  { name: 'left_current_a', unit: 'A', title: { en: 'Left motor current', de: 'Motorstrom links' } },
  { name: 'right_current_a', unit: 'A', title: { en: 'Right motor current', de: 'Motorstrom rechts' } },
  { name: 'battery_a_v', unit: 'V', title: { en: 'Battery A', de: 'Batterie A' } },
  { name: 'battery_b_v', unit: 'V', title: { en: 'Battery B', de: 'Batterie B' } },
];

/** The chosen curves by their unit, in the order of choice: each strip of the chart has one axis, and an axis has one unit. */
export function strips(names: readonly SignalName[]): Curve[][] {
  const byUnit = new Map<string, Curve[]>();
  for (const curve of names.map((name) => curves.find((one) => one.name === name)!))
    byUnit.set(curve.unit, [...(byUnit.get(curve.unit) ?? []), curve]);
  return [...byUnit.values()];
}
