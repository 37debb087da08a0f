// An event of the log in words.
import { faults, modes } from '../contract/faults.gen';
import { params } from '../contract/params.gen';
import { plain, refusalText, shownAs, t, textOf, withUnit, words } from '../text/text';
import { emergencyInfo } from './device';

export function eventText(kind: string, name: string, value: number | null, before: number | null, code: number | null = null): string {
  const title = textOf(`event.${kind}`) ?? kind.replaceAll('_', ' ');
  const fault = faults.find((row) => row.name === name);
  const mode = modes.find((row) => row.name === name);
  const param = params.find((row) => row.name === name);
  if ((kind === 'calibration_result' || kind === 'parameter_settled') && param) {
    const show = shownAs(param.name, param.unit);
    return `${title}: ${words(param.title)} ${withUnit(plain((value ?? NaN) * show.factor), show.unit)}`;
  }
  if (kind === 'parameter_changed' && param) {
    const show = shownAs(param.name, param.unit);
    const number = (si: number | null) => (si === null ? '–' : plain(si * show.factor));
    return `${title}: ${words(param.title)} ${number(before)} → ${withUnit(number(value), show.unit)}`;
  }
  if (kind === 'sync_input') return `${title}: ${t(code === 1 ? 'event.syncOn' : 'event.syncOff')}`;
  if (kind === 'alarm_paused') return `${title}: ${t(code === 1 ? 'event.alarmPaused' : 'event.alarmSounds')}`;
  if (kind === 'command_refused' && name !== '') return `${title}: ${refusalText(name)}`;
  if (fault) return `${title}: ${words(fault.text)}`;
  if (mode) return `${title}: ${words(mode.title)}`;
  const part = textOf(`health.part.${name}`);
  if (kind === 'emergency') return `${part ?? t('device.unknown')}: ${words(emergencyInfo(code ?? 0).text)}`;
  if (part !== null) return `${title}: ${part}`;
  if (kind === 'marker' && name !== '') return `${title}: ${name}`;
  return title;
}
