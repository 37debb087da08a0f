// Made by `deploy/dev gen` from control/contract/faults.def; do not edit.

export interface Words {
  en: string;
  de: string;
}

export type FaultName =
  | 'tilt_left_lost'
  | 'tilt_right_lost'
  | 'tilt_base_lost'
  | 'drive_left_lost'
  | 'drive_right_lost'
  | 'io_lost'
  | 'drive_left_fault'
  | 'drive_right_fault'
  | 'tilt_implausible'
  | 'tilt_frozen'
  | 'bumper_pressed'
  | 'fall_detected'
  | 'battery_empty'
  | 'supply_high'
  | 'battery_low'
  | 'remote_command_lost'
  | 'server_lost'
  | 'overspeed'
  | 'loop_overrun'
  | 'gate_refused'
  | 'stop_pressed'
  | 'tilt_sensor_fault'
  | 'bus_down'
  | 'node_duplicate'
  | 'node_babbling'
  | 'base_tilted'
  | 'base_tilt_high'
  | 'patient_hanging'
  | 'battery_uneven'
  | 'emergency_stop'
  | 'parameters_corrupt'
  | 'control_fault'
  | 'wheel_slip'
  | 'console_lost';

export type RefusalName =
  | 'not_standby'
  | 'nodes_missing'
  | 'fault_active'
  | 'not_neutral'
  | 'moving'
  | 'battery_empty_start'
  | 'sensors_settling'
  | 'no_lease'
  | 'stick_not_neutral'
  | 'out_of_range'
  | 'not_finite'
  | 'unknown_item'
  | 'only_when_stopped'
  | 'stale_command'
  | 'inconsistent_set'
  | 'cause_not_cleared'
  | 'bumper_start'
  | 'out_of_order'
  | 'not_allowed'
  | 'fault_mode'
  | 'emergency_stop_open'
  | 'set_outdated'
  | 'node_version'
  | 'no_exercise'
  | 'exercise_limits'
  | 'release_first'
  | 'not_calibrated'
  | 'cause_not_seen'
  | 'harness_unconfirmed'
  | 'parts_unchecked'
  | 'busy';

export type ModeName =
  | 'init'
  | 'standby'
  | 'user'
  | 'remote'
  | 'protective_stop'
  | 'calibrate'
  | 'guided'
  | 'fault'
  | 'emergency_stop';

export interface FaultInfo {
  /** Place in fault_bits: one of 53, which a number holds exactly. */
  bit: number;
  name: FaultName;
  priority: 'high' | 'medium' | 'low';
  reaction: 'warn' | 'soft_stop' | 'protective_stop' | 'out_of_service' | 'power_off';
  text: Words;
  /** What to do next. */
  action: Words;
}

