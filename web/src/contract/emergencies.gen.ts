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
    detail: { en: 'The error register names those that remain.', de: 'Das Fehlerregister nennt die verbliebenen.' },
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
    detail: { en: 'Current in the node.', de: 'Strom in der Baugruppe.' },
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
    detail: { en: 'Temperature of ambience, node or drive.', de: 'Temperatur von Umgebung, Baugruppe oder Antrieb.' },
  },
  {
    code: 0x5530, mask: 0xFFFF, name: 'memory_fault',
    text: { en: 'The stored settings are damaged', de: 'Die gespeicherten Einstellungen sind beschädigt' },
    detail: { en: 'Both copies of the parameters are unreadable; defaults are in force. Store them again.', de: 'Beide Kopien der Parameter sind unlesbar; es gelten die Vorgaben. Neu speichern.' },
  },
  {
    code: 0x5000, mask: 0xF000, name: 'hardware',
    text: { en: 'The electronics report a fault', de: 'Die Elektronik meldet eine Störung' },
    detail: { en: 'Hardware of the node: bridge driver, sensor chip or self-test. See the further bytes and the error register.', de: 'Hardware: Brückentreiber, Sensorchip oder Selbsttest. Siehe weitere Bytes und Fehlerregister.' },
  },
  {
    code: 0x6010, mask: 0xFFFF, name: 'watchdog_reset',
    text: { en: 'The watchdog has restarted the program', de: 'Der Watchdog hat das Programm neu gestartet' },
    detail: { en: 'The program had stopped running. Read the fault snapshot and report it.', de: 'Das Programm war stehen geblieben. Störungsabbild lesen und melden.' },
  },
  {
    code: 0x6310, mask: 0xFFFF, name: 'parameters_lost',
    text: { en: 'The stored settings are lost', de: 'Die gespeicherten Einstellungen sind verloren' },
    detail: { en: 'Parameters are missing; defaults are in force. Store them again.', de: 'Parameter fehlen; es gelten die Vorgaben. Neu speichern.' },
  },
  {
    code: 0x6000, mask: 0xF000, name: 'software',
    text: { en: 'The program reports a fault', de: 'Das Programm meldet eine Störung' },
    detail: { en: 'Software or data set of the node.', de: 'Software oder Datensatz der Baugruppe.' },
  },
  {
    code: 0x7121, mask: 0xFFFF, name: 'motor_blocked',
    text: { en: 'The wheel was blocked', de: 'Das Rad war blockiert' },
    detail: { en: 'Full current, no movement, no voltage from the motor: sill, cable or foot; else brake or gear.', de: 'Voller Strom, keine Bewegung und keine Spannung vom Motor: Schwelle, Kabel oder Fuß; sonst Bremse oder Getriebe.' },
  },
  {
    code: 0x7305, mask: 0xFFFF, name: 'encoder',
    text: { en: 'The wheel\'s rotation sensor reports a fault', de: 'Der Drehgeber des Rads meldet eine Störung' },
    detail: { en: 'Encoder: a line is broken, counts backward, or both lines change at once.', de: 'Drehgeber: Leitung unterbrochen, zählt rückwärts oder beide Spuren springen zugleich.' },
  },
  {
    code: 0x7300, mask: 0xFF00, name: 'sensor',
    text: { en: 'A sensor reports a fault', de: 'Ein Sensor meldet eine Störung' },
    detail: { en: 'Sensor of the node.', de: 'Sensor der Baugruppe.' },
  },
  {
    code: 0x7000, mask: 0xF000, name: 'module',
    text: { en: 'A part of the node reports a fault', de: 'Ein Teil der Baugruppe meldet eine Störung' },
    detail: { en: 'Additional module.', de: 'Zusatzmodul.' },
  },
  {
    code: 0x8110, mask: 0xFFFF, name: 'can_overrun',
    text: { en: 'Messages were lost', de: 'Nachrichten gingen verloren' },
    detail: { en: 'CAN overrun: a frame was lost inside the node.', de: 'CAN-Überlauf: eine Nachricht ging im Knoten verloren.' },
  },
  {
    code: 0x8120, mask: 0xFFFF, name: 'can_passive',
    text: { en: 'The connection to the bus is poor', de: 'Die Verbindung zum Bus ist schlecht' },
    detail: { en: 'CAN error passive: check plug, cable and terminators.', de: 'CAN error passive: Stecker, Kabel und Abschlusswiderstände prüfen.' },
  },
  {
    code: 0x8130, mask: 0xFFFF, name: 'heartbeat_lost',
    text: { en: 'No message from the control computer', de: 'Keine Nachricht vom Steuerrechner' },
    detail: { en: 'Heartbeat of the core missing for 250 ms: core ended, or bus broken in between.', de: 'Heartbeat des Steuerrechners fehlt seit 250 ms: Programm beendet oder Bus dazwischen unterbrochen.' },
  },
  {
    code: 0x8140, mask: 0xFFFF, name: 'bus_off_recovered',
    text: { en: 'Back after it was cut off from the bus', de: 'Zurück nach Trennung vom Bus' },
    detail: { en: 'Recovered from bus-off: check plug, cable and terminators.', de: 'Zurück aus Bus-off: Stecker, Kabel und Abschlusswiderstände prüfen.' },
  },
  {
    code: 0x8210, mask: 0xFFFF, name: 'pdo_length',
    text: { en: 'A message was too short', de: 'Eine Nachricht war zu kurz' },
    detail: { en: 'PDO too short: another program on the bus, or software versions that do not fit.', de: 'PDO zu kurz: ein fremdes Programm am Bus oder unpassende Softwarestände.' },
  },
  {
    code: 0x8220, mask: 0xFFFF, name: 'pdo_length_exceeded',
    text: { en: 'A message was too long', de: 'Eine Nachricht war zu lang' },
    detail: { en: 'PDO length exceeded: another program on the bus, or software versions that do not fit.', de: 'PDO-Länge überschritten: ein fremdes Programm am Bus oder unpassende Softwarestände.' },
  },
  {
    code: 0x8250, mask: 0xFFFF, name: 'rpdo_timeout',
    text: { en: 'No more commands: the drive braked by itself', de: 'Keine Befehle mehr: der Antrieb hat selbst gebremst' },
    detail: { en: 'RPDO deadline of 45 ms passed: core ended or delayed, or bus broken.', de: 'RPDO-Frist von 45 ms überschritten: Steuerprogramm beendet oder aufgehalten, oder Bus unterbrochen.' },
  },
  {
    code: 0x8400, mask: 0xFFFF, name: 'over_speed',
    text: { en: 'The wheel turned faster than allowed', de: 'Das Rad drehte schneller als erlaubt' },
    detail: { en: 'Speed monitor of the drive.', de: 'Drehzahlüberwachung des Antriebs.' },
  },
  {
    code: 0x8000, mask: 0xF000, name: 'monitoring',
    text: { en: 'Trouble with the bus', de: 'Schwierigkeiten mit dem Bus' },
    detail: { en: 'Communication or monitoring of the node.', de: 'Kommunikation oder Überwachung der Baugruppe.' },
  },
  {
    code: 0x9000, mask: 0xF000, name: 'external',
    text: { en: 'A fault outside the node', de: 'Eine Störung von außen' },
    detail: { en: 'External error.', de: 'Externer Fehler.' },
  },
  {
    code: 0xF000, mask: 0xF000, name: 'additional',
    text: { en: 'A fault of its own kind', de: 'Eine herstellereigene Störung' },
    detail: { en: 'Manufacturer\'s own code: see the firmware of the node.', de: 'Herstellereigener Code: siehe Firmware des Knotens.' },
  },
  {
    code: 0x0000, mask: 0x0000, name: 'generic',
    text: { en: 'A fault', de: 'Eine Störung' },
    detail: { en: 'A code without a text of its own.', de: 'Ein Code ohne eigenen Text.' },
  },
];
