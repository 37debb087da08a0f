// What a device on the bus is called.
import { emergencies, type EmergencyInfo } from '../contract/emergencies.gen';
import { nodes } from '../contract/messages.gen';
import { t, textOf } from '../text/text';

const coreId = nodes.find((node) => node.name === 'core')!.id;

/** The device with this node id, or null. */
export function deviceOfNode(id: number | null): string | null {
  if (id === null || id === 0) return null;
  if (id === coreId) return t('device.secondCore');
  const node = nodes.find((row) => row.id === id);
  return (node ? textOf(`health.part.${node.name}`) : null) ?? t('device.unknown');
}

/** The device that sends under this CAN id (the low seven bits are its node id, as CANopen has it); null for none. */
export function deviceOfCan(id: number | null): string | null {
  if (id === null) return null;
  const node = nodes.find((row) => row.id === (id & 0x7f) && row.id !== coreId);
  return (node && id < 0x800 && id > 0x80 ? textOf(`health.part.${node.name}`) : null) ?? t('device.unknown');
}

/** The words for an emergency code: its own row, or that of its class. */
export const emergencyInfo = (code: number): EmergencyInfo => emergencies.find((row) => (code & row.mask) === row.code)!;

/** As engineers write it: 8250h. */
export const hex = (code: number): string => `${code.toString(16).toUpperCase().padStart(4, '0')}h`;