export const faults: readonly FaultInfo[] = [
  {
    bit: 0, name: 'tilt_left_lost', priority: 'high', reaction: 'protective_stop',
    text: { en: 'Left strut sensor does not answer', de: 'Sensor der linken Strebe antwortet nicht' },
    action: { en: 'Check its plug, then release the stop.', de: 'Stecker prüfen, dann Halt freigeben.' },
  },
  {
    bit: 1, name: 'tilt_right_lost', priority: 'high', reaction: 'protective_stop',
    text: { en: 'Right strut sensor does not answer', de: 'Sensor der rechten Strebe antwortet nicht' },
    action: { en: 'Check its plug, then release the stop.', de: 'Stecker prüfen, dann Halt freigeben.' },
  },
  {
    bit: 2, name: 'tilt_base_lost', priority: 'high', reaction: 'protective_stop',
    text: { en: 'Chassis sensor does not answer', de: 'Sensor des Fahrgestells antwortet nicht' },
    action: { en: 'Check its plug, then release the stop.', de: 'Stecker prüfen, dann Halt freigeben.' },
  },
  {
    bit: 3, name: 'drive_left_lost', priority: 'high', reaction: 'protective_stop',
    text: { en: 'Left drive does not answer', de: 'Linker Antrieb antwortet nicht' },
    action: { en: 'Hold the patient, check its plug, then release the stop.', de: 'Patienten sichern, Stecker prüfen, dann Halt freigeben.' },
  },
  {
    bit: 4, name: 'drive_right_lost', priority: 'high', reaction: 'protective_stop',
    text: { en: 'Right drive does not answer', de: 'Rechter Antrieb antwortet nicht' },
    action: { en: 'Hold the patient, check its plug, then release the stop.', de: 'Patienten sichern, Stecker prüfen, dann Halt freigeben.' },
  },
  {
    bit: 5, name: 'io_lost', priority: 'high', reaction: 'protective_stop',
    text: { en: 'Bumpers and batteries do not answer', de: 'Stoßfänger und Batterien antworten nicht' },
    action: { en: 'Check their plug, then release the stop.', de: 'Stecker prüfen, dann Halt freigeben.' },
  },
  {
    bit: 6, name: 'drive_left_fault', priority: 'high', reaction: 'protective_stop',
    text: { en: 'Left drive reports a fault', de: 'Linker Antrieb meldet eine Störung' },
    action: { en: 'Release the stop; call service if it comes back.', de: 'Halt freigeben; kommt sie wieder, Service rufen.' },
  },
  {
    bit: 7, name: 'drive_right_fault', priority: 'high', reaction: 'protective_stop',
    text: { en: 'Right drive reports a fault', de: 'Rechter Antrieb meldet eine Störung' },
    action: { en: 'Release the stop; call service if it comes back.', de: 'Halt freigeben; kommt sie wieder, Service rufen.' },
  },
  {
    bit: 8, name: 'tilt_implausible', priority: 'high', reaction: 'protective_stop',
    text: { en: 'A tilt sensor reports impossible values', de: 'Ein Neigungssensor meldet unmögliche Werte' },
    action: { en: 'Check that the sensors sit firmly, then release the stop.', de: 'Festen Sitz der Sensoren prüfen, dann Halt freigeben.' },
  },
  {
    bit: 9, name: 'tilt_frozen', priority: 'high', reaction: 'protective_stop',
    text: { en: 'A tilt sensor has frozen', de: 'Ein Neigungssensor ist eingefroren' },
    action: { en: 'Switch the hoist off and on; call service if it comes back.', de: 'Aus- und einschalten; kommt es wieder, Service rufen.' },
  },
  {
    bit: 10, name: 'bumper_pressed', priority: 'high', reaction: 'protective_stop',
    text: { en: 'A bumper touches something', de: 'Ein Stoßfänger berührt etwas' },
    action: { en: 'Clear the way, then release the stop.', de: 'Weg frei machen, dann Halt freigeben.' },
  },
  {
    bit: 11, name: 'fall_detected', priority: 'high', reaction: 'protective_stop',
    text: { en: 'The patient is falling or hanging at the stop', de: 'Der Patient fällt oder hängt im Anschlag' },
    action: { en: 'Help the patient upright, then release the stop.', de: 'Patienten aufrichten, dann Halt freigeben.' },
  },
  {
    bit: 12, name: 'battery_empty', priority: 'medium', reaction: 'soft_stop',
    text: { en: 'Batteries are empty', de: 'Batterien sind leer' },
    action: { en: 'End the training and charge.', de: 'Training beenden und laden.' },
  },
  {
    bit: 33, name: 'supply_high', priority: 'medium', reaction: 'soft_stop',
    text: { en: 'The supply voltage is too high', de: 'Die Versorgungsspannung ist zu hoch' },
    action: { en: 'Unplug the charger; call service if it stays.', de: 'Ladegerät abziehen; bleibt es so, Service rufen.' },
  },
  {
    bit: 13, name: 'battery_low', priority: 'low', reaction: 'warn',
    text: { en: 'Batteries are low', de: 'Batterien sind schwach' },
    action: { en: 'Charge soon.', de: 'Bald laden.' },
  },
  {
    bit: 14, name: 'remote_command_lost', priority: 'medium', reaction: 'soft_stop',
    text: { en: 'Driving commands no longer arrive', de: 'Fahrbefehle kommen nicht mehr an' },
    action: { en: 'Let go of the joystick, check the WiFi, start again.', de: 'Joystick loslassen, WLAN prüfen, neu starten.' },
  },
  {
    bit: 15, name: 'server_lost', priority: 'medium', reaction: 'warn',
    text: { en: 'The console is not connected', de: 'Die Konsole ist nicht verbunden' },
    action: { en: 'The patient can walk on; stop at the hoist itself.', de: 'Der Patient kann weitergehen; am Gerät selbst anhalten.' },
  },
  {
    bit: 16, name: 'overspeed', priority: 'high', reaction: 'protective_stop',
    text: { en: 'The hoist moves differently than commanded', de: 'Das Gerät fährt anders als vorgegeben' },
    action: { en: 'Release the stop; call service if it comes back.', de: 'Halt freigeben; kommt es wieder, Service rufen.' },
  },
  {
    bit: 17, name: 'loop_overrun', priority: 'high', reaction: 'protective_stop',
    text: { en: 'The control computer was too late', de: 'Der Steuerrechner war zu langsam' },
    action: { en: 'Release the stop; call service if it comes back.', de: 'Halt freigeben; kommt es wieder, Service rufen.' },
  },
  {
    bit: 18, name: 'gate_refused', priority: 'high', reaction: 'protective_stop',
    text: { en: 'A command was outside the limits and was not sent', de: 'Ein Befehl lag außerhalb der Grenzen und wurde nicht gesendet' },
    action: { en: 'Release the stop; call service.', de: 'Halt freigeben; Service rufen.' },
  },
  {
    bit: 19, name: 'stop_pressed', priority: 'medium', reaction: 'protective_stop',
    text: { en: 'STOP was pressed', de: 'STOPP wurde gedrückt' },
    action: { en: 'Release the stop to go on.', de: 'Zum Weitergehen den Halt freigeben.' },
  },
  {
    bit: 20, name: 'tilt_sensor_fault', priority: 'high', reaction: 'protective_stop',
    text: { en: 'A tilt sensor failed its own check', de: 'Ein Neigungssensor hat seine Prüfung nicht bestanden' },
    action: { en: 'Switch the hoist off and on; call service if it comes back.', de: 'Aus- und einschalten; kommt es wieder, Service rufen.' },
  },
  {
    bit: 21, name: 'bus_down', priority: 'high', reaction: 'protective_stop',
    text: { en: 'The connection to sensors and drives is broken', de: 'Die Verbindung zu Sensoren und Antrieben ist unterbrochen' },
    action: { en: 'Check the bus cable, then release the stop.', de: 'Buskabel prüfen, dann Halt freigeben.' },
  },
  {
    bit: 22, name: 'node_duplicate', priority: 'high', reaction: 'protective_stop',
    text: { en: 'Two devices on the bus answer under the same number', de: 'Zwei Baugruppen am Bus haben dieselbe Nummer' },
    action: { en: 'Unplug the device that was added last, then release the stop; call service.', de: 'Die zuletzt angesteckte Baugruppe abziehen, dann Halt freigeben; Service rufen.' },
  },
  {
    bit: 23, name: 'node_babbling', priority: 'high', reaction: 'protective_stop',
    text: { en: 'A device floods the bus with messages', de: 'Eine Baugruppe überflutet den Bus mit Nachrichten' },
    action: { en: 'Unplug the named device, then release the stop; call service.', de: 'Die genannte Baugruppe abziehen, dann Halt freigeben; Service rufen.' },
  },
  {
    bit: 25, name: 'base_tilted', priority: 'high', reaction: 'protective_stop',
    text: { en: 'The hoist is tilted too far', de: 'Das Gerät steht zu schräg' },
    action: { en: 'Hold the patient. Press the emergency stop, release the brakes by hand, push the hoist onto level floor.', de: 'Patienten sichern. Not-Halt drücken, Bremsen von Hand lösen, das Gerät auf ebenen Boden schieben.' },
  },
  {
    bit: 26, name: 'base_tilt_high', priority: 'medium', reaction: 'warn',
    text: { en: 'The floor slopes: the hoist goes slowly', de: 'Der Boden ist schräg: das Gerät fährt langsam' },
    action: { en: 'Stay close to the patient and go back to level floor.', de: 'Nah beim Patienten bleiben und zurück auf ebenen Boden gehen.' },
  },
  {
    bit: 28, name: 'patient_hanging', priority: 'high', reaction: 'soft_stop',
    text: { en: 'The patient hangs in the harness and does not walk', de: 'Der Patient hängt im Gurt und geht nicht' },
    action: { en: 'Help the patient onto the feet; start again when the patient stands.', de: 'Dem Patienten auf die Füße helfen; neu starten, wenn er steht.' },
  },
  {
    bit: 29, name: 'battery_uneven', priority: 'low', reaction: 'warn',
    text: { en: 'One battery is weaker than the other', de: 'Eine Batterie ist schwächer als die andere' },
    action: { en: 'Finish this training, charge, and have the batteries checked.', de: 'Training beenden, laden und die Batterien prüfen lassen.' },
  },
  {
    bit: 24, name: 'emergency_stop', priority: 'high', reaction: 'power_off',
    text: { en: 'The emergency stop is pressed', de: 'Der Not-Halt ist gedrückt' },
    action: { en: 'Help the patient, release the button, then take control and release the stop.', de: 'Dem Patienten helfen, Taster lösen, dann Steuerung übernehmen und Halt freigeben.' },
  },
  {
    bit: 30, name: 'parameters_corrupt', priority: 'high', reaction: 'out_of_service',
    text: { en: 'The settings were damaged; undamaged ones are in force', de: 'Die Einstellungen waren beschädigt; unbeschädigte gelten' },
    action: { en: 'Compare the settings with your notes; an engineer releases the stop.', de: 'Einstellungen mit den Unterlagen vergleichen; ein Ingenieur gibt den Halt frei.' },
  },
  {
    bit: 31, name: 'control_fault', priority: 'high', reaction: 'out_of_service',
    text: { en: 'The hoist has put itself out of service', de: 'Das Gerät hat sich außer Betrieb gesetzt' },
    action: { en: 'Free the patient and call service.', de: 'Patienten befreien und Service rufen.' },
  },
  {
    bit: 27, name: 'wheel_slip', priority: 'medium', reaction: 'soft_stop',
    text: { en: 'The wheels slip', de: 'Die Räder rutschen' },
    action: { en: 'Check floor and wheels, then start again.', de: 'Boden und Räder prüfen, dann neu starten.' },
  },
  {
    bit: 32, name: 'console_lost', priority: 'medium', reaction: 'warn',
    text: { en: 'The tablet in control is gone', de: 'Das Tablet mit der Steuerung ist weg' },
    action: { en: 'Stay with the patient; take control on another tablet, or stop at the hoist itself.', de: 'Beim Patienten bleiben; an einem anderen Tablet steuern oder am Gerät selbst anhalten.' },
  },
];

