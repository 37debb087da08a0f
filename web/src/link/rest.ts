// Plain requests to /api/v1. Errors are returned as values, so that a screen can always show them.
import type { FieldError } from '../contract/messages.gen';

export interface Problem {
  status: number; // 0 = the server cannot be reached
  /** Row of the table of reasons, if the server gives one. */
  code: string;
  errors: FieldError[];
  refusals: string[];
}
export type Answer<T> = { ok: true; value: T } | { ok: false; problem: Problem };

const within_ms = 10_000;

export async function rest<T>(method: 'GET' | 'POST' | 'PATCH' | 'PUT' | 'DELETE', path: string, body?: object): Promise<Answer<T>> {
  const headers: Record<string, string> = { Accept: 'application/json' };
  if (method !== 'GET') {
    headers['X-Hoist'] = '1';
    headers['Content-Type'] = 'application/json';
  }
  try {
    const response = await fetch(`/api/v1${path}`, {
      method,
      headers,
      credentials: 'same-origin',
      cache: 'no-store',
      signal: AbortSignal.timeout(within_ms),
      keepalive: method !== 'GET', // sent also when the page is being closed
      ...(method === 'GET' ? {} : { body: JSON.stringify(body ?? {}) }),
    });
    const text = await response.text();
    const value: unknown = text === '' ? null : JSON.parse(text);
    if (response.ok) return { ok: true, value: value as T };
    const problem = (value ?? {}) as Partial<Problem> & { type?: string };
    return {
      ok: false,
      problem: {
        status: response.status,
        code: (problem.type ?? '').replace(/^.*\//, '').replaceAll('-', '_'),
        errors: problem.errors ?? [],
        refusals: problem.refusals ?? [],
      },
    };
  } catch {
    return { ok: false, problem: { status: 0, code: '', errors: [], refusals: ['link_lost'] } };
  }
}
