// Programs that people already use for watching and driving robots: Foxglove Studio and ROS pages.
import { useState } from 'preact/hooks';
import { useQuery } from '../../link/query';
import { rest, type Problem } from '../../link/rest';
import { useStore } from '../../link/store';
import { addressOf } from '../../router';
import { t } from '../../text/text';
import { Trouble } from '../../ui/field';
import { may } from './roles';

const socketOf = (path: string) => `${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}${path}`;

export function ToolsSection() {
  const role = useStore((s) => s.role);
  const tools = useQuery(() => rest('GET /api/v1/tools'), []);
  const [problem, setProblem] = useState<Problem | null>(null);
  const set = async (enabled: boolean, etag: string) => {
    const answer = await rest('PUT /api/v1/tools', { body: { enabled }, etag });
    setProblem(answer.ok ? null : answer.problem);
    tools.retry();
  };
  const now = tools.value;
  return (
    <section class="card">
      <h2>{t('settings.tools')}</h2>
      <p class="hint">{t('tools.hint')}</p>
      <Trouble problem={tools.problem} retry={tools.retry} />
      <Trouble problem={problem} />
      {now === null ? null : (
        <>
          <label class="check">
            <input
              type="checkbox"
              checked={now.enabled}
              disabled={!may(role, 'engineer')}
              onChange={(event) => void set(event.currentTarget.checked, now.etag)}
            />
            <span>{t('tools.allow')}</span>
          </label>
          <dl class="settings-known">
            <dt>Foxglove</dt>
            <dd>
              <code>{socketOf(now.foxglove)}</code>
            </dd>
            <dt>rosbridge</dt>
            <dd>
              <code>{socketOf(now.rosbridge)}</code>
            </dd>
          </dl>
          <p>
            {t('tools.token')} <a href={addressOf('settings', 'tokens')}>{t('settings.tokens')}</a>
          </p>
          <a class="plain" href={now.foxglove_layout} download>
            {t('tools.layout')}
          </a>
        </>
      )}
    </section>
  );
}