/** What a fault is about, where its code says more than its own row. */
export interface FaultDetail {
  fault: FaultName;
  code: number;
  name: string;
  text: Words;
  action: Words;
}

export const faultDetails: readonly FaultDetail[] = [
  {
    fault: 'drive_left_fault', code: 0x7121, name: 'left_wheel_blocked',
    text: { en: 'The left wheel was blocked', de: 'Das linke Rad war blockiert' },
    action: { en: 'Move what blocks it (sill, cable, foot), then release the stop.', de: 'Hindernis entfernen (Schwelle, Kabel, Fuß), dann Halt freigeben.' },
  },
  {
    fault: 'drive_right_fault', code: 0x7121, name: 'right_wheel_blocked',
    text: { en: 'The right wheel was blocked', de: 'Das rechte Rad war blockiert' },
    action: { en: 'Move what blocks it (sill, cable, foot), then release the stop.', de: 'Hindernis entfernen (Schwelle, Kabel, Fuß), dann Halt freigeben.' },
  },
  {
    fault: 'drive_left_fault', code: 0x4310, name: 'left_motor_hot',
    text: { en: 'The left motor is too hot', de: 'Der linke Motor ist zu heiß' },
    action: { en: 'Let it cool for ten minutes, then release the stop.', de: 'Zehn Minuten abkühlen lassen, dann Halt freigeben.' },
  },
  {
    fault: 'drive_right_fault', code: 0x4310, name: 'right_motor_hot',
    text: { en: 'The right motor is too hot', de: 'Der rechte Motor ist zu heiß' },
    action: { en: 'Let it cool for ten minutes, then release the stop.', de: 'Zehn Minuten abkühlen lassen, dann Halt freigeben.' },
  },
  {
    fault: 'tilt_implausible', code: 0x0001, name: 'pelvis_twisted',
    text: { en: 'The pelvis is turned too far', de: 'Das Becken ist zu weit verdreht' },
    action: { en: 'Turn the patient straight, then release the stop.', de: 'Patienten gerade stellen, dann Halt freigeben.' },
  },
  {
    fault: 'tilt_implausible', code: 0x0002, name: 'left_strut_still',
    text: { en: 'Left strap or strut loose', de: 'Gurt oder Strebe links lose' },
    action: { en: 'Hold the patient, check both, then release the stop.', de: 'Patienten sichern, beide prüfen, dann Halt freigeben.' },
  },
  {
    fault: 'tilt_implausible', code: 0x0003, name: 'right_strut_still',
    text: { en: 'Right strap or strut loose', de: 'Gurt oder Strebe rechts lose' },
    action: { en: 'Hold the patient, check both, then release the stop.', de: 'Patienten sichern, beide prüfen, dann Halt freigeben.' },
  },
  {
    fault: 'overspeed', code: 0x0001, name: 'wheel_held_back',
    text: { en: 'Something holds a wheel back', de: 'Etwas hält ein Rad zurück' },
    action: { en: 'Move what blocks it (sill, cable, foot), then release the stop.', de: 'Hindernis entfernen (Schwelle, Kabel, Fuß), dann Halt freigeben.' },
  },
];

