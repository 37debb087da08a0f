// The person who is signed in: password, PIN, signing out.
import { useState } from 'preact/hooks';
import { notify } from '../../link/console';
import { signOut } from '../../link/account';
import { rest, type Problem } from '../../link/rest';
import { useStore } from '../../link/store';
import { t, textOf } from '../../text/text';
import { Field, Form, Trouble } from '../../ui/field';
import { FormButtons } from '../../ui/form_buttons';

const passwordLeast = 12;
const passwordMost = 128;
const pinLeast = 4;
const pinMost = 8;

export function MeSection() {
  const role = useStore((s) => s.role);
  const person = useStore((s) => s.person);
  const account = useStore((s) => s.account);
  const [problem, setProblem] = useState<Problem | null>(null);
  return (
    <>
      <section class="card">
        <h2>{person ?? t('users.local')}</h2>
        <p class="hint">{textOf(`role.${role}`) ?? ''}</p>
        {account ? (
          <button type="button" class="plain" onClick={() => void signOut().then(setProblem)}>
            {t('signin.out')}
          </button>
        ) : (
          <p class="hint">{t('users.localHint')}</p>
        )}
        <Trouble problem={problem} />
      </section>
      {account ? <PasswordCard /> : null}
      {account ? <PinCard /> : null}
    </>
  );
}

function PasswordCard() {
  const [now, setNow] = useState('');
  const [next, setNext] = useState('');
  const [again, setAgain] = useState('');
  const [problem, setProblem] = useState<Problem | null>(null);
  const save = async () => {
    const answer = await rest('PUT /api/v1/session/password', { body: { password: now, new_password: next } });
    setProblem(answer.ok ? null : answer.problem);
    if (!answer.ok) return;
    [setNow, setNext, setAgain].forEach((set) => set(''));
    notify('info', 'users.passwordChanged');
  };
  const missing = [
    ...(now === '' ? [t('users.passwordNow')] : []),
    ...(next.length < passwordLeast ? [t('users.passwordNew')] : []),
    ...(again === '' || again !== next ? [t('users.again')] : []),
  ];
  return (
    <section class="card">
      <h2>{t('users.password')}</h2>
      <Form label={t('users.password')} onSend={() => void save()}>
        <Field label={t('users.passwordNow')} type="password" fill="current-password" value={now} most={passwordMost} onValue={setNow} />
        <Field
          label={t('users.passwordNew')}
          hint={t('users.passwordHint')}
          type="password"
          fill="new-password"
          value={next}
          most={passwordMost}
          onValue={setNext}
        />
        <Field label={t('users.again')} type="password" fill="new-password" value={again} most={passwordMost} onValue={setAgain} />
        {again !== '' && again !== next ? <p class="form-error">{t('users.differ')}</p> : null}
        <Trouble problem={problem} />
        <FormButtons missing={missing} />
      </Form>
    </section>
  );
}

function PinCard() {
  const [password, setPassword] = useState('');
  const [pin, setPin] = useState('');
  const [problem, setProblem] = useState<Problem | null>(null);
  const save = async (next: string | null) => {
    const answer = await rest('PUT /api/v1/session/pin', { body: { password, pin: next } });
    setProblem(answer.ok ? null : answer.problem);
    if (!answer.ok) return;
    setPassword('');
    setPin('');
    notify('info', next === null ? 'users.pinGone' : 'users.pinSet');
  };
  const fits = /^\d+$/.test(pin) && pin.length >= pinLeast;
  return (
    <section class="card">
      <h2>{t('signin.pin')}</h2>
      <p class="hint">{t('users.pinHint')}</p>
      <Form label={t('signin.pin')} onSend={() => void save(pin)}>
        <Field label={t('users.passwordNow')} type="password" fill="current-password" value={password} most={passwordMost} onValue={setPassword} />
        <Field label={t('users.pinNew')} hint={t('users.pinLength')} type="password" numeric value={pin} most={pinMost} onValue={setPin} />
        <Trouble problem={problem} />
        <FormButtons missing={[...(password === '' ? [t('users.passwordNow')] : []), ...(fits ? [] : [t('users.pinNew')])]}>
          <button type="button" class="quiet" disabled={password === ''} onClick={() => void save(null)}>
            {t('users.pinRemove')}
          </button>
        </FormButtons>
      </Form>
    </section>
  );
}
