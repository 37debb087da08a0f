// What staff did in a rehearsal on the simulated hoist: one sentence each, with its time.
import type { RehearsalCheck, RehearsalItem, RehearsalKind, RehearsalResult } from '../contract/rest.gen';
import { rehearse as texts, type RehearseKey } from '../text/rehearse';
import { addTexts, fixed, t } from '../text/text';
import './rehearsal.css';

addTexts(texts);

export const rehearsals: Readonly<Record<RehearsalKind, { title: RehearseKey; what: RehearseKey }>> = {
  trip: { title: 'rehearse.trip', what: 'rehearse.tripWhat' },
  freeze: { title: 'rehearse.freeze', what: 'rehearse.freezeWhat' },
  bumper: { title: 'rehearse.bumper', what: 'rehearse.bumperWhat' },
  link_loss: { title: 'rehearse.link', what: 'rehearse.linkWhat' },
  low_battery: { title: 'rehearse.battery', what: 'rehearse.batteryWhat' },
  second_therapist: { title: 'rehearse.second', what: 'rehearse.secondWhat' },
};
export const rehearsalTitle = (kind: RehearsalKind): string => t(rehearsals[kind].title);

const sentences: Readonly<Record<RehearsalCheck, Readonly<Record<RehearsalItem['seen'], RehearseKey>>>> = {
  stop: { good: 'rehearse.stopGood', wrong: 'rehearse.stopWrong', missing: 'rehearse.stopMissing' },
  look: { good: 'rehearse.lookGood', wrong: 'rehearse.lookWrong', missing: 'rehearse.notReleased' },
  cause_gone: { good: 'rehearse.causeGood', wrong: 'rehearse.causeWrong', missing: 'rehearse.notReleased' },
  acknowledge: { good: 'rehearse.releaseGood', wrong: 'rehearse.releaseWrong', missing: 'rehearse.releaseMissing' },
  zero: { good: 'rehearse.zeroGood', wrong: 'rehearse.zeroWrong', missing: 'rehearse.zeroMissing' },
  go_on: { good: 'rehearse.goGood', wrong: 'rehearse.goWrong', missing: 'rehearse.goMissing' },
  regain: { good: 'rehearse.regainGood', wrong: 'rehearse.regainWrong', missing: 'rehearse.regainMissing' },
  end: { good: 'rehearse.endGood', wrong: 'rehearse.endWrong', missing: 'rehearse.endMissing' },
  stay_ended: { good: 'rehearse.stayGood', wrong: 'rehearse.stayWrong', missing: 'rehearse.notEnded' },
  answer: { good: 'rehearse.answerGood', wrong: 'rehearse.answerWrong', missing: 'rehearse.answerMissing' },
  standing: { good: 'rehearse.standingGood', wrong: 'rehearse.standingWrong', missing: 'rehearse.notAnswered' },
};
const marks = { good: '✓', wrong: '✗', missing: '–' } as const;
const markTexts = { good: 'rehearse.good', wrong: 'rehearse.wrong', missing: 'rehearse.missing' } as const satisfies Record<string, RehearseKey>;

export const rehearsalSentence = ({ check, seen, after_s, limit_s }: RehearsalItem): string =>
  t(sentences[check][seen], { s: fixed(after_s, 1), limit: fixed(limit_s, 0) });

export function RehearsalItems({ result }: { result: RehearsalResult }) {
  return (
    <ul class="rehearsal-items">
      {result.items.map((item) => (
        <li key={item.check} class={item.seen}>
          <span class="rehearsal-mark" role="img" aria-label={t(markTexts[item.seen])}>
            {marks[item.seen]}
          </span>
          <span>{rehearsalSentence(item)}</span>
        </li>
      ))}
    </ul>
  );
}