/** Faults that have a code: the live value <name>_code. */
export const codedFaults = ['drive_left_fault', 'drive_right_fault', 'tilt_implausible', 'overspeed'] as const;

/** The effect is a consequence of the cause: shown under it. */
export const explanations: readonly { cause: FaultName; effect: FaultName }[] = [
  { cause: 'bus_down', effect: 'tilt_left_lost' },
  { cause: 'bus_down', effect: 'tilt_right_lost' },
  { cause: 'bus_down', effect: 'tilt_base_lost' },
  { cause: 'bus_down', effect: 'drive_left_lost' },
  { cause: 'bus_down', effect: 'drive_right_lost' },
  { cause: 'bus_down', effect: 'io_lost' },
  { cause: 'node_babbling', effect: 'tilt_left_lost' },
  { cause: 'node_babbling', effect: 'tilt_right_lost' },
  { cause: 'node_babbling', effect: 'tilt_base_lost' },
  { cause: 'node_babbling', effect: 'drive_left_lost' },
  { cause: 'node_babbling', effect: 'drive_right_lost' },
  { cause: 'node_babbling', effect: 'io_lost' },
  { cause: 'node_babbling', effect: 'bus_down' },
  { cause: 'node_duplicate', effect: 'tilt_implausible' },
  { cause: 'node_duplicate', effect: 'tilt_frozen' },
  { cause: 'emergency_stop', effect: 'drive_left_fault' },
  { cause: 'emergency_stop', effect: 'drive_right_fault' },
  { cause: 'emergency_stop', effect: 'overspeed' },
  { cause: 'loop_overrun', effect: 'drive_left_fault' },
  { cause: 'loop_overrun', effect: 'drive_right_fault' },
  { cause: 'drive_left_fault', effect: 'overspeed' },
  { cause: 'drive_right_fault', effect: 'overspeed' },
  { cause: 'drive_left_lost', effect: 'overspeed' },
  { cause: 'drive_right_lost', effect: 'overspeed' },
  { cause: 'base_tilted', effect: 'base_tilt_high' },
  { cause: 'battery_empty', effect: 'battery_low' },
  { cause: 'server_lost', effect: 'remote_command_lost' },
  { cause: 'server_lost', effect: 'console_lost' },
];

