// /api/docs: every route of the API, where it can be tried. A page for programmers, in English like the description it shows; it asks the hoist
// itself, so STOP is on it too.
import './docs.css';
import { bodyOf, exampleOf, groupsOf, matches, requestOf, type Description, type Input, type Route } from './model';

/** Longer answers are cut on the page. */
const shownMost = 100_000;
const toldHeaders = ['content-type', 'etag', 'location', 'retry-after', 'content-disposition'];

type Child = Node | string;
function make<Tag extends keyof HTMLElementTagNameMap>(
  tag: Tag,
  properties: Partial<HTMLElementTagNameMap[Tag]> = {},
  ...children: Child[]
): HTMLElementTagNameMap[Tag] {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children);
  return element;
}

let description: Description;
const token = make('input', { type: 'password', autocomplete: 'off', spellcheck: false });
const search = make('input', { type: 'search' });
const list = make('div', { className: 'docs-list' });

function inputFor({ name, in: place, required, description: text, schema }: Input, values: Map<string, () => string>): HTMLElement {
  const choices = schema.enum as readonly string[] | undefined;
  const field =
    choices === undefined
      ? make('input', { type: 'text', autocomplete: 'off', spellcheck: false, required: required && place === 'path' })
      : make('select', {}, make('option', { value: '' }, ''), ...choices.map((one) => make('option', { value: one }, one)));
  values.set(`${place} ${name}`, () => field.value);
  const title = make('span', {}, make('code', {}, name), ` ${place}${required ? ', needed' : ''}`);
  return make('label', { className: 'field' }, title, ...(text === undefined ? [] : [make('small', {}, text)]), field);
}

async function textOf(response: Response): Promise<string> {
  const type = response.headers.get('content-type') ?? '';
  if (response.status === 204) return '';
  const whole = await response.text();
  const text = /json/.test(type) ? JSON.stringify(JSON.parse(whole), null, 2) : whole;
  return text.length > shownMost ? `${text.slice(0, shownMost)}\n… ${text.length - shownMost} characters more` : text;
}

function answerOf(route: Route, fill: () => Parameters<typeof requestOf>[1], place: HTMLElement): () => Promise<void> {
  return async () => {
    const { address, init } = requestOf(route, fill());
    place.replaceChildren(make('p', { className: 'hint' }, `${route.method} ${address} …`));
    const begun = performance.now();
    try {
      const response = await fetch(address, init);
      const text = await textOf(response);
      const lasted_ms = Math.round(performance.now() - begun);
      const headers = toldHeaders.flatMap((name) => {
        const value = response.headers.get(name);
        return value === null ? [] : [`${name}: ${value}`];
      });
      place.replaceChildren(
        make('p', { className: response.ok ? 'docs-status' : 'docs-status refused' }, `${response.status} · ${lasted_ms} ms · ${address}`),
        make('pre', { tabIndex: 0 }, [...headers, '', text].join('\n')),
      );
    } catch (error) {
      place.replaceChildren(make('p', { className: 'docs-status refused' }, `No answer: ${String(error)}`));
    }
  };
}

/** What can be filled in, made when the route is opened. */
function formOf(route: Route): HTMLElement {
  const { operation } = route;
  if ('101' in operation.responses) return make('p', { className: 'hint' }, 'A WebSocket: open it with a client of its subprotocol.');
  const values = new Map<string, () => string>();
  const content = bodyOf(operation);
  const isJson = content?.type === 'application/json';
  const body = make('textarea', { rows: 6, spellcheck: false, ariaLabel: 'Body' });
  if (isJson) body.value = JSON.stringify(exampleOf(content.schema, description), null, 2);
  const file = make('input', { type: 'file', ariaLabel: 'Body' });
  const answer = make('div', { className: 'docs-answer', role: 'status' });
  const form = make('form', { className: 'docs-form' }, ...(operation.parameters ?? []).map((one) => inputFor(one, values)));
  if (content !== null) form.append(make('label', { className: 'field docs-body' }, make('span', {}, `Body, ${content.type}`), isJson ? body : file));
  form.append(make('button', { type: 'submit', className: 'plain primary' }, 'Send'));
  form.addEventListener('submit', (event) => {
    event.preventDefault();
    const inputs = Object.fromEntries([...values].map(([name, value]) => [name, value()]));
    const send = answerOf(route, () => ({ inputs, body: isJson ? body.value : (file.files?.[0] ?? null), token: token.value.trim() }), answer);
    void send();
  });
  const schemas = make('details', { className: 'docs-schema' }, make('summary', {}, 'Answers and schemas'));
  schemas.addEventListener('toggle', () => schemas.childElementCount > 1 || schemas.append(make('pre', { tabIndex: 0 }, schemaText(route))));
  return make('div', {}, form, answer, schemas);
}

