// Made by `deploy/dev gen` from control/contract/emergencies.def; do not edit.

import type { Words } from './faults.gen';

export interface EmergencyInfo {
  code: number;
  /** Bits of the code that count; of all rows that fit, the first one is meant. The last one fits every code. */
  mask: number;
  name: string;
  text: Words;
  /** For engineers. */
  detail: Words;
}

export const emergencies: readonly EmergencyInfo[] = [
  {
    code: 0x0000, mask: 0xFFFF, name: 'no_error',
    text: { en: 'An error has ended', de: 'Ein Fehler ist vorbei' },
    detail: { en: 'The error register says which remain.', de: 'Das Fehlerregister sagt, welche bleiben.' },
  },
  {
    code: 0x2310, mask: 0xFFFF, name: 'over_current',
    text: { en: 'The motor draws too much current', de: 'Der Motor zieht zu viel Strom' },
    detail: { en: 'Short circuit, blocked wheel, or a current limit set too high.', de: 'Kurzschluss, blockiertes Rad oder zu hohe Stromgrenze.' },
  },
  {
    code: 0x2300, mask: 0xFF00, name: 'current_class',
    text: { en: 'Something is wrong with the motor current', de: 'Mit dem Motorstrom stimmt etwas nicht' },
    detail: { en: 'Current at the output: measure bridge and motor.', de: 'Strom am Ausgang: Brücke und Motor messen.' },
  },
  {
    code: 0x2000, mask: 0xF000, name: 'current_any',
    text: { en: 'Something is wrong with a current', de: 'Mit einem Strom stimmt etwas nicht' },
    detail: { en: 'Current in the device.', de: 'Strom im Gerät.' },
  },
  {
    code: 0x3210, mask: 0xFFFF, name: 'over_voltage',
    text: { en: 'The supply voltage is too high', de: 'Die Versorgungsspannung ist zu hoch' },
    detail: { en: 'Braking feeds the batteries back: full batteries, or a lost battery connection.', de: 'Bremsen speist zurück: volle Batterien oder unterbrochene Batterieleitung.' },
  },
  {
    code: 0x3220, mask: 0xFFFF, name: 'under_voltage',
    text: { en: 'The supply voltage is too low', de: 'Die Versorgungsspannung ist zu niedrig' },
    detail: { en: 'Empty batteries, a fuse, or a bad contact under load.', de: 'Leere Batterien, Sicherung oder schlechter Kontakt unter Last.' },
  },
  {
    code: 0x3000, mask: 0xF000, name: 'voltage_any',
    text: { en: 'Something is wrong with a voltage', de: 'Mit einer Spannung stimmt etwas nicht' },
    detail: { en: 'Mains, inside or output voltage.', de: 'Eingangs-, Innen- oder Ausgangsspannung.' },
  },
  {
    code: 0x4310, mask: 0xFFFF, name: 'over_temperature_motor',
    text: { en: 'The motor is too hot', de: 'Der Motor ist zu heiß' },
    detail: { en: 'I2t model or sensor: overload over minutes. Let it cool.', de: 'I²t-Modell oder Fühler: Überlast über Minuten. Abkühlen lassen.' },
  },
  {
    code: 0x4000, mask: 0xF000, name: 'temperature_any',
    text: { en: 'Something is too hot', de: 'Etwas ist zu heiß' },
    detail: { en: 'Temperature of ambience, device or drive.', de: 'Temperatur von Umgebung, Gerät oder Antrieb.' },
  },
  {
    code: 0x5530, mask: 0xFFFF, name: 'memory_fault',
    text: { en: 'Its stored settings are damaged', de: 'Die gespeicherten Einstellungen sind beschädigt' },
    detail: { en: 'Both copies of the parameters are unreadable; it runs on its defaults. Store them again.', de: 'Beide Kopien der Parameter sind unlesbar; es gelten die Vorgaben. Neu speichern.' },
  },
  {
    code: 0x5000, mask: 0xF000, name: 'hardware',
    text: { en: 'Its electronics report a fault', de: 'Die Elektronik meldet eine Störung' },
    detail: { en: 'Hardware of the device: bridge driver, sensor chip or self-test. The further bytes and the error register say more.', de: 'Gerätehardware: Brückentreiber, Sensorchip oder Selbsttest. Die weiteren Bytes und das Fehlerregister sagen mehr.' },
  },
  {
    code: 0x6010, mask: 0xFFFF, name: 'watchdog_reset',
    text: { en: 'Its program was restarted by the watchdog', de: 'Das Programm wurde vom Wächter neu gestartet' },
    detail: { en: 'The program stood still and the watchdog reset it. Read the fault snapshot and report it.', de: 'Das Programm stand still, der Wächter hat es neu gestartet. Störungsabbild lesen und melden.' },
  },
  {
    code: 0x6310, mask: 0xFFFF, name: 'parameters_lost',
    text: { en: 'Its stored settings are lost', de: 'Die gespeicherten Einstellungen sind verloren' },
    detail: { en: 'Parameters are missing; it runs on its defaults. Store them again.', de: 'Parameter fehlen; es gelten die Vorgaben. Neu speichern.' },
  },
  {
    code: 0x6000, mask: 0xF000, name: 'software',
    text: { en: 'Its program reports a fault', de: 'Das Programm meldet eine Störung' },
    detail: { en: 'Software or data set of the device.', de: 'Software oder Datensatz des Geräts.' },
  },
  {
    code: 0x7121, mask: 0xFFFF, name: 'motor_blocked',
    text: { en: 'The wheel was blocked', de: 'Das Rad war blockiert' },
    detail: { en: 'Full current, no movement, and no voltage from the motor: a sill, a cable or a foot; if none, brake or gear.', de: 'Voller Strom, keine Bewegung und keine Spannung vom Motor: Schwelle, Kabel oder Fuß; sonst Bremse oder Getriebe.' },
  },
  {
    code: 0x7305, mask: 0xFFFF, name: 'encoder',
    text: { en: 'The wheel\'s rotation sensor reports a fault', de: 'Der Drehgeber des Rads meldet eine Störung' },
    detail: { en: 'Encoder: a line is broken, counts backward, or both lines change at once.', de: 'Drehgeber: Leitung unterbrochen, zählt rückwärts oder beide Spuren springen zugleich.' },
  },
  {
    code: 0x7300, mask: 0xFF00, name: 'sensor',
    text: { en: 'A sensor reports a fault', de: 'Ein Sensor meldet eine Störung' },
    detail: { en: 'Sensor of the device.', de: 'Sensor des Geräts.' },
  },
  {
    code: 0x7000, mask: 0xF000, name: 'module',
    text: { en: 'A part of the device reports a fault', de: 'Ein Teil des Geräts meldet eine Störung' },
    detail: { en: 'Additional module.', de: 'Zusatzmodul.' },
  },
  {
    code: 0x8110, mask: 0xFFFF, name: 'can_overrun',
    text: { en: 'It lost messages', de: 'Es hat Nachrichten verloren' },
    detail: { en: 'CAN overrun: a frame was lost inside the node.', de: 'CAN-Überlauf: eine Nachricht ging im Knoten verloren.' },
  },
  {
    code: 0x8120, mask: 0xFFFF, name: 'can_passive',
    text: { en: 'Its connection to the bus is poor', de: 'Die Verbindung zum Bus ist schlecht' },
    detail: { en: 'CAN error passive: check plug, cable and terminators.', de: 'CAN error passive: Stecker, Kabel und Abschlusswiderstände prüfen.' },
  },
  {
    code: 0x8130, mask: 0xFFFF, name: 'heartbeat_lost',
    text: { en: 'It no longer hears the control computer', de: 'Es hört die Steuerung nicht mehr' },
    detail: { en: 'Heartbeat of the core missing for 250 ms: the core ended, or the bus is broken between them.', de: 'Lebenszeichen der Steuerung fehlt seit 250 ms: Steuerung beendet oder Bus dazwischen unterbrochen.' },
  },
  {
    code: 0x8140, mask: 0xFFFF, name: 'bus_off_recovered',
    text: { en: 'It had dropped off the bus and is back', de: 'Es war vom Bus getrennt und ist zurück' },
    detail: { en: 'Recovered from bus-off: check plug, cable and terminators.', de: 'Zurück aus Bus-off: Stecker, Kabel und Abschlusswiderstände prüfen.' },
  },
  {
    code: 0x8210, mask: 0xFFFF, name: 'pdo_length',
    text: { en: 'It received a message that was too short', de: 'Es erhielt eine zu kurze Nachricht' },
    detail: { en: 'PDO too short: another program on the bus, or software versions that do not fit.', de: 'PDO zu kurz: ein fremdes Programm am Bus oder unpassende Softwarestände.' },
  },
  {
    code: 0x8220, mask: 0xFFFF, name: 'pdo_length_exceeded',
    text: { en: 'It received a message that was too long', de: 'Es erhielt eine zu lange Nachricht' },
    detail: { en: 'PDO length exceeded: another program on the bus, or software versions that do not fit.', de: 'PDO-Länge überschritten: ein fremdes Programm am Bus oder unpassende Softwarestände.' },
  },
  {
    code: 0x8250, mask: 0xFFFF, name: 'rpdo_timeout',
    text: { en: 'Its commands stopped coming; it braked by itself', de: 'Die Befehle blieben aus; es hat selbst gebremst' },
    detail: { en: 'RPDO deadline of 45 ms passed: the core ended or was held up, or the bus is broken.', de: 'RPDO-Frist von 45 ms überschritten: Steuerung beendet oder aufgehalten, oder Bus unterbrochen.' },
  },
  {
    code: 0x8400, mask: 0xFFFF, name: 'over_speed',
    text: { en: 'The wheel turned faster than allowed', de: 'Das Rad drehte schneller als erlaubt' },
    detail: { en: 'Speed monitor of the drive.', de: 'Drehzahlüberwachung des Antriebs.' },
  },
  {
    code: 0x8000, mask: 0xF000, name: 'monitoring',
    text: { en: 'It has trouble with the bus', de: 'Es hat Schwierigkeiten mit dem Bus' },
    detail: { en: 'Communication or monitoring of the device.', de: 'Kommunikation oder Überwachung des Geräts.' },
  },
  {
    code: 0x9000, mask: 0xF000, name: 'external',
    text: { en: 'It reports a fault outside itself', de: 'Es meldet eine Störung von außen' },
    detail: { en: 'External error.', de: 'Externer Fehler.' },
  },
  {
    code: 0xF000, mask: 0xF000, name: 'additional',
    text: { en: 'It reports a fault of its own kind', de: 'Es meldet eine eigene Störung' },
    detail: { en: 'Manufacturer\'s own code: see the firmware of the node.', de: 'Herstellereigener Code: siehe Firmware des Knotens.' },
  },
  {
    code: 0x0000, mask: 0x0000, name: 'generic',
    text: { en: 'It reports a fault', de: 'Es meldet eine Störung' },
    detail: { en: 'A code without its own words.', de: 'Ein Code ohne eigene Worte.' },
  },
];
