// Texts of what a study tells. They come with its screen, which adds them (addTexts).
import type { Language } from './settings';

const en = {
  'study.assumed': 'Put in by assumption',
  'study.assumedHelp': 'None of this is measured, so none of it is a finding.',
  'study.assumedSpeed': 'Preferred speed {speed}; settings “{preset}”.',
  'study.assumedFollow':
    'Who is driven turns to the path ahead by {share} of what a leading person would, {more} more with each run, and trails {late} behind. So C of the runs without * and its rise are assumed.',
  'study.assumedTherapist':
    'The therapist drives at {speed}, reacts {late} late and misjudges place and direction by {aside} and {turned}. So J of the runs without * is assumed.',
  'study.assumedOrthosis': 'Orthosis (runs 4 to 6): steps uneven by {limp} %, gait sways {sway} times as wide.',
  'study.findings': 'What comes out',
  'study.findSquare': 'C of the squares {c}: their path turns only in the corners.',
  'study.findLed': 'C while the patient leads {c}: the pelvis steers.',
  'study.findRatio': 'J of the squares is {n} times that of the driven eights: nobody turns on the spot.',
  'study.recorded': 'recorded',
  'study.recordedTitle': 'Evaluate recorded sessions',
  'study.recordedWhat': 'Counts sessions with a patient whose note begins with “run 1” to “run 6”: the paper’s six runs. Of several the newest.',
  'study.ofPeople': 'Recorded sessions. They stay when the study is deleted.',
  'study.sureRecorded': 'Delete the study? Its sessions stay.',
  'study.evaluate': 'Evaluate',
  'study.evaluating': 'Evaluating …',
};
export type StudyKey = keyof typeof en;

const de: Record<StudyKey, string> = {
  'study.assumed': 'Was angenommen ist',
  'study.assumedHelp': 'Nichts davon ist gemessen, also ist nichts davon ein Ergebnis.',
  'study.assumedSpeed': 'Wunschtempo {speed}; Einstellungen „{preset}“.',
  'study.assumedFollow':
    'Wer gefahren wird, dreht sich zum Weg voraus, und zwar {share} mal so weit wie beim Führen, mit jedem Durchgang {more} mehr und {late} verspätet. C der Durchgänge ohne * und sein Anstieg sind also angenommen.',
  'study.assumedTherapist':
    'Wer fährt, fährt {speed}, reagiert {late} verspätet und schätzt Ort und Richtung um {aside} und {turned} falsch. J der Durchgänge ohne * ist also angenommen.',
  'study.assumedOrthosis': 'Orthese (Durchgänge 4 bis 6): Schritte um {limp} % ungleich, der Gang schwankt {sway}-mal so weit.',
  'study.findings': 'Was herauskommt',
  'study.findSquare': 'C der Quadrate {c}: Ihr Weg dreht nur in den Ecken.',
  'study.findLed': 'C beim Führen durch die Person {c}: Das Becken lenkt.',
  'study.findRatio': 'J der Quadrate ist {n}-mal so groß wie bei den gefahrenen Achten: Niemand dreht auf der Stelle.',
  'study.recorded': 'aufgenommen',
  'study.recordedTitle': 'Aufgenommene Sitzungen auswerten',
  'study.recordedWhat':
    'Zählt Sitzungen mit Patient, deren Notiz mit „run 1“ bis „run 6“ beginnt: die sechs Läufe der Veröffentlichung. Von mehreren die neueste.',
  'study.ofPeople': 'Aufgenommene Sitzungen. Sie bleiben, wenn die Studie gelöscht wird.',
  'study.sureRecorded': 'Studie löschen? Ihre Sitzungen bleiben.',
  'study.evaluate': 'Auswerten',
  'study.evaluating': 'Wertet aus …',
};

export const study: Readonly<Record<Language, Readonly<Record<StudyKey, string>>>> = { en, de };
