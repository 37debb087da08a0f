// The API's description (OpenAPI 3.1) as the page of its routes needs it: a list, an example of each body, a request from a filled-in form.

export interface Schema {
  $ref?: string;
  type?: string | readonly string[];
  const?: unknown;
  enum?: readonly unknown[];
  anyOf?: readonly Schema[];
  properties?: Readonly<Record<string, Schema>>;
  required?: readonly string[];
  items?: Schema;
  minimum?: number;
  minLength?: number;
}
export interface Input {
  name: string;
  in: 'path' | 'query' | 'header';
  required: boolean;
  description?: string;
  schema: Schema;
}
interface Content {
  content?: Readonly<Record<string, { schema?: Schema }>>;
}
export interface Operation {
  operationId: string;
  summary: string;
  'x-role': string;
  parameters?: readonly Input[];
  requestBody?: Content & { required: boolean };
  responses: Readonly<Record<string, Content & { description: string }>>;
}
export interface Description {
  paths: Readonly<Record<string, Readonly<Record<string, Operation>>>>;
  components: { schemas: Readonly<Record<string, Schema>> };
}
export interface Route {
  method: string;
  path: string;
  operation: Operation;
}

/** By what they are about: the first part of the path after the version. */
export function groupsOf({ paths }: Description): Map<string, Route[]> {
  const groups = new Map<string, Route[]>();
  for (const [path, methods] of Object.entries(paths))
    for (const [method, operation] of Object.entries(methods)) {
      const group = /^\/api\/v1\/([\w-]+)/.exec(path)?.[1] ?? 'other';
      groups.set(group, [...(groups.get(group) ?? []), { method: method.toUpperCase(), path, operation }]);
    }
  return groups;
}

export function matches({ method, path, operation }: Route, search: string): boolean {
  const text = `${method} ${path} ${operation.operationId} ${operation.summary}`.toLowerCase();
  return search
    .toLowerCase()
    .split(/\s+/)
    .every((word) => text.includes(word));
}

const deepest = 6;

/** Something that the schema allows: what an object needs, or all that it may have when it needs nothing. */
export function exampleOf(schema: Schema, { components }: Pick<Description, 'components'>, depth = 0): unknown {
  const of = (one: Schema) => exampleOf(one, { components }, depth + 1);
  if (depth > deepest) return null;
  if (schema.$ref !== undefined) return of(components.schemas[schema.$ref.replace(/^.*\//, '')] ?? {});
  if (schema.const !== undefined) return schema.const;
  if (schema.enum !== undefined) return schema.enum[0];
  if (schema.anyOf !== undefined) return of(schema.anyOf[0] ?? {});
  const type = Array.isArray(schema.type) ? (schema.type as readonly string[])[0] : schema.type;
  if (type === 'object') {
    const needed = schema.required ?? [];
    const members = Object.entries(schema.properties ?? {}).filter(([name]) => needed.length === 0 || needed.includes(name));
    return Object.fromEntries(members.map(([name, member]) => [name, of(member)]));
  }
  if (type === 'array') return schema.items === undefined ? [] : [of(schema.items)];
  if (type === 'integer' || type === 'number') return schema.minimum ?? 0;
  if (type === 'boolean') return false;
  if (type === 'null') return null;
  return 'x'.repeat(schema.minLength ?? 0) || 'text';
}

/** The media type and schema of a route's body. */
export function bodyOf({ requestBody }: Operation): { type: string; schema: Schema } | null {
  const [first] = Object.entries(requestBody?.content ?? {});
  return first === undefined ? null : { type: first[0], schema: first[1].schema ?? {} };
}

export interface Filled {
  inputs: Readonly<Record<string, string>>;
  body: string | Blob | null;
  token: string;
}
/** The request that the browser makes. Without a token its cookie shows who asks; then X-Hoist says that it was this page. */
export function requestOf({ method, path, operation }: Route, { inputs, body, token }: Filled): { address: string; init: RequestInit } {
  let address = path;
  const query = new URLSearchParams();
  const headers: Record<string, string> = {};
  for (const { name, in: place } of operation.parameters ?? []) {
    const value = inputs[`${place} ${name}`] ?? '';
    if (place === 'path') address = address.replace(`{${name}}`, encodeURIComponent(value));
    else if (value === '') continue;
    else if (place === 'query') query.set(name, value);
    else headers[name] = value;
  }
  if (token !== '') headers['Authorization'] = `Bearer ${token}`;
  else if (method !== 'GET') headers['X-Hoist'] = '1';
  const content = bodyOf(operation);
  const sent = typeof body === 'string' && body.trim() === '' ? null : body;
  if (sent !== null && content !== null) headers['Content-Type'] = content.type;
  const fields = query.toString();
  return {
    address: fields === '' ? address : `${address}?${fields}`,
    init: {
      method,
      headers,
      credentials: token === '' ? 'same-origin' : 'omit',
      cache: 'no-store',
      ...(sent === null ? {} : { body: sent }),
    },
  };
}
