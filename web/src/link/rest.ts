// Plain requests to /api/v1. Errors are returned as values, so that a screen can always show them.
import type { FieldError, Problem as ToldProblem, Routes } from '../contract/rest.gen';

export interface Problem {
  status: number; // 0 = the server cannot be reached
  /** Row of the table of reasons, if the server gives one. */
  code: string;
  errors: readonly FieldError[];
  refusals: readonly string[];
  /** The server wants no further try before (Retry-After); null: it says nothing. */
  wait_s: number | null;
}
export type Answer<T> = { ok: true; value: T } | { ok: false; problem: Problem };

/** What a route takes: fields of its path, its query, its body; `etag` of what a change is made for, null for any. */
type Given<R extends keyof Routes> = Omit<Routes[R], 'answer'>;
/** May be left out where the route needs nothing. */
type MaybeGiven<R extends keyof Routes> = Record<never, never> extends Given<R> ? [given?: Given<R>] : [given: Given<R>];
interface AnyGiven {
  path?: Record<string, string | number>;
  query?: Record<string, string | number | undefined>;
  body?: object;
  etag?: string | null;
}

const within_ms = 10_000;

/** The address of a route with its fields filled in; those of the query that are undefined are left out. */
export function address<R extends keyof Routes>(route: R, ...[given]: MaybeGiven<R>): string {
  const { path = {}, query = {} } = (given ?? {}) as AnyGiven;
  const place = route.slice(route.indexOf(' ') + 1).replace(/\{(\w+)\}/g, (_, name: string) => encodeURIComponent(path[name] ?? ''));
  const fields = Object.entries(query).flatMap(([name, value]) => (value === undefined ? [] : [[name, String(value)]]));
  return fields.length === 0 ? place : `${place}?${new URLSearchParams(fields).toString()}`;
}

function waitOf(response: Response): number | null {
  const told = response.headers.get('Retry-After');
  return told !== null && /^\d+$/.test(told) ? Number(told) : null;
}

export async function rest<R extends keyof Routes>(route: R, ...given: MaybeGiven<R>): Promise<Answer<Routes[R]['answer']>> {
  const method = route.slice(0, route.indexOf(' '));
  const { body = {}, etag } = (given[0] ?? {}) as AnyGiven;
  const headers: Record<string, string> = { Accept: 'application/json' };
  if (method !== 'GET') {
    headers['X-Hoist'] = '1';
    headers['Content-Type'] = 'application/json';
    if (etag !== undefined) headers['If-Match'] = etag === null ? '*' : `"${etag}"`;
  }
  try {
    const response = await fetch(address(route, ...given), {
      method,
      headers,
      credentials: 'same-origin',
      cache: 'no-store',
      signal: AbortSignal.timeout(within_ms),
      keepalive: method !== 'GET', // sent also when the page is being closed
      ...(method === 'GET' ? {} : { body: JSON.stringify(body) }),
    });
    const text = await response.text();
    const value: unknown = text === '' ? null : JSON.parse(text);
    if (response.ok) return { ok: true, value: value as Routes[R]['answer'] };
    const problem = (value ?? {}) as Partial<ToldProblem>;
    return {
      ok: false,
      problem: {
        status: response.status,
        code: (problem.type ?? '').replace(/^.*\//, '').replaceAll('-', '_'),
        errors: problem.errors ?? [],
        refusals: problem.refusals ?? [],
        wait_s: waitOf(response),
      },
    };
  } catch {
    return { ok: false, problem: { status: 0, code: '', errors: [], refusals: ['link_lost'], wait_s: null } };
  }
}

interface Page<T> {
  items: readonly T[];
  next: string | null;
}
/** The most rows that the server puts on a page. */
const pageMost = 200;

/** A short list as a whole: all its pages, one after the other. `page` requests one. */
export async function wholeList<T>(page: (query: { limit: number; cursor?: string }) => Promise<Answer<Page<T>>>): Promise<Answer<{ items: T[] }>> {
  const items: T[] = [];
  let cursor: string | null = null;
  do {
    const answer: Answer<Page<T>> = await page({ limit: pageMost, ...(cursor === null ? {} : { cursor }) });
    if (!answer.ok) return answer;
    items.push(...answer.value.items);
    cursor = answer.value.next;
  } while (cursor !== null);
  return { ok: true, value: { items } };
}
