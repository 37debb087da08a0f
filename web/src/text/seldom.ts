// Words of what is opened seldom (rehearsals, what a study tells): they come with their screens, not with the first page.
import type { Words } from '../contract/params.gen';
import { filled, words } from './text';

export const seldomWords = {
  assumed: {
    en: 'Put in by assumption',
    de: 'Was angenommen ist',
  },
  assumedHelp: {
    en: 'None of this is measured, so none of it is a finding.',
    de: 'Nichts davon ist gemessen, also ist nichts davon ein Ergebnis.',
  },
  assumedSpeed: {
    en: 'Preferred speed {speed}; settings “{preset}”.',
    de: 'Wunschtempo {speed}; Einstellungen „{preset}“.',
  },
  assumedFollow: {
    en: 'Who is driven turns to the path ahead by {share} of what a leading person would, {more} more with each run, and trails {late} behind. So C of the runs without * and its rise are assumed.',
    de: 'Wer gefahren wird, dreht sich zum Weg voraus, und zwar {share} mal so weit wie beim Führen, mit jedem Durchgang {more} mehr und {late} verspätet. C der Durchgänge ohne * und sein Anstieg sind also angenommen.',
  },
  assumedTherapist: {
    en: 'The therapist drives at {speed}, reacts {late} late and misjudges place and direction by {aside} and {turned}. So J of the runs without * is assumed.',
    de: 'Wer fährt, fährt {speed}, reagiert {late} verspätet und schätzt Ort und Richtung um {aside} und {turned} falsch. J der Durchgänge ohne * ist also angenommen.',
  },
  assumedOrthosis: {
    en: 'Orthosis (runs 4 to 6): steps uneven by {limp} %, gait sways {sway} times as wide.',
    de: 'Orthese (Durchgänge 4 bis 6): Schritte um {limp} % ungleich, der Gang schwankt {sway}-mal so weit.',
  },
  findings: {
    en: 'What comes out',
    de: 'Was herauskommt',
  },
  findSquare: {
    en: 'C of the squares {c}: their path turns only in the corners.',
    de: 'C der Quadrate {c}: Ihr Weg dreht nur in den Ecken.',
  },
  findLed: {
    en: 'C while the patient leads {c}: the pelvis steers.',
    de: 'C beim Führen durch die Person {c}: Das Becken lenkt.',
  },
  findRatio: {
    en: 'J of the squares is {n} times that of the driven eights: nobody turns on the spot.',
    de: 'J der Quadrate ist {n}-mal so groß wie bei den gefahrenen Achten: Niemand dreht auf der Stelle.',
  },
  recorded: {
    en: 'recorded',
    de: 'aufgenommen',
  },
  openHint: {
    en: 'Trip, lost link, low batteries: practise on the simulated hoist what to do.',
    de: 'Sturz, Verbindung weg, Batterie schwach: das Richtige am simulierten Gerät üben.',
  },
  label: {
    en: 'Rehearsal, simulated hoist',
    de: 'Probe, simuliertes Gerät',
  },
  recordedTitle: {
    en: 'Evaluate recorded sessions',
    de: 'Aufgenommene Sitzungen auswerten',
  },
  recordedWhat: {
    en: 'Counts sessions with a patient whose note begins with “run 1” to “run 6”: the paper’s six runs. Of several the newest.',
    de: 'Zählt Sitzungen mit Patient, deren Notiz mit „run 1“ bis „run 6“ beginnt: die sechs Läufe der Veröffentlichung. Von mehreren die neueste.',
  },
  ofPeople: {
    en: 'Recorded sessions. They stay when the study is deleted.',
    de: 'Aufgenommene Sitzungen. Sie bleiben, wenn die Studie gelöscht wird.',
  },
  sureRecorded: {
    en: 'Delete the study? Its sessions stay.',
    de: 'Studie löschen? Ihre Sitzungen bleiben.',
  },
  evaluate: {
    en: 'Evaluate',
    de: 'Auswerten',
  },
  evaluating: {
    en: 'Evaluating …',
    de: 'Wertet aus …',
  },
  what: {
    en: 'Something happens while the patient walks, at a moment that is not told. Do what you would do on the real hoist. Afterwards you see what you did, and when.',
    de: 'Unterwegs passiert etwas; wann, wird nicht gesagt. Handeln Sie wie am echten Gerät. Danach sehen Sie, was Sie getan haben und wann.',
  },
  choose: {
    en: 'What happens',
    de: 'Was passiert',
  },
  start: {
    en: 'Start the rehearsal',
    de: 'Probe beginnen',
  },
  waits: {
    en: '{what}: start the walk. It happens on the way.',
    de: '{what}: jetzt losgehen. Es passiert unterwegs.',
  },
  toWalk: {
    en: 'Go to Walk',
    de: 'Zum Gehen',
  },
  result: {
    en: 'Result: {what}',
    de: 'Ergebnis: {what}',
  },
  toSession: {
    en: 'Open the session',
    de: 'Sitzung öffnen',
  },
  trip: {
    en: 'The patient trips',
    de: 'Der Patient stolpert',
  },
  tripWhat: {
    en: 'Stop, look after the patient, release, set upright, go on.',
    de: 'Anhalten, nach dem Patienten sehen, freigeben, aufrecht setzen, weitergehen.',
  },
  freeze: {
    en: 'The feet freeze',
    de: 'Die Füße frieren ein',
  },
  freezeWhat: {
    en: 'Nothing stops by itself: the patient needs your STOP.',
    de: 'Nichts hält von selbst an: Der Patient braucht Ihr STOP.',
  },
  bumper: {
    en: 'A bumper touches something',
    de: 'Ein Stoßfänger berührt etwas',
  },
  bumperWhat: {
    en: 'Clear the way before you release the stop.',
    de: 'Erst den Weg frei machen, dann den Halt freigeben.',
  },
  link: {
    en: 'The tablet loses its link',
    de: 'Das Tablet verliert die Verbindung',
  },
  linkWhat: {
    en: 'The patient walks on. Get control again, here or on another tablet.',
    de: 'Der Patient geht weiter. Steuerung zurückholen, hier oder an einem anderen Tablet.',
  },
  battery: {
    en: 'The batteries run low',
    de: 'Die Batterien werden schwach',
  },
  batteryWhat: {
    en: 'End the walk, and do not start another one.',
    de: 'Das Gehen beenden und nicht neu starten.',
  },
  second: {
    en: 'A second therapist wants control',
    de: 'Jemand möchte die Steuerung',
  },
  secondWhat: {
    en: 'Say yes or no. Hand over only while the hoist stands.',
    de: 'Ja oder Nein sagen. Nur im Stand übergeben.',
  },
  good: {
    en: 'Good',
    de: 'Gut',
  },
  wrong: {
    en: 'Not good',
    de: 'Nicht gut',
  },
  missing: {
    en: 'Not done',
    de: 'Nicht getan',
  },
  stopGood: {
    en: 'STOP after {s} s.',
    de: 'STOP nach {s} s.',
  },
  stopWrong: {
    en: 'STOP after {s} s: later than {limit} s.',
    de: 'STOP nach {s} s, später als {limit} s.',
  },
  stopMissing: {
    en: 'Nobody pressed STOP.',
    de: 'Niemand hat STOP gedrückt.',
  },
  lookGood: {
    en: '{s} s to look at the patient before the release.',
    de: 'Vor der Freigabe {s} s Zeit für den Patienten.',
  },
  lookWrong: {
    en: 'Only {s} s before the release: look at the patient for {limit} s first.',
    de: 'Nur {s} s bis zur Freigabe: erst {limit} s nach dem Patienten sehen.',
  },
  notReleased: {
    en: 'Not judged: the stop was not released.',
    de: 'Nicht bewertet: Der Halt wurde nicht freigegeben.',
  },
  causeGood: {
    en: 'Released when the cause had gone.',
    de: 'Erst freigegeben, als der Grund weg war.',
  },
  causeWrong: {
    en: 'Tried to release while the cause was still there.',
    de: 'Freigabe versucht, als der Grund noch bestand.',
  },
  releaseGood: {
    en: 'Stop released after {s} s.',
    de: 'Halt nach {s} s freigegeben.',
  },
  releaseWrong: {
    en: 'Stop released after {s} s: later than {limit} s.',
    de: 'Halt nach {s} s freigegeben, später als {limit} s.',
  },
  releaseMissing: {
    en: 'The stop was not released.',
    de: 'Der Halt wurde nicht freigegeben.',
  },
  zeroGood: {
    en: 'Posture set as upright after {s} s, before going on.',
    de: 'Haltung nach {s} s als aufrecht gesetzt, vor dem Weitergehen.',
  },
  zeroWrong: {
    en: 'Posture set as upright only after going on.',
    de: 'Haltung erst nach dem Weitergehen als aufrecht gesetzt.',
  },
  zeroMissing: {
    en: 'The posture was not set as upright.',
    de: 'Die Haltung wurde nicht als aufrecht gesetzt.',
  },
  goGood: {
    en: 'Walked on after {s} s.',
    de: 'Nach {s} s weitergegangen.',
  },
  goWrong: {
    en: 'Walked on after {s} s: later than {limit} s.',
    de: 'Nach {s} s weitergegangen, später als {limit} s.',
  },
  goMissing: {
    en: 'The walk did not go on.',
    de: 'Es ging nicht weiter.',
  },
  regainGood: {
    en: 'In control again after {s} s.',
    de: 'Steuerung nach {s} s zurück.',
  },
  regainWrong: {
    en: 'In control again after {s} s: later than {limit} s.',
    de: 'Steuerung nach {s} s zurück, später als {limit} s.',
  },
  regainMissing: {
    en: 'Nobody took control again.',
    de: 'Niemand hat die Steuerung zurückgeholt.',
  },
  endGood: {
    en: 'Walk ended after {s} s.',
    de: 'Gehen nach {s} s beendet.',
  },
  endWrong: {
    en: 'Walk ended after {s} s: later than {limit} s.',
    de: 'Gehen nach {s} s beendet, später als {limit} s.',
  },
  endMissing: {
    en: 'The walk was not ended.',
    de: 'Das Gehen wurde nicht beendet.',
  },
  stayGood: {
    en: 'No new start.',
    de: 'Kein neuer Start.',
  },
  stayWrong: {
    en: 'Started again after {s} s.',
    de: 'Nach {s} s neu gestartet.',
  },
  notEnded: {
    en: 'Not judged: the walk was not ended.',
    de: 'Nicht bewertet: Das Gehen wurde nicht beendet.',
  },
  answerGood: {
    en: 'Answered after {s} s.',
    de: 'Antwort nach {s} s.',
  },
  answerWrong: {
    en: 'Answered after {s} s: later than {limit} s.',
    de: 'Antwort nach {s} s, später als {limit} s.',
  },
  answerMissing: {
    en: 'Nobody answered.',
    de: 'Niemand hat geantwortet.',
  },
  standingGood: {
    en: 'Nothing handed over while the hoist was moving.',
    de: 'Nichts während der Fahrt übergeben.',
  },
  standingWrong: {
    en: 'Tried to hand over while the hoist was moving.',
    de: 'Übergabe während der Fahrt versucht.',
  },
  notAnswered: {
    en: 'Not judged: nobody answered.',
    de: 'Nicht bewertet: Niemand hat geantwortet.',
  },
} as const satisfies Record<string, Words>;
export type SeldomText = keyof typeof seldomWords;

export const told = (key: SeldomText, values: Record<string, string | number> = {}): string => filled(words(seldomWords[key]), values);
