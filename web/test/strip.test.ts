import { describe, expect, it } from 'vitest';
import { storageAlarms } from '../src/ui/strip';

const notice = (name: string, priority: 'low' | 'medium') => ({
  name,
  priority,
  text: { en: `${name} text`, de: '' },
  action: { en: `${name} action`, de: '' },
  detail: '',
});

describe('the strip', () => {
  it('shows each standing notice in words, with what to do', () => {
    expect(storageAlarms([notice('settings_not_stored', 'medium')], false)).toEqual([
      { id: 'settings_not_stored', priority: 'medium', text: 'settings_not_stored text', action: 'settings_not_stored action' },
    ]);
    expect(storageAlarms([], false)).toEqual([]);
  });

  it('says once that nothing is recorded', () => {
    expect(storageAlarms([notice('recordings_foreign', 'medium')], true)).toHaveLength(1);
    expect(storageAlarms([notice('recordings_set_aside', 'low')], true).map((alarm) => alarm.id)).toEqual(['recordings_set_aside', 'recording']);
  });
});