/** The patient needs help before the machine does: shown above every other alarm, in this order. */
export const endangers: readonly FaultName[] = ['fall_detected', 'patient_hanging', 'base_tilted', 'control_fault', 'emergency_stop'];

/** How alarms of a priority sound and flash, here and at the hoist (control/contract/alarms.def, after IEC 60601-1-8). */
export interface AlarmSignal {
  colour: 'cyan' | 'yellow' | 'red';
  /** When each pulse of a burst begins. */
  pulses_ms: readonly number[];
  pulse_ms: number;
  /** From one burst to the next. */
  burst_ms: number;
  /** Period of the light; 0: steady. */
  flash_ms: number;
  lit_ms: number;
}

export const alarmSignals: Readonly<Record<FaultInfo['priority'], AlarmSignal>> = {
  low: {
    colour: 'cyan', pulses_ms: [0],
    pulse_ms: 180, burst_ms: 16180, flash_ms: 0, lit_ms: 0,
  },
  medium: {
    colour: 'yellow', pulses_ms: [0, 360, 720],
    pulse_ms: 180, burst_ms: 7900, flash_ms: 2000, lit_ms: 1000,
  },
  high: {
    colour: 'red', pulses_ms: [0, 200, 400, 800, 1000, 1720, 1920, 2120, 2520, 2720],
    pulse_ms: 120, burst_ms: 6340, flash_ms: 500, lit_ms: 250,
  },
};

