// The first account of a device: switch on, code from the hoist, name and password of the engineer.
import { useState } from 'preact/hooks';
import type { WhoAmI } from '../../contract/rest.gen';
import { setUp } from '../../link/account';
import { duration, t } from '../../text/text';
import { Field, Form } from '../../ui/field';
import { nameMost, passwordMost, Send, useSending } from './send';

const codeMost = 16;
export const passwordLeast = 12;

export function SetUp({ first, set_up }: { first: boolean; set_up: WhoAmI['set_up'] }) {
  const [code, setCode] = useState('');
  const [name, setName] = useState('');
  const [display, setDisplay] = useState('');
  const [password, setPassword] = useState('');
  const [again, setAgain] = useState('');
  const sending = useSending(() => setUp({ code: code.trim(), user: name.trim().toLowerCase(), display_name: display.trim(), password }));
  const differs = again !== '' && again !== password;
  return (
    <>
      <h1>{t(first ? 'setup.title' : 'setup.lostTitle')}</h1>
      <ol class="set-up-steps">
        <li class={set_up.switch_on ? 'done' : undefined}>
          {t('setup.switch')} <strong>{t(set_up.switch_on ? 'setup.on' : 'setup.off')}</strong>
        </li>
        <li>
          {t('setup.code')}{' '}
          {set_up.switch_on ? (
            <strong class="num">{set_up.seconds_left > 0 ? t('setup.left', { time: duration(set_up.seconds_left) }) : t('setup.over')}</strong>
          ) : null}
        </li>
        <li>{t(first ? 'setup.account' : 'setup.again')}</li>
      </ol>
      <Form label={t('setup.title')} onSend={() => void sending.go()}>
        <Field label={t('setup.codeField')} value={code} most={codeMost} fill="one-time-code" onValue={setCode} />
        <Field label={t('signin.name')} hint={t('users.nameHint')} value={name} most={nameMost} fill="username" onValue={setName} />
        <Field label={t('users.display')} value={display} most={64} onValue={setDisplay} />
        <Field
          label={t('signin.password')}
          hint={t('users.passwordHint')}
          type="password"
          value={password}
          most={passwordMost}
          fill="new-password"
          onValue={setPassword}
        />
        <Field label={t('users.again')} type="password" value={again} most={passwordMost} fill="new-password" onValue={setAgain} />
        {differs ? <p class="form-error">{t('users.differ')}</p> : null}
        <Send
          sending={sending}
          label={t('setup.do')}
          ready={
            set_up.switch_on &&
            code.trim() !== '' &&
            name.trim() !== '' &&
            display.trim() !== '' &&
            password.length >= passwordLeast &&
            again === password
          }
          back={null}
        />
      </Form>
      {first ? <p class="hint">{t('setup.link')}</p> : null}
    </>
  );
}
