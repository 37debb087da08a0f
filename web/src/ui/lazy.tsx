// Code loaded on first use, with a placeholder while loading and after a failure.
import { useEffect, useState } from 'preact/hooks';
import { t } from '../text/text';
import './lazy.css';

export type LazyState<T> = { state: 'loading' } | { state: 'failed' } | { state: 'ready'; value: T };

/** Loads once. A failed load stays failed, since a browser does not request a module twice in one page; reloading the page helps. This happens
 * after a new build on the server, whose files have other names. */
export class Lazy<T> {
  private now: LazyState<T> = { state: 'loading' };
  private loading: Promise<LazyState<T>> | null = null;
  constructor(private readonly load: () => Promise<T>) {}

  get state(): LazyState<T> {
    return this.now;
  }

  /** Never rejects. */
  start(): Promise<LazyState<T>> {
    this.loading ??= this.load().then(
      (value) => (this.now = { state: 'ready', value }),
      () => (this.now = { state: 'failed' }),
    );
    return this.loading;
  }
}

/** Starts the load, and renders the component when it has ended. */
export function useLazy<T>(lazy: Lazy<T>): LazyState<T> {
  const [, again] = useState<LazyState<T> | null>(null);
  useEffect(() => {
    void lazy.start().then(again);
  }, [lazy]);
  return lazy.state;
}

/** Placeholder of a screen. It takes no space, so nothing jumps when the screen appears. */
export const Loading = () => (
  <p class="hint loading" role="status">
    {t('common.loading')}
  </p>
);

export const LoadFailed = () => (
  <div class="card load-failed" role="alert">
    <p>
      <strong>{t('load.failed')}</strong> {t('load.action')}
    </p>
    <button type="button" class="big" onClick={() => location.reload()}>
      {t('load.again')}
    </button>
  </div>
);