/** Pitch of a pulse and the harmonics above it. */
export const alarmPitch_hz = 523.25;
export const alarmHarmonics = 4;

/** How long sound is paused at the most. */
export const audioPause_s = 120;

export interface RefusalInfo {
  /** Place in blocked_bits. */
  bit: number;
  name: RefusalName;
  text: Words;
}

export const refusals: readonly RefusalInfo[] = [
  { bit: 0, name: 'not_standby', text: { en: 'The hoist is not on standby.', de: 'Das Gerät ist nicht in Bereitschaft.' } },
  { bit: 1, name: 'nodes_missing', text: { en: 'Not all sensors and drives have answered yet.', de: 'Noch nicht alle Sensoren und Antriebe haben geantwortet.' } },
  { bit: 2, name: 'fault_active', text: { en: 'An alarm is active: solve it first.', de: 'Ein Alarm ist aktiv: zuerst beheben.' } },
  { bit: 3, name: 'not_neutral', text: { en: 'The patient is not upright and straight: stand upright or set neutral.', de: 'Der Patient steht nicht aufrecht und gerade: aufrichten oder neutral setzen.' } },
  { bit: 4, name: 'moving', text: { en: 'The hoist is still moving.', de: 'Das Gerät bewegt sich noch.' } },
  { bit: 5, name: 'battery_empty_start', text: { en: 'The batteries are empty.', de: 'Die Batterien sind leer.' } },
  { bit: 6, name: 'sensors_settling', text: { en: 'The sensors are still settling: stand quietly for ten seconds. If this stays, switch the hoist off and on.', de: 'Die Sensoren stellen sich noch ein: zehn Sekunden ruhig stehen. Bleibt das so, das Gerät aus- und einschalten.' } },
  { bit: 7, name: 'no_lease', text: { en: 'Take control first.', de: 'Zuerst die Steuerung übernehmen.' } },
  { bit: 8, name: 'stick_not_neutral', text: { en: 'Let go of the joystick first.', de: 'Zuerst den Joystick loslassen.' } },
  { bit: 9, name: 'out_of_range', text: { en: 'The value is outside its range.', de: 'Der Wert liegt außerhalb seines Bereichs.' } },
  { bit: 10, name: 'not_finite', text: { en: 'The value is not a number.', de: 'Der Wert ist keine Zahl.' } },
  { bit: 11, name: 'unknown_item', text: { en: 'The hoist does not know this item.', de: 'Das kennt das Gerät nicht.' } },
  { bit: 12, name: 'only_when_stopped', text: { en: 'This can only be changed on standby.', de: 'Das lässt sich nur in Bereitschaft ändern.' } },
  { bit: 13, name: 'stale_command', text: { en: 'This came too late: look at the hoist, then try again.', de: 'Das kam zu spät: Gerät ansehen, dann noch einmal versuchen.' } },
  { bit: 14, name: 'inconsistent_set', text: { en: 'These values do not fit together with the others: change them together.', de: 'Diese Werte passen nicht zu den übrigen: gemeinsam ändern.' } },
  { bit: 15, name: 'cause_not_cleared', text: { en: 'The cause of the stop remains: see the alarm.', de: 'Der Grund für den Halt besteht noch: siehe Alarm.' } },
  { bit: 16, name: 'bumper_start', text: { en: 'A bumper touches something.', de: 'Ein Stoßfänger berührt etwas.' } },
  { bit: 17, name: 'out_of_order', text: { en: 'Not possible at this moment. Check the screen, then try again.', de: 'Im Moment nicht möglich. Anzeige prüfen, dann noch einmal versuchen.' } },
  { bit: 18, name: 'not_allowed', text: { en: 'Your role may not change this.', de: 'Das darf Ihre Rolle nicht ändern.' } },
  { bit: 19, name: 'fault_mode', text: { en: 'The hoist is out of service: see the alarm.', de: 'Das Gerät ist außer Betrieb: siehe Alarm.' } },
  { bit: 20, name: 'emergency_stop_open', text: { en: 'The emergency stop is still pressed: release it first.', de: 'Der Not-Halt ist noch gedrückt: zuerst lösen.' } },
  { bit: 21, name: 'set_outdated', text: { en: 'These settings are outdated or incomplete: check them, then try again.', de: 'Diese Einstellungen sind veraltet oder unvollständig: prüfen, dann noch einmal versuchen.' } },
  { bit: 22, name: 'node_version', text: { en: 'A sensor or drive has a different software version: call service.', de: 'Ein Sensor oder Antrieb hat einen anderen Softwarestand: Service rufen.' } },
  { bit: 23, name: 'no_exercise', text: { en: 'Choose an exercise first.', de: 'Zuerst eine Übung wählen.' } },
  { bit: 24, name: 'exercise_limits', text: { en: 'The exercise does not fit: check size, speed and laps.', de: 'Die Übung passt nicht: Größe, Tempo und Runden prüfen.' } },
  { bit: 25, name: 'release_first', text: { en: 'Let go of the button first, then press it again.', de: 'Zuerst den Knopf loslassen, dann neu drücken.' } },
  { bit: 26, name: 'not_calibrated', text: { en: 'The struts have never been zeroed: do this under Calibrate first.', de: 'Die Streben wurden noch nie genullt: zuerst unter Kalibrieren nachholen.' } },
  { bit: 27, name: 'cause_not_seen', text: { en: 'There is a new cause of the stop: see the alarm, then release again.', de: 'Es gibt einen neuen Grund für den Halt: Alarm ansehen, dann neu freigeben.' } },
  { bit: 28, name: 'harness_unconfirmed', text: { en: 'Confirm first that nobody is strapped in.', de: 'Zuerst bestätigen, dass niemand im Gurt ist.' } },
  { bit: 29, name: 'parts_unchecked', text: { en: 'Sensors or drives are new: check wheels, bumpers and struts under Calibrate first.', de: 'Sensoren oder Antriebe sind neu: zuerst unter Kalibrieren Räder, Stoßfänger und Streben prüfen.' } },
  { bit: 30, name: 'busy', text: { en: 'Too many requests at once: try again.', de: 'Zu viele Anfragen auf einmal: noch einmal versuchen.' } },
];

