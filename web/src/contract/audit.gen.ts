// Made by `deploy/dev gen` from server/contract/audit.def; do not edit.

import type { AuditAction, Words } from './rest.gen';

/** What follows the person in a sentence of the audit log: what was done, and what was tried and refused. */
export const auditActions: Readonly<Record<AuditAction, { done: Words; tried: Words }>> = {
  sign_in: {
    done: { en: 'signed in', de: 'hat sich angemeldet' },
    tried: { en: 'sign in', de: 'sich anmelden' },
  },
  sign_out: {
    done: { en: 'signed out', de: 'hat sich abgemeldet' },
    tried: { en: 'sign out', de: 'sich abmelden' },
  },
  set_up: {
    done: { en: 'set up an engineer\'s account', de: 'hat ein Ingenieurkonto eingerichtet' },
    tried: { en: 'set up an engineer\'s account', de: 'ein Ingenieurkonto einrichten' },
  },
  change_password: {
    done: { en: 'changed the own password', de: 'hat das eigene Passwort geändert' },
    tried: { en: 'change the own password', de: 'das eigene Passwort ändern' },
  },
  change_pin: {
    done: { en: 'changed the own PIN', de: 'hat die eigene PIN geändert' },
    tried: { en: 'change the own PIN', de: 'die eigene PIN ändern' },
  },
  add_user: {
    done: { en: 'added the account {what}', de: 'hat das Konto {what} angelegt' },
    tried: { en: 'add an account', de: 'ein Konto anlegen' },
  },
  change_user: {
    done: { en: 'changed the account {what}', de: 'hat das Konto {what} geändert' },
    tried: { en: 'change the account {what}', de: 'das Konto {what} ändern' },
  },
  user: {
    done: { en: 'added or changed the account {what}', de: 'hat das Konto {what} angelegt oder geändert' },
    tried: { en: 'change an account', de: 'ein Konto ändern' },
  },
  add_token: {
    done: { en: 'made the access {what} for a program', de: 'hat den Zugang {what} für ein Programm angelegt' },
    tried: { en: 'make an access for a program', de: 'einen Zugang für ein Programm anlegen' },
  },
  token: {
    done: { en: 'made the access {what} for a program', de: 'hat den Zugang {what} für ein Programm angelegt' },
    tried: { en: 'make an access for a program', de: 'einen Zugang für ein Programm anlegen' },
  },
  remove_token: {
    done: { en: 'removed the access of a program', de: 'hat den Zugang eines Programms entfernt' },
    tried: { en: 'remove the access of a program', de: 'den Zugang eines Programms entfernen' },
  },
  set_tools: {
    done: { en: 'switched the access of Foxglove and ROS {what}', de: 'hat den Zugang für Foxglove und ROS {what}geschaltet' },
    tried: { en: 'switch the access of Foxglove and ROS', de: 'den Zugang für Foxglove und ROS schalten' },
  },
  change_settings: {
    done: { en: 'changed name or language of the hoist', de: 'hat Name oder Sprache des Geräts geändert' },
    tried: { en: 'change name or language of the hoist', de: 'Name oder Sprache des Geräts ändern' },
  },
  set_time: {
    done: { en: 'set the clock', de: 'hat die Uhr gestellt' },
    tried: { en: 'set the clock', de: 'die Uhr stellen' },
  },
  set_retention: {
    done: { en: 'set how long sessions are kept', de: 'hat festgelegt, wie lange Sitzungen bleiben' },
    tried: { en: 'set how long sessions are kept', de: 'festlegen, wie lange Sitzungen bleiben' },
  },
  retention: {
    done: { en: 'deleted sessions by the rule', de: 'hat Sitzungen nach der Regel gelöscht' },
    tried: { en: 'delete sessions by the rule', de: 'Sitzungen nach der Regel löschen' },
  },
  lose_rows: {
    done: { en: 'lost rows of this log: the storage took none', de: 'hat Zeilen dieses Protokolls verloren: Der Speicher nahm keine an' },
    tried: { en: 'keep rows of this log', de: 'Zeilen dieses Protokolls behalten' },
  },
  start_job: {
    done: { en: 'started: {what}', de: 'hat gestartet: {what}' },
    tried: { en: 'start: {what}', de: 'starten: {what}' },
  },
  cancel_job: {
    done: { en: 'cancelled long work', de: 'hat einen Auftrag abgebrochen' },
    tried: { en: 'cancel long work', de: 'einen Auftrag abbrechen' },
  },
  get_job_file: {
    done: { en: 'downloaded several sessions', de: 'hat mehrere Sitzungen heruntergeladen' },
    tried: { en: 'download several sessions', de: 'mehrere Sitzungen herunterladen' },
  },
  export_session: {
    done: { en: 'downloaded {what}', de: 'hat {what} heruntergeladen' },
    tried: { en: 'download {what}', de: '{what} herunterladen' },
  },
  export_mcap: {
    done: { en: 'downloaded {what}', de: 'hat {what} heruntergeladen' },
    tried: { en: 'download {what}', de: '{what} herunterladen' },
  },
  get_session_report: {
    done: { en: 'opened the report of {what}', de: 'hat den Bericht geöffnet: {what}' },
    tried: { en: 'open the report of {what}', de: 'den Bericht öffnen: {what}' },
  },
  get_visit_report: {
    done: { en: 'opened the report of a visit', de: 'hat den Bericht zu einem Termin geöffnet' },
    tried: { en: 'open the report of a visit', de: 'den Bericht zu einem Termin öffnen' },
  },
  change_session: {
    done: { en: 'changed note, code or exercise of {what}', de: 'hat Notiz, Kürzel oder Übung geändert: {what}' },
    tried: { en: 'change {what}', de: '{what} ändern' },
  },
  delete_session: {
    done: { en: 'deleted {what}', de: 'hat {what} gelöscht' },
    tried: { en: 'delete {what}', de: '{what} löschen' },
  },
  add_marker: {
    done: { en: 'set a mark', de: 'hat einen Merkpunkt gesetzt' },
    tried: { en: 'set a mark', de: 'einen Merkpunkt setzen' },
  },
  change_marker: {
    done: { en: 'changed a mark in {what}', de: 'hat einen Merkpunkt geändert: {what}' },
    tried: { en: 'change a mark in {what}', de: 'einen Merkpunkt ändern: {what}' },
  },
  delete_marker: {
    done: { en: 'deleted a mark in {what}', de: 'hat einen Merkpunkt gelöscht: {what}' },
    tried: { en: 'delete a mark in {what}', de: 'einen Merkpunkt löschen: {what}' },
  },
  control_recording: {
    done: { en: 'began or ended a recording', de: 'hat eine Aufnahme begonnen oder beendet' },
    tried: { en: 'begin or end a recording', de: 'eine Aufnahme beginnen oder beenden' },
  },
  begin_recording: {
    done: { en: 'began a recording', de: 'hat eine Aufnahme begonnen' },
    tried: { en: 'begin a recording', de: 'eine Aufnahme beginnen' },
  },
  end_recording: {
    done: { en: 'ended a recording', de: 'hat eine Aufnahme beendet' },
    tried: { en: 'end a recording', de: 'eine Aufnahme beenden' },
  },
  create_patient: {
    done: { en: 'added a patient', de: 'hat einen Patienten angelegt' },
    tried: { en: 'add a patient', de: 'einen Patienten anlegen' },
  },
  change_patient: {
    done: { en: 'changed code or archive of {what}', de: 'hat Kürzel oder Archiv geändert: {what}' },
    tried: { en: 'change {what}', de: '{what} ändern' },
  },
  delete_patient: {
    done: { en: 'deleted {what} with all sessions', de: 'hat {what} mit allen Sitzungen gelöscht' },
    tried: { en: 'delete {what}', de: '{what} löschen' },
  },
  choose_patient: {
    done: { en: 'chose {what} for the hoist', de: 'hat {what} für das Gerät gewählt' },
    tried: { en: 'choose {what} for the hoist', de: '{what} für das Gerät wählen' },
  },
  set_identity: {
    done: { en: 'stored the name of {what}', de: 'hat den Namen gespeichert: {what}' },
    tried: { en: 'store the name of {what}', de: 'den Namen speichern: {what}' },
  },
  put_identity: {
    done: { en: 'stored the name of {what}', de: 'hat den Namen gespeichert: {what}' },
    tried: { en: 'store the name of {what}', de: 'den Namen speichern: {what}' },
  },
  delete_identity: {
    done: { en: 'deleted the name of {what}', de: 'hat den Namen gelöscht: {what}' },
    tried: { en: 'delete the name of {what}', de: 'den Namen löschen: {what}' },
  },
  change_visit: {
    done: { en: 'wrote the note of a visit', de: 'hat die Notiz eines Termins geschrieben' },
    tried: { en: 'write the note of a visit', de: 'die Notiz eines Termins schreiben' },
  },
  create_profile: {
    done: { en: 'saved settings for {what}', de: 'hat Einstellungen gespeichert: {what}' },
    tried: { en: 'save settings for {what}', de: 'Einstellungen speichern: {what}' },
  },
  change_profile: {
    done: { en: 'changed a patient\'s saved settings', de: 'hat gespeicherte Einstellungen geändert' },
    tried: { en: 'change a patient\'s saved settings', de: 'gespeicherte Einstellungen ändern' },
  },
  delete_profile: {
    done: { en: 'deleted a patient\'s saved settings', de: 'hat gespeicherte Einstellungen gelöscht' },
    tried: { en: 'delete a patient\'s saved settings', de: 'gespeicherte Einstellungen löschen' },
  },
  apply_profile: {
    done: { en: 'put a patient\'s saved settings in force', de: 'hat gespeicherte Einstellungen übernommen' },
    tried: { en: 'put a patient\'s saved settings in force', de: 'gespeicherte Einstellungen übernehmen' },
  },
  create_line: {
    done: { en: 'drew a line', de: 'hat eine Linie gezeichnet' },
    tried: { en: 'draw a line', de: 'eine Linie zeichnen' },
  },
  change_line: {
    done: { en: 'changed a line', de: 'hat eine Linie geändert' },
    tried: { en: 'change a line', de: 'eine Linie ändern' },
  },
  delete_line: {
    done: { en: 'deleted a line', de: 'hat eine Linie gelöscht' },
    tried: { en: 'delete a line', de: 'eine Linie löschen' },
  },
  change_parameters: {
    done: { en: 'changed settings', de: 'hat Einstellungen geändert' },
    tried: { en: 'change settings', de: 'Einstellungen ändern' },
  },
  put_parameter: {
    done: { en: 'changed a setting', de: 'hat eine Einstellung geändert' },
    tried: { en: 'change a setting', de: 'eine Einstellung ändern' },
  },
  keep_parameters: {
    done: { en: 'kept settings that were on trial', de: 'hat Einstellungen auf Probe behalten' },
    tried: { en: 'keep settings that were on trial', de: 'Einstellungen auf Probe behalten' },
  },
  undo_parameters: {
    done: { en: 'took back settings that were on trial', de: 'hat Einstellungen auf Probe zurückgenommen' },
    tried: { en: 'take back settings that were on trial', de: 'Einstellungen auf Probe zurücknehmen' },
  },
  apply_preset: {
    done: { en: 'put the preset {what} in force', de: 'hat die Voreinstellung {what} übernommen' },
    tried: { en: 'put the preset {what} in force', de: 'die Voreinstellung {what} übernehmen' },
  },
  set_neutral: {
    done: { en: 'took the patient\'s posture as upright', de: 'hat die Haltung als aufrecht übernommen' },
    tried: { en: 'take the patient\'s posture as upright', de: 'die Haltung als aufrecht übernehmen' },
  },
  set_pose: {
    done: { en: 'set the starting pose', de: 'hat die Startpose gesetzt' },
    tried: { en: 'set the starting pose', de: 'die Startpose setzen' },
  },
  begin_calibration: {
    done: { en: 'began to calibrate: {what}', de: 'hat eine Kalibrierung begonnen: {what}' },
    tried: { en: 'calibrate: {what}', de: 'kalibrieren: {what}' },
  },
  measure_calibration: {
    done: { en: 'entered a measurement of the calibration', de: 'hat eine Messung der Kalibrierung eingegeben' },
    tried: { en: 'enter a measurement of the calibration', de: 'eine Messung der Kalibrierung eingeben' },
  },
  use_calibration: {
    done: { en: 'took over the result of the calibration', de: 'hat das Ergebnis der Kalibrierung übernommen' },
    tried: { en: 'take over the result of the calibration', de: 'das Ergebnis der Kalibrierung übernehmen' },
  },
  cancel_calibration: {
    done: { en: 'cancelled the calibration', de: 'hat die Kalibrierung abgebrochen' },
    tried: { en: 'cancel the calibration', de: 'die Kalibrierung abbrechen' },
  },
  update_firmware: {
    done: { en: 'updated the program of {what}', de: 'hat das Programm erneuert: {what}' },
    tried: { en: 'update the program of {what}', de: 'das Programm erneuern: {what}' },
  },
  take_lease: {
    done: { en: 'took control', de: 'hat die Steuerung übernommen' },
    tried: { en: 'take control', de: 'die Steuerung übernehmen' },
  },
  release_lease: {
    done: { en: 'gave control back', de: 'hat die Steuerung abgegeben' },
    tried: { en: 'give control back', de: 'die Steuerung abgeben' },
  },
  ask_lease: {
    done: { en: 'asked for control', de: 'hat um die Steuerung gebeten' },
    tried: { en: 'ask for control', de: 'um die Steuerung bitten' },
  },
  withdraw_lease: {
    done: { en: 'no longer asked for control', de: 'hat die Bitte um die Steuerung zurückgezogen' },
    tried: { en: 'no longer ask for control', de: 'die Bitte um die Steuerung zurückziehen' },
  },
  keep_lease: {
    done: { en: 'kept control', de: 'hat die Steuerung behalten' },
    tried: { en: 'keep control', de: 'die Steuerung behalten' },
  },
  hand_over: {
    done: { en: 'gave control to {what}', de: 'hat die Steuerung weitergegeben: {what}' },
    tried: { en: 'give control to {what}', de: 'die Steuerung weitergeben: {what}' },
  },
  set_mode: {
    done: { en: 'started or ended motion', de: 'hat die Bewegung gestartet oder beendet' },
    tried: { en: 'start or end motion', de: 'die Bewegung starten oder beenden' },
  },
  start_motion: {
    done: { en: 'started motion: {what}', de: 'hat die Bewegung gestartet: {what}' },
    tried: { en: 'start motion: {what}', de: 'die Bewegung starten: {what}' },
  },
  end_motion: {
    done: { en: 'ended motion', de: 'hat die Bewegung beendet' },
    tried: { en: 'end motion', de: 'die Bewegung beenden' },
  },
  choose_exercise: {
    done: { en: 'chose an exercise: {what}', de: 'hat eine Übung gewählt: {what}' },
    tried: { en: 'choose an exercise: {what}', de: 'eine Übung wählen: {what}' },
  },
  choose_task: {
    done: { en: 'chose a task or none', de: 'hat eine Aufgabe oder keine gewählt' },
    tried: { en: 'choose a task', de: 'eine Aufgabe wählen' },
  },
  choose_rehearsal: {
    done: { en: 'chose a rehearsal on the simulated hoist or none', de: 'hat eine Probe am simulierten Gerät oder keine gewählt' },
    tried: { en: 'choose a rehearsal', de: 'eine Probe wählen' },
  },
  pause_alarm: {
    done: { en: 'paused the sound of the alarms or let them sound again', de: 'hat den Alarmton unterbrochen oder wieder angestellt' },
    tried: { en: 'pause the sound of the alarms', de: 'den Alarmton unterbrechen' },
  },
  stop: {
    done: { en: 'pressed STOP', de: 'hat STOPP gedrückt' },
    tried: { en: 'press STOP', de: 'STOPP drücken' },
  },
  acknowledge: {
    done: { en: 'released a stop', de: 'hat einen Stopp freigegeben' },
    tried: { en: 'release a stop', de: 'einen Stopp freigeben' },
  },
};