/** The route's part of the description, with the schemas that it names. */
function schemaText({ operation }: Route): string {
  const named = new Map<string, unknown>();
  const collect = (part: unknown): void => {
    for (const [, name] of JSON.stringify(part).matchAll(/#\/components\/schemas\/(\w+)/g)) {
      if (named.has(name!)) continue;
      named.set(name!, description.components.schemas[name!]);
      collect(named.get(name!));
    }
  };
  collect(operation);
  return JSON.stringify({ responses: operation.responses, schemas: Object.fromEntries(named) }, null, 2);
}

function rowOf(route: Route): HTMLElement {
  const { method, path, operation } = route;
  const summary = make(
    'summary',
    {},
    make('span', { className: `docs-method ${method.toLowerCase()}` }, method),
    make('code', {}, path),
    make('span', { className: 'docs-role' }, operation['x-role']),
    make('span', { className: 'docs-about' }, operation.summary),
  );
  const row = make('details', { className: 'docs-route', id: operation.operationId }, summary);
  row.addEventListener('toggle', () => row.open && row.childElementCount === 1 && row.append(formOf(route)));
  return row;
}

function show(): void {
  const words = search.value.trim();
  const parts = [...groupsOf(description)].map(([name, routes]) => [name, routes.filter((one) => matches(one, words))] as const);
  list.replaceChildren(
    ...parts
      .filter(([, routes]) => routes.length > 0)
      .map(([name, routes]) => make('section', { className: 'card' }, make('h2', {}, name), ...routes.map(rowOf))),
  );
  const wanted = document.getElementById(location.hash.slice(1));
  if (wanted instanceof HTMLDetailsElement) {
    wanted.open = true;
    wanted.scrollIntoView();
  }
}

const told = make('p', { className: 'docs-status', role: 'alert' });
async function stopNow(): Promise<void> {
  const key = token.value.trim();
  const headers: Record<string, string> = key === '' ? { 'X-Hoist': '1' } : { Authorization: `Bearer ${key}` };
  const answer = await fetch('/api/v1/stop', { method: 'POST', headers, keepalive: true }).catch(() => null);
  told.textContent = answer?.ok === true ? 'STOP sent.' : 'STOP did not get through: stop at the hoist itself.';
}
function stopButton(): HTMLElement {
  const stop = make('button', { type: 'button', className: 'docs-stop' }, 'STOP');
  stop.addEventListener('pointerdown', () => void stopNow());
  stop.addEventListener('keydown', (event) => {
    if (event.key === 'Enter' || event.key === ' ') void stopNow();
  });
  return stop;
}

async function start(): Promise<void> {
  const place = document.getElementById('docs')!;
  place.append(
    make('header', {}, make('h1', {}, 'Hoist API'), make('a', { href: '/' }, 'Console'), told, stopButton()),
    make(
      'section',
      { className: 'card docs-about-page' },
      make('p', {}, 'Every request here goes to this hoist: what moves it moves it. SI units; a name ends with its unit. Errors are problem+json.'),
      make('p', {}, make('a', { href: '/api/openapi.json' }, 'openapi.json'), ' is the whole description (OpenAPI 3.1).'),
      make('label', { className: 'field' }, make('span', {}, 'Token; empty: as this browser is signed in'), token),
      make('label', { className: 'field' }, make('span', {}, 'Search'), search),
    ),
    list,
  );
  const answer = await fetch('/api/openapi.json');
  description = (await answer.json()) as Description;
  search.addEventListener('input', show);
  show();
}
void start();