/** Why the hoist goes more slowly than it is asked to, by the value of speed_cause. */
export const speedCauses: readonly { value: number; name: string; text: Words }[] = [
  { value: 1, name: 'command_age', text: { en: 'Slower: driving commands arrive late.', de: 'Langsamer: Fahrbefehle kommen verspätet an.' } },
  { value: 2, name: 'patient_lag', text: { en: 'Slower: the patient lags behind.', de: 'Langsamer: Der Patient bleibt zurück.' } },
  { value: 3, name: 'bumper', text: { en: 'Slower: a bumper touches something.', de: 'Langsamer: Ein Stoßfänger berührt etwas.' } },
  { value: 4, name: 'slope', text: { en: 'Slower: the floor slopes.', de: 'Langsamer: Der Boden ist schräg.' } },
  { value: 5, name: 'cap', text: { en: 'Slower: the set top speed is reached.', de: 'Langsamer: Das eingestellte Höchsttempo ist erreicht.' } },
  { value: 6, name: 'turn', text: { en: 'Slower: the hoist turns.', de: 'Langsamer: Das Gerät dreht.' } },
];

export interface ModeInfo {
  value: number;
  name: ModeName;
  /** The wheels may turn in this mode. */
  moving: boolean;
  title: Words;
}

export const modes: readonly ModeInfo[] = [
  { value: 0, name: 'init', moving: false, title: { en: 'Starting', de: 'Startet' } },
  { value: 1, name: 'standby', moving: false, title: { en: 'Standby', de: 'Bereitschaft' } },
  { value: 2, name: 'user', moving: true, title: { en: 'Patient leads', de: 'Patient führt' } },
  { value: 3, name: 'remote', moving: true, title: { en: 'Therapist drives', de: 'Therapeut fährt' } },
  { value: 4, name: 'protective_stop', moving: false, title: { en: 'Stopped', de: 'Angehalten' } },
  { value: 5, name: 'calibrate', moving: false, title: { en: 'Calibrating', de: 'Kalibrierung läuft' } },
  { value: 6, name: 'guided', moving: true, title: { en: 'Exercise', de: 'Übung' } },
  { value: 7, name: 'fault', moving: false, title: { en: 'Out of service', de: 'Außer Betrieb' } },
  { value: 8, name: 'emergency_stop', moving: false, title: { en: 'Emergency stop', de: 'Not-Halt' } },
];
